//! The k nearest photons themselves.

use super::{PhotonMap, Search, query_count, whole};
use crate::options::neighbours_kernel;
use crate::{Gather, MAX_K, MapError};
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::grid::HASH_LINEAR;
use caustic_kernels::layout::{Neighbour, Query};

/// Where a plan leaves the neighbours of queries.
pub struct Neighbours {
    /// k places a query, of [`Neighbour`]; those after its last hold anything.
    pub neighbours: Buffer,
    /// How many each query has, or [`CUT_SHORT`](caustic_kernels::gather::CUT_SHORT).
    pub counts: Buffer,
}

impl Neighbours {
    /// Room for the `k` nearest photons of `count` queries.
    ///
    /// # Errors
    /// [`MapError::K`], [`MapError::TooMany`] and [`MapError::Device`].
    pub fn new(device: &Device, count: u32, k: u32) -> Result<Self, MapError> {
        if k == 0 || k > MAX_K {
            return Err(MapError::K { k: u64::from(k), max: MAX_K });
        }
        let rows = u64::from(count) * u64::from(k);
        if rows > u64::from(u32::MAX) {
            return Err(MapError::TooMany { what: "neighbours", count: rows, max: u32::MAX });
        }
        let neighbours = device.scratch::<Neighbour>("neighbours", rows)?;
        let counts = device.scratch::<u32>("neighbour counts", u64::from(count))?;
        Ok(Self { neighbours, counts })
    }
}

impl PhotonMap {
    /// Appends the search for the `k` nearest photons of `count` queries to a plan.
    ///
    /// # Errors
    /// [`MapError::K`], [`MapError::TooMany`], [`MapError::Compact`] and [`MapError::Device`].
    pub fn plan_neighbours(
        &self,
        device: &Device,
        plan: &mut Plan,
        queries: &Buffer,
        count: u32,
        k: u32,
        gather: Gather,
    ) -> Result<Neighbours, MapError> {
        if self.compact.is_some() {
            return Err(MapError::Compact { what: "neighbours" });
        }
        let kernel = neighbours_kernel(gather, k, device.is_gpu(), self.grid.hash == HASH_LINEAR)?;
        let Neighbours { neighbours, counts } = Neighbours::new(device, count, k)?;
        let Search { params, order } = self.plan_search(device, plan, queries, count, k, k)?;
        let search = [&params, &self.grid_buffer, &self.rows, queries, &order, &self.sites, &self.begins];
        let [params, ..] = search;
        if matches!(kernel, Kernel::NeighboursHistogram | Kernel::NeighboursHistogramHashed) {
            let all = count * k;
            let unordered = device.scratch::<Neighbour>("neighbours, unordered", u64::from(all))?;
            let windows = device.scratch::<u32>("neighbour windows", 2 * u64::from(count))?;
            plan.each(kernel, count, &[&search[..], &[&unordered, &counts, &windows]].concat());
            plan.each(Kernel::OrderNeighbours, all, &[params, &counts, &windows, &unordered, &neighbours]);
        } else {
            plan.each(kernel, count, &[&search[..], &[&neighbours, &counts]].concat());
        }
        Ok(Neighbours { neighbours, counts })
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
        neighbours_kernel(gather, k, true, true)?;
        let count = query_count(queries)?;
        let query_buffer = device.upload("queries", queries)?;
        let mut plan = Plan::new();
        let found = self.plan_neighbours(device, &mut plan, &query_buffer, count, k, gather)?;
        device.run(&plan)?;
        let counts: Vec<u32> = device.read(&found.counts, u64::from(count))?;
        whole(device, counts.iter().copied())?;
        let neighbours: Vec<Neighbour> = device.read(&found.neighbours, u64::from(count) * u64::from(k))?;
        Ok(counts
            .iter()
            .zip(neighbours.chunks(k as usize))
            .map(|(&found, row)| row[..found as usize].to_vec())
            .collect())
    }
}
