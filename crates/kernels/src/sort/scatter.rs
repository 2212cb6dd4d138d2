//! Last stage of a radix pass: every pair to its place.

use super::{DIGITS, RadixPass, SORT_BLOCK, SORT_ITEMS, SORT_LANES, digit};
use crate::exec::{Lanes, Store};

/// Shared memory of [`radix_scatter`]: a counter for each (digit, lane), then two copies of 256 partial sums.
pub type ScatterShared = [u32; 4608];
/// Registers of a lane: 16 running counters, one a digit.
pub type ScatterRegisters = [u32; 16];

const SUMS: u32 = DIGITS * SORT_LANES;

/// Writes the pairs of block `group` to their places in the order of this digit, equal digits keeping their order.
///
/// `offsets` and `digit_totals` are the outputs of [`scan_rows`](super::scan_rows()) over the histogram, a row a digit.
#[inline]
pub fn radix_scatter<L: Lanes<ScatterRegisters>, K: Store<u32> + ?Sized, V: Store<u32> + ?Sized>(
    lanes: &mut L,
    group: u32,
    shared: &mut ScatterShared,
    pass: &RadixPass,
    keys: &[u32],
    values: &[u32],
    offsets: &[u32],
    digit_totals: &[u32],
    keys_out: &mut K,
    values_out: &mut V,
) {
    if group >= pass.blocks {
        return;
    }
    // 1. Each lane counts the digits of its own consecutive items.
    lanes.each(shared, move |lane, counts: &mut ScatterRegisters, shared: &mut ScatterShared| {
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
            shared[(d * SORT_LANES + lane) as usize] = counts[d as usize];
            d += 1;
        }
    });
    // 2. Exclusive prefix sums along each digit's 256 counters: sixteen lanes a digit, sixteen counters a lane.
    lanes.each(shared, move |lane, _, shared: &mut ScatterShared| {
        let mut sum = 0;
        let mut j = 0;
        while j < 16 {
            let at = (lane * 16 + j) as usize;
            let count = shared[at];
            shared[at] = sum;
            sum += count;
            j += 1;
        }
        shared[(SUMS + lane) as usize] = sum;
    });
    lanes.each(shared, move |lane, _, shared: &mut ScatterShared| {
        // The sums of the lanes before this one that serve the same digit.
        let mut before = 0;
        let mut other = lane - lane % 16;
        while other < lane {
            before += shared[(SUMS + other) as usize];
            other += 1;
        }
        shared[(SUMS + SORT_LANES + lane) as usize] = before;
    });
    // 3. Where each digit's run of this lane begins in the output, then the items in order.
    lanes.each(shared, move |lane, next: &mut ScatterRegisters, shared: &mut ScatterShared| {
        let mut smaller_digits = 0;
        let mut d = 0;
        while d < DIGITS {
            let in_block =
                shared[(d * SORT_LANES + lane) as usize] + shared[(SUMS + SORT_LANES + d * 16 + lane / 16) as usize];
            next[d as usize] = smaller_digits + offsets[(d * pass.blocks + group) as usize] + in_block;
            smaller_digits += digit_totals[d as usize];
            d += 1;
        }
        let first = group * SORT_BLOCK + lane * SORT_ITEMS;
        let mut item = 0;
        while item < SORT_ITEMS {
            let i = first + item;
            if i < pass.count {
                let key = keys[i as usize];
                let mut value = i;
                if pass.values_are_indices == 0 {
                    value = values[i as usize];
                }
                let d = digit(key, pass.shift) as usize;
                let place = next[d];
                next[d] = place + 1;
                keys_out.set(place, key);
                values_out.set(place, value);
            }
            item += 1;
        }
    });
}
