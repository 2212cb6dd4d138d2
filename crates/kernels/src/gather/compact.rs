//! A photon in 16 bytes: where it is and what it brings, a quarter of what a map takes else.
//!
//! Positions are on a lattice of 2²¹ steps along each axis of the grid, and powers share an exponent (Ward, "Real Pixels", Graphics
//! Gems II, 1991); the thesis's own entry has 8 bytes, without a power (section 3.1). Photons are moved to what their records can hold before
//! anything is made of them ([`snap_photons`]): a compact map has the bits of a whole one of the photons so moved.

use super::estimate::over_disc;
use super::filter::{FILTER_CONSTANT, filter_integral, filter_weight};
use super::power::Power;
use super::reach::{ALL_COUNT, Reach};
use super::{CUT_SHORT, Candidates, EstimateParams, Placed, search};
use crate::exec::{Batch, Input, Store, Update};
use crate::grid::{Grid, Moved, Row};
use crate::layout::{Irradiance, Photon, Query, Site};
use crate::num::{MAX_TERMS, div};
use bytemuck::{Pod, Zeroable};

/// Bits of a coordinate.
const BITS: u32 = 21;
/// The largest coordinate.
const MOST: u32 = (1 << BITS) - 1;

/// A photon of a compact map: position in steps of the grid, index of the photon as it was given, and power.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Compact(Site);

impl Compact {
    /// The record of a photon, which [`snap`] has moved.
    #[inline]
    #[must_use]
    pub fn new(photon: &Photon, index: u32, grid: &Grid) -> Self {
        let [x, y, z] = steps(photon.position, grid);
        // 64 bits: x, y and z from the lowest up.
        let words = [x | (y << BITS), (y >> (32 - BITS)) | (z << (2 * BITS - 32)), index];
        let bits = [f32::from_bits(words[0]), f32::from_bits(words[1]), f32::from_bits(words[2])];
        Self(Site::new(bits, pack_power(photon.power)))
    }

    #[inline]
    fn words(self) -> [u32; 4] {
        let [a, b, c] = self.0.position();
        [a.to_bits(), b.to_bits(), c.to_bits(), self.0.photon()]
    }

    /// Power ΔΦ, W.
    #[inline]
    #[must_use]
    pub fn power(self) -> [f32; 3] {
        unpack_power(self.words()[3])
    }
}

impl Placed for Compact {
    #[inline]
    fn position(self, grid: &Grid) -> [f32; 3] {
        let [low, high, _, _] = self.words();
        let y = (low >> BITS) | ((high & ((1 << (2 * BITS - 32)) - 1)) << (32 - BITS));
        at([low & MOST, y, high >> (2 * BITS - 32)], grid)
    }

    #[inline]
    fn photon(self) -> u32 {
        self.words()[2]
    }
}

/// The nearest lattice point of a position.
#[inline]
fn steps(position: [f32; 3], grid: &Grid) -> [u32; 3] {
    let inverse = div(1.0, grid.step);
    let axis = |axis: usize| {
        let steps = (position[axis] - grid.origin[axis]) * inverse + 0.5;
        if steps > 0.0 {
            let steps = steps as u32;
            if steps < MOST { steps } else { MOST }
        } else {
            0
        }
    };
    [axis(0), axis(1), axis(2)]
}

/// Where a lattice point is, m.
#[inline]
fn at(steps: [u32; 3], grid: &Grid) -> [f32; 3] {
    let axis = |axis: usize| grid.origin[axis] + steps[axis] as f32 * grid.step;
    [axis(0), axis(1), axis(2)]
}

/// Three powers in a word: eight bits each of the exponent of the largest, rounded, and that exponent.
#[inline]
fn pack_power(power: [f32; 3]) -> u32 {
    let [r, g, b] = [power[0].to_bits(), power[1].to_bits(), power[2].to_bits()];
    let larger = if r > g { r } else { g };
    let largest = if larger > b { larger } else { b };
    let mut exponent = largest >> 23;
    if part(largest, exponent) > 255 {
        exponent += 1;
    }
    // Where a unit would not be a normal number, or the largest no number.
    if exponent <= 8 || exponent >= 255 {
        return if exponent <= 8 { 0 } else { 0xfeff_ffff };
    }
    (exponent << 24) | (part(r, exponent) << 16) | (part(g, exponent) << 8) | part(b, exponent)
}

/// A power in units of 2^(exponent − 127 − 7), rounded to the nearest.
#[inline]
fn part(bits: u32, exponent: u32) -> u32 {
    let own = bits >> 23;
    let shift = 16 + exponent - own;
    if own == 0 || shift > 24 {
        return 0;
    }
    (((bits & 0x007f_ffff) | 0x0080_0000) + (1 << (shift - 1))) >> shift
}

#[inline]
fn unpack_power(word: u32) -> [f32; 3] {
    let exponent = word >> 24;
    if exponent <= 8 {
        return [0.0; 3];
    }
    let unit = f32::from_bits((exponent - 7) << 23);
    [((word >> 16) & 255) as f32 * unit, ((word >> 8) & 255) as f32 * unit, (word & 255) as f32 * unit]
}

/// A photon as a compact record has it.
#[inline]
#[must_use]
pub fn snap(photon: Photon, grid: &Grid) -> Photon {
    let position = at(steps(photon.position, grid), grid);
    Photon { position, power: unpack_power(pack_power(photon.power)), ..photon }
}

/// Moves photon `i` to what a compact record can hold.
#[inline]
pub fn snap_photons<P: Update<Photon> + ?Sized>(i: u32, grid: &Grid, photons: &mut P) {
    if i < grid.photons {
        photons.set(i, snap(photons.get(i), grid));
    }
}

/// Writes the records of the photons in sorted order: [`reorder_photons`](crate::grid::reorder_photons) for compact maps.
#[inline]
pub fn reorder_compact<B: Batch<Moved>, C: Store<Compact> + ?Sized>(
    batch: &mut B,
    grid: &Grid,
    order: &Input<u32>,
    photons: &Input<Photon>,
    records: &mut C,
) {
    batch.each(move |i, moved| {
        if i < grid.photons {
            let index = order[i as usize];
            *moved = Moved { index, photon: photons[index as usize] };
        }
    });
    batch.each(move |i, moved| {
        if i < grid.photons {
            records.set(i, Compact::new(&moved.photon, moved.index, grid));
        }
    });
}

/// Sums the weighted power of the candidates.
struct Weighed {
    filter: u32,
    radius2: f32,
    /// Index from which on photons at the very radius do not count.
    photon: u32,
    /// 1 / r², m⁻².
    inverse2: f32,
    /// Largest powers of the map.
    scale: [f32; 3],
    power: Power,
    /// What has left the highest limb of each channel.
    above: [u32; 3],
    photons: u32,
}

impl<M: ?Sized, A: ?Sized, O: ?Sized> Candidates<M, A, O, Compact> for Weighed {
    #[inline]
    fn bound(&self) -> f32 {
        self.radius2
    }

    #[inline]
    fn offer(
        &mut self,
        _memory: &mut M,
        _output: &mut O,
        distance2: f32,
        slot: u32,
        records: &Input<Compact>,
        _arrivals: &A,
    ) {
        let record = records[slot as usize];
        if distance2 == self.radius2 && record.photon() >= self.photon {
            return;
        }
        let mut power = record.power();
        if self.filter != FILTER_CONSTANT {
            let weight = filter_weight(self.filter, distance2 * self.inverse2);
            power = [power[0] * weight, power[1] * weight, power[2] * weight];
        }
        self.power.add_power(power, self.scale);
        self.photons += 1;
        if self.photons & (MAX_TERMS / 2 - 1) == 0 {
            let left = self.power.settle();
            self.above = [self.above[0] + left[0], self.above[1] + left[1], self.above[2] + left[2]];
        }
    }
}

/// Irradiance at the `i`-th query from the photons of a compact map within its reach, weighted by a filter:
/// [`gather_filtered`](super::gather_filtered) for any surface.
#[inline]
pub fn gather_compact<const LINEAR: bool, I: Store<Irradiance> + ?Sized>(
    i: u32,
    params: &EstimateParams,
    grid: &Grid,
    rows: &Input<Row>,
    queries: &Input<Query>,
    query_order: &Input<u32>,
    reaches: &Input<Reach>,
    records: &Input<Compact>,
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
        let mut reach = Reach { radius2: grid.radius2, photon: ALL_COUNT, photons: 0 };
        if params.reach != 0 {
            reach = reaches[q as usize];
        }
        // Photons that all lie in the query's own point span no disc: see `over_disc`.
        let disc2 = if reach.radius2 == 0.0 { grid.radius2 } else { reach.radius2 };
        let scale = [f32::from_bits(power[0]), f32::from_bits(power[1]), f32::from_bits(power[2])];
        let mut weighed = Weighed {
            filter: params.filter,
            radius2: reach.radius2,
            photon: reach.photon,
            inverse2: div(1.0, disc2),
            scale,
            power: Power::new(),
            above: [0; 3],
            photons: 0,
        };
        let (memory, output) = (&mut (), &mut ());
        let whole = search::<LINEAR, _, _, _, _, _>(
            query.position,
            grid,
            rows,
            records,
            &(),
            begins,
            memory,
            output,
            &mut weighed,
        );
        let channel = |n: usize| weighed.power.channel(n).value_with(weighed.above[n], scale[n]);
        let over = over_disc([channel(0), channel(1), channel(2)], disc2, grid.radius2);
        let part = filter_integral(params.filter, 1.0);
        result.rgb = if part == 1.0 { over } else { [div(over[0], part), div(over[1], part), div(over[2], part)] };
        result.photons = if whole && reach.photons != CUT_SHORT { weighed.photons } else { CUT_SHORT };
    }
    irradiance.set(q, result);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::pcg4d;

    fn grid(origin: f32, step: f32) -> Grid {
        Grid { origin: [origin, 2.0 * origin, -origin], step, ..Grid::default() }
    }

    fn photon(i: u32, grid: &Grid) -> Photon {
        let random = pcg4d([i, 1, 2, 3]);
        let along = |axis: usize| {
            grid.origin[axis] + (f64::from(random[axis]) / 4_294_967_296.0 * 2_097_150.0) as f32 * grid.step
        };
        let power = |axis: usize| (random[axis] >> 8) as f32 * f32::from_bits((40 + (random[3] >> 25)) << 23);
        Photon { position: [along(0), along(1), along(2)], power: [power(0), power(1), power(2)], ..Photon::default() }
    }

    #[test]
    fn what_is_snapped_stays_where_it_is_and_is_what_its_record_says() {
        // At the origin, and so far away that a step is four units of the last place there.
        for (origin, step) in [(0.0, 1e-6), (1.0, 2f32.powi(-20)), (-3.0, 1e-3), (1000.0, 4.0 * 2f32.powi(-13))] {
            let grid = grid(origin, step);
            for i in 0..100_000 {
                let given = photon(i, &grid);
                let once = snap(given, &grid);
                assert_eq!(snap(once, &grid), once, "{i}");
                let record = Compact::new(&once, i, &grid);
                assert_eq!((Placed::position(record, &grid), record.power()), (once.position, once.power));
                assert_eq!(Placed::photon(record), i);
                for axis in 0..3 {
                    let moved = (once.position[axis] - given.position[axis]).abs();
                    assert!(moved <= 0.8 * step, "{origin} {step}: {given:?} {once:?}");
                }
            }
        }
    }

    #[test]
    fn powers_are_within_a_255th_of_the_largest() {
        for i in 0..100_000 {
            let given = photon(i, &grid(0.0, 1.0)).power;
            let found = unpack_power(pack_power(given));
            let largest = given.into_iter().fold(0.0, f32::max);
            for (given, found) in given.into_iter().zip(found) {
                assert!((given - found).abs() <= largest / 255.0, "{given} {found}");
            }
        }
        // One of two powers so near to the next exponent that it rounds up to it, and the ends of all.
        assert_eq!(unpack_power(pack_power([1.9999, 1.0, 0.0])), [2.0, 1.0, 0.0]);
        assert_eq!(unpack_power(pack_power([0.0; 3])), [0.0; 3]);
        assert_eq!(unpack_power(pack_power([1e-38, 0.0, 0.0])), [0.0; 3]);
        assert!(unpack_power(pack_power([f32::MAX; 3]))[0] > 3.3e38);
    }

    #[test]
    fn beyond_the_lattice_is_its_end() {
        let grid = grid(0.0, 0.5);
        assert_eq!(steps([-1.0, 1e30, 0.26], &grid), [0, MOST, 1]);
    }
}
