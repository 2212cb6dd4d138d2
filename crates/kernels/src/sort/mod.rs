//! Stable least-significant-digit radix sort of `u32` keys with `u32` values: reduce, scan, scatter.
//!
//! The sort of the thesis (section 3.1.3) is that of Satish, Harris and Garland, "Designing Efficient Sorting
//! Algorithms for Manycore GPUs" (IPDPS 2009), and so is this one: four bits a pass, ranks by prefix sums in shared memory. A pass is
//! three stages, [`radix_count`], [`scan_rows`](crate::sort::scan_rows()) and [`radix_scatter`]; a key of `b` bits needs ⌈b / 4⌉ passes.
//! No stage waits for another workgroup, because forward progress between workgroups is not guaranteed.

mod count;
mod scan;
mod scatter;

pub use count::radix_count;
pub use scan::{SCAN_BLOCK, ScanParams, ScanShared, scan_rows};
pub use scatter::{ScatterRegisters, ScatterShared, radix_scatter};

use bytemuck::{Pod, Zeroable};

/// Bits of the key that one pass sorts by.
pub const DIGIT_BITS: u32 = 4;
/// Values of a digit.
pub const DIGITS: u32 = 1 << DIGIT_BITS;
/// Lanes of a sorting workgroup.
pub const SORT_LANES: u32 = 256;
/// Consecutive pairs that one lane handles.
pub const SORT_ITEMS: u32 = 16;
/// Pairs that one workgroup handles.
pub const SORT_BLOCK: u32 = SORT_LANES * SORT_ITEMS;

/// Parameters of one radix pass.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct RadixPass {
    /// Number of pairs.
    pub count: u32,
    /// Number of blocks: ⌈count / [`SORT_BLOCK`]⌉.
    pub blocks: u32,
    /// Lowest bit of the digit.
    pub shift: u32,
    /// 1 in the first pass, whose values are the indices 0, 1, 2, … and need no buffer filled with them.
    pub values_are_indices: u32,
}

/// The digit of `key` that a pass with this `shift` sorts by.
#[inline]
#[must_use]
pub fn digit(key: u32, shift: u32) -> u32 {
    (key >> shift) & (DIGITS - 1)
}
