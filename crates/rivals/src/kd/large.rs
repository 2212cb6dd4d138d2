//! The stage of large nodes. Every level is one submission, after which the host reads how many nodes are active next.

use super::build::{Orders, Roots};
use crate::Photons;
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::rivals::kd::{KD_SMALL, KdLarge, KdLevel, KdSmall, KdSplit, coordinate};
use caustic_photon_map::{MapError, scan};

/// Splits the root and what is large below it. Returns the orders in which the small nodes have their photons, these nodes, and the number
/// of levels.
pub(super) fn split(
    device: &Device,
    photons: &Photons,
    orders: Orders,
    tree: &Buffer,
) -> Result<(Orders, Roots, u32), MapError> {
    let count = photons.count;
    let mut now = orders;
    let mut next = Orders {
        orders: device.scratch::<u32>("kd: orders", 3 * u64::from(count))?,
        owners: device.scratch::<u32>("kd: owners", u64::from(count))?,
    };
    let sides = device.scratch::<u32>("kd: sides", u64::from(count))?;
    let flags = device.scratch::<u32>("kd: sides in lists", 3 * u64::from(count))?;
    let mut scan_flags = Plan::new();
    scan_flags.scope("kd large");
    let [sums, offsets, _] = scan(device, &mut scan_flags, &flags, 3 * count)?;
    // Every small node has a photon.
    let roots = device.scratch::<KdSmall>("kd: small nodes", u64::from(count))?;
    let mut small = 0;
    let root = KdLarge {
        begin: 0,
        photons: count,
        place: 0,
        low: photons.low.map(coordinate),
        high: photons.high.map(coordinate),
    };
    let mut nodes = device.upload("kd: large nodes", &[root])?;
    let mut active = 1;
    let mut levels = 0;
    while active > 0 {
        let level = KdLevel { photons: count, nodes: active, level: levels, roots: small, radius: 0.0 };
        let level = device.upload("kd: level", &[level])?;
        let splits = device.scratch::<KdSplit>("kd: splits", u64::from(active))?;
        let children = device.scratch::<KdLarge>("kd: children", 2 * u64::from(active))?;
        let is_large = device.scratch::<u32>("kd: large children", 2 * u64::from(active))?;
        let most = (2 * active).min(count / (KD_SMALL + 1));
        let next_nodes = device.scratch::<KdLarge>("kd: large nodes", u64::from(most))?;
        let mut plan = Plan::new();
        plan.scope("kd large");
        let split = [&level, &photons.buffer, &now.orders, &nodes, &splits, &children, &is_large, tree];
        plan.each(Kernel::KdSplitLarge, active, &split);
        let [larger, larger_offsets, totals] = scan(device, &mut plan, &is_large, 2 * active)?;
        let hand_out = [&level, &children, &is_large, &larger, &larger_offsets, &next_nodes, &roots];
        plan.each(Kernel::KdHandOut, 2 * active, &hand_out);
        let (owners, orders) = (&now.owners, &now.orders);
        let classify = [&level, owners, &splits, orders, &is_large, &larger, &larger_offsets, &sides, &next.owners];
        plan.each(Kernel::KdClassify, count, &classify);
        plan.each(Kernel::KdListSides, count, &[&level, orders, &sides, &flags]);
        plan.append(&scan_flags);
        let shift = [&level, owners, &splits, orders, &flags, &sums, &offsets, &next.orders];
        plan.each(Kernel::KdMove, count, &shift);
        device.run(&plan)?;
        let large = total(device, &totals, 2 * active)?;
        small += 2 * active - large;
        active = large;
        nodes = next_nodes;
        std::mem::swap(&mut now, &mut next);
        levels += 1;
    }
    Ok((now, Roots { nodes: roots, count: small }, levels))
}

/// The sum of what was scanned.
pub(super) fn total(device: &Device, totals: &Buffer, scanned: u32) -> Result<u32, MapError> {
    let blocks = scanned.div_ceil(caustic_kernels::sort::SCAN_BLOCK);
    Ok(device.read::<u32>(totals, u64::from(blocks))?.iter().sum())
}
