//! The stages of a sort and of a scan, as plans.

use caustic_device::{Buffer, Device, Kernel, Plan, Result};
use caustic_kernels::sort::{DIGIT_BITS, DIGITS, RadixPass, SCAN_BLOCK, SORT_BLOCK, ScanParams};

/// Sorts `u32` keys, of which only the lowest bits count, together with the indices they came from.
pub struct RadixSort {
    /// The sorted keys, once the plan has run.
    pub keys: Buffer,
    /// The index that each sorted key had before.
    pub order: Buffer,
}

impl RadixSort {
    /// Appends the passes that sort the `count` keys in `keys` by their lowest `bits` bits, rounded up to
    /// whole digits. `keys` is overwritten.
    ///
    /// # Errors
    /// Those of [`Device::buffer`].
    pub fn plan(device: &Device, plan: &mut Plan, keys: &Buffer, count: u32, bits: u32) -> Result<Self> {
        let blocks = count.div_ceil(SORT_BLOCK);
        let elements = u64::from(count);
        let mut from = (keys.clone(), device.buffer::<u32>("sort: order", elements)?);
        let mut to = (device.buffer::<u32>("sort: keys", elements)?, device.buffer::<u32>("sort: order", elements)?);
        let cells = u64::from(DIGITS * blocks);
        let histogram = device.buffer::<u32>("sort: histogram", cells)?;
        let offsets = device.buffer::<u32>("sort: offsets", cells)?;
        let totals = device.buffer::<u32>("sort: digit totals", u64::from(DIGITS))?;
        let scan = device.upload("sort: scan", &[ScanParams { count: DIGITS * blocks, row_length: blocks }])?;
        // One pass at least: it is what fills the order.
        for pass in 0..bits.div_ceil(DIGIT_BITS).max(1) {
            let record =
                RadixPass { count, blocks, shift: pass * DIGIT_BITS, values_are_indices: u32::from(pass == 0) };
            let pass = device.upload("sort: pass", &[record])?;
            plan.groups(Kernel::RadixCount, blocks, &[&pass, &from.0, &histogram]);
            let rows = if blocks == 0 { 0 } else { DIGITS };
            plan.groups(Kernel::ScanRows, rows, &[&scan, &histogram, &offsets, &totals]);
            plan.groups(Kernel::RadixScatter, blocks, &[&pass, &from.0, &from.1, &offsets, &totals, &to.0, &to.1]);
            std::mem::swap(&mut from, &mut to);
        }
        Ok(Self { keys: from.0, order: from.1 })
    }
}

/// Appends an exclusive prefix sum over `count` elements of `input`. Returns the sums within each block of [`SCAN_BLOCK`], the
/// sums of the blocks before each block, and the blocks' totals: element `i`'s sum is the first at `i` plus the second at
/// `i / SCAN_BLOCK`.
///
/// # Errors
/// Those of [`Device::buffer`].
pub fn scan(device: &Device, plan: &mut Plan, input: &Buffer, count: u32) -> Result<[Buffer; 3]> {
    let blocks = count.div_ceil(SCAN_BLOCK);
    let sums = device.buffer::<u32>("scan: sums", u64::from(count))?;
    let totals = device.buffer::<u32>("scan: block totals", u64::from(blocks))?;
    let offsets = device.buffer::<u32>("scan: block offsets", u64::from(blocks))?;
    let total = device.buffer::<u32>("scan: total", 1)?;
    let rows = device.upload("scan: params", &[ScanParams { count, row_length: SCAN_BLOCK }])?;
    let row = device.upload("scan: params", &[ScanParams { count: blocks, row_length: blocks }])?;
    plan.groups(Kernel::ScanRows, blocks, &[&rows, input, &sums, &totals]);
    plan.groups(Kernel::ScanRows, blocks.min(1), &[&row, &totals, &offsets, &total]);
    Ok([sums, offsets, totals])
}
