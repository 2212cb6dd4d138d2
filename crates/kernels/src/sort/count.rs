//! First stage of a radix pass: how often each digit occurs in each block.

use super::block::{BlockRegisters, SUBGROUPS, count_digits, for_items};
use super::{DIGITS, RadixPass, SORT_BLOCK, digit};
use crate::exec::{Input, Store, Turns};

/// Shared memory for counters of 8 subgroups. A GPU runs as many workgroups at once as fit its shared memory.
pub type CountShared = [u32; 2048];
/// For 16 subgroups.
pub type NarrowCountShared = [u32; 4096];

/// Counts the digits of block `group` into `histogram[digit · blocks + block]`.
///
/// Digit-major order makes the exclusive prefix sum over the whole table the place where each block's run of each digit
/// begins in the output.
#[inline]
pub fn radix_count<const N: usize, const W: usize, L: Turns<BlockRegisters<N>>, H: Store<u32> + ?Sized>(
    lanes: &mut L,
    group: u32,
    shared: &mut [u32; W],
    pass: &RadixPass,
    keys: &Input<u32>,
    histogram: &mut H,
) {
    if group >= pass.blocks {
        return;
    }
    let first = group * SORT_BLOCK;
    let size = if pass.count - first < SORT_BLOCK { pass.count - first } else { SORT_BLOCK };
    if lanes.lanes() == 1 {
        // With nobody beside it, a lane counts as it reads.
        lanes.each(shared, move |_, _, shared: &mut [u32; W]| {
            let mut d = 0;
            while d < DIGITS {
                shared[d as usize] = 0;
                d += 1;
            }
            let mut i = first;
            while i < first + size {
                shared[digit(keys[i as usize], pass.shift) as usize] += 1;
                i += 1;
            }
            let mut d = 0;
            while d < DIGITS {
                histogram.set(d * pass.blocks + group, shared[d as usize]);
                d += 1;
            }
        });
        return;
    }
    count_digits::<N, W, L>(lanes, group, shared, pass, keys);
    let count = lanes.lanes();
    let subgroups = count >> lanes.subgroup_bits();
    lanes.each(shared, move |lane, _, shared: &mut [u32; W]| {
        let mut digit = lane;
        while digit < DIGITS {
            // What is missing in the last block was counted as the last digit.
            let mut sum = if digit == DIGITS - 1 { size.wrapping_sub(SORT_BLOCK) } else { 0 };
            for_items!(SUBGROUPS, subgroup => {
                if subgroup < subgroups {
                    sum = sum.wrapping_add(shared[(subgroup * DIGITS + digit) as usize]);
                }
            });
            histogram.set(digit * pass.blocks + group, sum);
            digit += count;
        }
    });
}
