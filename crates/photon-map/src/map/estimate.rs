//! Estimates of any kind: filtered, of one surface, from the k nearest photons or from all within the radius.

use super::{PhotonMap, estimates, query_count, whole};
use crate::{Gather, MAX_K, MapError};
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::gather::{
    EstimateParams, FILTER_CONE, FILTER_CONSTANT, FILTER_EPANECHNIKOV, FILTER_GAUSSIAN, Reach, SURFACE_ANY,
    SURFACE_FACING, SURFACE_OWN,
};
use caustic_kernels::grid::HASH_LINEAR;
use caustic_kernels::layout::{Irradiance, Query};
use caustic_kernels::trace::{Primitive, Vertex};

/// How much a photon counts, by its distance d within the radius r. All are normalised: an even irradiance is estimated as what
/// it is. The narrower ones blur less and are noisier.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// 1.
    #[default]
    Constant,
    /// 1 − d/r (Jensen 2001, section 7.4).
    Cone,
    /// Jensen's truncated Gaussian, 1 − (1 − e^(−β·d²/2r²)) / (1 − e^(−β)) with β = 1.953.
    Gaussian,
    /// 1 − d²/r² (Silverman 1986): the least mean squared error.
    Epanechnikov,
}

impl Filter {
    fn code(self) -> u32 {
        match self {
            Self::Constant => FILTER_CONSTANT,
            Self::Cone => FILTER_CONE,
            Self::Gaussian => FILTER_GAUSSIAN,
            Self::Epanechnikov => FILTER_EPANECHNIKOV,
        }
    }
}

/// Which photons around a point count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Surface {
    /// All within the radius.
    #[default]
    Any,
    /// Those that arrived on the side that is seen, of surfaces within 45° of this one, and near its tangent plane.
    Facing,
    /// Those that arrived on the side that is seen of the same quad or sphere, over the part of the disc that lies on it: no light
    /// comes through thin walls or from around corners, and edges keep their brightness. On meshes like `Facing`.
    Own,
}

impl Surface {
    fn code(self) -> u32 {
        match self {
            Self::Any => SURFACE_ANY,
            Self::Facing => SURFACE_FACING,
            Self::Own => SURFACE_OWN,
        }
    }
}

/// How far the k nearest photons are taken to reach.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Nearest {
    /// As far as they do.
    #[default]
    Exact,
    /// As far as the number of photons in the cells around says, without a look at them: all within that radius count, so that they are k
    /// photons about. Unlike all else about a map, this depends on its cells, and so on what chooses their width.
    Approximate,
}

/// How an irradiance is estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Estimate {
    /// How much a photon counts.
    pub filter: Filter,
    /// Which count.
    pub surface: Surface,
    /// The estimate is over the disc that reaches to the (k + 1)-th nearest photon; over that of the map's radius if not given.
    pub k: Option<u32>,
    /// How the k nearest are found, where nothing but their power is asked for. Other estimates find them by counting.
    pub gather: Gather,
    /// Whether they are the k nearest.
    pub nearest: Nearest,
}

impl Estimate {
    /// The estimate from half of the area: from half of the photons, where it is from the k nearest. k + 1 of them reach as far as the disc.
    #[must_use]
    pub fn halved(self) -> Self {
        Self { k: self.k.map(|k| (k.saturating_sub(1) / 2).max(1)), ..self }
    }

    /// Whether photons need to know on which side they arrived: [`PhotonMap::plan_sides`].
    #[must_use]
    pub fn needs_sides(&self) -> bool {
        self.surface != Surface::Any
    }
}

/// Points at which irradiance is estimated.
#[derive(Clone, Copy)]
pub struct Seen<'a> {
    /// Records of [`Query`].
    pub queries: &'a Buffer,
    /// A [`Vertex`] for each, and the scene's [`Primitive`]s: what surfaces the points lie on.
    pub surfaces: Option<[&'a Buffer; 2]>,
}

impl PhotonMap {
    /// Appends to a plan the stage that gives each photon the normal of the side on which it arrived; its index of a primitive is one
    /// of `primitives`.
    pub fn plan_sides(&self, plan: &mut Plan, primitives: &Buffer) {
        let buffers = [&self.grid_buffer, primitives, &self.sites, &self.arrivals];
        plan.each(Kernel::FaceArrivals, self.grid.photons, &buffers);
    }

    /// Appends the reach of the `k` `nearest` photons of `count` queries to a plan: a record of [`Reach`] each.
    ///
    /// # Errors
    /// [`MapError::K`] and [`MapError::Device`].
    pub fn plan_reaches(
        &self,
        device: &Device,
        plan: &mut Plan,
        queries: &Buffer,
        count: u32,
        k: u32,
        nearest: Nearest,
    ) -> Result<Buffer, MapError> {
        let search = self.plan_search(device, plan, queries, count, known(k)?, k + 1)?;
        self.append_reaches(device, plan, queries, count, &search, nearest)
    }

    /// How far the `k` nearest photons of each query reach, or are taken to reach.
    ///
    /// # Errors
    /// [`MapError::NotFinite`], [`MapError::K`], [`MapError::TooMany`], [`MapError::CutShort`] and [`MapError::Device`].
    pub fn reaches(
        &self,
        device: &Device,
        queries: &[Query],
        k: u32,
        nearest: Nearest,
    ) -> Result<Vec<Reach>, MapError> {
        let count = query_count(queries)?;
        let query_buffer = device.upload("queries", queries)?;
        let mut plan = Plan::new();
        let reaches = self.plan_reaches(device, &mut plan, &query_buffer, count, k, nearest)?;
        device.run(&plan)?;
        let reaches: Vec<Reach> = device.read(&reaches, u64::from(count))?;
        whole(device, reaches.iter().map(|reach| reach.photons))?;
        Ok(reaches)
    }

    fn append_reaches(
        &self,
        device: &Device,
        plan: &mut Plan,
        queries: &Buffer,
        count: u32,
        super::Search { params, order }: &super::Search,
        nearest: Nearest,
    ) -> Result<Buffer, MapError> {
        let reaches = device.scratch::<Reach>("reaches", u64::from(count))?;
        let compact = self.compact.is_some();
        let kernel = match (nearest, self.grid.hash == HASH_LINEAR) {
            (Nearest::Exact, true) if compact => Kernel::ReachCompact,
            (Nearest::Exact, false) if compact => Kernel::ReachCompactHashed,
            (Nearest::Exact, true) => Kernel::ReachHistogram,
            (Nearest::Exact, false) => Kernel::ReachHistogramHashed,
            (Nearest::Approximate, true) => Kernel::LikelyReach,
            (Nearest::Approximate, false) if compact => Kernel::LikelyReachCompact,
            (Nearest::Approximate, false) => Kernel::LikelyReachHashed,
        };
        let Self { grid_buffer, rows, begins, .. } = self;
        let rows = (nearest == Nearest::Exact).then_some(rows);
        // A run of cells is counted without a look at the photons.
        let photons = (kernel != Kernel::LikelyReach).then_some(self.compact.as_ref().unwrap_or(&self.sites));
        let cells = [params, grid_buffer].into_iter().chain(rows);
        let buffers: Vec<_> = cells.chain([queries, order]).chain(photons).chain([begins, &reaches]).collect();
        plan.each(kernel, count, &buffers);
        Ok(reaches)
    }

    /// Appends an estimate for `count` points to a plan: a record of [`Irradiance`] each. A constant filter over any surface takes the
    /// stages of [`plan_irradiance`](Self::plan_irradiance) and [`plan_density`](Self::plan_density).
    ///
    /// # Errors
    /// [`MapError::K`], [`MapError::Compact`] and [`MapError::Device`].
    ///
    /// # Panics
    /// If the surface matters and the points have none.
    pub fn plan_estimate(
        &self,
        device: &Device,
        plan: &mut Plan,
        seen: Seen<'_>,
        count: u32,
        estimate: &Estimate,
        out: &Buffer,
    ) -> Result<(), MapError> {
        let queries = seen.queries;
        if let Some(records) = &self.compact {
            if estimate.needs_sides() {
                return Err(MapError::Compact { what: "estimates of one surface" });
            }
            return self.append_compact(device, plan, records, queries, count, estimate, out);
        }
        let usual = estimate.filter == Filter::Constant && estimate.surface == Surface::Any;
        if usual && (estimate.nearest == Nearest::Exact || estimate.k.is_none()) {
            return match estimate.k {
                Some(k) => self.plan_irradiance(device, plan, queries, count, k, estimate.gather, out),
                None => self.plan_density(device, plan, queries, count, out),
            };
        }
        assert!(seen.surfaces.is_some() || !estimate.needs_sides(), "points without surfaces");
        let k = estimate.k.map_or(Ok(0), known)?;
        let search = self.plan_search(device, plan, queries, count, k, k + 1)?;
        let reaches = match estimate.k {
            Some(_) => self.append_reaches(device, plan, queries, count, &search, estimate.nearest)?,
            None => device.scratch::<Reach>("reaches", 0)?,
        };
        let (filter, surface) = (estimate.filter.code(), estimate.surface.code());
        let params = EstimateParams { queries: count, filter, surface, reach: u32::from(estimate.k.is_some()) };
        let params = device.upload("estimate: params", &[params])?;
        let none = [device.scratch::<Vertex>("no vertices", 0)?, device.scratch::<Primitive>("no primitives", 0)?];
        let [vertices, primitives] = seen.surfaces.unwrap_or([&none[0], &none[1]]);
        let linear = self.grid.hash == HASH_LINEAR;
        let kernel = if linear { Kernel::IrradianceFiltered } else { Kernel::IrradianceFilteredHashed };
        let Self { grid_buffer, rows, sites, arrivals, begins, power, .. } = self;
        let order = &search.order;
        let known = [&params, grid_buffer, rows, queries, order, &reaches, vertices, primitives];
        plan.each(kernel, count, &[&known[..], &[sites, arrivals, begins, power, out]].concat());
        Ok(())
    }

    /// An estimate from a compact map.
    pub(super) fn append_compact(
        &self,
        device: &Device,
        plan: &mut Plan,
        records: &Buffer,
        queries: &Buffer,
        count: u32,
        estimate: &Estimate,
        out: &Buffer,
    ) -> Result<(), MapError> {
        let k = estimate.k.map_or(Ok(0), known)?;
        let search = self.plan_search(device, plan, queries, count, k, k + 1)?;
        let reaches = match estimate.k {
            Some(_) => self.append_reaches(device, plan, queries, count, &search, estimate.nearest)?,
            None => device.scratch::<Reach>("reaches", 0)?,
        };
        let reach = u32::from(estimate.k.is_some());
        let params = EstimateParams { queries: count, filter: estimate.filter.code(), surface: SURFACE_ANY, reach };
        let params = device.upload("estimate: params", &[params])?;
        let linear = self.grid.hash == HASH_LINEAR;
        let kernel = if linear { Kernel::IrradianceCompact } else { Kernel::IrradianceCompactHashed };
        let Self { grid_buffer, rows, begins, power, .. } = self;
        let order = &search.order;
        plan.each(kernel, count, &[&params, grid_buffer, rows, queries, order, &reaches, records, begins, power, out]);
        Ok(())
    }

    /// An estimate at each query, of which nothing but the place is known.
    ///
    /// # Errors
    /// [`MapError::NotFinite`], [`MapError::K`], [`MapError::TooMany`], [`MapError::CutShort`] and [`MapError::Device`].
    ///
    /// # Panics
    /// If the surface matters.
    pub fn estimate(
        &self,
        device: &Device,
        queries: &[Query],
        estimate: &Estimate,
    ) -> Result<Vec<Irradiance>, MapError> {
        estimates(device, queries, |plan, queries, count, out| {
            self.plan_estimate(device, plan, Seen { queries, surfaces: None }, count, estimate, out)
        })
    }
}

/// A number of photons that kernels are compiled for.
fn known(k: u32) -> Result<u32, MapError> {
    if k == 0 || k > MAX_K { Err(MapError::K { k: u64::from(k), max: MAX_K }) } else { Ok(k) }
}
