//! The stage of large nodes: where each is split.
//!
//! A node has a cell, what the planes above it left of space, and a box, the tightest around its photons. Where more than a quarter
//! of the cell's extent along an axis is empty at one side, the cell ends at the box there ("cutting off empty space", Havran,
//! "Heuristic Ray Shooting Algorithms", 2000; Zhou et al. take the quarter). Zhou et al. cut for triangles by a node with an empty
//! child; here the box is stored with every node, so a smaller cell is all there is to it. Sides are cut until none is left to cut,
//! and so at least half the cell's extent along each axis is the box's: the spatial median of the longest axis has photons on both
//! sides.

use super::node::{right_place, write_inner};
use super::{KD_MEDIAN_LEVELS, KD_SMALL, KdLarge, KdLevel, KdSplit, coordinate};
use crate::exec::{Input, Store};
use crate::layout::{Photon, Site};

/// Share of an extent that may be empty at a side.
const MOST_EMPTY: f32 = 0.25;

/// Splits the `i`-th active node: says how, writes it into the tree, and its children with whether they are large.
#[inline]
pub fn kd_split_large<
    P: Store<KdSplit> + ?Sized,
    C: Store<KdLarge> + ?Sized,
    L: Store<u32> + ?Sized,
    T: Store<Site> + ?Sized,
>(
    i: u32,
    level: &KdLevel,
    photons: &Input<Photon>,
    orders: &Input<u32>,
    nodes: &Input<KdLarge>,
    splits: &mut P,
    children: &mut C,
    is_large: &mut L,
    tree: &mut T,
) {
    if i >= level.nodes {
        return;
    }
    let node = nodes[i as usize];
    let mut cell_low = node.low;
    let mut cell_high = node.high;
    let mut low = [0.0; 3];
    let mut high = [0.0; 3];
    let mut longest = 0;
    let mut axis = 0;
    while axis < 3 {
        let first = axis * level.photons + node.begin;
        low[axis as usize] = along(axis, first, photons, orders);
        high[axis as usize] = along(axis, first + node.photons - 1, photons, orders);
        let a = axis as usize;
        [cell_low[a], cell_high[a]] = cut(cell_low[a], cell_high[a], low[a], high[a]);
        let l = longest as usize;
        if half_extent(cell_low[a], cell_high[a]) > half_extent(cell_low[l], cell_high[l]) {
            longest = axis;
        }
        axis += 1;
    }
    let a = longest as usize;
    let first = longest * level.photons + node.begin;
    let mut left = node.photons / 2;
    let mut plane = along(longest, first + left, photons, orders);
    if level.level < KD_MEDIAN_LEVELS && low[a] < high[a] {
        plane = median(cell_low[a], cell_high[a], low[a], high[a]);
        left = below(plane, longest, first, node.photons, photons, orders);
    }
    let right = node.photons - left;
    write_inner(tree, node.place, low, high, longest, plane, left, node.photons);
    splits.set(i, KdSplit { begin: node.begin, left, axis: longest });
    let mut left_high = cell_high;
    left_high[a] = plane;
    let place = node.place + 2;
    children.set(2 * i, KdLarge { begin: node.begin, photons: left, place, low: cell_low, high: left_high });
    is_large.set(2 * i, u32::from(left > KD_SMALL));
    let mut right_low = cell_low;
    right_low[a] = plane;
    let place = right_place(node.place, left);
    let begin = node.begin + left;
    children.set(2 * i + 1, KdLarge { begin, photons: right, place, low: right_low, high: cell_high });
    is_large.set(2 * i + 1, u32::from(right > KD_SMALL));
}

/// A coordinate of the photon at a place of the orders, m.
#[inline]
fn along(axis: u32, place: u32, photons: &Input<Photon>, orders: &Input<u32>) -> f32 {
    coordinate(photons[orders[place as usize] as usize].position[axis as usize])
}

/// Half of an extent, m, which is finite between any floats.
#[inline]
fn half_extent(low: f32, high: f32) -> f32 {
    high * 0.5 - low * 0.5
}

/// What is left of a cell's extent along an axis once its empty sides are cut off, of photons from `low` to `high`. Cutting one side
/// raises the share that is empty at the other, so each has its turn twice.
#[inline]
fn cut(mut cell_low: f32, mut cell_high: f32, low: f32, high: f32) -> [f32; 2] {
    let mut turn = 0;
    while turn < 2 {
        let most = half_extent(cell_low, cell_high) * MOST_EMPTY;
        if half_extent(cell_low, low) > most {
            cell_low = low;
        }
        let most = half_extent(cell_low, cell_high) * MOST_EMPTY;
        if half_extent(high, cell_high) > most {
            cell_high = high;
        }
        turn += 1;
    }
    [cell_low, cell_high]
}

/// The spatial median of a cell, or where no photon would be left or right of it, the highest coordinate, which differs from the lowest.
#[inline]
fn median(cell_low: f32, cell_high: f32, low: f32, high: f32) -> f32 {
    let middle = cell_low * 0.5 + cell_high * 0.5;
    if middle > low && middle <= high { middle } else { high }
}

/// How many of the `count` photons from place `first` of the orders on lie before a plane: they are in order along the axis.
#[inline]
fn below(plane: f32, axis: u32, first: u32, count: u32, photons: &Input<Photon>, orders: &Input<u32>) -> u32 {
    let mut low = 0;
    let mut high = count;
    while low < high {
        let middle = (low + high) / 2;
        if along(axis, first + middle, photons, orders) < plane {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::super::KdInner;
    use super::*;
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn empty_sides_beyond_a_quarter_are_cut_until_none_is_left() {
        assert_eq!(cut(0.0, 1.0, 0.25, 0.75), [0.0, 1.0], "a quarter each");
        assert_eq!(cut(0.0, 1.0, 0.26, 0.9), [0.26, 1.0], "the lower side; of what is left the upper is 0.14");
        assert_eq!(cut(0.0, 1.0, 0.2, 0.3), [0.2, 0.3], "the upper side, and then the lower is too large");
        assert_eq!(cut(-3e38, 3e38, 1.0, 1.0), [1.0, 1.0]);
        assert_eq!(cut(0.0, 0.0, 0.0, 0.0), [0.0, 0.0]);
        for i in 0..1000u32 {
            let random = crate::num::pcg4d([i, 0, 0, 1]).map(|x| (x >> 8) as f32 - 8e6);
            let mut x = [random[0], random[1], random[2], random[3]];
            x.sort_by(f32::total_cmp);
            let [low, high] = cut(x[0], x[3], x[1], x[2]);
            assert!(x[2] - x[1] >= 0.4999 * (high - low), "half of it is the box's: {x:?}");
        }
    }

    #[test]
    fn a_median_has_photons_on_both_sides() {
        assert_eq!(median(0.0, 1.0, 0.1, 0.9), 0.5);
        assert_eq!(median(f32::MIN, f32::MAX, f32::MIN, f32::MAX), 0.0);
        // Neighbouring floats, and a median that is no coordinate between them.
        let next = 1.0f32.next_up();
        assert_eq!(median(1.0, next, 1.0, next), next);
        assert_eq!(median(0.0, 1.0, 0.6, 0.9), 0.9);
    }

    /// Splits one node of photons along x (and in one place of the other axes); returns the split, its children and the tree.
    fn split(xs: &[f32], level: u32) -> (KdSplit, Vec<KdLarge>, Vec<u32>, KdInner) {
        let photons: Vec<_> = xs.iter().map(|&x| Photon { position: [x, -1.0, -0.0], ..Photon::default() }).collect();
        let n = xs.len() as u32;
        let mut order: Vec<u32> = (0..n).collect();
        order.sort_by(|&a, &b| xs[a as usize].total_cmp(&xs[b as usize]));
        let orders: Vec<u32> = order.iter().copied().chain(0..n).chain(0..n).collect();
        let level = KdLevel { photons: n, nodes: 1, level, ..KdLevel::default() };
        let root = KdLarge { begin: 0, photons: n, place: 0, low: [0.0, -1.0, 0.0], high: [10.0, -1.0, 0.0] };
        let (mut splits, mut children) = (vec![KdSplit::default()], vec![KdLarge::default(); 2]);
        let (mut is_large, mut tree) = (vec![7; 2], vec![Site::default(); 2]);
        for i in 0..2 {
            let (splits, children) = (splits.as_mut_slice(), children.as_mut_slice());
            let (is_large, tree) = (is_large.as_mut_slice(), tree.as_mut_slice());
            kd_split_large(i, &level, &photons, &orders, &[root], splits, children, is_large, tree);
        }
        (splits[0], children, is_large, KdInner::read(&tree, 0))
    }

    #[test]
    fn a_large_node_is_split_at_the_spatial_median_of_what_is_not_empty() {
        // 40 photons from 0 to 3.9: what lies above is cut off, and the median is 1.95.
        let xs: Vec<f32> = (0..40).map(|i| i as f32 * 0.1).collect();
        let (split, children, is_large, node) = self::split(&xs, 0);
        assert_eq!(split, KdSplit { begin: 0, left: 20, axis: 0 });
        assert_eq!((node.plane, node.axis, node.right), (0.5 * xs[39], 0, 60));
        assert_eq!((node.low, node.high), ([0.0, -1.0, 0.0], [xs[39], -1.0, 0.0]));
        let expected = [(0, 20, 2, 0.0, node.plane), (20, 20, 60, node.plane, xs[39])];
        let found = children.iter().map(|c| (c.begin, c.photons, c.place, c.low[0], c.high[0]));
        assert!(found.eq(expected), "{children:?}");
        assert_eq!(is_large, [0, 0]);
        // One far away: 39 are left of the median, too many for a small node.
        let xs: Vec<f32> = (0..39).map(|i| i as f32 * 0.01).chain([9.0]).collect();
        let (split, _, is_large, node) = self::split(&xs, 0);
        assert_eq!((split.left, node.plane, is_large), (39, 5.0, vec![1, 0]));
    }

    #[test]
    fn photons_in_one_point_and_deep_levels_are_split_by_rank() {
        let (split, _, _, node) = self::split(&[4.0; 41], 0);
        assert_eq!((split.left, node.plane, node.low[0], node.high[0]), (20, 4.0, 4.0, 4.0));
        let xs: Vec<f32> = (0..39).map(|i| i as f32 * 0.01).chain([9.0]).collect();
        assert_eq!(self::split(&xs, KD_MEDIAN_LEVELS - 1).0.left, 39);
        let (split, _, _, node) = self::split(&xs, KD_MEDIAN_LEVELS);
        assert_eq!((split.left, node.plane), (20, xs[20]));
    }
}
