//! What counting and scattering share: a block of pairs, and who handles which of them.

use super::{DIGITS, RadixPass, SORT_BLOCK, digit};
use crate::exec::{TURN_VALUES, Turns};

/// Most subgroups of a sorting workgroup: for each there is a counter a digit.
pub const MAX_SUBGROUPS: u32 = 16;
/// Words of shared memory for counters; afterwards, for the block in its new order.
const COUNTERS: u32 = MAX_SUBGROUPS * DIGITS;
/// Where the block's pairs of each digit begin in the block …
pub(super) const STARTS: u32 = COUNTERS;
/// … and in the output.
pub(super) const PLACES: u32 = STARTS + DIGITS;
/// One word a lane, for sums across lanes.
const SUMS: u32 = PLACES + DIGITS;

/// Shared memory of a sorting workgroup.
pub type BlockShared = [u32; 4864];

const _: () = assert!(DIGITS == TURN_VALUES && COUNTERS >= SORT_BLOCK && SUMS + 256 == 4864);

/// Registers of a lane that handles `N` items.
#[repr(C)]
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

/// The place in the block of item `item` of a lane: a subgroup's items are consecutive, and so are those that its lanes
/// handle together.
#[inline]
pub(super) fn item_of(lane: u32, item: u32, subgroup_lanes: u32, items: u32) -> u32 {
    (lane / subgroup_lanes * items + item) * subgroup_lanes + lane % subgroup_lanes
}

/// Counts the digits of block `group` by subgroup: `shared[s · DIGITS + digit]`. Keeps each item's key, and its rank among the
/// items of its digit in its subgroup.
#[inline]
pub(super) fn count_digits<const N: usize, L: Turns<BlockRegisters<N>>>(
    lanes: &mut L,
    group: u32,
    shared: &mut BlockShared,
    pass: &RadixPass,
    keys: &[u32],
) {
    let count = lanes.lanes();
    let subgroup = lanes.subgroup_lanes();
    lanes.each(shared, move |lane, _, shared: &mut BlockShared| {
        let mut at = lane;
        while at < count / subgroup * DIGITS {
            shared[at as usize] = 0;
            at += count;
        }
    });
    let first = group * SORT_BLOCK;
    let shift = pass.shift;
    let end = pass.count;
    lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, _: &mut BlockShared| {
        let mut item = 0;
        while item < N as u32 {
            let i = first + item_of(lane, item, subgroup, N as u32);
            if i < end {
                r.keys[item as usize] = keys[i as usize];
            }
            item += 1;
        }
    });
    let mut item = 0;
    while item < N as u32 {
        lanes.take_turns(
            shared,
            move |lane, r: &mut BlockRegisters<N>| {
                let i = first + item_of(lane, item, subgroup, N as u32);
                if i < end { digit(r.keys[item as usize], shift) } else { DIGITS }
            },
            move |_, r: &mut BlockRegisters<N>, rank| r.ranks[item as usize] = rank,
        );
        item += 1;
    }
    lanes.each(shared, move |_, _, _: &mut BlockShared| {});
}

/// Replaces the [`DIGITS`] words from `at` on by their exclusive prefix sums.
#[inline]
pub(super) fn scan_digits<const N: usize, L: Turns<BlockRegisters<N>>>(
    lanes: &mut L,
    shared: &mut BlockShared,
    at: u32,
) {
    let count = lanes.lanes();
    let each = DIGITS / count;
    lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut BlockShared| {
        let mut sum = 0;
        let mut j = 0;
        while j < each {
            sum += shared[(at + lane * each + j) as usize];
            j += 1;
        }
        r.sums[0] = sum;
        shared[(SUMS + lane) as usize] = sum;
    });
    // Hillis and Steele 1986, in two phases a step.
    let mut step = 1;
    while step < count {
        lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut BlockShared| {
            r.sums[1] = if lane >= step { shared[(SUMS + lane - step) as usize] } else { 0 };
        });
        lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut BlockShared| {
            shared[(SUMS + lane) as usize] += r.sums[1];
        });
        step *= 2;
    }
    lanes.each(shared, move |lane, r: &mut BlockRegisters<N>, shared: &mut BlockShared| {
        let mut sum = shared[(SUMS + lane) as usize] - r.sums[0];
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
