//! First stage of a radix pass: how often each digit occurs in each block.

use super::{DIGITS, RadixPass, SORT_BLOCK, SORT_ITEMS, digit};
use crate::exec::{Lanes, Store};

/// Counts the digits of block `group` into `histogram[digit · blocks + block]`.
///
/// Digit-major order makes the exclusive prefix sum over the whole table the place where each block's run of each digit
/// begins in the output.
#[inline]
pub fn radix_count<L: Lanes<[u32; 16]>, H: Store<u32> + ?Sized>(
    lanes: &mut L,
    group: u32,
    shared: &mut [u32; 4096],
    pass: &RadixPass,
    keys: &[u32],
    histogram: &mut H,
) {
    if group >= pass.blocks {
        return;
    }
    // A lane counts its own items in registers, so that no atomics are needed …
    lanes.each(shared, move |lane, counts: &mut [u32; 16], shared: &mut [u32; 4096]| {
        let mut d = 0;
        while d < DIGITS {
            counts[d as usize] = 0;
            d += 1;
        }
        let first = group * SORT_BLOCK + lane * SORT_ITEMS;
        let mut item = 0;
        while item < SORT_ITEMS {
            let i = first + item;
            if i < pass.count {
                counts[digit(keys[i as usize], pass.shift) as usize] += 1;
            }
            item += 1;
        }
        d = 0;
        while d < DIGITS {
            shared[(d * 256 + lane) as usize] = counts[d as usize];
            d += 1;
        }
    });
    // … then 256 lanes sum 16 runs of 256 counters: first 16 lanes a digit, then one.
    lanes.each(shared, move |lane, counts: &mut [u32; 16], shared: &mut [u32; 4096]| {
        let mut sum = 0;
        let mut j = 0;
        while j < 16 {
            sum += shared[(lane * 16 + j) as usize];
            j += 1;
        }
        counts[0] = sum;
    });
    lanes.each(shared, move |lane, counts: &mut [u32; 16], shared: &mut [u32; 4096]| {
        shared[lane as usize] = counts[0];
    });
    lanes.each(shared, move |lane, _, shared: &mut [u32; 4096]| {
        if lane < DIGITS {
            let mut sum = 0;
            let mut j = 0;
            while j < 16 {
                sum += shared[(lane * 16 + j) as usize];
                j += 1;
            }
            histogram.set(lane * pass.blocks + group, sum);
        }
    });
}
