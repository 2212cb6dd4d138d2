//! The estimate from all photons within the radius, of one map or of one after another.

use super::estimate::over_disc;
use super::power::Power;
use super::{CUT_SHORT, Candidates, GatherParams, search};
use crate::exec::{Input, Store, Update};
use crate::grid::{Grid, Row};
use crate::layout::{Arrival, Irradiance, PowerSum, Query, Site};
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
            self.settle();
        }
    }
}

impl All {
    /// Nothing yet.
    #[inline]
    fn new(radius2: f32) -> Self {
        Self { radius2, power: Power::new(), above: [0; 3], photons: 0 }
    }

    /// What was found before, whose limbs are settled: like one term more.
    #[inline]
    fn after(sum: &PowerSum, radius2: f32) -> Self {
        let power = Power::of_limbs(sum.high, sum.middle, sum.low);
        Self { radius2, power, above: sum.above, photons: 0 }
    }

    #[inline]
    fn settle(&mut self) {
        let left = self.power.settle();
        self.above = [self.above[0] + left[0], self.above[1] + left[1], self.above[2] + left[2]];
    }

    /// Irradiance of what was found: its power over the disc. `power` are the largest powers, to which limbs are aligned, as bits.
    #[inline]
    fn irradiance(&self, power: &Input<u32>) -> [f32; 3] {
        let channel = |n: usize| self.power.channel(n).value_with(self.above[n], f32::from_bits(power[n]));
        over_disc([channel(0), channel(1), channel(2)], self.radius2, self.radius2)
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
        let mut all = All::new(grid.radius2);
        let memory = &mut ();
        let whole =
            search::<LINEAR, _, _, _, _, _>(position, grid, rows, sites, arrivals, begins, memory, &mut (), &mut all);
        result.rgb = all.irradiance(power);
        result.photons = if whole { all.photons } else { CUT_SHORT };
    }
    irradiance.set(q, result);
}

/// Adds what [`gather_density`] would sum up at the `i`-th query to the query's sum, so that many maps count as one of all their
/// photons. The maps' powers have to be aligned to the same largest ones, and all photons together to be fewer than [`CUT_SHORT`].
#[inline]
pub fn gather_power<const LINEAR: bool, S: Update<PowerSum> + ?Sized>(
    i: u32,
    params: &GatherParams,
    grid: &Grid,
    rows: &Input<Row>,
    queries: &Input<Query>,
    query_order: &Input<u32>,
    sites: &Input<Site>,
    arrivals: &Input<Arrival>,
    begins: &Input<u32>,
    sums: &mut S,
) {
    if i >= params.queries {
        return;
    }
    let q = query_order[i as usize];
    let query = queries[q as usize];
    if query.active != 0 {
        let position = query.position;
        let before = sums.get(q);
        let mut all = All::after(&before, grid.radius2);
        let memory = &mut ();
        let whole =
            search::<LINEAR, _, _, _, _, _>(position, grid, rows, sites, arrivals, begins, memory, &mut (), &mut all);
        all.settle();
        // A search that was ended early stays one, whatever is added later.
        let photons = if whole && before.photons != CUT_SHORT { before.photons + all.photons } else { CUT_SHORT };
        let [high, middle, low] = all.power.limbs();
        sums.set(q, PowerSum { high, middle, low, above: all.above, photons });
    }
}

/// The estimate that a sum of [`gather_power`] stands for: that of [`gather_density`] in a map of all photons.
#[inline]
#[must_use]
pub fn density_of(sum: &PowerSum, radius2: f32, power: &Input<u32>) -> Irradiance {
    Irradiance { rgb: All::after(sum, radius2).irradiance(power), photons: sum.photons }
}
