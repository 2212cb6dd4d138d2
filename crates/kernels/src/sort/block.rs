//! What counting and scattering share: a block of pairs, and who handles which of them.

use super::{DIGITS, RadixPass, SORT_BLOCK, digit};
use crate::exec::{Input, TURN_ITEMS, TURN_VALUES, Turns};

/// Does something for the items 0, 1, … of a lane, eight a turn: drivers do not unroll such loops, and what is unrolled needs no
/// memory for its registers.
macro_rules! for_items {
    ($items:expr, $item:ident => $body:block) => {
        let mut first = 0;
        while first < $items {
            for_items!(@ first, $item, $body, 0 1 2 3 4 5 6 7);
            first += 8;
        }
    };
    (@ $first:ident, $item:ident, $body:block, $($n:literal)*) => {
        $({
            let $item = $first + $n;
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
    /// For sums across lanes.
    sums: [u32; 2],
}

impl<const N: usize> Default for BlockRegisters<N> {
    #[inline]
    fn default() -> Self {
        Self { ranks: [0; N], keys: [0; N], sums: [0; 2] }
    }
}

/// Where the items of a lane are in the block: the first, and the step to the next. A subgroup's items are consecutive, and so
/// are those that its lanes handle together.
#[inline]
pub(super) fn items_of(lane: u32, subgroup_lanes: u32, items: u32) -> [u32; 2] {
    let subgroup = lane / subgroup_lanes;
    [subgroup * items * subgroup_lanes + (lane - subgroup * subgroup_lanes), subgroup_lanes]
}

/// Counts the digits of block `group` by subgroup: `shared[s · DIGITS + digit]`. Keeps each item's key, and its rank among the
/// items of its digit in its subgroup, if `KEEP` says so.
#[inline]
pub(super) fn count_digits<const KEEP: bool, const N: usize, const W: usize, L: Turns<BlockRegisters<N>>>(
    lanes: &mut L,
    group: u32,
    shared: &mut [u32; W],
    pass: &RadixPass,
    keys: &Input<u32>,
) {
    const { assert!(DIGITS == TURN_VALUES && (N as u32).is_multiple_of(TURN_ITEMS)) };
    let count = lanes.lanes();
    let subgroup_lanes = lanes.subgroup_lanes();
    lanes.each(shared, move |lane, _, shared: &mut [u32; W]| {
        let mut at = lane;
        while at < count / subgroup_lanes * DIGITS {
            shared[at as usize] = 0;
            at += count;
        }
    });
    let shift = pass.shift;
    let end = pass.count;
    let mut item = 0;
    while item < N as u32 {
        lanes.take_turns(
            shared,
            move |lane, r: &mut BlockRegisters<N>, j| {
                let [first, step] = items_of(lane, subgroup_lanes, N as u32);
                let i = group * SORT_BLOCK + first + (item + j) * step;
                let mut value = DIGITS;
                if i < end {
                    let key = keys[i as usize];
                    value = digit(key, shift);
                    if KEEP {
                        r.keys[(item + j) as usize] = key;
                    }
                }
                value
            },
            move |_, r: &mut BlockRegisters<N>, j, rank| {
                if KEEP {
                    r.ranks[(item + j) as usize] = rank;
                }
            },
        );
        item += TURN_ITEMS;
    }
    lanes.each(shared, move |_, _, _: &mut [u32; W]| {});
}

/// Replaces the [`DIGITS`] words from `at` on by their exclusive prefix sums. From `scratch` on, a word a lane is used.
#[inline]
pub(super) fn scan_digits<const N: usize, const W: usize, L: Turns<BlockRegisters<N>>>(
    lanes: &mut L,
    shared: &mut [u32; W],
    at: u32,
    scratch: u32,
) {
    // Lanes beyond the digits have none.
    let count = lanes.lanes();
    let each = if count < DIGITS { DIGITS / count } else { 1 };
    let count = DIGITS / each;
    lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut [u32; W]| {
        if lane >= count {
            return;
        }
        let mut sum = 0;
        let mut j = 0;
        while j < each {
            sum += shared[(at + lane * each + j) as usize];
            j += 1;
        }
        r.sums[0] = sum;
        shared[(scratch + lane) as usize] = sum;
    });
    // Hillis and Steele 1986, in two phases a step.
    let mut step = 1;
    while step < count {
        lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut [u32; W]| {
            r.sums[1] = if lane >= step && lane < count { shared[(scratch + lane - step) as usize] } else { 0 };
        });
        lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut [u32; W]| {
            if lane < count {
                shared[(scratch + lane) as usize] += r.sums[1];
            }
        });
        step *= 2;
    }
    lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut [u32; W]| {
        if lane >= count {
            return;
        }
        let mut sum = shared[(scratch + lane) as usize] - r.sums[0];
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
