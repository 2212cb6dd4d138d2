//! How far the k nearest photons are, without what they bring.

use super::bins::{Columns, WORDS, at};
use super::counting::{Place, is_before, take_first};
use super::kth::find;
use super::seen::Seen;
use super::{CUT_SHORT, Candidates, GatherParams, Placed, search};
use crate::exec::{Input, Store};
use crate::grid::{Grid, Row};
use crate::layout::Query;
use bytemuck::{Pod, Zeroable};

/// How far an estimate reaches: photons count that come before a place in the order of neighbours.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Reach {
    /// Squared radius, m².
    pub radius2: f32,
    /// Index of the first photon at that distance that does not count.
    pub photon: u32,
    /// Photons that come before; k, or fewer where the largest radius holds no more, or [`CUT_SHORT`].
    pub photons: u32,
}

/// [`Reach::photon`] if all at that distance count.
pub(super) const ALL_COUNT: u32 = 0xffff_ffff;

/// Lists the candidates from a place on up to an end.
struct List {
    lane: u32,
    from: Place,
    end: u32,
    len: u32,
}

impl<const N: usize, A: ?Sized, O: ?Sized, S: Placed> Candidates<[u32; N], A, O, S> for List {
    const SHORT: bool = true;

    #[inline]
    fn bound(&self) -> f32 {
        f32::from_bits(self.end - 1)
    }

    #[inline]
    fn offer(
        &mut self,
        memory: &mut [u32; N],
        _output: &mut O,
        distance2: f32,
        slot: u32,
        sites: &Input<S>,
        _arrivals: &A,
    ) {
        if !is_before(distance2.to_bits(), slot, self.from, sites) && self.len < WORDS {
            memory[at(self.len, self.lane)] = slot;
            self.len += 1;
        }
    }
}

/// The reach of the `i`-th query: to the (k + 1)-th photon, by counting (see
/// [`gather_irradiance_by_counting`](super::gather_irradiance_by_counting)), or to the largest radius.
#[inline]
pub fn gather_reach<const LINEAR: bool, S: Placed, R: Store<Reach> + ?Sized>(
    i: u32,
    lane: u32,
    memory: &mut Columns,
    params: &GatherParams,
    grid: &Grid,
    rows: &Input<Row>,
    queries: &Input<Query>,
    query_order: &Input<u32>,
    sites: &Input<S>,
    begins: &Input<u32>,
    reaches: &mut R,
) {
    if i >= params.queries {
        return;
    }
    let q = query_order[i as usize];
    let query = queries[q as usize];
    let mut reach = Reach { radius2: grid.radius2, photon: ALL_COUNT, photons: 0 };
    if query.active != 0 {
        let position = query.position;
        let mut seen = Seen::new();
        let found = find::<LINEAR, _, _, _>(
            lane,
            memory,
            position,
            params.k + 1,
            params,
            grid,
            rows,
            sites,
            sites,
            begins,
            &mut seen,
        );
        let mut whole = found.whole;
        reach.photons = found.before;
        if found.enough {
            reach.photons = params.k;
            let from = Place { bits: found.bins.first, index: found.index };
            let mut list = List { lane, from, end: found.bins.end, len: 0 };
            let output = &mut ();
            if seen.is_whole() {
                seen.offer(position, grid, sites, sites, memory, output, &mut list);
            } else {
                whole = search::<LINEAR, _, _, _, _, _>(
                    position, grid, rows, sites, sites, begins, memory, output, &mut list,
                ) && whole;
            }
            let mut last = from;
            let mut n = 0;
            while n < found.rank && n < list.len {
                (last, _) = take_first(memory, lane, 0, list.len - n, position, grid, sites);
                n += 1;
            }
            reach.radius2 = f32::from_bits(last.bits);
            reach.photon = last.index;
        }
        if !whole {
            reach.photons = CUT_SHORT;
        }
    }
    reaches.set(q, reach);
}
