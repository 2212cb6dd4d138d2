//! The estimate from all photons within the radius.

use super::estimate::over_disc;
use super::power::Power;
use super::{CUT_SHORT, Candidates, GatherParams, search};
use crate::exec::{Input, Store};
use crate::grid::{Grid, Row};
use crate::layout::{Arrival, Irradiance, Query, Site};
use crate::num::MAX_TERMS;

/// Sums the power of every candidate.
struct All {
    radius2: f32,
    power: Power,
    /// What has left the highest limb of each channel.
    above: [u32; 3],
    photons: u32,
}

impl<M: ?Sized, O: ?Sized> Candidates<M, Input<Arrival>, O> for All {
    const SHORT: bool = true;

    #[inline]
    fn bound(&self) -> f32 {
        self.radius2
    }

    #[inline]
    fn offer(
        &mut self,
        _memory: &mut M,
        _output: &mut O,
        _distance2: f32,
        slot: u32,
        _sites: &Input<Site>,
        arrivals: &Input<Arrival>,
    ) {
        self.power.add(arrivals[slot as usize]);
        self.photons += 1;
        if self.photons & (MAX_TERMS / 2 - 1) == 0 {
            let left = self.power.settle();
            self.above = [self.above[0] + left[0], self.above[1] + left[1], self.above[2] + left[2]];
        }
    }
}

/// Irradiance at the `i`-th query from all photons within the grid's radius: their power over the disc π·r_max² (eq. 2.1 with
/// a fixed radius), one walk through the cells.
#[inline]
pub fn gather_density<const LINEAR: bool, I: Store<Irradiance> + ?Sized>(
    i: u32,
    params: &GatherParams,
    grid: &Grid,
    rows: &Input<Row>,
    queries: &Input<Query>,
    query_order: &Input<u32>,
    sites: &Input<Site>,
    arrivals: &Input<Arrival>,
    begins: &Input<u32>,
    power: &Input<u32>,
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
        let mut all = All { radius2, power: Power::new(), above: [0; 3], photons: 0 };
        let memory = &mut ();
        let whole =
            search::<LINEAR, _, _, _, _, _>(position, grid, rows, sites, arrivals, begins, memory, &mut (), &mut all);
        let channel = |n: usize| all.power.channel(n).value_with(all.above[n], f32::from_bits(power[n]));
        result.rgb = over_disc([channel(0), channel(1), channel(2)], radius2, grid.radius2);
        result.photons = if whole { all.photons } else { CUT_SHORT };
    }
    irradiance.set(q, result);
}
