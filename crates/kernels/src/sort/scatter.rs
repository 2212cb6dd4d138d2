//! Last stage of a radix pass: every pair to its place.

use super::block::{BlockRegisters, SUBGROUPS, count_digits, for_items, items_of, scan_words};
use super::{DIGITS, RadixPass, SORT_BLOCK, VALUES_INDICES, VALUES_NONE, digit};
use crate::exec::{Input, Store, Turns};

/// Shared memory of a scattering workgroup: counters of up to 16 subgroups and then the block in its new order …
pub type ScatterShared = [u32; 4624];
/// … where the pairs of each digit begin in the block …
const STARTS: u32 = SORT_BLOCK;
/// … and in the output …
const PLACES: u32 = STARTS + DIGITS;
/// … and a word a subgroup.
const SCRATCH: u32 = PLACES + DIGITS;

/// Writes the pairs of block `group` to their places in the order of this digit, equal digits keeping their order.
///
/// `offsets` and `digit_totals` are the outputs of [`scan_rows`](super::scan_rows()) over the histogram, a row a digit. A block
/// is put in order in shared memory before it is written, so that what lies together is written together.
#[inline]
pub fn radix_scatter<const N: usize, L: Turns<BlockRegisters<N>>, K: Store<u32> + ?Sized, V: Store<u32> + ?Sized>(
    lanes: &mut L,
    group: u32,
    shared: &mut ScatterShared,
    pass: &RadixPass,
    keys: &Input<u32>,
    values: &Input<u32>,
    offsets: &Input<u32>,
    digit_totals: &Input<u32>,
    keys_out: &mut K,
    values_out: &mut V,
) {
    if group >= pass.blocks {
        return;
    }
    if lanes.lanes() == 1 {
        one_by_one(lanes, group, shared, pass, keys, values, offsets, digit_totals, keys_out, values_out);
        return;
    }
    let count = lanes.lanes();
    let subgroup_bits = lanes.subgroup_bits();
    let subgroups = count >> subgroup_bits;
    let first = group * SORT_BLOCK;
    let size = if pass.count - first < SORT_BLOCK { pass.count - first } else { SORT_BLOCK };
    let shift = pass.shift;

    // 1. Ranks within subgroups.
    count_digits::<N, _, L>(lanes, group, shared, pass, keys);
    // 2. Where digits begin in the block, and in the output: both prefix sums at once.
    lanes.each(shared, move |lane, _, shared: &mut ScatterShared| {
        let mut digit = lane;
        while digit < 2 * DIGITS {
            let mut sum = 0;
            if digit < DIGITS {
                for_items!(SUBGROUPS, s => {
                    if s < subgroups {
                        sum += shared[(s * DIGITS + digit) as usize];
                    }
                });
            } else {
                sum = digit_totals[(digit - DIGITS) as usize];
            }
            shared[(STARTS + digit) as usize] = sum;
            digit += count;
        }
    });
    scan_words(lanes, shared, STARTS, 2 * DIGITS, SCRATCH);
    lanes.each(shared, move |lane, _, shared: &mut ScatterShared| {
        let mut digit = lane;
        while digit < 2 * DIGITS {
            if digit < DIGITS {
                // Where the pairs of each subgroup begin.
                let mut sum = shared[(STARTS + digit) as usize];
                for_items!(SUBGROUPS, s => {
                    if s < subgroups {
                        let word = (s * DIGITS + digit) as usize;
                        let inside = shared[word];
                        shared[word] = sum;
                        sum += inside;
                    }
                });
                let _ = sum;
            } else {
                let digit = digit - DIGITS;
                // The scan has added the whole block on top.
                let place =
                    shared[(PLACES + digit) as usize] - SORT_BLOCK + offsets[(digit * pass.blocks + group) as usize];
                // Minus the start: what is at i in the block goes to this plus i. It may wrap.
                shared[(PLACES + digit) as usize] = place.wrapping_sub(shared[(STARTS + digit) as usize]);
            }
            digit += count;
        }
    });
    lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut ScatterShared| {
        let table = (lane >> subgroup_bits) * DIGITS;
        for_items!(N, item => {
            r.ranks[item as usize] += shared[(table + digit(r.keys[item as usize], shift)) as usize];
        });
    });
    // 3. The keys in order, in the counters' memory.
    lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut ScatterShared| {
        for_items!(N, item => {
            shared[r.ranks[item as usize] as usize] = r.keys[item as usize];
        });
        if pass.values != VALUES_NONE {
            let [of_lane, step] = items_of(lane, subgroup_bits, N as u32);
            for_items!(N, item => {
                let i = first + of_lane + item * step;
                r.values[item as usize] = if pass.values == VALUES_INDICES {
                    i
                } else {
                    values[(if i < pass.count { i } else { pass.count - 1 }) as usize]
                };
            });
        }
    });
    lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut ScatterShared| {
        for_items!(N, item => {
            let i = item * count + lane;
            let key = shared[i as usize];
            let place = shared[(PLACES + digit(key, shift)) as usize].wrapping_add(i);
            r.keys[item as usize] = place;
            if i < size {
                keys_out.set(place, key);
            }
        });
    });
    // 4. The values after them.
    if pass.values == VALUES_NONE {
        return;
    }
    lanes.each(shared, move |_, r: &mut BlockRegisters<N>, shared: &mut ScatterShared| {
        for_items!(N, item => {
            shared[r.ranks[item as usize] as usize] = r.values[item as usize];
        });
    });
    lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut ScatterShared| {
        for_items!(N, item => {
            let i = item * count + lane;
            if i < size {
                values_out.set(r.keys[item as usize], shared[i as usize]);
            }
        });
    });
}

/// What a single lane does: with nobody beside it, pairs go to their places one after another, and ranks are how far places have
/// moved on.
#[inline]
fn one_by_one<const N: usize, L: Turns<BlockRegisters<N>>, K: Store<u32> + ?Sized, V: Store<u32> + ?Sized>(
    lanes: &mut L,
    group: u32,
    shared: &mut ScatterShared,
    pass: &RadixPass,
    keys: &Input<u32>,
    values: &Input<u32>,
    offsets: &Input<u32>,
    digit_totals: &Input<u32>,
    keys_out: &mut K,
    values_out: &mut V,
) {
    let first = group * SORT_BLOCK;
    let size = if pass.count - first < SORT_BLOCK { pass.count - first } else { SORT_BLOCK };
    lanes.each(shared, move |_, _, shared: &mut ScatterShared| {
        let mut sum = 0;
        let mut d = 0;
        while d < DIGITS {
            shared[d as usize] = sum + offsets[(d * pass.blocks + group) as usize];
            sum += digit_totals[d as usize];
            d += 1;
        }
        let mut i = first;
        while i < first + size {
            let key = keys[i as usize];
            let place = &mut shared[digit(key, pass.shift) as usize];
            keys_out.set(*place, key);
            if pass.values == VALUES_INDICES {
                values_out.set(*place, i);
            } else if pass.values != VALUES_NONE {
                values_out.set(*place, values[i as usize]);
            }
            *place += 1;
            i += 1;
        }
    });
}
