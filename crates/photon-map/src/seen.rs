//! The cells that queries lie in, and the photons near enough to be of use to one.

use crate::grid::plan_grid;
use crate::map::key_bits;
use crate::{Hash, MapError, MapOptions, RadixSort, scan};
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::gather::GatherParams;
use caustic_kernels::grid::{BEGINS_BLOCK, GRID_BLOCK, Grid};
use caustic_kernels::layout::Photon;
use caustic_kernels::sort::SCAN_BLOCK;

/// Cells in which queries lie, of a grid of its own: linear, and no finer than the radius within which queries look for photons.
pub struct SeenCells {
    grid: Grid,
    seen: Buffer,
}

impl SeenCells {
    /// No cell is seen yet of those that photons and queries between `low` and `high` can lie in.
    ///
    /// # Errors
    /// [`MapError::Radius`], [`MapError::Extent`] and [`MapError::Device`].
    pub fn new(device: &Device, low: [f32; 3], high: [f32; 3], radius: f32) -> Result<Self, MapError> {
        let options = MapOptions { radius, hash: Hash::Linear, table: None, cell: Some(radius) };
        let grid = plan_grid(low, high, 0, &[], &options)?;
        let seen = device.buffer::<u32>("seen: cells", u64::from(grid.table))?;
        Ok(Self { grid, seen })
    }

    /// Appends to a plan the stages that mark the cells of `count` queries. Those that seek nothing mark the last cell, which keeps a few
    /// photons more than need be.
    ///
    /// # Errors
    /// [`MapError::Device`].
    pub fn plan_mark(&self, device: &Device, plan: &mut Plan, queries: &Buffer, count: u32) -> Result<(), MapError> {
        let grid = Grid { photons: count, ..self.grid };
        let grid_buffer = device.upload("seen: grid", &[grid])?;
        let params = device.upload("gather: params", &[GatherParams { queries: count, k: 0, guess: 0.0 }])?;
        let keys = device.scratch::<u32>("sort: query keys", u64::from(count))?;
        plan.each(Kernel::HashQueries, count, &[&params, &grid_buffer, queries, &keys]);
        let keys = RadixSort::plan_keys(device, plan, &keys, count, key_bits(&grid))?;
        let begins = device.scratch::<u32>("seen: cell begins", u64::from(grid.table) + 1)?;
        // Queries have no power.
        let powers = device.buffer::<u32>("seen: powers", 3 * u64::from(count.div_ceil(GRID_BLOCK)))?;
        let power = device.scratch::<u32>("seen: power", 3)?;
        let entries = (grid.table + 1).div_ceil(BEGINS_BLOCK);
        plan.groups(Kernel::CellBegins, entries, &[&grid_buffer, &keys, &powers, &begins, &power]);
        plan.each(Kernel::MarkCells, grid.table, &[&grid_buffer, &begins, &self.seen]);
        Ok(())
    }

    /// Those of `count` photons that are within the radius of a marked cell, in their order, and how many they are.
    ///
    /// # Errors
    /// [`MapError::Device`].
    pub fn keep(&self, device: &Device, photons: &Buffer, count: u32) -> Result<(Buffer, u32), MapError> {
        let grid = device.upload("seen: grid", &[Grid { photons: count, ..self.grid }])?;
        let near = device.scratch::<u32>("seen: photons", u64::from(count))?;
        let mut plan = Plan::new();
        plan.scope("seen");
        plan.each(Kernel::SeePhotons, count, &[&grid, &self.seen, photons, &near]);
        let [offsets, block_offsets, totals] = scan(device, &mut plan, &near, count)?;
        device.run(&plan)?;
        let totals: Vec<u32> = device.read(&totals, u64::from(count.div_ceil(SCAN_BLOCK)))?;
        let kept = totals.iter().sum();
        let out = device.scratch::<Photon>("photons", u64::from(kept))?;
        let mut plan = Plan::new();
        plan.scope("seen");
        plan.each(Kernel::KeepPhotons, count, &[&grid, photons, &near, &offsets, &block_offsets, &out]);
        device.run(&plan)?;
        Ok((out, kept))
    }
}
