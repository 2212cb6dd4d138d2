//! The stage of small nodes. Lists of nodes are as long as the host reads that they have to be: none grows by doubling.

use super::build::{Orders, Roots};
use super::large::total;
use crate::Photons;
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::layout::Site;
use caustic_kernels::rivals::kd::{KdLevel, KdSmall};
use caustic_photon_map::{MapError, scan};

/// Splits small nodes until each has one photon; returns the number of levels.
pub(super) fn split(
    device: &Device,
    photons: &Photons,
    radius: f32,
    orders: Orders,
    roots: Roots,
    tree: &Buffer,
) -> Result<u32, MapError> {
    let (members, masks) = prepare(device, photons, orders, &roots)?;
    let Roots { mut nodes, count: mut active } = roots;
    let mut levels = 0;
    let mut plan = Plan::new();
    plan.scope("kd small");
    loop {
        let level = KdLevel { photons: photons.count, nodes: active, level: levels, roots: 0, radius };
        let level = device.upload("kd: level", &[level])?;
        let lefts = device.scratch::<u32>("kd: left sets", u64::from(active))?;
        let is_split = device.scratch::<u32>("kd: split nodes", u64::from(active))?;
        plan.each(Kernel::KdSplitSmall, active, &[&level, &nodes, &members, &masks, &lefts, &is_split, tree]);
        let [sums, offsets, totals] = scan(device, &mut plan, &is_split, active)?;
        device.run(&plan)?;
        let split = total(device, &totals, active)?;
        if split == 0 {
            return Ok(levels);
        }
        // Goes with the next level.
        plan = Plan::new();
        plan.scope("kd small");
        let next = device.scratch::<KdSmall>("kd: small nodes", 2 * u64::from(split))?;
        plan.each(Kernel::KdCompact, active, &[&level, &nodes, &lefts, &sums, &offsets, &next]);
        nodes = next;
        active = 2 * split;
        levels += 1;
    }
}

/// The members of all small roots, and the sets that splits at them leave on the left. The orders are not needed any more.
fn prepare(device: &Device, photons: &Photons, orders: Orders, roots: &Roots) -> Result<(Buffer, Buffer), MapError> {
    let count = photons.count;
    let level = device.upload("kd: level", &[KdLevel { photons: count, ..KdLevel::default() }])?;
    let members = device.scratch::<Site>("kd: members", u64::from(count))?;
    let masks = device.scratch::<u32>("kd: masks", 3 * u64::from(count))?;
    let mut plan = Plan::new();
    plan.scope("kd small");
    plan.each(Kernel::KdMembers, count, &[&level, &photons.buffer, &orders.orders, &members]);
    plan.each(Kernel::KdMasks, count, &[&level, &orders.owners, &roots.nodes, &members, &masks]);
    device.run(&plan)?;
    Ok((members, masks))
}
