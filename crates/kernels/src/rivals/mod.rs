//! Other ways to find photons, those that the thesis compares with its own (sections 2.2, 2.3 and 4.3).
//!
//! They return what a photon map returns: the k nearest within a radius, ordered by (squared distance, index of the photon).

mod brute;
mod cells;
mod estimate;
mod jensen;
pub mod kd;

pub use brute::{
    BRUTE_TILE, BruteParams, BruteTile, brute_comb_sort, brute_copy, brute_distance, brute_insertion_sort,
};
pub use cells::{CELLS_LANES, CellsRegisters, cells_neighbours, cells_words};
pub use estimate::estimate_of_neighbours;
pub use jensen::{jensen_neighbours, jensen_word};
pub use kd::{
    KdLarge, KdLevel, KdRadius, KdSmall, KdSplit, kd_begin, kd_classify, kd_compact, kd_hand_out, kd_keys,
    kd_list_sides, kd_masks, kd_members, kd_move, kd_nearest, kd_radius, kd_range, kd_split_large, kd_split_small,
};

use bytemuck::{Pod, Zeroable};

/// Parameters of a search among photons.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SearchParams {
    /// Number of queries.
    pub queries: u32,
    /// Neighbours sought a query, k.
    pub k: u32,
    /// Number of photons.
    pub photons: u32,
    /// Largest squared distance of a neighbour, m².
    pub radius2: f32,
}
