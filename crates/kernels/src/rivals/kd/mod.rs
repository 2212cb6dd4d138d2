//! The kd-tree on the GPU (thesis, section 2.3): Zhou, Hou, Wang and Guo, "Real-time KD-tree construction on graphics hardware"
//! (2008), in the variant for photons.
//!
//! **Construction** is breadth first, a level at a time, in stages:
//!
//! * *initialisation* (`keys`): the photons sorted along each axis, three orders of one list.
//! * *large nodes* (`large`, `lists`), of more than [`KD_SMALL`] photons, in parallel over photons: empty space is cut off, then a node is
//!   split at the spatial median of its longest axis, and the three lists with it, stably. So photons of a node stay side by side, in
//!   the same place of all three lists, in order, and the box of a node is read off the ends of its lists.
//! * *small nodes* (`small`), in parallel over nodes: all splits at a photon are known beforehand as sets of 32 bits, and the cheapest by
//!   the voxel volume heuristic is taken, until every node has one photon. Lists of active nodes are compacted by a scan.
//! * *output* needs no stage of its own. Every node is split until it has one photon, so a subtree of n photons takes 3n − 2 quads
//!   whatever its shape: the size that Zhou et al. sum up bottom-up is known, and a node learns its place in preorder when its parent is
//!   split. It is written there at once (`node`).
//!
//! **Search** (`traverse`) walks the tree with a stack: for the k nearest at once (`search`), or as Zhou et al. do, who first narrow
//! down the radius by histograms (`radius`).
//!
//! # Rules for what is degenerate
//!
//! * A spatial median that f32 cannot place between two coordinates is the upper of them.
//! * A node whose photons all lie in one point, and every large node from level [`KD_MEDIAN_LEVELS`] on, is split by rank: half of its
//!   photons each, in the order of (coordinate, index) along the longest axis. So there are at most [`KD_DEPTH`] inner nodes above a
//!   photon, and a stack of as many places never overflows.
//! * Small nodes are split by rank in that order, too, so that photons in one point can be told apart.
//! * Coordinates below 2⁻⁹⁰ m count as 0 where the tree is built ([`coordinate`]).

mod keys;
mod large;
mod lists;
mod node;
mod radius;
mod search;
mod small;
mod traverse;

pub use keys::{coordinate, kd_begin, kd_keys};
pub use large::kd_split_large;
pub use lists::{kd_classify, kd_hand_out, kd_list_sides, kd_move};
pub use node::{KD_AXIS_BITS, KD_LEAF, KD_PLACE_BITS, KdInner, kd_quads};
pub use radius::{KD_CUT_SHORT, kd_radius};
pub use search::{kd_nearest, kd_range};
pub use small::{kd_compact, kd_masks, kd_members, kd_split_small};

use crate::exec::Input;
use crate::sort::SCAN_BLOCK;
use bytemuck::{Pod, Zeroable};

/// Most photons of a small node (T): a set of them is a word.
pub const KD_SMALL: u32 = 32;
/// Most photons of a tree: its quads are numbered by [`KD_PLACE_BITS`] bits.
pub const KD_MAX_PHOTONS: u32 = (1u32 << KD_PLACE_BITS).div_ceil(3);
/// Levels of large nodes that are split at a spatial median.
pub const KD_MEDIAN_LEVELS: u32 = 32;
/// Inner nodes above a photon at the most: those split at medians, those split by rank until 32 of [`KD_MAX_PHOTONS`] are left (a split
/// leaves half, rounded up), and those of a small node that always gives up a single photon.
pub const KD_DEPTH: u32 = KD_MEDIAN_LEVELS + 23 + 31;
const _: () = assert!(KD_MAX_PHOTONS <= KD_SMALL << 23);
/// Bit of an owner that tells small nodes from large ones.
pub const KD_SMALL_OWNER: u32 = 1 << 31;

/// Parameters of the stages of construction.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct KdLevel {
    /// Number of photons.
    pub photons: u32,
    /// Number of active nodes.
    pub nodes: u32,
    /// Levels above.
    pub level: u32,
    /// Small nodes that earlier levels left to the stage of small nodes.
    pub roots: u32,
    /// Radius of the queries to come (R), m.
    pub radius: f32,
}

/// A large node that is to be split.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct KdLarge {
    /// Where its photons begin in each list.
    pub begin: u32,
    /// How many it has.
    pub photons: u32,
    /// Its first quad in the tree.
    pub place: u32,
    /// Lowest corner of its cell, m: what the planes above left of space.
    pub low: [f32; 3],
    /// Highest corner of its cell, m.
    pub high: [f32; 3],
}

/// How a large node was split.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct KdSplit {
    /// Where its photons begin in each list.
    pub begin: u32,
    /// How many went left: the first so many along the axis.
    pub left: u32,
    /// Along which axis it was split.
    pub axis: u32,
}

/// A small node.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct KdSmall {
    /// Where the photons of the small root above it begin in the list of members.
    pub begin: u32,
    /// Which of those it has, a bit each.
    pub set: u32,
    /// Its first quad in the tree.
    pub place: u32,
}

/// Parameters of the search for a radius.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct KdRadius {
    /// Number of queries.
    pub queries: u32,
    /// Neighbours sought a query, k.
    pub k: u32,
    /// Number of photons.
    pub photons: u32,
    /// Histograms that are made.
    pub iterations: u32,
    /// The radius to begin with (r₀), m.
    pub radius: f32,
}

/// The set of the first `photons` (1 to 32).
#[inline]
#[must_use]
pub fn kd_first(photons: u32) -> u32 {
    u32::MAX >> (KD_SMALL - photons)
}

/// What a scan found before element `i`: its sums within blocks, and the sums of the blocks before each.
#[inline]
fn before(sums: &Input<u32>, offsets: &Input<u32>, i: u32) -> u32 {
    sums[i as usize] + offsets[(i / SCAN_BLOCK) as usize]
}
