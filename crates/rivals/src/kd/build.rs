//! Construction: initialisation, then the stages one after another. A buffer is freed after the last stage that needs it.

use super::{large, small};
use crate::Photons;
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::layout::Site;
use caustic_kernels::rivals::kd::{KD_SMALL, KdLevel, KdSmall, kd_first, kd_quads};
use caustic_photon_map::{MapError, RadixSort};

/// Photons in three orders.
pub(super) struct Orders {
    /// Their indices along x, then along y, then along z.
    pub(super) orders: Buffer,
    /// Which node has each place.
    pub(super) owners: Buffer,
}

/// What the stage of large nodes leaves.
pub(super) struct Roots {
    /// Records of [`KdSmall`].
    pub(super) nodes: Buffer,
    /// How many.
    pub(super) count: u32,
}

/// Builds the tree; returns its quads and the numbers of levels of both stages.
pub(super) fn tree(device: &Device, photons: &Photons, radius: f32) -> Result<(Buffer, [u32; 2]), MapError> {
    let count = photons.count;
    let tree = device.scratch::<Site>("kd-tree", u64::from(kd_quads(count)))?;
    if count == 0 {
        return Ok((tree, [0, 0]));
    }
    let orders = sort(device, photons)?;
    let (orders, roots, large_levels) = if count > KD_SMALL {
        large::split(device, photons, orders, &tree)?
    } else {
        let root = KdSmall { begin: 0, set: kd_first(count), place: 0 };
        (orders, Roots { nodes: device.upload("kd: small nodes", &[root])?, count: 1 }, 0)
    };
    let small_levels = small::split(device, photons, radius, orders, roots, &tree)?;
    Ok((tree, [large_levels, small_levels]))
}

/// Sorts the photons along each axis, one after another, so that only one sort's memory is needed at a time.
fn sort(device: &Device, photons: &Photons) -> Result<Orders, MapError> {
    let count = photons.count;
    let level = device.upload("kd: level", &[KdLevel { photons: count, ..KdLevel::default() }])?;
    let buffer = |name, length: u64| device.scratch::<u32>(name, length);
    let of_axis = || buffer("sort: keys", u64::from(count));
    let keys = [of_axis()?, of_axis()?, of_axis()?];
    let mut plan = Plan::new();
    plan.scope("kd sort");
    plan.each(Kernel::KdKeys, count, &[&level, &photons.buffer, &keys[0], &keys[1], &keys[2]]);
    device.run(&plan)?;
    let mut sorted = Vec::new();
    for keys in keys {
        let mut plan = Plan::new();
        plan.scope("kd sort");
        sorted.push(RadixSort::plan(device, &mut plan, &keys, count, u32::BITS)?.order);
        device.run(&plan)?;
    }
    let orders = buffer("kd: orders", 3 * u64::from(count))?;
    let owners = buffer("kd: owners", u64::from(count))?;
    let mut plan = Plan::new();
    plan.scope("kd sort");
    plan.each(Kernel::KdBegin, count, &[&level, &sorted[0], &sorted[1], &sorted[2], &orders, &owners]);
    device.run(&plan)?;
    Ok(Orders { orders, owners })
}
