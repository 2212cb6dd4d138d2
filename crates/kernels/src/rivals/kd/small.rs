//! The stage of small nodes: sets of photons as words.
//!
//! A small root has at most 32 photons, its members. A node below it is a set of them, a bit each. Splits are possible at members only: the
//! split at a member along an axis has those left of it that come before it in the order of (coordinate, index). These sets are known
//! before the first split ([`kd_masks`]), and a node's share of them is an AND (thesis, figure 4).

use super::node::{right_place, write_inner};
use super::{KD_SMALL_OWNER, KdLevel, KdSmall, before, coordinate};
use crate::exec::{Input, Store};
use crate::layout::{Photon, Site};
use crate::num::recip;

/// What widths are scaled by in costs, 2⁻⁸: a sum of 32 of the largest is finite.
const SCALE: f32 = 0.003_906_25;

/// Writes the member at place `i`: the photon that has it in the list along x.
#[inline]
pub fn kd_members<M: Store<Site> + ?Sized>(
    i: u32,
    level: &KdLevel,
    photons: &Input<Photon>,
    orders: &Input<u32>,
    members: &mut M,
) {
    if i < level.photons {
        let photon = orders[i as usize];
        members.set(i, Site::new(photons[photon as usize].position, photon));
    }
}

/// Writes which members of its small root come before the member at place `i`, along each axis: one axis after another.
#[inline]
pub fn kd_masks<M: Store<u32> + ?Sized>(
    i: u32,
    level: &KdLevel,
    owners: &Input<u32>,
    roots: &Input<KdSmall>,
    members: &Input<Site>,
    masks: &mut M,
) {
    if i >= level.photons {
        return;
    }
    let root = roots[(owners[i as usize] & !KD_SMALL_OWNER) as usize];
    let mine = members[i as usize];
    let mut x = 0;
    let mut y = 0;
    let mut z = 0;
    let mut bit = 0;
    while bit < root.set.count_ones() {
        let other = members[(root.begin + bit) as usize];
        x |= u32::from(comes_before(other, mine, 0)) << bit;
        y |= u32::from(comes_before(other, mine, 1)) << bit;
        z |= u32::from(comes_before(other, mine, 2)) << bit;
        bit += 1;
    }
    masks.set(i, x);
    masks.set(level.photons + i, y);
    masks.set(2 * level.photons + i, z);
}

#[inline]
fn comes_before(a: Site, b: Site, axis: usize) -> bool {
    let a_at = coordinate(a.position()[axis]);
    let b_at = coordinate(b.position()[axis]);
    a_at < b_at || (a_at == b_at && a.photon() < b.photon())
}

/// A width along an axis, scaled.
#[inline]
fn width(low: f32, high: f32) -> f32 {
    high * SCALE - low * SCALE
}

/// The cost of a split by the voxel volume heuristic (eq. 2.2), where the volume of a node is the product of its widths, each larger
/// by twice the query radius (eq. 2.3). Two of the three factors are the same in the numerator and the denominator, so what remains
/// are those of the axis that is split: `left` and `right` photons in widths `left_width` and `right_width`. `radius2` is twice the
/// radius, scaled as the widths are, and `inverse` the reciprocal of the node's own width and that together.
#[inline]
fn vvh(left: u32, right: u32, left_width: f32, right_width: f32, radius2: f32, inverse: f32) -> f32 {
    (left as f32 * (left_width + radius2) + right as f32 * (right_width + radius2)) * inverse
}

/// Splits the `i`-th active node where that costs least; of splits that cost the same, the first most balanced is taken. Writes it into the
/// tree, and says which of its photons go left, and whether it was split: a single photon is not.
#[inline]
pub fn kd_split_small<L: Store<u32> + ?Sized, P: Store<u32> + ?Sized, T: Store<Site> + ?Sized>(
    i: u32,
    level: &KdLevel,
    nodes: &Input<KdSmall>,
    members: &Input<Site>,
    masks: &Input<u32>,
    lefts: &mut L,
    is_split: &mut P,
    tree: &mut T,
) {
    if i >= level.nodes {
        return;
    }
    let node = nodes[i as usize];
    let count = node.set.count_ones();
    lefts.set(i, 0);
    is_split.set(i, 0);
    if count == 1 {
        tree.set(node.place, members[(node.begin + node.set.trailing_zeros()) as usize]);
        return;
    }
    let mut low = [f32::MAX; 3];
    let mut high = [f32::MIN; 3];
    let mut rest = node.set;
    while rest != 0 {
        let position = members[(node.begin + rest.trailing_zeros()) as usize].position();
        let mut axis = 0;
        while axis < 3 {
            let x = coordinate(position[axis]);
            low[axis] = if x < low[axis] { x } else { low[axis] };
            high[axis] = if x > high[axis] { x } else { high[axis] };
            axis += 1;
        }
        rest &= rest - 1;
    }
    let radius2 = 2.0 * SCALE * level.radius;
    let mut least = f32::MAX;
    let mut imbalance = count;
    let mut chosen = 0;
    let mut chosen_axis = 0;
    let mut plane = 0.0;
    let mut axis = 0;
    while axis < 3 {
        let from = low[axis as usize];
        let to = high[axis as usize];
        let inverse = recip(width(from, to) + radius2);
        let mut rest = node.set;
        while rest != 0 {
            let member = node.begin + rest.trailing_zeros();
            let left = node.set & masks[(axis * level.photons + member) as usize];
            let on_left = left.count_ones();
            let on_right = count - on_left;
            let at = coordinate(members[member as usize].position()[axis as usize]);
            let cost = vvh(on_left, on_right, width(from, at), width(at, to), radius2, inverse);
            let difference = on_left.abs_diff(on_right);
            if on_left > 0 && (cost < least || (cost == least && difference < imbalance)) {
                least = cost;
                imbalance = difference;
                chosen = left;
                chosen_axis = axis;
                plane = at;
            }
            rest &= rest - 1;
        }
        axis += 1;
    }
    write_inner(tree, node.place, low, high, chosen_axis, plane, chosen.count_ones(), count);
    lefts.set(i, chosen);
    is_split.set(i, 1);
}

/// Puts the children of the `i`-th active node, if it was split, into the list of the next level, without gaps (thesis, figure 5).
/// `sums` and `offsets` are the scan of `is_split`.
#[inline]
pub fn kd_compact<N: Store<KdSmall> + ?Sized>(
    i: u32,
    level: &KdLevel,
    nodes: &Input<KdSmall>,
    lefts: &Input<u32>,
    sums: &Input<u32>,
    offsets: &Input<u32>,
    next: &mut N,
) {
    if i >= level.nodes {
        return;
    }
    let left = lefts[i as usize];
    if left != 0 {
        let node = nodes[i as usize];
        let pair = 2 * before(sums, offsets, i);
        let place = right_place(node.place, left.count_ones());
        next.set(pair, KdSmall { begin: node.begin, set: left, place: node.place + 2 });
        next.set(pair + 1, KdSmall { begin: node.begin, set: node.set & !left, place });
    }
}

#[cfg(test)]
mod tests {
    use super::super::{KD_LEAF, KdInner};
    use super::*;
    use std::vec;
    use std::vec::Vec;

    fn close(found: f32, expected: f32) -> bool {
        (found / expected - 1.0).abs() < 1e-6
    }

    /// Eqs. 2.2 and 2.3 as they are written, in all three dimensions.
    fn whole_vvh(left: f32, right: f32, low: [f32; 3], high: [f32; 3], axis: usize, at: f32, radius: f32) -> f32 {
        let volume = |low: [f32; 3], high: [f32; 3]| -> f32 {
            (0..3).map(|axis| high[axis] - low[axis] + 2.0 * radius).product()
        };
        let (mut left_high, mut right_low) = (high, low);
        (left_high[axis], right_low[axis]) = (at, at);
        (left * volume(low, left_high) + right * volume(right_low, high)) / volume(low, high)
    }

    #[test]
    fn the_cost_of_a_split_is_that_of_the_thesis() {
        // A box of 4 × 1 × 1 m and a radius of ½ m, split at a quarter: 3 photons in (1 + 1)/(4 + 1), 5 in (3 + 1)/(4 + 1).
        let inverse = recip(5.0 * SCALE);
        let cost = vvh(3, 5, SCALE, 3.0 * SCALE, SCALE, inverse);
        assert!(close(cost, 26.0 / 5.0), "{cost}");
        assert!(close(whole_vvh(3.0, 5.0, [0.0; 3], [4.0, 1.0, 1.0], 0, 1.0, 0.5), 26.0 / 5.0));
        for i in 0..1000u32 {
            let random = crate::num::pcg4d([i, 4, 0, 0]).map(|x| (x >> 8) as f32 * 2f32.powi(-24));
            let (low, high) = ([-1.0, 2.0, 0.0], [random[0], 2.0 + random[1], 1e-3]);
            let at = -1.0 + random[2] * (1.0 + random[0]);
            let inverse = recip(width(low[0], high[0]) + 2.0 * SCALE * random[3]);
            let found = vvh(4, 9, width(low[0], at), width(at, high[0]), 2.0 * SCALE * random[3], inverse);
            assert!(close(found, whole_vvh(4.0, 9.0, low, high, 0, at, random[3])), "{random:?}");
        }
    }

    /// The masks of members that are one small root, at the places from 2 on.
    fn masks(positions: &[[f32; 3]]) -> (KdLevel, Vec<Site>, Vec<u32>, KdSmall) {
        let n = positions.len() as u32 + 2;
        let level = KdLevel { photons: n, nodes: 1, radius: 0.5, ..KdLevel::default() };
        let mut members = vec![Site::new([9.0; 3], 0), Site::new([9.0; 3], 1)];
        members.extend((2..).zip(positions).map(|(i, &position)| Site::new(position, i)));
        let root = KdSmall { begin: 2, set: super::super::kd_first(n - 2), place: 0 };
        let roots = [KdSmall { begin: 0, set: 3, place: 90 }, root];
        let owners: Vec<u32> = (0..n).map(|i| KD_SMALL_OWNER | u32::from(i >= 2)).collect();
        let mut masks = vec![99; 3 * n as usize];
        (0..=n).for_each(|i| kd_masks(i, &level, &owners, &roots, &members, masks.as_mut_slice()));
        (level, members, masks, root)
    }

    #[test]
    fn masks_are_the_members_before_each_and_tell_ties_apart() {
        let (level, _, masks, _) =
            masks(&[[0.0, 5.0, 1.0], [1.0, 4.0, -0.0], [2.0, 4.0, 0.0], [3.0, 3.0, 1e-40], [3.0, 4.0, -1.0]]);
        let of = |axis: usize| &masks[axis * level.photons as usize..][2..7];
        assert_eq!(of(0), [0, 0b1, 0b11, 0b111, 0b1111]);
        assert_eq!(of(1), [0b11110, 0b01000, 0b01010, 0, 0b01110]);
        assert_eq!(of(2), [0b11110, 0b10000, 0b10010, 0b10110, 0]);
        assert_eq!(masks[..2], [0, 0b1], "the other root's");
    }

    fn split(level: &KdLevel, node: KdSmall, members: &[Site], masks: &[u32]) -> (u32, u32, Vec<Site>) {
        let (mut lefts, mut is_split, mut tree) = (vec![7], vec![7], vec![Site::default(); 40]);
        for i in 0..2 {
            let (lefts, is_split) = (lefts.as_mut_slice(), is_split.as_mut_slice());
            kd_split_small(i, level, &[node], members, masks, lefts, is_split, tree.as_mut_slice());
        }
        (lefts[0], is_split[0], tree)
    }

    #[test]
    fn a_small_node_is_split_where_it_costs_least() {
        // Two crowds along y: the plane is cheapest at the first member of the larger one.
        let positions = [[0.0, 0.0, 0.0], [0.1, 9.0, 0.0], [0.2, 0.2, 0.0], [0.3, 9.1, 0.1], [0.4, 9.05, 0.0]];
        let (level, members, masks, root) = masks(&positions);
        let (left, is_split, tree) = split(&level, root, &members, &masks);
        assert_eq!((left, is_split), (0b00101, 1));
        let node = KdInner::read(&tree, 0);
        assert_eq!((node.axis, node.plane, node.left, node.right), (1, 9.0, 2, 6));
        assert_eq!((node.low, node.high), ([0.0; 3], [0.4, 9.1, 0.1]));
        // Every split costs at least as much, by the equations as they are written.
        let cost = |axis: usize, at: f32| {
            let before = positions.iter().filter(|position| position[axis] < at).count() as f32;
            whole_vvh(before, 5.0 - before, node.low, node.high, axis, at, 0.5)
        };
        for position in positions {
            for axis in 0..3 {
                let costs_less = cost(axis, position[axis]) < 0.999 * cost(1, 9.0);
                assert!(!costs_less || position[axis] == node.low[axis], "{axis} {position:?}");
            }
        }
        // A part of it: the set decides.
        let part = KdSmall { set: 0b00110, place: 20, ..root };
        let (left, _, tree) = split(&level, part, &members, &masks);
        let node = KdInner::read(&tree, 20);
        assert_eq!((left, node.left, node.right), (0b00100, 22 | KD_LEAF, 23 | KD_LEAF));
        // And one photon is no node.
        let one = KdSmall { set: 0b01000, place: 7, ..root };
        let (left, is_split, tree) = split(&level, one, &members, &masks);
        assert_eq!((left, is_split, tree[7]), (0, 0, members[5]));
    }

    #[test]
    fn photons_in_one_point_and_at_the_ends_of_all_floats_are_halved() {
        let (level, members, masks, root) = self::masks(&[[2.0; 3]; 9]);
        assert_eq!(split(&level, root, &members, &masks).0.count_ones(), 4);
        let ends: Vec<_> = (0..8).map(|i| [if i % 2 == 0 { f32::MAX } else { f32::MIN }, 0.0, 0.0]).collect();
        let (level, members, masks, root) = self::masks(&ends);
        let (left, _, _) = split(&KdLevel { radius: 1e18, ..level }, root, &members, &masks);
        assert_eq!(left, 0b1010_1010);
    }

    #[test]
    fn nodes_without_children_leave_no_gap() {
        let level = KdLevel { nodes: 3, ..KdLevel::default() };
        let node = |set, place| KdSmall { begin: 4, set, place };
        let nodes = [node(0b111, 10), node(0b1000, 30), node(0b110000, 40)];
        let mut next = vec![KdSmall::default(); 4];
        for i in 0..4 {
            kd_compact(i, &level, &nodes, &[0b101, 0, 0b100000], &[0, 1, 1], &[0], next.as_mut_slice());
        }
        assert_eq!(next, [node(0b101, 12), node(0b010, 16), node(0b100000, 42), node(0b010000, 43)]);
    }
}
