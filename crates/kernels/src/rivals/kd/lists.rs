//! The stage of large nodes: what follows from the splits for the lists of nodes and of photons.
//!
//! Splitting a list stably is the split of Sengupta et al., "Scan Primitives for GPU Computing" (2007): a flag says who goes left,
//! and a scan of the flags where to.

use super::{KD_SMALL_OWNER, KdLarge, KdLevel, KdSmall, KdSplit, before, kd_first};
use crate::exec::{Input, Store};

/// Puts child `i` where it belongs: among the active nodes of the next level, or among the small nodes. `sums` and `offsets` are the
/// scan of `is_large`.
#[inline]
pub fn kd_hand_out<N: Store<KdLarge> + ?Sized, R: Store<KdSmall> + ?Sized>(
    i: u32,
    level: &KdLevel,
    children: &Input<KdLarge>,
    is_large: &Input<u32>,
    sums: &Input<u32>,
    offsets: &Input<u32>,
    next: &mut N,
    roots: &mut R,
) {
    if i >= 2 * level.nodes {
        return;
    }
    let child = children[i as usize];
    let place = place_of(i, level, is_large, sums, offsets);
    if place & KD_SMALL_OWNER == 0 {
        next.set(place, child);
    } else {
        let set = kd_first(child.photons);
        roots.set(place & !KD_SMALL_OWNER, KdSmall { begin: child.begin, set, place: child.place });
    }
}

/// Where a child is put: the owner that its photons get.
#[inline]
fn place_of(child: u32, level: &KdLevel, is_large: &Input<u32>, sums: &Input<u32>, offsets: &Input<u32>) -> u32 {
    let large = before(sums, offsets, child);
    if is_large[child as usize] != 0 { large } else { KD_SMALL_OWNER | (level.roots + child - large) }
}

/// Says of the photon at place `i` of the list along which its node was split on which side it is (1 for left), and of the place which node
/// owns it on the next level: a split keeps a node's places, the left child's before the right one's.
#[inline]
pub fn kd_classify<S: Store<u32> + ?Sized, W: Store<u32> + ?Sized>(
    i: u32,
    level: &KdLevel,
    owners: &Input<u32>,
    splits: &Input<KdSplit>,
    orders: &Input<u32>,
    is_large: &Input<u32>,
    sums: &Input<u32>,
    offsets: &Input<u32>,
    sides: &mut S,
    next_owners: &mut W,
) {
    if i >= level.photons {
        return;
    }
    let owner = owners[i as usize];
    let mut next = owner;
    if owner & KD_SMALL_OWNER == 0 {
        let split = splits[owner as usize];
        let right = u32::from(i >= split.begin + split.left);
        sides.set(orders[(split.axis * level.photons + i) as usize], 1 - right);
        next = place_of(2 * owner + right, level, is_large, sums, offsets);
    }
    next_owners.set(i, next);
}

/// Lists the sides of the photons at place `i` of all three lists. Those of small nodes have sides that nobody reads.
#[inline]
pub fn kd_list_sides<F: Store<u32> + ?Sized>(
    i: u32,
    level: &KdLevel,
    orders: &Input<u32>,
    sides: &Input<u32>,
    flags: &mut F,
) {
    if i < level.photons {
        let mut place = i;
        while place < 3 * level.photons {
            flags.set(place, sides[orders[place as usize] as usize]);
            place += level.photons;
        }
    }
}

/// Moves the photons at place `i` of the three lists to their child's places. `sums` and `offsets` are the scan of `flags`.
#[inline]
pub fn kd_move<O: Store<u32> + ?Sized>(
    i: u32,
    level: &KdLevel,
    owners: &Input<u32>,
    splits: &Input<KdSplit>,
    orders: &Input<u32>,
    flags: &Input<u32>,
    sums: &Input<u32>,
    offsets: &Input<u32>,
    next_orders: &mut O,
) {
    if i >= level.photons {
        return;
    }
    let owner = owners[i as usize];
    let mut list = 0;
    while list < 3 * level.photons {
        let place = list + i;
        let mut to = place;
        if owner & KD_SMALL_OWNER == 0 {
            let split = splits[owner as usize];
            let first = list + split.begin;
            let lefts = before(sums, offsets, place) - before(sums, offsets, first);
            to = if flags[place as usize] != 0 { first + lefts } else { place + split.left - lefts };
        }
        next_orders.set(to, orders[place as usize]);
        list += level.photons;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    fn exclusive(flags: &[u32]) -> Vec<u32> {
        flags.iter().scan(0, |sum, &flag| Some(std::mem::replace(sum, *sum + flag))).collect()
    }

    #[test]
    fn lists_are_split_stably_and_every_place_gets_its_new_owner() {
        // Places 0 … 2 are of a small node, 3 … 6 of the first active one, split along y, 7 … 9 of the second, split along z.
        let n = 10;
        let level = KdLevel { photons: n, nodes: 2, roots: 5, ..KdLevel::default() };
        let splits = [KdSplit { begin: 3, left: 3, axis: 1 }, KdSplit { begin: 7, left: 1, axis: 2 }];
        let small = KD_SMALL_OWNER | 4;
        let owners = [small, small, small, 0, 0, 0, 0, 1, 1, 1];
        let orders = [[0, 1, 2, 3, 4, 5, 6, 7, 8, 9], [2, 1, 0, 6, 4, 5, 3, 9, 8, 7], [1, 0, 2, 5, 3, 6, 4, 8, 9, 7]];
        // The first child of the first node and the last of the second are large.
        let (is_large, sums) = ([1, 0, 0, 1], [0, 1, 1, 1]);
        let (mut sides, mut next_owners) = (vec![9; 10], vec![9; 10]);
        let orders_flat = orders.as_flattened();
        for i in 0..=n {
            let (sides, next_owners) = (sides.as_mut_slice(), next_owners.as_mut_slice());
            kd_classify(i, &level, &owners, &splits, orders_flat, &is_large, &sums, &[0], sides, next_owners);
        }
        assert_eq!(sides, [9, 9, 9, 0, 1, 1, 1, 0, 1, 0]);
        let child = |i: u32| KD_SMALL_OWNER | i;
        assert_eq!(next_owners, [small, small, small, 0, 0, 0, child(5), child(6), 1, 1]);
        let mut flags = vec![7; 30];
        (0..=n).for_each(|i| kd_list_sides(i, &level, orders_flat, &sides, flags.as_mut_slice()));
        let mut moved = vec![99; 30];
        let sums = exclusive(&flags);
        for i in 0..=n {
            let moved = moved.as_mut_slice();
            kd_move(i, &level, &owners, &splits, orders_flat, &flags, &sums, &[0], moved);
        }
        let expected = [[0, 1, 2, 4, 5, 6, 3, 8, 7, 9], [2, 1, 0, 6, 4, 5, 3, 8, 9, 7], [1, 0, 2, 5, 6, 4, 3, 8, 9, 7]];
        assert_eq!(moved, expected.as_flattened());
    }

    #[test]
    fn children_are_handed_out_as_their_photons_are() {
        let level = KdLevel { photons: 100, nodes: 2, roots: 3, ..KdLevel::default() };
        let child = |begin, photons| KdLarge { begin, photons, place: 3 * begin, ..KdLarge::default() };
        let children = [child(0, 40), child(40, 2), child(42, 32), child(74, 33)];
        let (mut next, mut roots) = (vec![KdLarge::default(); 2], vec![KdSmall::default(); 5]);
        for i in 0..5 {
            let (next, roots) = (next.as_mut_slice(), roots.as_mut_slice());
            kd_hand_out(i, &level, &children, &[1, 0, 0, 1], &[0, 1, 1, 1], &[0], next, roots);
        }
        assert_eq!(next, [children[0], children[3]]);
        let root = |begin, set| KdSmall { begin, set, place: 3 * begin };
        assert_eq!(roots, [[KdSmall::default(); 3].to_vec(), vec![root(40, 0b11), root(42, u32::MAX)]].concat());
    }
}
