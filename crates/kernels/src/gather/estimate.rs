//! What the gathering stages return: the neighbours themselves, or the irradiance they add up to.

use super::{CUT_SHORT, GatherParams, Selection, search};
use crate::exec::Store;
use crate::grid::Grid;
use crate::layout::{Irradiance, Neighbour, Photon, Query};
use crate::num::{Sum, div, max};

const PI: f32 = core::f32::consts::PI;
/// No candidate is left out.
const NONE: u32 = 0xffff_ffff;

/// Writes the k nearest neighbours of query `i` within the grid's radius, nearest first, to `neighbours[i·k ..]`, and how
/// many there are, or [`CUT_SHORT`], to `counts[i]`.
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
    let mut whole = true;
    if query.active != 0 {
        whole = search(query.position, grid, photons, order, starts, ends, &mut selection);
        selection.sort(order);
    }
    let mut n = 0;
    while n < selection.count() {
        let photon = order[selection.slot(n) as usize];
        neighbours.set(i * params.k + n, Neighbour { distance2: selection.distance2(n), photon });
        n += 1;
    }
    counts.set(i, if whole && n >= selection.count() { n } else { CUT_SHORT });
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
        let whole = search(query.position, grid, photons, order, starts, ends, &mut selection);
        let mut radius2 = grid.radius2;
        let mut left_out = NONE;
        result.photons = selection.count();
        if selection.count() > params.k {
            result.photons = params.k;
            left_out = selection.last();
            radius2 = selection.distance2(left_out);
        }
        result.rgb = over_disc(sum_power(&selection, left_out, photons), radius2, grid);
        if !whole {
            result.photons = CUT_SHORT;
        }
    }
    irradiance.set(i, result);
}

/// Power of photons, W, added up so that their order does not show: all are aligned to first, then all are added.
#[derive(Clone, Copy)]
pub(super) struct Power {
    largest: [f32; 3],
    sums: [Sum; 3],
}

impl Power {
    #[inline]
    pub(super) fn new() -> Self {
        Self { largest: [0.0; 3], sums: [Sum::new(0.0); 3] }
    }

    /// Makes room for the powers of a photon.
    #[inline]
    pub(super) fn align(&mut self, photon: &Photon) {
        let power = photon.power;
        self.largest = [max(self.largest[0], power[0]), max(self.largest[1], power[1]), max(self.largest[2], power[2])];
        self.sums = [Sum::new(self.largest[0]), Sum::new(self.largest[1]), Sum::new(self.largest[2])];
    }

    /// Adds the powers of a photon that was aligned to.
    #[inline]
    pub(super) fn add(&mut self, photon: &Photon) {
        self.sums[0].add(photon.power[0]);
        self.sums[1].add(photon.power[1]);
        self.sums[2].add(photon.power[2]);
    }

    #[inline]
    pub(super) fn value(&self) -> [f32; 3] {
        [self.sums[0].value(), self.sums[1].value(), self.sums[2].value()]
    }
}

/// Power of the selected photons, W, without the one at `left_out`.
#[inline]
fn sum_power<S: Selection>(selection: &S, left_out: u32, photons: &[Photon]) -> [f32; 3] {
    let mut power = Power::new();
    let mut n = 0;
    while n < selection.count() {
        if n != left_out {
            power.align(&photons[selection.slot(n) as usize]);
        }
        n += 1;
    }
    n = 0;
    while n < selection.count() {
        if n != left_out {
            power.add(&photons[selection.slot(n) as usize]);
        }
        n += 1;
    }
    power.value()
}

/// Irradiance of a power that arrives on the disc of squared radius `radius2`, W·m⁻². Photons that all lie in the query's own
/// point span no disc: the largest disc gives a finite lower bound.
#[inline]
pub(super) fn over_disc(power: [f32; 3], radius2: f32, grid: &Grid) -> [f32; 3] {
    let area = PI * if radius2 == 0.0 { grid.radius2 } else { radius2 };
    [div(power[0], area), div(power[1], area), div(power[2], area)]
}
