//! What counting and scattering share: a block of pairs, and who handles which of them.

use super::{DIGITS, RadixPass, SORT_BLOCK, digit};
use crate::exec::{Input, TURN_ITEMS, TURN_VALUES, Turns};

/// Most subgroups of a workgroup.
pub(super) const SUBGROUPS: u32 = 16;
/// Key in places after the last pair: it counts, comes after all others, and is not written.
const PAD: u32 = 0xffff_ffff;

/// Does something for the items 0, 1, … of a lane. It is written out for 8 and for 16 of them, which leaves nothing to index when the
/// kernel runs: drivers do not unroll such loops, and keep what they index in memory.
macro_rules! for_items {
    ($items:expr, $item:ident => $body:block) => {
        if const { $items == 8 } {
            for_items!(@ 0, $item, $body, 0 1 2 3 4 5 6 7);
        } else if const { $items == 16 } {
            for_items!(@ 0, $item, $body, 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15);
        } else {
            let mut first = 0;
            while first < $items as u32 {
                for_items!(@ first, $item, $body, 0 1 2 3 4 5 6 7);
                first += 8;
            }
        }
    };
    (@ $first:expr, $item:ident, $body:block, $($n:literal)*) => {
        $({
            let $item: u32 = $first + $n;
            $body
        })*
    };
}
pub(super) use for_items;

/// Registers of a lane that handles `N` items.
#[derive(Clone, Copy)]
pub struct BlockRegisters<const N: usize> {
    /// How many pairs of its digit come before an item in its subgroup; then its place in the block.
    pub(super) ranks: [u32; N],
    /// The keys; then where they went.
    pub(super) keys: [u32; N],
    /// The values.
    pub(super) values: [u32; N],
    /// For sums across lanes.
    sums: [u32; 2],
}

impl<const N: usize> Default for BlockRegisters<N> {
    #[inline]
    fn default() -> Self {
        Self { ranks: [0; N], keys: [0; N], values: [0; N], sums: [0; 2] }
    }
}

/// Where the items of a lane are in the block: the first, and the step to the next. A subgroup's items are consecutive, and so
/// are those that its lanes handle together.
#[inline]
pub(super) fn items_of(lane: u32, subgroup_bits: u32, items: u32) -> [u32; 2] {
    let subgroup = lane >> subgroup_bits;
    [((subgroup * (items - 1)) << subgroup_bits) + lane, 1 << subgroup_bits]
}

/// Reads the keys of block `group`, and counts their digits by subgroup: `shared[s · DIGITS + digit]`. Keeps each item's key, and its
/// rank among the items of its digit in its subgroup.
///
/// What is missing in the last block counts as [`PAD`].
#[inline]
pub(super) fn count_digits<const N: usize, const W: usize, L: Turns<BlockRegisters<N>>>(
    lanes: &mut L,
    group: u32,
    shared: &mut [u32; W],
    pass: &RadixPass,
    keys: &Input<u32>,
) {
    const { assert!(DIGITS == TURN_VALUES && (N as u32).is_multiple_of(TURN_ITEMS)) };
    let count = lanes.lanes();
    let subgroup_bits = lanes.subgroup_bits();
    let end = pass.count;
    lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut [u32; W]| {
        let [first, step] = items_of(lane, subgroup_bits, N as u32);
        let first = group * SORT_BLOCK + first;
        // All are on their way before the first is needed.
        for_items!(N, item => {
            let i = first + item * step;
            let key = keys[(if i < end { i } else { end - 1 }) as usize];
            r.keys[item as usize] = if i < end { key } else { PAD };
        });
        let mut at = lane;
        while at < (count >> subgroup_bits) * DIGITS {
            shared[at as usize] = 0;
            at += count;
        }
    });
    let shift = pass.shift;
    macro_rules! turns {
        ($first:expr) => {{
            let first: u32 = $first;
            lanes.take_turns(
                shared,
                move |_, r: &mut BlockRegisters<N>, j| digit(r.keys[(first + j) as usize], shift),
                move |_, r: &mut BlockRegisters<N>, j, rank| r.ranks[(first + j) as usize] = rank,
            );
        }};
    }
    if const { N == 8 } {
        turns!(0);
    } else if const { N == 16 } {
        turns!(0);
        turns!(8);
    } else {
        let mut item = 0;
        while item < N as u32 {
            turns!(item);
            item += TURN_ITEMS;
        }
    }
    lanes.each(shared, move |_, _, _: &mut [u32; W]| {});
}

/// Replaces `words` words from `at` on by their exclusive prefix sums. From `scratch` on, a word a subgroup is used.
#[inline]
pub(super) fn scan_words<const N: usize, const W: usize, L: Turns<BlockRegisters<N>>>(
    lanes: &mut L,
    shared: &mut [u32; W],
    at: u32,
    words: u32,
    scratch: u32,
) {
    let each = words / lanes.lanes();
    let subgroup_bits = lanes.subgroup_bits();
    lanes.running_sums(
        shared,
        move |lane, _, shared: &[u32; W]| {
            let mut sum = 0;
            let mut j = 0;
            while j < each {
                sum += shared[(at + lane * each + j) as usize];
                j += 1;
            }
            sum
        },
        move |_, r: &mut BlockRegisters<N>, before, value| r.sums = [before, before + value],
    );
    lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut [u32; W]| {
        // The last lane of a subgroup.
        if (lane + 1) & ((1 << subgroup_bits) - 1) == 0 {
            shared[(scratch + (lane >> subgroup_bits)) as usize] = r.sums[1];
        }
    });
    lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut [u32; W]| {
        let mut sum = r.sums[0];
        for_items!(SUBGROUPS, subgroup => {
            if subgroup < lane >> subgroup_bits {
                sum += shared[(scratch + subgroup) as usize];
            }
        });
        let mut j = 0;
        while j < each {
            let word = (at + lane * each + j) as usize;
            let count = shared[word];
            shared[word] = sum;
            sum += count;
            j += 1;
        }
    });
}
