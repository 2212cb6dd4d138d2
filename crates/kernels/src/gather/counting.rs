//! The estimate without a container: counting finds which photons are the nearest, then their power is summed.
//!
//! Candidates are counted by squared distance in a few bins ([`find`]) and remembered ([`Seen`]); of those, what the bin with the (k + 1)-th
//! holds is listed, and what is nearer is summed. Where they are too many to remember, a second walk through the cells finds them
//! again: that still costs less than a container of hundreds of photons in a GPU's memory, and any k is served by the same
//! kernel. The result has the bits that the containers give.
//!
//! Source: selection by distribution counting (Alabi et al., "Fast k-Selection Algorithms for Graphics Processing Units",
//! 2012), here over cells that are walked again and not over a list.

use super::bins::{Columns, WORDS, at};
use super::estimate::over_disc;
use super::kth::find;
use super::power::Power;
use super::seen::Seen;
use super::{CUT_SHORT, Candidates, GatherParams, Placed, distance2, search};
use crate::exec::{Input, Store};
use crate::grid::{Grid, Row};
use crate::layout::{Arrival, Irradiance, Query, Site};

/// A place in the order of neighbours.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// Bits of the squared distance.
    pub(super) bits: u32,
    /// Index of the photon before sorting.
    pub(super) index: u32,
}

impl Place {
    /// Every candidate comes before this.
    pub(super) const ALL: Self = Self { bits: 0xffff_ffff, index: 0 };
}

/// Whether a candidate comes before a place. Its index is read for a tie only.
#[inline]
pub(super) fn is_before<S: Placed>(bits: u32, slot: u32, place: Place, sites: &Input<S>) -> bool {
    bits < place.bits || (bits == place.bits && sites[slot as usize].photon() < place.index)
}

/// Sums the power of the candidates before a place, and lists those from there on up to an end.
struct Collect {
    lane: u32,
    from: Place,
    end: u32,
    power: Power,
    len: u32,
}

impl<const N: usize, O: ?Sized> Candidates<[u32; N], Input<Arrival>, O> for Collect {
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
        sites: &Input<Site>,
        arrivals: &Input<Arrival>,
    ) {
        if is_before(distance2.to_bits(), slot, self.from, sites) {
            self.power.add(arrivals[slot as usize]);
        } else if self.len < WORDS {
            memory[at(self.len, self.lane)] = slot;
            self.len += 1;
        }
    }
}

/// The first in order of the `len` candidates that are listed in a lane's column from `word` on; it is taken out by putting the
/// last in its place.
#[inline]
pub(super) fn take_first<const N: usize, S: Placed>(
    memory: &mut [u32; N],
    lane: u32,
    word: u32,
    len: u32,
    position: [f32; 3],
    grid: &Grid,
    sites: &Input<S>,
) -> (Place, u32) {
    let mut first = Place::ALL;
    let mut slot = 0;
    let mut n = word;
    let mut taken = word;
    while n < word + len {
        let other = memory[at(n, lane)];
        let site = sites[other as usize];
        let bits = distance2(position, site.position(grid)).to_bits();
        if bits < first.bits || (bits == first.bits && site.photon() < first.index) {
            first = Place { bits, index: site.photon() };
            slot = other;
            taken = n;
        }
        n += 1;
    }
    memory[at(taken, lane)] = memory[at(word + len - 1, lane)];
    (first, slot)
}

/// Irradiance at the `i`-th query: [`gather_irradiance`](super::gather_irradiance) without a container.
#[inline]
pub fn gather_irradiance_by_counting<const LINEAR: bool, I: Store<Irradiance> + ?Sized>(
    i: u32,
    lane: u32,
    memory: &mut Columns,
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
    if query.active == 0 {
        irradiance.set(q, Irradiance { rgb: [0.0, 0.0, 0.0], photons: 0 });
        return;
    }
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
        arrivals,
        begins,
        &mut seen,
    );
    let counted = if found.enough { params.k } else { found.before };
    let mut collect = Collect {
        lane,
        from: if found.enough { Place { bits: found.bins.first, index: found.index } } else { Place::ALL },
        end: if found.enough { found.bins.end } else { grid.radius2.to_bits() + 1 },
        power: Power::new(),
        len: 0,
    };
    let mut whole = found.whole;
    if seen.is_whole() {
        seen.offer(position, grid, sites, arrivals, memory, &mut (), &mut collect);
    } else {
        whole = search::<LINEAR, _, _, _, _, _>(
            position,
            grid,
            rows,
            sites,
            arrivals,
            begins,
            memory,
            &mut (),
            &mut collect,
        ) && whole;
    }
    // Those of the list up to the last, which the disc reaches to.
    let mut last = collect.from;
    let mut n = 0;
    while n < found.rank && n < collect.len {
        let (first, slot) = take_first(memory, lane, 0, collect.len - n, position, grid, sites);
        last = first;
        n += 1;
        if n < found.rank {
            collect.power.add(arrivals[slot as usize]);
        }
    }
    let radius2 = if found.enough { f32::from_bits(last.bits) } else { grid.radius2 };
    let photons = if whole { counted } else { CUT_SHORT };
    irradiance.set(q, Irradiance { rgb: over_disc(collect.power.value(power), radius2, grid.radius2), photons });
}
