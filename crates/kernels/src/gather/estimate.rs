//! What the gathering stages return: the neighbours themselves, or the irradiance they add up to.

use super::power::Power;
use super::{CUT_SHORT, Candidates, GatherParams, Selection, search};
use crate::exec::{Input, Store};
use crate::grid::{Grid, HASH_LINEAR, Row};
use crate::layout::{Arrival, Irradiance, Neighbour, Query, Site};
use crate::num::div;

const PI: f32 = core::f32::consts::PI;
/// No candidate is left out.
const NONE: u32 = 0xffff_ffff;

/// Writes the k nearest neighbours of the `i`-th query within the grid's radius, nearest first, to `neighbours[q·k ..]`, and how
/// many there are, or [`CUT_SHORT`], to `counts[q]`, where `q = query_order[i]` is the query's index.
#[inline]
pub fn gather_neighbours<
    S: Selection + Candidates<(), Input<Site>, ()>,
    N: Store<Neighbour> + ?Sized,
    C: Store<u32> + ?Sized,
>(
    i: u32,
    mut selection: S,
    params: &GatherParams,
    grid: &Grid,
    rows: &Input<Row>,
    queries: &Input<Query>,
    query_order: &Input<u32>,
    sites: &Input<Site>,
    begins: &Input<u32>,
    neighbours: &mut N,
    counts: &mut C,
) {
    if i >= params.queries {
        return;
    }
    let q = query_order[i as usize];
    let query = queries[q as usize];
    selection.reset(params.k, grid.radius2);
    let mut whole = true;
    if query.active != 0 {
        whole = search_any(query.position, grid, rows, sites, sites, begins, &mut selection);
        selection.sort(sites);
    }
    let mut n = 0;
    while n < selection.count() {
        let photon = sites[selection.slot(n) as usize].photon();
        neighbours.set(q * params.k + n, Neighbour { distance2: selection.distance2(n), photon });
        n += 1;
    }
    counts.set(q, if whole && n >= selection.count() { n } else { CUT_SHORT });
}

/// Irradiance at the `i`-th query by density estimation (eq. 2.1): the power of the k nearest photons over the disc π·r².
///
/// A diffuse surface of reflectance ρ reflects the radiance ρ/π times this, since f_r = ρ/π is the same for every photon
/// of eq. 2.1. The disc reaches to the (k + 1)-th neighbour, which is not counted: where photons are spread evenly the
/// expected value is then exact, whereas r = r_k overestimates by the factor k / (k − 1) (Fukunaga, "Introduction to
/// Statistical Pattern Recognition", 1990, section 6.2). With fewer than k + 1 within r_max, the disc is π·r_max².
///
/// `power` is the largest power of any photon in each channel, as bits.
#[inline]
pub fn gather_irradiance<S: Selection + Candidates<(), Input<Arrival>, ()>, I: Store<Irradiance> + ?Sized>(
    i: u32,
    mut selection: S,
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
    let mut result = Irradiance { rgb: [0.0, 0.0, 0.0], photons: 0 };
    if query.active != 0 {
        selection.reset(params.k + 1, grid.radius2);
        let whole = search_any(query.position, grid, rows, sites, arrivals, begins, &mut selection);
        let mut radius2 = grid.radius2;
        let mut left_out = NONE;
        result.photons = selection.count();
        if selection.count() > params.k {
            result.photons = params.k;
            left_out = selection.last();
            radius2 = selection.distance2(left_out);
        }
        let rgb = sum_power(&selection, left_out, arrivals).value(power);
        result.rgb = over_disc(rgb, radius2, grid.radius2);
        if !whole {
            result.photons = CUT_SHORT;
        }
    }
    irradiance.set(q, result);
}

/// A search in a table of either kind.
#[inline]
fn search_any<A: ?Sized, S: Candidates<(), A, ()>>(
    position: [f32; 3],
    grid: &Grid,
    rows: &Input<Row>,
    sites: &Input<Site>,
    arrivals: &A,
    begins: &Input<u32>,
    selection: &mut S,
) -> bool {
    if grid.hash == HASH_LINEAR {
        search::<true, _, _, _, _, _>(position, grid, rows, sites, arrivals, begins, &mut (), &mut (), selection)
    } else {
        search::<false, _, _, _, _, _>(position, grid, rows, sites, arrivals, begins, &mut (), &mut (), selection)
    }
}

/// Power of the selected photons, without the one at `left_out`.
#[inline]
fn sum_power<S: Selection>(selection: &S, left_out: u32, arrivals: &Input<Arrival>) -> Power {
    let mut power = Power::new();
    let mut n = 0;
    while n < selection.count() {
        if n != left_out {
            power.add(arrivals[selection.slot(n) as usize]);
        }
        n += 1;
    }
    power
}

/// Irradiance of a power that arrives on the disc of squared radius `radius2`, W·m⁻². Photons that all lie in the query's own
/// point span no disc: the largest disc, of squared radius `largest`, gives a finite lower bound.
#[inline]
pub(crate) fn over_disc(power: [f32; 3], radius2: f32, largest: f32) -> [f32; 3] {
    let area = PI * if radius2 == 0.0 { largest } else { radius2 };
    [div(power[0], area), div(power[1], area), div(power[2], area)]
}
