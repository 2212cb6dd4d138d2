//! What the gathering stages return: the neighbours themselves, or the irradiance they add up to.

use super::{GatherParams, Selection, search};
use crate::exec::Store;
use crate::grid::Grid;
use crate::layout::{Irradiance, Neighbour, Photon, Query};
use crate::num::{Sum, div, max};

const PI: f32 = core::f32::consts::PI;
/// No candidate is left out.
const NONE: u32 = 0xffff_ffff;

/// Writes the k nearest neighbours of query `i` within the grid's radius, nearest first, to `neighbours[i·k ..]`, and how
/// many there are to `counts[i]`.
#[inline]
pub fn gather_neighbours<S: Selection, N: Store<Neighbour> + ?Sized, C: Store<u32> + ?Sized>(
    i: u32,
    mut selection: S,
    params: &GatherParams,
    grid: &Grid,
    queries: &[Query],
    photons: &[Photon],
    order: &[u32],
    starts: &[u32],
    ends: &[u32],
    neighbours: &mut N,
    counts: &mut C,
) {
    if i >= params.queries {
        return;
    }
    let query = queries[i as usize];
    selection.reset(params.k, grid.radius2);
    if query.active != 0 {
        search(query.position, grid, photons, order, starts, ends, &mut selection);
        selection.sort(order);
    }
    let mut n = 0;
    while n < selection.count() {
        let photon = order[selection.slot(n) as usize];
        neighbours.set(i * params.k + n, Neighbour { distance2: selection.distance2(n), photon });
        n += 1;
    }
    counts.set(i, selection.count());
}

/// Irradiance at query `i` by density estimation (eq. 2.1): the power of the k nearest photons over the disc π·r².
///
/// A diffuse surface of reflectance ρ reflects the radiance ρ/π times this, since f_r = ρ/π is the same for every photon
/// of eq. 2.1. The disc reaches to the (k + 1)-th neighbour, which is not counted: where photons are spread evenly the
/// expected value is then exact, whereas r = r_k overestimates by the factor k / (k − 1) (Fukunaga, "Introduction to
/// Statistical Pattern Recognition", 1990, section 6.2). With fewer than k + 1 within r_max, the disc is π·r_max².
#[inline]
pub fn gather_irradiance<S: Selection, I: Store<Irradiance> + ?Sized>(
    i: u32,
    mut selection: S,
    params: &GatherParams,
    grid: &Grid,
    queries: &[Query],
    photons: &[Photon],
    order: &[u32],
    starts: &[u32],
    ends: &[u32],
    irradiance: &mut I,
) {
    if i >= params.queries {
        return;
    }
    let query = queries[i as usize];
    let mut result = Irradiance { rgb: [0.0, 0.0, 0.0], photons: 0 };
    if query.active != 0 {
        selection.reset(params.k + 1, grid.radius2);
        search(query.position, grid, photons, order, starts, ends, &mut selection);
        let mut radius2 = grid.radius2;
        let mut left_out = NONE;
        result.photons = selection.count();
        if selection.count() > params.k {
            result.photons = params.k;
            left_out = selection.last();
            radius2 = selection.distance2(left_out);
        }
        let rgb = sum_power(&selection, left_out, photons);
        // Photons that all lie in the query's own point span no disc: the largest disc gives a finite lower bound.
        if radius2 == 0.0 {
            radius2 = grid.radius2;
        }
        let area = PI * radius2;
        result.rgb = [div(rgb[0], area), div(rgb[1], area), div(rgb[2], area)];
    }
    irradiance.set(i, result);
}

/// Power of the selected photons, W, without the one at `left_out`: the same bits in whatever order they are held.
#[inline]
fn sum_power<S: Selection>(selection: &S, left_out: u32, photons: &[Photon]) -> [f32; 3] {
    let mut largest = [0.0, 0.0, 0.0];
    let mut n = 0;
    while n < selection.count() {
        if n != left_out {
            let power = photons[selection.slot(n) as usize].power;
            largest = [max(largest[0], power[0]), max(largest[1], power[1]), max(largest[2], power[2])];
        }
        n += 1;
    }
    let mut red = Sum::new(largest[0]);
    let mut green = Sum::new(largest[1]);
    let mut blue = Sum::new(largest[2]);
    n = 0;
    while n < selection.count() {
        if n != left_out {
            let power = photons[selection.slot(n) as usize].power;
            red.add(power[0]);
            green.add(power[1]);
            blue.add(power[2]);
        }
        n += 1;
    }
    [red.value(), green.value(), blue.value()]
}
