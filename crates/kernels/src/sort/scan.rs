//! Exclusive prefix sums of the rows of a table, one workgroup a row.
//!
//! One kernel serves every scan of the project. Sorting scans a row a digit. A long array is scanned as
//! rows of [`SCAN_BLOCK`] elements, then their totals as one more row; whoever reads element `i` adds the two.

use super::block::for_items;
use crate::exec::{Input, Lanes, Store};
use bytemuck::{Pod, Zeroable};

/// Lanes of a scanning workgroup.
pub const SCAN_LANES: u32 = 256;
/// Length of the rows into which a long array is cut, in elements.
pub const SCAN_BLOCK: u32 = 4096;
/// Elements a lane sums before the workgroup's own scan.
const LANE_ITEMS: u32 = 16;

/// Shape of the table to scan.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ScanParams {
    /// Elements in all; the last row may be shorter than the others.
    pub count: u32,
    /// Elements of a row.
    pub row_length: u32,
}

/// Registers of a scanning lane.
#[derive(Clone, Copy, Default)]
pub struct ScanRegisters {
    items: [u32; LANE_ITEMS as usize],
    /// The sum of the lane's items.
    sum: u32,
    /// The sum of the row so far.
    row: u32,
}

/// Shared memory of a scanning workgroup: two copies, so that a step reads one and writes the other.
pub type ScanShared = [u32; 512];

/// Scans row `group`: `sums[i]` becomes the sum of the row's elements before `i`, and `totals[group]` that of all.
/// Sums wrap at 2³²; the host bounds the counts so that they cannot.
#[inline]
pub fn scan_rows<L: Lanes<ScanRegisters>, O: Store<u32> + ?Sized, T: Store<u32> + ?Sized>(
    lanes: &mut L,
    group: u32,
    shared: &mut ScanShared,
    params: &ScanParams,
    input: &Input<u32>,
    sums: &mut O,
    totals: &mut T,
) {
    let begin = group * params.row_length;
    if begin >= params.count {
        return;
    }
    let mut end = begin + params.row_length;
    if end > params.count {
        end = params.count;
    }
    lanes.each(shared, move |_, r: &mut ScanRegisters, _: &mut ScanShared| {
        r.row = 0;
    });
    let mut chunk = begin;
    while chunk < end {
        lanes.each(shared, move |lane, r: &mut ScanRegisters, shared: &mut ScanShared| {
            let first = chunk + lane * LANE_ITEMS;
            r.sum = 0;
            if first < end {
                // All are on their way before the first is needed.
                for_items!(LANE_ITEMS, item => {
                    let i = first + item;
                    let value = input[(if i < end { i } else { end - 1 }) as usize];
                    r.items[item as usize] = if i < end { value } else { 0 };
                });
                for_items!(LANE_ITEMS, item => { r.sum = r.sum.wrapping_add(r.items[item as usize]); });
            }
            shared[lane as usize] = r.sum;
        });
        // Of a short row few lanes have any.
        let left = end - chunk;
        let used = if left < SCAN_BLOCK { left.div_ceil(LANE_ITEMS) } else { SCAN_LANES };
        let from = inclusive_scan(lanes, shared, used);
        let sums = &mut *sums;
        lanes.each(shared, move |lane, r: &mut ScanRegisters, shared: &mut ScanShared| {
            let mut sum = shared[(from + lane) as usize].wrapping_sub(r.sum).wrapping_add(r.row);
            let first = chunk + lane * LANE_ITEMS;
            if first < end {
                for_items!(LANE_ITEMS, item => {
                    if first + item < end {
                        sums.set(first + item, sum);
                    }
                    sum = sum.wrapping_add(r.items[item as usize]);
                });
            }
            r.row = r.row.wrapping_add(shared[(from + used - 1) as usize]);
        });
        chunk += SCAN_BLOCK;
    }
    lanes.each(shared, move |lane, r: &mut ScanRegisters, _: &mut ScanShared| {
        if lane == 0 {
            totals.set(group, r.row);
        }
    });
}

/// Inclusive prefix sums of the first `used` of `shared[0..256]` (Hillis and Steele 1986), from one half of the memory into the other and back.
/// Returns where they begin.
#[inline]
fn inclusive_scan<R, L: Lanes<R>>(lanes: &mut L, shared: &mut ScanShared, used: u32) -> u32 {
    let mut from = 0;
    let mut step = 1;
    while step < used {
        let to = SCAN_LANES - from;
        lanes.each(shared, move |lane, _, shared: &mut ScanShared| {
            if lane < used {
                let mut sum = shared[(from + lane) as usize];
                if lane >= step {
                    sum = sum.wrapping_add(shared[(from + lane - step) as usize]);
                }
                shared[(to + lane) as usize] = sum;
            }
        });
        from = to;
        step *= 2;
    }
    from
}
