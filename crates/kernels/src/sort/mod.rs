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

    fn keys(count: u32) -> Vec<u32> {
        (0..count).map(|i| pcg4d([i, 1, 2, 3])[0]).collect()
    }

    #[test]
    fn a_digit_is_four_bits() {
        let digits: Vec<u32> = (0..8).map(|i| digit(0x8765_4321, i * DIGIT_BITS)).collect();
        assert_eq!(digits, [1, 2, 3, 4, 5, 6, 7, 8]);
    }

    #[test]
    fn every_digit_of_every_block_is_counted_in_digit_major_order() {
        for count in [1, 16, 4095, 4096, 4097, 10_000] {
            let keys = keys(count);
            let pass = RadixPass { count, blocks: count.div_ceil(SORT_BLOCK), shift: 8, values_are_indices: 1 };
            let mut expected = vec![0; (DIGITS * pass.blocks) as usize];
            for (i, &key) in (0..).zip(&keys) {
                expected[(digit(key, 8) * pass.blocks + i / SORT_BLOCK) as usize] += 1;
            }
            for order in &orders() {
                let mut histogram = vec![u32::MAX; expected.len()];
                // A workgroup too many, which must do nothing; registers and shared memory start with rubbish.
                for group in 0..=pass.blocks {
                    let mut lanes = Workgroup { registers: &mut [[7; 16]; 256], order };
                    radix_count(&mut lanes, group, &mut [9; 4096], &pass, &keys, histogram.as_mut_slice());
                }
                assert_eq!(histogram, expected, "{count} keys");
            }
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
                let mut lanes = Workgroup { registers: &mut [[7; 2]; 256], order };
                let (sums, totals) = (sums.as_mut_slice(), totals.as_mut_slice());
                scan_rows(&mut lanes, group, &mut [9; 512], &params, &input, sums, totals);
            }
            assert!(sums == expected && totals == expected_totals);
        }
    }

    #[test]
    fn a_pass_moves_every_pair_to_its_place_and_keeps_the_order_of_equal_digits() {
        for (count, values_are_indices) in [(1, 1), (4097, 1), (9000, 0)] {
            let keys = keys(count);
            let values: Vec<u32> = (0..count).map(|i| 1_000_000 - i).collect();
            let pass = RadixPass { count, blocks: count.div_ceil(SORT_BLOCK), shift: 4, values_are_indices };
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
            let value = |i: u32| if values_are_indices == 1 { i } else { values[i as usize] };
            let mut expected: Vec<(u32, u32)> = (0..count).map(|i| (keys[i as usize], value(i))).collect();
            expected.sort_by_key(|&(key, _)| digit(key, 4));
            for order in &orders() {
                let (mut keys_out, mut values_out) = (vec![0; count as usize], vec![u32::MAX; count as usize]);
                for group in 0..=pass.blocks {
                    let mut lanes = Workgroup { registers: &mut [[7; 16]; 256], order };
                    let (k, v) = (keys_out.as_mut_slice(), values_out.as_mut_slice());
                    radix_scatter(&mut lanes, group, &mut [9; 4608], &pass, &keys, &values, &offsets, &totals, k, v);
                }
                let found: Vec<_> = keys_out.into_iter().zip(values_out).collect();
                assert!(found == expected, "{count} keys");
            }
        }
    }
}
