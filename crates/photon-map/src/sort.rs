//! The stages of a sort and of a scan, as plans.

use caustic_device::{Buffer, Device, Kernel, Plan, Result};
use caustic_kernels::sort::{
    DIGIT_BITS, DIGITS, RadixPass, SCAN_BLOCK, SORT_BLOCK, ScanParams, VALUES_GIVEN, VALUES_INDICES, VALUES_NONE,
};

/// Sorts `u32` keys, of which only the lowest bits count, together with the indices they came from.
pub struct RadixSort {
    /// The sorted keys, once the plan has run.
    pub keys: Buffer,
    /// The index that each sorted key had before.
    pub order: Buffer,
}

/// What is sorted with the keys.
enum Values {
    None,
    Indices,
}

impl RadixSort {
    /// Appends the passes that sort the `count` keys in `keys` by their lowest `bits` bits, rounded up to
    /// whole digits. `keys` is overwritten.
    ///
    /// # Errors
    /// Those of [`Device::buffer`].
    pub fn plan(device: &Device, plan: &mut Plan, keys: &Buffer, count: u32, bits: u32) -> Result<Self> {
        let (keys, order) = passes(device, plan, keys, &Values::Indices, count, bits, device.subgroup_lanes())?;
        Ok(Self { keys, order })
    }

    /// [`RadixSort::plan`] with the kernels for devices without subgroups, which every device can run.
    ///
    /// # Errors
    /// Those of [`Device::buffer`].
    pub fn plan_plain(device: &Device, plan: &mut Plan, keys: &Buffer, count: u32, bits: u32) -> Result<Self> {
        let (keys, order) = passes(device, plan, keys, &Values::Indices, count, bits, None)?;
        Ok(Self { keys, order })
    }

    /// [`RadixSort::plan`] without the indices: returns the sorted keys.
    ///
    /// # Errors
    /// Those of [`Device::buffer`].
    pub fn plan_keys(device: &Device, plan: &mut Plan, keys: &Buffer, count: u32, bits: u32) -> Result<Buffer> {
        passes(device, plan, keys, &Values::None, count, bits, device.subgroup_lanes()).map(|(keys, _)| keys)
    }
}

fn passes(
    device: &Device,
    plan: &mut Plan,
    keys: &Buffer,
    values: &Values,
    count: u32,
    bits: u32,
    subgroup_lanes: Option<u32>,
) -> Result<(Buffer, Buffer)> {
    let blocks = count.div_ceil(SORT_BLOCK);
    let of_values = if matches!(values, Values::None) { 0 } else { u64::from(count) };
    let mut from = (keys.clone(), device.scratch::<u32>("sort: order", of_values)?);
    let mut to =
        (device.scratch::<u32>("sort: keys", u64::from(count))?, device.buffer::<u32>("sort: order", of_values)?);
    let cells = u64::from(DIGITS) * u64::from(blocks);
    let histogram = device.scratch::<u32>("sort: histogram", cells)?;
    let offsets = device.scratch::<u32>("sort: offsets", cells)?;
    let totals = device.scratch::<u32>("sort: digit totals", u64::from(DIGITS))?;
    let scan = device.upload("sort: scan", &[ScanParams { count: DIGITS * blocks, row_length: blocks }])?;
    // Every subgroup needs counters of its own: there is memory for so many. The CPU has one lane for all.
    let (count_digits, scatter) = match subgroup_lanes {
        None | Some(2..8) => (Kernel::RadixCountPlain, Kernel::RadixScatterPlain),
        Some(8..32) => (Kernel::RadixCountNarrow, Kernel::RadixScatterNarrow),
        Some(_) => (Kernel::RadixCount, Kernel::RadixScatter),
    };
    // One pass at least: it is what fills the order.
    for number in 0..bits.div_ceil(DIGIT_BITS).max(1) {
        let values = match (values, number) {
            (Values::None, _) => VALUES_NONE,
            (Values::Indices, 0) => VALUES_INDICES,
            (Values::Indices, _) => VALUES_GIVEN,
        };
        let pass = device.upload("sort: pass", &[RadixPass { count, blocks, shift: number * DIGIT_BITS, values }])?;
        plan.groups(count_digits, blocks, &[&pass, &from.0, &histogram]);
        let rows = if blocks == 0 { 0 } else { DIGITS };
        plan.groups(Kernel::ScanRows, rows, &[&scan, &histogram, &offsets, &totals]);
        plan.groups(scatter, blocks, &[&pass, &from.0, &from.1, &offsets, &totals, &to.0, &to.1]);
        std::mem::swap(&mut from, &mut to);
    }
    Ok(from)
}

/// Appends an exclusive prefix sum over `count` elements of `input`. Returns the sums within each block of [`SCAN_BLOCK`], the
/// sums of the blocks before each block, and the blocks' totals: element `i`'s sum is the first at `i` plus the second at
/// `i / SCAN_BLOCK`.
///
/// # Errors
/// Those of [`Device::buffer`].
pub fn scan(device: &Device, plan: &mut Plan, input: &Buffer, count: u32) -> Result<[Buffer; 3]> {
    let blocks = count.div_ceil(SCAN_BLOCK);
    let sums = device.scratch::<u32>("scan: sums", u64::from(count))?;
    let totals = device.scratch::<u32>("scan: block totals", u64::from(blocks))?;
    let offsets = device.scratch::<u32>("scan: block offsets", u64::from(blocks))?;
    let total = device.scratch::<u32>("scan: total", 1)?;
    let rows = device.upload("scan: params", &[ScanParams { count, row_length: SCAN_BLOCK }])?;
    let row = device.upload("scan: params", &[ScanParams { count: blocks, row_length: blocks }])?;
    plan.groups(Kernel::ScanRows, blocks, &[&rows, input, &sums, &totals]);
    plan.groups(Kernel::ScanRows, blocks.min(1), &[&row, &totals, &offsets, &total]);
    Ok([sums, offsets, totals])
}
