//! The estimate from all photons within the radius.

use super::counting::{Place, sum_again};
use super::estimate::over_disc;
use super::power::{Power, scale_of};
use super::{CUT_SHORT, Candidates, GatherParams, search};
use crate::exec::Store;
use crate::grid::{Grid, Row};
use crate::layout::{Arrival, Irradiance, Query, Site};

/// Sums the power of every candidate.
struct All {
    radius2: f32,
    power: Power,
    photons: u32,
}

impl<M: ?Sized, O: ?Sized> Candidates<M, [Arrival], O> for All {
    const SHORT: bool = true;

    #[inline]
    fn bound(&self) -> f32 {
        self.radius2
    }

    #[inline]
    fn offer(&mut self, _memory: &mut M, _output: &mut O, _distance2: f32, slot: u32, _sites: &[Site], arrivals: &[Arrival]) {
        self.power.add(&arrivals[slot as usize]);
        self.photons += 1;
    }
}

/// Irradiance at the `i`-th query from all photons within the grid's radius: their power over the disc π·r_max² (eq. 2.1 with
/// a fixed radius), one walk through the cells.
#[inline]
pub fn gather_density<const LINEAR: bool, I: Store<Irradiance> + ?Sized>(
    i: u32,
    params: &GatherParams,
    grid: &Grid,
    rows: &[Row],
    queries: &[Query],
    query_order: &[u32],
    sites: &[Site],
    arrivals: &[Arrival],
    begins: &[u32],
    power: &[u32],
    irradiance: &mut I,
) {
    if i >= params.queries {
        return;
    }
    let q = query_order[i as usize];
    let query = queries[q as usize];
    let mut result = Irradiance { rgb: [0.0; 3], photons: 0 };
    if query.active != 0 {
        let position = query.position;
        let radius2 = grid.radius2;
        let scale = scale_of(power);
        let mut all = All { radius2, power: Power::new(scale, params.guard), photons: 0 };
        let mut whole = search::<LINEAR, _, _, _, _>(position, grid, rows, sites, arrivals, begins, &mut (), &mut (), &mut all);
        let mut rgb = all.power.value();
        if all.power.is_vague(scale, params.guard, all.photons) {
            let memory = &mut [0u32; 1];
            let (again, ended) = sum_again::<LINEAR, _>(
                memory, position, Place::ALL, radius2, params.guard, grid, rows, sites, arrivals, begins,
            );
            whole = whole && ended;
            rgb = all.power.value_or(&again, scale, params.guard, all.photons);
        }
        result.rgb = over_disc(rgb, radius2, grid);
        result.photons = if whole { all.photons } else { CUT_SHORT };
    }
    irradiance.set(q, result);
}
