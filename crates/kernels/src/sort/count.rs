//! First stage of a radix pass: how often each digit occurs in each block.

use super::block::{BlockRegisters, count_digits};
use super::{DIGITS, RadixPass};
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
    count_digits::<false, N, W, L>(lanes, group, shared, pass, keys);
    let count = lanes.lanes();
    let subgroups = count / lanes.subgroup_lanes();
    lanes.each(shared, move |lane, _, shared: &mut [u32; W]| {
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
