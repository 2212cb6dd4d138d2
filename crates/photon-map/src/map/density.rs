//! Estimates from all photons within the radius.

use super::{Estimate, PhotonMap, estimates};
use crate::MapError;
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::grid::HASH_LINEAR;
use caustic_kernels::layout::{Irradiance, Query};

impl PhotonMap {
    /// Appends the estimate of `count` queries from all photons within the map's radius to a plan, into records of
    /// [`Irradiance`].
    ///
    /// # Errors
    /// [`MapError::Device`].
    pub fn plan_density(
        &self,
        device: &Device,
        plan: &mut Plan,
        queries: &Buffer,
        count: u32,
        out: &Buffer,
    ) -> Result<(), MapError> {
        if let Some(records) = &self.compact {
            return self.append_compact(device, plan, records, queries, count, &Estimate::default(), out);
        }
        let search = self.plan_search(device, plan, queries, count, 0, 1)?;
        let linear = self.grid.hash == HASH_LINEAR;
        let kernel = if linear { Kernel::IrradianceDensity } else { Kernel::IrradianceDensityHashed };
        plan.each(kernel, count, &self.estimate_buffers(&search, queries, out));
        Ok(())
    }

    /// Appends to a plan that the power of all photons within the map's radius of `count` queries is added to `sums`, records of
    /// [`PowerSum`](caustic_kernels::layout::PowerSum).
    pub(crate) fn plan_power(
        &self,
        device: &Device,
        plan: &mut Plan,
        queries: &Buffer,
        count: u32,
        sums: &Buffer,
    ) -> Result<(), MapError> {
        let search = self.plan_search(device, plan, queries, count, 0, 1)?;
        let kernel = if self.grid.hash == HASH_LINEAR { Kernel::PowerWithin } else { Kernel::PowerWithinHashed };
        let [params, grid, rows, queries, order, sites, arrivals, begins, ..] =
            self.estimate_buffers(&search, queries, sums);
        plan.each(kernel, count, &[params, grid, rows, queries, order, sites, arrivals, begins, sums]);
        Ok(())
    }

    /// The irradiance at each query, estimated from all photons within the map's radius.
    ///
    /// # Errors
    /// [`MapError::NotFinite`], [`MapError::TooMany`], [`MapError::CutShort`] and [`MapError::Device`].
    pub fn density(&self, device: &Device, queries: &[Query]) -> Result<Vec<Irradiance>, MapError> {
        estimates(device, queries, |plan, query_buffer, count, out| {
            self.plan_density(device, plan, query_buffer, count, out)
        })
    }
}
