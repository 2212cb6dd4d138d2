//! The estimate that weighs photons by their distance and knows the surface it is for.

use super::estimate::over_disc;
use super::filter::{FILTER_CONSTANT, filter_integral, filter_weight};
use super::power::Power;
use super::reach::{ALL_COUNT, Reach};
use super::surface::{self, SURFACE_ANY, SURFACE_FACING, SURFACE_OWN, is_known, part_on};
use super::{CUT_SHORT, Candidates, search};
use crate::exec::{Input, Store};
use crate::grid::{Grid, Row};
use crate::layout::{Arrival, Irradiance, Query, Site};
use crate::num::{MAX_TERMS, div};
use crate::trace::{Primitive, Vertex};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Which photons an estimate counts, and how much.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct EstimateParams {
    /// Number of queries.
    pub queries: u32,
    /// A `FILTER_` constant.
    pub filter: u32,
    /// A `SURFACE_` constant.
    pub surface: u32,
    /// 1 if each query has its own reach; 0 if all reach to the map's radius.
    pub reach: u32,
}

/// Sums the weighted power of the candidates that count.
struct Filtered {
    place: surface::Place,
    filter: u32,
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

impl<M: ?Sized, O: ?Sized> Candidates<M, Input<Arrival>, O> for Filtered {
    #[inline]
    fn bound(&self) -> f32 {
        self.place.radius2
    }

    #[inline]
    fn offer(
        &mut self,
        _memory: &mut M,
        _output: &mut O,
        distance2: f32,
        slot: u32,
        sites: &Input<Site>,
        arrivals: &Input<Arrival>,
    ) {
        let site = sites[slot as usize];
        if distance2 == self.place.radius2 && site.photon() >= self.photon {
            return;
        }
        let arrival = arrivals[slot as usize];
        if !self.place.has(site, arrival) {
            return;
        }
        if self.filter == FILTER_CONSTANT {
            self.power.add(arrival);
        } else {
            self.power.add_weighted(arrival, filter_weight(self.filter, distance2 * self.inverse2), self.scale);
        }
        self.photons += 1;
        if self.photons & (MAX_TERMS / 2 - 1) == 0 {
            let left = self.power.settle();
            self.above = [self.above[0] + left[0], self.above[1] + left[1], self.above[2] + left[2]];
        }
    }
}

/// Irradiance at the `i`-th query from the photons on its surface within its reach, weighted by a filter: one walk through the cells.
///
/// A weighted power is rounded to `f32` once, and these are added exactly, so that no order shows. With a constant filter and photons
/// of any surface this has the bits of [`gather_irradiance`](super::gather_irradiance) and [`gather_density`](super::gather_density).
#[inline]
pub fn gather_filtered<const LINEAR: bool, I: Store<Irradiance> + ?Sized>(
    i: u32,
    params: &EstimateParams,
    grid: &Grid,
    rows: &Input<Row>,
    queries: &Input<Query>,
    query_order: &Input<u32>,
    reaches: &Input<Reach>,
    vertices: &Input<Vertex>,
    primitives: &Input<Primitive>,
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
        let mut reach = Reach { radius2: grid.radius2, photon: ALL_COUNT, photons: 0 };
        if params.reach != 0 {
            reach = reaches[q as usize];
        }
        let position = Vec3::from_array(query.position);
        let mut place =
            surface::Place { surface: params.surface, primitive: 0, position, normal: Vec3::Y, radius2: reach.radius2 };
        // Photons that all lie in the query's own point span no disc: see `over_disc`.
        let disc2 = if reach.radius2 == 0.0 { grid.radius2 } else { reach.radius2 };
        let mut part = filter_integral(params.filter, 1.0);
        if params.surface != SURFACE_ANY {
            let vertex = vertices[q as usize];
            place.primitive = vertex.primitive;
            place.normal = Vec3::from_array(vertex.normal);
            let primitive = primitives[vertex.primitive as usize];
            if params.surface == SURFACE_OWN {
                if is_known(&primitive) {
                    part = part_on(&primitive, position, disc2, params.filter);
                } else {
                    place.surface = SURFACE_FACING;
                }
            }
        }
        let scale = [f32::from_bits(power[0]), f32::from_bits(power[1]), f32::from_bits(power[2])];
        let mut filtered = Filtered {
            place,
            filter: params.filter,
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
            sites,
            arrivals,
            begins,
            memory,
            output,
            &mut filtered,
        );
        let channel = |n: usize| filtered.power.channel(n).value_with(filtered.above[n], scale[n]);
        let over = over_disc([channel(0), channel(1), channel(2)], disc2, grid.radius2);
        // The constant filter over a whole disc keeps its bits.
        result.rgb = if part == 1.0 { over } else { [div(over[0], part), div(over[1], part), div(over[2], part)] };
        result.photons = if whole && reach.photons != CUT_SHORT { filtered.photons } else { CUT_SHORT };
    }
    irradiance.set(q, result);
}
