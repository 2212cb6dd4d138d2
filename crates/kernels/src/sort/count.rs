//! First stage of a radix pass: how often each digit occurs in each block.

use super::block::{BlockRegisters, BlockShared, count_digits};
use super::{DIGITS, RadixPass};
use crate::exec::{Store, Turns};

/// Counts the digits of block `group` into `histogram[digit · blocks + block]`.
///
/// Digit-major order makes the exclusive prefix sum over the whole table the place where each block's run of each digit
/// begins in the output.
#[inline]
pub fn radix_count<const N: usize, L: Turns<BlockRegisters<N>>, H: Store<u32> + ?Sized>(
    lanes: &mut L,
    group: u32,
    shared: &mut BlockShared,
    pass: &RadixPass,
    keys: &[u32],
    histogram: &mut H,
) {
    if group >= pass.blocks {
        return;
    }
    count_digits(lanes, group, shared, pass, keys);
    let count = lanes.lanes();
    let subgroups = count / lanes.subgroup_lanes();
    lanes.each(shared, move |lane, _, shared: &mut BlockShared| {
        let mut digit = lane;
        while digit < DIGITS {
            let mut sum = 0;
            let mut subgroup = 0;
            while subgroup < subgroups {
                sum += shared[(subgroup * DIGITS + digit) as usize];
                subgroup += 1;
            }
            histogram.set(digit * pass.blocks + group, sum);
            digit += count;
        }
    });
}
