//! Stable least-significant-digit radix sort of `u32` keys, with `u32` values or alone: reduce, scan, scatter.
//!
//! The sort of the thesis (section 3.1.3) is that of Satish, Harris and Garland, "Designing Efficient Sorting Algorithms for
//! Manycore GPUs" (IPDPS 2009): ranks in shared memory, blocks put in order there before they are written. This one takes eight
//! bits a pass and ranks by ballots (Ashkiani et al., "GPU Multisplit", 2016; Merrill and Garland, "Single-pass Parallel Prefix
//! Scan…", 2016, and "Onesweep", 2022, for the costs). A pass is three stages, [`radix_count`],
//! [`scan_rows`](crate::sort::scan_rows()) and [`radix_scatter`]; a key of `b` bits needs ⌈b / 8⌉ passes. No stage waits for
//! another workgroup, because forward progress between workgroups is not guaranteed.

mod block;
mod count;
mod scan;
mod scatter;

pub use block::BlockRegisters;
pub use count::{CountShared, NarrowCountShared, radix_count};
pub use scan::{SCAN_BLOCK, SCAN_LANES, ScanParams, ScanRegisters, ScanShared, scan_rows};
pub use scatter::{ScatterShared, radix_scatter};

use bytemuck::{Pod, Zeroable};

/// Bits of the key that one pass sorts by.
pub const DIGIT_BITS: u32 = 8;
/// Values of a digit.
pub const DIGITS: u32 = 1 << DIGIT_BITS;
/// Pairs that one workgroup handles.
pub const SORT_BLOCK: u32 = 4096;

/// [`RadixPass::values`]: keys alone.
pub const VALUES_NONE: u32 = 0;
/// [`RadixPass::values`]: those of the buffer.
pub const VALUES_GIVEN: u32 = 1;
/// [`RadixPass::values`]: 0, 1, 2, …, so that the first pass needs no buffer filled with them.
pub const VALUES_INDICES: u32 = 2;

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
    /// [`VALUES_NONE`], [`VALUES_GIVEN`] or [`VALUES_INDICES`].
    pub values: u32,
}

/// The digit of `key` that a pass with this `shift` sorts by.
#[inline]
#[must_use]
pub fn digit(key: u32, shift: u32) -> u32 {
    (key >> shift) & (DIGITS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::Workgroup;
    use crate::num::pcg4d;
    use std::vec;
    use std::vec::Vec;

    /// Lanes forward, reversed and in strides.
    fn orders() -> [Vec<u32>; 3] {
        [(0..256).collect(), (0..256).rev().collect(), (0..256).map(|i| i * 37 % 256).collect()]
    }

    /// Lanes, subgroups of them, and an order: as GPUs and the CPU have them.
    macro_rules! on_all_shapes {
        ($lanes:ident => $body:block) => {
            on_all_shapes!($lanes, 8, 32, $body);
            on_all_shapes!($lanes, 16, 32, $body);
            on_all_shapes!($lanes, 16, 64, $body);
            on_all_shapes!($lanes, 32, 8, $body);
            on_all_shapes!($lanes, 32, 128, $body);
            on_all_shapes!($lanes, 256, 1, $body);
            on_all_shapes!($lanes, 4096, 1, $body);
        };
        ($lanes:ident, $items:expr, $subgroup:expr, $body:block) => {
            for stride in [1, 3, 4095] {
                let count = SORT_BLOCK / $items;
                let order: Vec<u32> = (0..count).map(|i| (i * stride + stride / 2) % count).collect();
                let mut registers = vec![BlockRegisters::<$items>::default(); count as usize];
                let $lanes = &mut Workgroup { registers: &mut registers, order: &order, subgroup_lanes: $subgroup };
                $body
            }
        };
    }

    fn keys(count: u32) -> Vec<u32> {
        (0..count).map(|i| pcg4d([i, 1, 2, 3])[0]).collect()
    }

    #[test]
    fn a_digit_is_eight_bits() {
        let digits: Vec<u32> = (0..4).map(|i| digit(0x8765_4321, i * DIGIT_BITS)).collect();
        assert_eq!(digits, [0x21, 0x43, 0x65, 0x87]);
    }

    #[test]
    fn every_digit_of_every_block_is_counted_in_digit_major_order() {
        for count in [1, 16, 4095, 4096, 4097, 10_000] {
            let keys = keys(count);
            let pass = RadixPass { count, blocks: count.div_ceil(SORT_BLOCK), shift: 8, values: VALUES_INDICES };
            let mut expected = vec![0; (DIGITS * pass.blocks) as usize];
            for (i, &key) in (0..).zip(&keys) {
                expected[(digit(key, 8) * pass.blocks + i / SORT_BLOCK) as usize] += 1;
            }
            on_all_shapes!(lanes => {
                let mut histogram = vec![u32::MAX; expected.len()];
                // A workgroup too many, which must do nothing; shared memory starts with rubbish.
                for group in 0..=pass.blocks {
                    radix_count(lanes, group, &mut [9; 4096], &pass, &keys, histogram.as_mut_slice());
                }
                assert_eq!(histogram, expected, "{count} keys");
            });
        }
    }

    #[test]
    fn sums_wrap_and_each_row_has_its_own() {
        // Rows of 5000 elements, more than a block, the last with 10; sums pass 2³² many times.
        let params = ScanParams { count: 10_010, row_length: 5000 };
        let input = keys(10_010);
        let (mut expected, mut expected_totals) = (vec![], vec![]);
        for row in input.chunks(5000) {
            let mut sum = 0u32;
            for &x in row {
                expected.push(sum);
                sum = sum.wrapping_add(x);
            }
            expected_totals.push(sum);
        }
        for order in &orders() {
            let (mut sums, mut totals) = (vec![0; 10_010], vec![0; 3]);
            for group in 0..4 {
                let mut lanes = Workgroup { registers: &mut [ScanRegisters::default(); 256], order, subgroup_lanes: 1 };
                let (sums, totals) = (sums.as_mut_slice(), totals.as_mut_slice());
                scan_rows(&mut lanes, group, &mut [9; 512], &params, &input, sums, totals);
            }
            assert!(sums == expected && totals == expected_totals);
        }
    }

    #[test]
    fn a_pass_moves_every_pair_to_its_place_and_keeps_the_order_of_equal_digits() {
        for (count, kind) in [(1, VALUES_INDICES), (4097, VALUES_INDICES), (9000, VALUES_GIVEN), (5000, VALUES_NONE)] {
            let keys = keys(count);
            let values: Vec<u32> = (0..count).map(|i| 1_000_000 - i).collect();
            let pass = RadixPass { count, blocks: count.div_ceil(SORT_BLOCK), shift: 4, values: kind };
            // What counting and scanning give, written out.
            let mut histogram = vec![0; (DIGITS * pass.blocks) as usize];
            for (i, &key) in (0..).zip(&keys) {
                histogram[(digit(key, 4) * pass.blocks + i / SORT_BLOCK) as usize] += 1;
            }
            let (mut offsets, mut totals) = (vec![], vec![]);
            for row in histogram.chunks(pass.blocks as usize) {
                offsets.extend((0..row.len()).map(|block| row[..block].iter().sum::<u32>()));
                totals.push(row.iter().sum::<u32>());
            }
            let value = |i: u32| match kind {
                VALUES_INDICES => i,
                VALUES_GIVEN => values[i as usize],
                _ => u32::MAX,
            };
            let mut expected: Vec<(u32, u32)> = (0..count).map(|i| (keys[i as usize], value(i))).collect();
            expected.sort_by_key(|&(key, _)| digit(key, 4));
            on_all_shapes!(lanes => {
                let (mut keys_out, mut values_out) = (vec![0; count as usize], vec![u32::MAX; count as usize]);
                for group in 0..=pass.blocks {
                    let (k, v) = (keys_out.as_mut_slice(), values_out.as_mut_slice());
                    radix_scatter(lanes, group, &mut [9; 4624], &pass, &keys, &values, &offsets, &totals, k, v);
                }
                let found: Vec<_> = keys_out.into_iter().zip(values_out).collect();
                assert!(found == expected, "{count} keys");
            });
        }
    }
}
