//! Searching an index for queries of the host.

use crate::{PhotonIndex, Photons};
use caustic_device::{Device, Kernel, Plan};
use caustic_kernels::layout::{Irradiance, Neighbour, Query};
use caustic_kernels::rivals::SearchParams;
use caustic_photon_map::{MapError, query_count, whole};

/// The `k` nearest photons of each query within the radius of the index, nearest first, ties by index.
///
/// # Errors
/// [`MapError::NotFinite`], [`MapError::K`], [`MapError::TooMany`], [`MapError::CutShort`] and [`MapError::Device`].
pub fn k_nearest(
    device: &Device,
    index: &dyn PhotonIndex,
    queries: &[Query],
    k: u32,
) -> Result<Vec<Vec<Neighbour>>, MapError> {
    let count = query_count(queries)?;
    let found = index.search(device, &device.upload("queries", queries)?, count, k)?;
    let counts: Vec<u32> = device.read(&found.counts, u64::from(count))?;
    whole(device, counts.iter().copied())?;
    let neighbours: Vec<Neighbour> = device.read(&found.neighbours, u64::from(count) * u64::from(k))?;
    let rows = counts.iter().zip(neighbours.chunks(k as usize));
    Ok(rows.map(|(&found, row)| row[..found as usize].to_vec()).collect())
}

/// The irradiance at each query by eq. 2.1, estimated from the `k` nearest photons that the index finds within `radius` (m), which is
/// the radius that it was built for.
///
/// # Errors
/// Those of [`k_nearest`].
pub fn irradiance(
    device: &Device,
    index: &dyn PhotonIndex,
    photons: &Photons,
    radius: f32,
    queries: &[Query],
    k: u32,
) -> Result<Vec<Irradiance>, MapError> {
    let count = query_count(queries)?;
    let found = index.search(device, &device.upload("queries", queries)?, count, k + 1)?;
    let params = SearchParams { queries: count, k, photons: photons.count, radius2: radius * radius };
    let params = device.upload("estimate: params", &[params])?;
    let out = device.scratch::<Irradiance>("irradiance", u64::from(count))?;
    let mut plan = Plan::new();
    let buffers = [&params, &photons.buffer, &photons.power, &found.neighbours, &found.counts, &out];
    plan.each(Kernel::EstimateOfNeighbours, count, &buffers);
    device.run(&plan)?;
    let estimates: Vec<Irradiance> = device.read(&out, u64::from(count))?;
    whole(device, estimates.iter().map(|estimate| estimate.photons))?;
    Ok(estimates)
}
