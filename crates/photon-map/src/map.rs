//! The photon map: its construction and its search, as plans or at once.

use crate::grid::{MAX_PHOTONS, bounds, plan_grid};
use crate::options::{irradiance_kernel, neighbours_kernel};
use crate::{Gather, MapError, MapOptions, RadixSort};
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::gather::{CUT_SHORT, GatherParams};
use caustic_kernels::grid::Grid;
use caustic_kernels::layout::{Irradiance, Neighbour, Photon, Query};

/// A photon map on a device.
pub struct PhotonMap {
    grid: Grid,
    grid_buffer: Buffer,
    photons: Buffer,
    order: Buffer,
    starts: Buffer,
    ends: Buffer,
}

impl PhotonMap {
    /// Appends the construction of a map over the photons in `unsorted` to a plan: hash, sort, ranges, reorder. The map can be
    /// used by the stages that follow.
    ///
    /// # Errors
    /// [`MapError::Device`].
    pub fn plan(device: &Device, plan: &mut Plan, unsorted: &Buffer, grid: Grid) -> Result<Self, MapError> {
        let count = grid.photons;
        let grid_buffer = device.upload("map: grid", &[grid])?;
        let keys = device.buffer::<u32>("sort: keys", u64::from(count))?;
        plan.each(Kernel::HashPhotons, count, &[&grid_buffer, unsorted, &keys]);
        let bits = u32::BITS - (grid.table - 1).leading_zeros();
        let sorted = RadixSort::plan(device, plan, &keys, count, bits)?;
        let starts = device.buffer::<u32>("map: cell starts", u64::from(grid.table))?;
        let ends = device.buffer::<u32>("map: cell ends", u64::from(grid.table))?;
        plan.clear(&starts);
        plan.clear(&ends);
        plan.each(Kernel::CellRanges, count, &[&grid_buffer, &sorted.keys, &starts, &ends]);
        let photons = device.buffer::<Photon>("map: photons", u64::from(count))?;
        plan.each(Kernel::ReorderPhotons, count, &[&grid_buffer, &sorted.order, unsorted, &photons]);
        Ok(Self { grid, grid_buffer, photons, order: sorted.order, starts, ends })
    }

    /// Builds a map of `photons`.
    ///
    /// # Errors
    /// All of [`MapError`] but those of queries.
    pub fn build(device: &Device, photons: &[Photon], options: &MapOptions) -> Result<Self, MapError> {
        let (low, high) = bounds("photons", photons.iter().map(|photon| photon.position))?;
        let bad = |photon: &&Photon| !photon.power.iter().all(|power| power.is_finite() && *power >= 0.0);
        if let Some(first) = photons.iter().position(|photon| bad(&photon)) {
            return Err(MapError::Power { count: photons.iter().filter(bad).count(), first });
        }
        let grid = plan_grid(low, high, photons.len() as u64, options)?;
        let unsorted = device.upload("photons", photons)?;
        let mut plan = Plan::new();
        let map = Self::plan(device, &mut plan, &unsorted, grid)?;
        device.run(&plan)?;
        Ok(map)
    }

    /// The grid of the map.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The map's buffers: photons in sorted order, the index that each had before, and where each table entry begins and ends.
    #[must_use]
    pub fn buffers(&self) -> [&Buffer; 4] {
        [&self.photons, &self.order, &self.starts, &self.ends]
    }

    /// Bytes that the map takes on its device.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.buffers().iter().map(|buffer| buffer.bytes()).sum()
    }

    /// Appends the irradiance estimate of `count` queries from `k` photons each (eq. 2.1) to a plan. `out` gets a record of
    /// [`Irradiance`] a query.
    ///
    /// # Errors
    /// [`MapError::K`] and [`MapError::Device`].
    pub fn plan_irradiance(
        &self,
        device: &Device,
        plan: &mut Plan,
        queries: &Buffer,
        count: u32,
        k: u32,
        gather: Gather,
        out: &Buffer,
    ) -> Result<(), MapError> {
        let kernel = irradiance_kernel(gather, k, device.is_software_gpu())?;
        let params = device.upload("gather: params", &[GatherParams { queries: count, k }])?;
        plan.each(
            kernel,
            count,
            &[&params, &self.grid_buffer, queries, &self.photons, &self.order, &self.starts, &self.ends, out],
        );
        Ok(())
    }

    /// The irradiance at each query, estimated from `k` photons.
    ///
    /// # Errors
    /// [`MapError::NotFinite`], [`MapError::K`], [`MapError::TooMany`], [`MapError::CutShort`] and [`MapError::Device`].
    pub fn irradiance(
        &self,
        device: &Device,
        queries: &[Query],
        k: u32,
        gather: Gather,
    ) -> Result<Vec<Irradiance>, MapError> {
        let count = query_count(queries)?;
        let query_buffer = device.upload("queries", queries)?;
        let out = device.buffer::<Irradiance>("irradiance", u64::from(count))?;
        let mut plan = Plan::new();
        self.plan_irradiance(device, &mut plan, &query_buffer, count, k, gather, &out)?;
        device.run(&plan)?;
        let estimates: Vec<Irradiance> = device.read(&out, u64::from(count))?;
        whole(device, estimates.iter().map(|estimate| estimate.photons))?;
        Ok(estimates)
    }

    /// The `k` nearest photons of each query within the map's radius, nearest first, ties by index.
    ///
    /// # Errors
    /// [`MapError::NotFinite`], [`MapError::K`], [`MapError::TooMany`], [`MapError::CutShort`] and [`MapError::Device`].
    pub fn k_nearest(
        &self,
        device: &Device,
        queries: &[Query],
        k: u32,
        gather: Gather,
    ) -> Result<Vec<Vec<Neighbour>>, MapError> {
        let kernel = neighbours_kernel(gather, k)?;
        let count = query_count(queries)?;
        let rows = u64::from(count) * u64::from(k);
        if rows > u64::from(u32::MAX) {
            return Err(MapError::TooMany { what: "neighbours", count: rows, max: u32::MAX });
        }
        let query_buffer = device.upload("queries", queries)?;
        let params = device.upload("gather: params", &[GatherParams { queries: count, k }])?;
        let neighbours = device.buffer::<Neighbour>("neighbours", rows)?;
        let counts = device.buffer::<u32>("neighbour counts", u64::from(count))?;
        let mut plan = Plan::new();
        let [photons, order, starts, ends] = self.buffers();
        plan.each(
            kernel,
            count,
            &[&params, &self.grid_buffer, &query_buffer, photons, order, starts, ends, &neighbours, &counts],
        );
        device.run(&plan)?;
        let counts: Vec<u32> = device.read(&counts, u64::from(count))?;
        whole(device, counts.iter().copied())?;
        let neighbours: Vec<Neighbour> = device.read(&neighbours, rows)?;
        Ok(counts
            .iter()
            .zip(neighbours.chunks(k as usize))
            .map(|(&found, row)| row[..found as usize].to_vec())
            .collect())
    }
}

/// Refuses results of searches that the device ended early.
fn whole(device: &Device, counts: impl Iterator<Item = u32>) -> Result<(), MapError> {
    match counts.filter(|&count| count == CUT_SHORT).count() {
        0 => Ok(()),
        searches => Err(MapError::CutShort { device: device.name(), searches }),
    }
}

fn query_count(queries: &[Query]) -> Result<u32, MapError> {
    bounds("queries", queries.iter().map(|query| query.position))?;
    u32::try_from(queries.len()).ok().filter(|&count| count <= MAX_PHOTONS).ok_or(MapError::TooMany {
        what: "queries",
        count: queries.len() as u64,
        max: MAX_PHOTONS,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Hash;

    #[test]
    fn powers_that_photons_cannot_have_are_counted_and_the_first_is_named() {
        let with = |power: f32| Photon { power: [1.0, power, 0.0], ..Photon::default() };
        let photons = [with(0.0), with(f32::NAN), with(2.0), with(-1.0), with(f32::INFINITY)];
        let options = MapOptions { radius: 1.0, hash: Hash::Linear, table: None };
        let error = PhotonMap::build(&Device::cpu(), &photons, &options).err();
        assert!(matches!(error, Some(MapError::Power { count: 3, first: 1 })), "{error:?}");
    }
}
