//! The estimate without a container: counting finds which photons are the nearest, then their power is summed.
//!
//! Candidates are counted by squared distance in a few bins; the bin that holds the (k + 1)-th is cut into bins of its own,
//! until what it holds fits a short list. A walk through the cells for each of these steps costs less than a container of
//! hundreds of photons in a GPU's memory, and any k is served by the same kernel. Everything is compared as integers: the
//! bits of positive floats are in the order of the floats. The result has the bits that the containers give.
//!
//! Source: selection by distribution counting (Alabi et al., "Fast k-Selection Algorithms for Graphics Processing Units",
//! 2012), here over cells that are walked again and not over a list.
#![allow(clippy::implicit_saturating_sub)] // rust-gpu 0.10 cannot compile `saturating_sub`

use super::estimate::{Power, over_disc};
use super::{CUT_SHORT, Candidates, GatherParams, search};
use crate::exec::Store;
use crate::grid::Grid;
use crate::layout::{Irradiance, Photon, Query};

/// Bins of a count: with more, each invocation needs more memory than a GPU has at hand for it.
const BINS: u32 = 32;
/// Binary digits of a bin's number.
const DIGITS: u32 = 5;
/// Most candidates that are put in order one by one.
const LIST: usize = 32;
/// Every candidate comes before this.
const ALL: Place = Place { bits: 0xffff_ffff, index: 0 };

/// A place in the order of neighbours.
#[derive(Clone, Copy)]
struct Place {
    /// Bits of the squared distance.
    bits: u32,
    /// Index of the photon before sorting.
    index: u32,
}

/// Whether a candidate comes before a place. Its index is read for a tie only.
#[inline]
fn is_before(bits: u32, slot: u32, place: Place, order: &[u32]) -> bool {
    bits < place.bits || (bits == place.bits && order[slot as usize] < place.index)
}

/// Numbers from `first` on, in bins of 2^`shift`, up to `end`.
#[derive(Clone, Copy)]
struct Bins {
    first: u32,
    end: u32,
    shift: u32,
}

impl Bins {
    /// The squared distances of sixteen binades below `end`, half a binade to a bin.
    #[inline]
    fn below(end: u32) -> Self {
        const SHIFT: u32 = 22;
        let first = if end > BINS << SHIFT { end - (BINS << SHIFT) } else { 0 };
        Self { first, end, shift: SHIFT }
    }
}

/// Counts candidates by the bits of their squared distance.
struct ByDistance {
    bins: Bins,
    counts: [u32; BINS as usize],
    /// Candidates nearer than all bins.
    nearer: u32,
    /// Which of them is sought, from 1.
    wanted: u32,
    /// The last bin that may hold it, and how many are no farther than that bin.
    top: u32,
    within: u32,
    bound: f32,
}

impl Candidates for ByDistance {
    const SHORT: bool = true;

    #[inline]
    fn bound(&self) -> f32 {
        self.bound
    }

    #[inline]
    fn offer(&mut self, distance2: f32, _slot: u32, _order: &[u32], _photons: &[Photon]) {
        let bits = distance2.to_bits();
        self.within += 1;
        if bits < self.bins.first {
            self.nearer += 1;
        } else {
            self.counts[((bits - self.bins.first) >> self.bins.shift) as usize] += 1;
        }
    }

    /// Leaves out what is farther than enough others: most cells, once the query's own has been walked.
    #[inline]
    fn settle(&mut self) {
        let mut far = self.counts[self.top as usize];
        let mut falls = self.top > 0 && self.within - far >= self.wanted;
        while falls {
            self.within -= far;
            self.top -= 1;
            self.bound = f32::from_bits(self.bins.first + ((self.top + 1) << self.bins.shift) - 1);
            far = self.counts[self.top as usize];
            falls = self.top > 0 && self.within - far >= self.wanted;
        }
    }
}

impl ByDistance {
    #[inline]
    fn new(bins: Bins, wanted: u32) -> Self {
        let bound = f32::from_bits(bins.end - 1);
        Self { bins, counts: [0; BINS as usize], nearer: 0, wanted, top: BINS - 1, within: 0, bound }
    }
}

/// Counts the candidates of one distance by their index.
struct ByIndex {
    bins: Bins,
    counts: [u32; BINS as usize],
    bits: u32,
}

impl Candidates for ByIndex {
    const SHORT: bool = true;

    #[inline]
    fn bound(&self) -> f32 {
        f32::from_bits(self.bits)
    }

    #[inline]
    fn offer(&mut self, distance2: f32, slot: u32, order: &[u32], _photons: &[Photon]) {
        if distance2.to_bits() == self.bits {
            let index = order[slot as usize];
            if index >= self.bins.first && index < self.bins.end {
                self.counts[((index - self.bins.first) >> self.bins.shift) as usize] += 1;
            }
        }
    }
}

/// The bin that holds the `rank`-th of what was counted (from 1; [`BINS`] if there are fewer), how many are in bins before it,
/// and how many in it.
#[inline]
fn bin_of(counts: &[u32; BINS as usize], rank: u32) -> (u32, u32, u32) {
    let mut bin = 0;
    let mut before = 0;
    let mut inside = counts[0];
    while bin < BINS && before + inside < rank {
        before += inside;
        bin += 1;
        inside = if bin < BINS { counts[bin as usize] } else { 0 };
    }
    (bin, before, inside)
}

/// Finds the largest power of each channel among the candidates before a place, and lists those from there to `end`.
struct Listing {
    from: Place,
    end: u32,
    power: Power,
    len: u32,
    bits: [u32; LIST],
    slots: [u32; LIST],
}

impl Candidates for Listing {
    const SHORT: bool = true;

    #[inline]
    fn bound(&self) -> f32 {
        f32::from_bits(self.end - 1)
    }

    #[inline]
    fn offer(&mut self, distance2: f32, slot: u32, order: &[u32], photons: &[Photon]) {
        let bits = distance2.to_bits();
        if is_before(bits, slot, self.from, order) {
            self.power.align(&photons[slot as usize]);
        } else if (self.len as usize) < LIST {
            self.bits[self.len as usize] = bits;
            self.slots[self.len as usize] = slot;
            self.len += 1;
        }
    }
}

impl Listing {
    /// The `rank`-th (from 1) of what is listed.
    #[inline]
    fn place(&self, rank: u32, order: &[u32]) -> Place {
        let mut found = self.from;
        let mut a = 0;
        while a < self.len {
            let place = Place { bits: self.bits[a as usize], index: order[self.slots[a as usize] as usize] };
            let mut before = 0;
            let mut b = 0;
            while b < self.len {
                if is_before(self.bits[b as usize], self.slots[b as usize], place, order) {
                    before += 1;
                }
                b += 1;
            }
            if before + 1 == rank {
                found = place;
            }
            a += 1;
        }
        found
    }
}

/// Sums the power of the candidates before a place.
struct Before {
    place: Place,
    bound: f32,
    power: Power,
}

impl Candidates for Before {
    const SHORT: bool = true;

    #[inline]
    fn bound(&self) -> f32 {
        self.bound
    }

    #[inline]
    fn offer(&mut self, distance2: f32, slot: u32, order: &[u32], photons: &[Photon]) {
        if is_before(distance2.to_bits(), slot, self.place, order) {
            self.power.add(&photons[slot as usize]);
        }
    }
}

/// Irradiance at query `i`: [`gather_irradiance`](super::gather_irradiance) without a container.
#[inline]
pub fn gather_irradiance_by_counting<I: Store<Irradiance> + ?Sized>(
    i: u32,
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
    if query.active == 0 {
        irradiance.set(i, Irradiance { rgb: [0.0, 0.0, 0.0], photons: 0 });
        return;
    }
    let position = query.position;
    let wanted = params.k + 1;

    let last = grid.radius2.to_bits();
    let mut bins = Bins::below(last + 1);
    let mut whole = true;
    let mut counted = params.k;
    // What the disc reaches to, and how many of the bin come up to it.
    let mut place = ALL;
    let mut rank = 0;
    let mut crowded = false;
    let mut searching = true;
    while searching {
        let mut count = ByDistance::new(bins, wanted);
        whole = search(position, grid, photons, order, starts, ends, &mut count) && whole;
        if count.nearer >= wanted {
            // Only the first bins leave out what is nearer.
            bins = Bins::below(bins.first);
        } else {
            let (bin, before, inside) = bin_of(&count.counts, wanted - count.nearer);
            if bin == BINS {
                counted = count.nearer + before;
                searching = false;
            } else {
                rank = wanted - count.nearer - before;
                let first = bins.first + (bin << bins.shift);
                let end = first + (1 << bins.shift);
                crowded = inside > LIST as u32;
                searching = crowded && bins.shift > 0;
                place = Place { bits: first, index: 0 };
                bins.first = first;
                bins.end = if end < bins.end { end } else { bins.end };
                bins.shift = if bins.shift > DIGITS { bins.shift - DIGITS } else { 0 };
            }
        }
        // A device that ends loops early must not be kept in this one.
        searching = searching && whole;
    }
    let found = place.bits != ALL.bits;

    // Too many at one distance: their indices decide.
    let mut indices = Bins { first: 0, end: 0xffff_ffff, shift: 27 };
    searching = found && crowded && whole;
    while searching {
        let mut count = ByIndex { bins: indices, counts: [0; BINS as usize], bits: place.bits };
        whole = search(position, grid, photons, order, starts, ends, &mut count) && whole;
        let (bin, before, _) = bin_of(&count.counts, rank);
        rank -= before;
        place.index = indices.first + (bin << indices.shift);
        searching = indices.shift > 0 && whole;
        indices.first = place.index;
        indices.end = place.index + (1 << indices.shift);
        indices.shift = if indices.shift > DIGITS { indices.shift - DIGITS } else { 0 };
    }

    let end = if found { bins.end } else { last + 1 };
    let mut listing = Listing { from: place, end, power: Power::new(), len: 0, bits: [0; LIST], slots: [0; LIST] };
    whole = search(position, grid, photons, order, starts, ends, &mut listing) && whole;
    if found && !crowded {
        place = listing.place(rank, order);
        let mut n = 0;
        while n < listing.len {
            if is_before(listing.bits[n as usize], listing.slots[n as usize], place, order) {
                listing.power.align(&photons[listing.slots[n as usize] as usize]);
            }
            n += 1;
        }
    }
    let radius2 = if found { f32::from_bits(place.bits) } else { grid.radius2 };
    let mut before = Before { place, bound: radius2, power: listing.power };
    whole = search(position, grid, photons, order, starts, ends, &mut before) && whole;
    let rgb = over_disc(before.power.value(), radius2, grid);
    irradiance.set(i, Irradiance { rgb, photons: if whole { counted } else { CUT_SHORT } });
}
