//! Brute force (thesis, section 2.2): Garcia, Debreuve and Barlaud, "Fast k Nearest Neighbor Search using GPU", 2008.
//!
//! Three stages, the rows of the thesis's table 3: all distances between queries and photons are put in a matrix, each column of it, which is a
//! query's, is sorted, and the first k are copied out. The matrix has a row a photon: lanes have a query each, so that those of
//! a subgroup lie side by side in a row, whatever row each of them is at.
//!
//! Columns are sorted where they lie, as Garcia's program does it: a lane owns its column and reads and writes nothing else
//! ([`Update`](crate::exec::Update)). Passes from one matrix to another would have been a second matrix and another algorithm.

mod copy;
mod distance;
mod sort;

pub use copy::brute_copy;
pub use distance::{BruteTile, brute_distance};
pub use sort::{brute_comb_sort, brute_insertion_sort};

use bytemuck::{Pod, Zeroable};

/// Lanes of a workgroup that fills a part of the matrix: as many queries, and as many photons.
pub const BRUTE_TILE: u32 = 256;

/// Parameters of the stages of brute force, for as many queries as the matrix has columns.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct BruteParams {
    /// The query of the first column.
    pub first: u32,
    /// Number of queries from that on.
    pub queries: u32,
    /// Columns of the matrix: queries at most.
    pub columns: u32,
    /// Number of photons: rows of the matrix.
    pub photons: u32,
    /// Neighbours sought a query, k.
    pub k: u32,
    /// Largest squared distance of a neighbour, m². It leaves out what was sorted and saves no work, as the thesis found (section 5.4).
    pub radius2: f32,
}

/// The smaller of two numbers.
#[inline]
fn least(a: u32, b: u32) -> u32 {
    if a < b { a } else { b }
}
