//! The photon map: its construction and its search, as plans or at once.

mod density;
mod estimate;
mod neighbours;

pub use estimate::{Estimate, Filter, Nearest, Seen, Surface};
pub use neighbours::Neighbours;

use crate::grid::{MAX_PHOTONS, bounds, plan_grid, rows};
use crate::options::irradiance_kernel;
use crate::{Gather, LargestPower, MapError, MapOptions, RadixSort};
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::gather::{CUT_SHORT, Compact, GatherParams, Placed};
use caustic_kernels::grid::{BEGINS_BLOCK, GRID_BLOCK, Grid, HASH_LINEAR, Row};
use caustic_kernels::layout::{Arrival, Irradiance, Photon, Query, Site};

/// A photon map on a device.
#[derive(Clone)]
pub struct PhotonMap {
    grid: Grid,
    grid_buffer: Buffer,
    rows: Buffer,
    /// Of a compact map its records are all there is.
    compact: Option<Buffer>,
    sites: Buffer,
    arrivals: Buffer,
    begins: Buffer,
    power: Buffer,
}

/// What a map keeps of its photons.
enum Records {
    /// All of it, with powers aligned to the largest.
    Whole,
    /// The same, with powers aligned to these: none is larger.
    Below(LargestPower),
    /// What 16 bytes hold.
    Compact,
}

impl PhotonMap {
    /// Appends the construction of a map over the photons in `unsorted` to a plan: hash, sort, begins, reorder. The map can be
    /// used by the stages that follow.
    ///
    /// # Errors
    /// [`MapError::Device`].
    pub fn plan(device: &Device, plan: &mut Plan, unsorted: &Buffer, grid: Grid) -> Result<Self, MapError> {
        Self::plan_with_rows(device, plan, unsorted, grid, &rows(&grid))
    }

    /// The same with photons of 16 bytes, a quarter of what they take else: positions are rounded to [`Grid::step`] and powers to a 256th of
    /// their largest channel, in `unsorted` as well. Only estimates of [`Surface::Any`] can be made from it.
    ///
    /// # Errors
    /// [`MapError::Device`].
    pub fn plan_compact(device: &Device, plan: &mut Plan, unsorted: &Buffer, grid: Grid) -> Result<Self, MapError> {
        let grid_buffer = device.upload("map: grid of steps", &[grid])?;
        plan.each(Kernel::SnapPhotons, grid.photons, &[&grid_buffer, unsorted]);
        Self::plan_records(device, plan, unsorted, grid, &rows(&grid), Records::Compact).map(|(map, _)| map)
    }

    /// [`PhotonMap::plan`] with powers aligned to `largest` instead of the largest of these photons, of which there is a buffer as well: three
    /// floats. Where one of them has a larger exponent than `largest`, the powers of this map are wrong.
    ///
    /// # Errors
    /// [`MapError::Device`].
    pub fn plan_below(
        device: &Device,
        plan: &mut Plan,
        unsorted: &Buffer,
        grid: Grid,
        largest: LargestPower,
    ) -> Result<(Self, Buffer), MapError> {
        Self::plan_records(device, plan, unsorted, grid, &rows(&grid), Records::Below(largest))
    }

    /// [`PhotonMap::plan`] with rows of cells of the caller's, for the measurement of others than [`rows`]. A search ends at the first
    /// row whose least distance is beyond its bound, so all rows after it have to be as far.
    ///
    /// # Errors
    /// [`MapError::Device`].
    pub fn plan_with_rows(
        device: &Device,
        plan: &mut Plan,
        unsorted: &Buffer,
        grid: Grid,
        rows: &[Row],
    ) -> Result<Self, MapError> {
        Self::plan_records(device, plan, unsorted, grid, rows, Records::Whole).map(|(map, _)| map)
    }

    /// The map, and the largest powers of these photons.
    fn plan_records(
        device: &Device,
        plan: &mut Plan,
        unsorted: &Buffer,
        mut grid: Grid,
        rows: &[Row],
        records: Records,
    ) -> Result<(Self, Buffer), MapError> {
        grid.rows = rows.len() as u32;
        let count = grid.photons;
        let blocks = count.div_ceil(GRID_BLOCK);
        let grid_buffer = device.upload("map: grid", &[grid])?;
        let rows = device.upload("map: rows", rows)?;
        let keys = device.scratch::<u32>("sort: keys", u64::from(count))?;
        let powers = device.scratch::<u32>("map: powers", 3 * u64::from(blocks))?;
        plan.groups(Kernel::HashPhotons, blocks, &[&grid_buffer, unsorted, &keys, &powers]);
        let sorted = RadixSort::plan(device, plan, &keys, count, key_bits(&grid))?;
        let begins = device.scratch::<u32>("map: cell begins", u64::from(grid.table) + 1)?;
        let own = device.scratch::<u32>("map: power", 3)?;
        let entries = (grid.table + 1).div_ceil(BEGINS_BLOCK);
        plan.groups(Kernel::CellBegins, entries, &[&grid_buffer, &sorted.keys, &powers, &begins, &own]);
        let power = match records {
            Records::Below(largest) => device.upload("map: power", &[largest.0])?,
            _ => own.clone(),
        };
        let compact = matches!(records, Records::Compact);
        let whole = u64::from(if compact { 0 } else { count });
        let sites = device.scratch::<Site>("map: sites", whole)?;
        let arrivals = device.scratch::<Arrival>("map: arrivals", whole)?;
        let compact = compact.then(|| device.scratch::<Compact>("map: records", u64::from(count))).transpose()?;
        let from = [&grid_buffer, &sorted.order, unsorted];
        match &compact {
            Some(records) => plan.each(Kernel::ReorderCompact, count, &[&from[..], &[records]].concat()),
            None => {
                plan.each(Kernel::ReorderPhotons, count, &[&from[..], &[&power, &sites, &arrivals]].concat());
            }
        }
        Ok((Self { grid, grid_buffer, rows, compact, sites, arrivals, begins, power }, own))
    }

    /// Builds a map of `photons`.
    ///
    /// # Errors
    /// All of [`MapError`] but those of queries.
    pub fn build(device: &Device, photons: &[Photon], options: &MapOptions) -> Result<Self, MapError> {
        Self::build_with(device, photons, options, Self::plan)
    }

    /// Builds a compact map of `photons`: see [`PhotonMap::plan_compact`].
    ///
    /// # Errors
    /// All of [`MapError`] but those of queries.
    pub fn build_compact(device: &Device, photons: &[Photon], options: &MapOptions) -> Result<Self, MapError> {
        Self::build_with(device, photons, options, Self::plan_compact)
    }

    /// [`PhotonMap::build`] with powers aligned to `largest`, of which none of these is larger.
    pub(crate) fn build_below(
        device: &Device,
        photons: &[Photon],
        options: &MapOptions,
        largest: LargestPower,
    ) -> Result<Self, MapError> {
        Self::build_with(device, photons, options, |device, plan, unsorted, grid| {
            Self::plan_below(device, plan, unsorted, grid, largest).map(|(map, _)| map)
        })
    }

    fn build_with(
        device: &Device,
        photons: &[Photon],
        options: &MapOptions,
        plan_map: impl FnOnce(&Device, &mut Plan, &Buffer, Grid) -> Result<Self, MapError>,
    ) -> Result<Self, MapError> {
        let (low, high) = bounds("photons", photons.iter().map(|photon| photon.position))?;
        let bad = |photon: &&Photon| !photon.power.iter().all(|power| power.is_finite() && *power >= 0.0);
        if let Some(first) = photons.iter().position(|photon| bad(&photon)) {
            return Err(MapError::Power { count: photons.iter().filter(bad).count(), first });
        }
        let sample = sample(photons);
        let grid = plan_grid(low, high, photons.len() as u64, &sample, options)?;
        let unsorted = device.upload("photons", photons)?;
        let mut plan = Plan::new();
        let map = plan_map(device, &mut plan, &unsorted, grid)?;
        device.run(&plan)?;
        Ok(map)
    }

    /// The same map with half the largest squared radius: its discs have half the area.
    ///
    /// # Errors
    /// [`MapError::Device`].
    pub fn halved(&self, device: &Device) -> Result<Self, MapError> {
        let grid = Grid { radius2: 0.5 * self.grid.radius2, ..self.grid };
        // Rows of cells for the larger radius are more than enough: a search ends where they are too far.
        Ok(Self { grid, grid_buffer: device.upload("map: grid", &[grid])?, ..self.clone() })
    }

    /// The grid of the map.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The map's buffers: sites and arrivals in sorted order, of which a compact map has none, and where each table entry begins.
    #[must_use]
    pub fn buffers(&self) -> [&Buffer; 3] {
        [&self.sites, &self.arrivals, &self.begins]
    }

    /// The sites of the photons, in sorted order.
    pub(crate) fn sites(&self, device: &Device) -> Result<Vec<Site>, MapError> {
        let count = u64::from(self.grid.photons);
        let Some(records) = &self.compact else { return Ok(device.read(&self.sites, count)?) };
        let records: Vec<Compact> = device.read(records, count)?;
        Ok(records.iter().map(|record| Site::new(record.position(&self.grid), record.photon())).collect())
    }

    /// What a search by other means needs: the grid, its rows of cells, the sites and where each table entry begins.
    #[must_use]
    pub fn search_buffers(&self) -> [&Buffer; 4] {
        [&self.grid_buffer, &self.rows, &self.sites, &self.begins]
    }

    /// Bytes that the map takes on its device.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.buffers().into_iter().chain(&self.compact).map(Buffer::bytes).sum()
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
        if let Some(records) = &self.compact {
            let estimate = Estimate { k: Some(k), ..Estimate::default() };
            return self.append_compact(device, plan, records, queries, count, &estimate, out);
        }
        let kernel = irradiance_kernel(gather, k, device.is_gpu(), self.grid.hash == HASH_LINEAR)?;
        let search = self.plan_search(device, plan, queries, count, k, k + 1)?;
        plan.each(kernel, count, &self.estimate_buffers(&search, queries, out));
        Ok(())
    }

    /// Puts queries in the order of their cells.
    fn plan_search(
        &self,
        device: &Device,
        plan: &mut Plan,
        queries: &Buffer,
        count: u32,
        k: u32,
        wanted: u32,
    ) -> Result<Search, MapError> {
        let params = device.upload("gather: params", &[GatherParams { queries: count, k, guess: guess(wanted) }])?;
        let keys = device.scratch::<u32>("sort: query keys", u64::from(count))?;
        plan.each(Kernel::HashQueries, count, &[&params, &self.grid_buffer, queries, &keys]);
        let order = RadixSort::plan(device, plan, &keys, count, key_bits(&self.grid))?.order;
        Ok(Search { params, order })
    }

    /// The buffers of an estimate.
    fn estimate_buffers<'a>(&'a self, search: &'a Search, queries: &'a Buffer, out: &'a Buffer) -> [&'a Buffer; 10] {
        let Search { params, order } = search;
        let Self { grid_buffer, rows, sites, arrivals, begins, power, .. } = self;
        [params, grid_buffer, rows, queries, order, sites, arrivals, begins, power, out]
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
        estimates(device, queries, |plan, query_buffer, count, out| {
            self.plan_irradiance(device, plan, query_buffer, count, k, gather, out)
        })
    }
}

/// Queries in the order in which they are searched.
struct Search {
    params: Buffer,
    order: Buffer,
}

/// Bits of the table entries.
pub(crate) fn key_bits(grid: &Grid) -> u32 {
    u32::BITS - (grid.table - 1).leading_zeros()
}

/// [`GatherParams::guess`] for so many wanted photons. Their number in a ball varies by its root: two and a half of it on top
/// make nearly every guess hold enough.
fn guess(wanted: u32) -> f32 {
    let wanted = f64::from(wanted);
    ((wanted + 2.5 * wanted.sqrt()) / (4.0 / 3.0 * std::f64::consts::PI)).powf(2.0 / 3.0) as f32
}

/// Positions of some photons, evenly from all, m: what [`plan_grid`] wants to see of them.
#[must_use]
pub fn sample(photons: &[Photon]) -> Vec<[f32; 3]> {
    photons.iter().step_by(photons.len().div_ceil(4096).max(1)).map(|photon| photon.position).collect()
}

/// Runs an estimate for queries of the host.
fn estimates(
    device: &Device,
    queries: &[Query],
    plan_estimate: impl FnOnce(&mut Plan, &Buffer, u32, &Buffer) -> Result<(), MapError>,
) -> Result<Vec<Irradiance>, MapError> {
    let count = query_count(queries)?;
    let query_buffer = device.upload("queries", queries)?;
    let out = device.scratch::<Irradiance>("irradiance", u64::from(count))?;
    let mut plan = Plan::new();
    plan_estimate(&mut plan, &query_buffer, count, &out)?;
    device.run(&plan)?;
    let estimates: Vec<Irradiance> = device.read(&out, u64::from(count))?;
    whole(device, estimates.iter().map(|estimate| estimate.photons))?;
    Ok(estimates)
}

/// Refuses results of searches that the device ended early, which say [`CUT_SHORT`] where they say how many photons they found.
///
/// # Errors
/// [`MapError::CutShort`].
pub fn whole(device: &Device, counts: impl Iterator<Item = u32>) -> Result<(), MapError> {
    match counts.filter(|&count| count == CUT_SHORT).count() {
        0 => Ok(()),
        searches => Err(MapError::CutShort { device: device.name(), searches }),
    }
}

/// The number of queries.
///
/// # Errors
/// [`MapError::NotFinite`] and [`MapError::TooMany`].
pub fn query_count(queries: &[Query]) -> Result<u32, MapError> {
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
        let options = MapOptions { radius: 1.0, hash: Hash::Linear, table: None, cell: None };
        let error = PhotonMap::build(&Device::cpu(), &photons, &options).err();
        assert!(matches!(error, Some(MapError::Power { count: 3, first: 1 })), "{error:?}");
    }
}
