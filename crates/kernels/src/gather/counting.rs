//! The estimate without a container: counting finds which photons are the nearest, then their power is summed.
//!
//! Candidates are counted by squared distance in a few bins; what the bin with the (k + 1)-th holds is listed in a second walk,
//! which also sums what is nearer. Two walks through the cells cost less than a container of hundreds of photons in a GPU's memory,
//! and any k is served by the same kernel. A first radius is guessed from how many photons are in the cells around; it only has to
//! be likely, for the count shows whether it was enough. Everything is compared as integers: the bits of positive floats are in
//! the order of the floats. The result has the bits that the containers give.
//!
//! Source: selection by distribution counting (Alabi et al., "Fast k-Selection Algorithms for Graphics Processing Units",
//! 2012), here over cells that are walked again and not over a list.
#![allow(clippy::implicit_saturating_sub)] // rust-gpu 0.10 cannot compile `saturating_sub`

use super::estimate::over_disc;
use super::power::Power;
use super::{CUT_SHORT, Candidates, GatherParams, distance2, search};
use crate::exec::{Input, Store};
use crate::grid::{Grid, MAX_REACH, Row, cell_of, linear};
use crate::layout::{Arrival, Irradiance, Query, Site};

/// Lanes of a workgroup that shares out columns.
pub const COLUMN_LANES: u32 = 64;
/// Bins of a count, two to a word.
pub(crate) const BINS: u32 = 32;
/// Words of a lane for counters, or for a list.
pub(super) const WORDS: u32 = 16;
/// Most that a bin counts. More is not asked for.
const MOST: u32 = 0xffff;
/// Binary digits of a bin's number.
const DIGITS: u32 = 5;
/// Shared memory of a workgroup, a column a lane: word `w` of a lane lies beside the others' words `w`, so that lanes never meet
/// in a bank. It is small because a GPU runs as many workgroups at once as fit its shared memory.
pub type Columns = [u32; (WORDS * COLUMN_LANES) as usize];

/// Place of word `word` in the column of `lane`.
#[inline]
pub(super) fn at(word: u32, lane: u32) -> usize {
    (word * COLUMN_LANES + lane) as usize
}

/// The count of a bin.
#[inline]
pub(super) fn count_of<const N: usize>(memory: &[u32; N], lane: u32, from: u32, bin: u32) -> u32 {
    (memory[at(from + bin % WORDS, lane)] >> (bin & WORDS)) & MOST
}

/// Counts one more, unless that is too many for a bin; returns how many.
#[inline]
pub(crate) fn count<const N: usize>(memory: &mut [u32; N], lane: u32, from: u32, bin: u32) -> u32 {
    let word = at(from + bin % WORDS, lane);
    let shift = bin & WORDS;
    let counts = memory[word];
    if (counts >> shift) & MOST == MOST {
        return 0;
    }
    memory[word] = counts + (1 << shift);
    1
}

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
pub(super) fn is_before(bits: u32, slot: u32, place: Place, sites: &Input<Site>) -> bool {
    bits < place.bits || (bits == place.bits && sites[slot as usize].photon() < place.index)
}

/// Numbers from `first` on, in bins of 2^`shift`, up to `end`.
#[derive(Clone, Copy)]
pub(super) struct Bins {
    pub(super) first: u32,
    pub(super) end: u32,
    pub(super) shift: u32,
}

impl Bins {
    /// The squared distances of two binades below `end`: in the upper, where a good guess has the last neighbour, each bin is a
    /// 32nd of the whole.
    #[inline]
    fn below(end: u32) -> Self {
        const SHIFT: u32 = 19;
        let first = if end > BINS << SHIFT { end - (BINS << SHIFT) } else { 0 };
        Self { first, end, shift: SHIFT }
    }

    /// All squared distances below `end`, eight binades to a bin.
    #[inline]
    fn all_below(end: u32) -> Self {
        Self { first: 0, end, shift: 26 }
    }

    /// The parts of one of the bins.
    #[inline]
    fn inside(self, bin: u32) -> Self {
        let first = self.first + (bin << self.shift);
        let end = first + (1 << self.shift);
        Self {
            first,
            end: if end < self.end { end } else { self.end },
            shift: if self.shift > DIGITS { self.shift - DIGITS } else { 0 },
        }
    }
}

/// Counts candidates by the bits of their squared distance, in the lane's column.
struct ByDistance {
    lane: u32,
    bins: Bins,
    /// Candidates nearer than all bins.
    nearer: u32,
    /// Which of them is sought, from 1.
    wanted: u32,
    /// The last bin that may hold it, and how many are counted no farther than that bin.
    top: u32,
    within: u32,
    bound: f32,
}

impl ByDistance {
    #[inline]
    fn new(lane: u32, bins: Bins, wanted: u32) -> Self {
        let bound = f32::from_bits(bins.end - 1);
        Self { lane, bins, nearer: 0, wanted, top: BINS - 1, within: 0, bound }
    }
}

impl<const N: usize, A: ?Sized, O: ?Sized> Candidates<[u32; N], A, O> for ByDistance {
    const SHORT: bool = true;

    #[inline]
    fn bound(&self) -> f32 {
        self.bound
    }

    #[inline]
    fn offer(
        &mut self,
        memory: &mut [u32; N],
        _output: &mut O,
        distance2: f32,
        _slot: u32,
        _sites: &Input<Site>,
        _arrivals: &A,
    ) {
        let bits = distance2.to_bits();
        if bits < self.bins.first {
            self.nearer += 1;
            self.within += 1;
        } else {
            self.within += count(memory, self.lane, 0, (bits - self.bins.first) >> self.bins.shift);
        }
    }

    /// Leaves out what is farther than enough others.
    #[inline]
    fn settle(&mut self, memory: &mut [u32; N]) {
        let mut far = count_of(memory, self.lane, 0, self.top);
        let mut falls = self.top > 0 && self.within - far >= self.wanted;
        while falls {
            self.within -= far;
            self.top -= 1;
            self.bound = f32::from_bits(self.bins.first + ((self.top + 1) << self.bins.shift) - 1);
            far = count_of(memory, self.lane, 0, self.top);
            falls = self.top > 0 && self.within - far >= self.wanted;
        }
    }
}

/// Counts the candidates of one distance by their index, from word `from` of the lane's column on.
struct ByIndex {
    lane: u32,
    from: u32,
    bins: Bins,
    bits: u32,
}

impl<const N: usize, A: ?Sized, O: ?Sized> Candidates<[u32; N], A, O> for ByIndex {
    const SHORT: bool = true;

    #[inline]
    fn bound(&self) -> f32 {
        f32::from_bits(self.bits)
    }

    #[inline]
    fn offer(
        &mut self,
        memory: &mut [u32; N],
        _output: &mut O,
        distance2: f32,
        slot: u32,
        sites: &Input<Site>,
        _arrivals: &A,
    ) {
        if distance2.to_bits() == self.bits {
            let index = sites[slot as usize].photon();
            if index >= self.bins.first && index < self.bins.end {
                count(memory, self.lane, self.from, (index - self.bins.first) >> self.bins.shift);
            }
        }
    }
}

#[inline]
pub(crate) fn clear<const N: usize>(memory: &mut [u32; N], lane: u32, from: u32) {
    let mut word = 0;
    while word < WORDS {
        memory[at(from + word, lane)] = 0;
        word += 1;
    }
}

/// The bin that holds the `rank`-th of what was counted from word `from` on (from 1; [`BINS`] if there are fewer), how many are in bins before it,
/// and how many in it.
#[inline]
pub(crate) fn bin_of<const N: usize>(memory: &[u32; N], lane: u32, from: u32, rank: u32) -> (u32, u32, u32) {
    let mut bin = 0;
    let mut before = 0;
    let mut inside = count_of(memory, lane, from, 0);
    while bin < BINS && before + inside < rank {
        before += inside;
        bin += 1;
        inside = if bin < BINS { count_of(memory, lane, from, bin) } else { 0 };
    }
    (bin, before, inside)
}

/// Bits after those of a squared radius within which the wanted photons probably are.
///
/// The 27 cells around hold n photons in the volume (3c)³. If that is the density, a ball of v photons has the radius
/// 3c·(v / (4π/3·n))^(1/3). Photons on surfaces lie closer than so in space, so the guess is a little far for them.
#[inline]
fn guess<const LINEAR: bool>(
    position: [f32; 3],
    params: &GatherParams,
    grid: &Grid,
    rows: &Input<Row>,
    begins: &Input<u32>,
) -> u32 {
    let last = grid.radius2.to_bits() + 1;
    if !LINEAR {
        return last;
    }
    let centre = cell_of(grid, position);
    let low = if centre[0] > 0 { centre[0] - 1 } else { 0 };
    let high = if centre[0] + 1 < grid.cells[0] { centre[0] + 1 } else { centre[0] };
    let mut n = 0;
    let mut row = 0;
    // Those around come first; in a flat grid there are fewer than nine of them.
    while row < 9 && row < grid.rows {
        let y = (centre[1] + rows[row as usize].y).wrapping_sub(MAX_REACH);
        let z = (centre[2] + rows[row as usize].z).wrapping_sub(MAX_REACH);
        let around = y.wrapping_add(1).wrapping_sub(centre[1]) <= 2 && z.wrapping_add(1).wrapping_sub(centre[2]) <= 2;
        if around && y < grid.cells[1] && z < grid.cells[2] {
            let entry = linear([low, y, z], grid.cells);
            n += begins[(entry + high - low + 1) as usize] - begins[entry as usize];
        }
        row += 1;
    }
    if n == 0 {
        return last;
    }
    // n^(−2/3) within a few percent, by its exponent: 5/3 · 127 · 2²³ − 2/3 of the bits.
    let power = f32::from_bits(1_775_588_693 - (n as f32).to_bits() / 3 * 2);
    let width = 3.0 * grid.cell_width;
    let end = (width * width * params.guess * power).to_bits() + 1;
    if end < last { end } else { last }
}

/// What counting found: the neighbours sought are those before a place among the candidates below `bins.end`.
#[derive(Clone, Copy)]
pub(super) struct Found {
    /// Whether the walks came to their ends.
    pub(super) whole: bool,
    /// Whether there are as many photons as were wanted. If not, all within the radius are sought.
    pub(super) enough: bool,
    /// The bins of the last count, and in them the one with the last that is wanted.
    pub(super) counted: Bins,
    /// Its limits.
    pub(super) bins: Bins,
    /// How many are before all of those bins, and how many before the one.
    pub(super) nearer: u32,
    pub(super) before: u32,
    /// Which of the bin is the last that is wanted, from 1. 0 where more lie at one distance than a list takes: then it is
    /// the one with this index.
    pub(super) rank: u32,
    pub(super) index: u32,
}

/// Finds where the `wanted`-th nearest photon lies, as closely as a list of [`WORDS`] candidates can finish.
#[inline]
pub(super) fn find<const LINEAR: bool, const N: usize, A: ?Sized>(
    lane: u32,
    memory: &mut [u32; N],
    position: [f32; 3],
    wanted: u32,
    params: &GatherParams,
    grid: &Grid,
    rows: &Input<Row>,
    sites: &Input<Site>,
    arrivals: &A,
    begins: &Input<u32>,
) -> Found {
    let last = grid.radius2.to_bits() + 1;
    let mut bins = Bins::below(guess::<LINEAR>(position, params, grid, rows, begins));
    let mut found = Found { whole: true, enough: true, counted: bins, bins, nearer: 0, before: 0, rank: 0, index: 0 };
    let mut crowded = false;
    let mut missed = false;
    let mut grown = false;
    let mut searching = true;
    while searching {
        clear(memory, lane, 0);
        let mut count = ByDistance::new(lane, bins, wanted);
        found.whole =
            search::<LINEAR, _, _, _, _>(position, grid, rows, sites, arrivals, begins, memory, &mut (), &mut count)
                && found.whole;
        found.counted = bins;
        if count.nearer >= wanted {
            // Only bins of a guess leave out what is nearer. A second one would be no better founded than the first.
            bins = if missed { Bins::all_below(bins.first) } else { Bins::below(bins.first) };
            missed = true;
        } else {
            let (bin, before, inside) = bin_of(memory, lane, 0, wanted - count.nearer);
            found.nearer = count.nearer;
            found.before = count.nearer + before;
            if bin < BINS {
                found.rank = wanted - found.before;
                crowded = inside > WORDS;
                searching = crowded && bins.shift > 0;
                bins = bins.inside(bin);
            } else if bins.end >= last {
                found.enough = false;
                searching = false;
            } else {
                // Twice the radius, then the whole.
                let end = bins.end + (2 << 23);
                bins = Bins::below(if grown || end > last { last } else { end });
                grown = true;
            }
        }
        // A device that ends loops early must not be kept in this one.
        searching = searching && found.whole;
    }
    found.bins = bins;

    // Too many at one distance: their indices decide. Whoever has more memory may still need the counts of distances.
    let from = if N >= (2 * WORDS * COLUMN_LANES) as usize { WORDS } else { 0 };
    let mut indices = Bins { first: 0, end: 0xffff_ffff, shift: 27 };
    searching = found.enough && crowded && found.whole;
    while searching {
        clear(memory, lane, from);
        let mut count = ByIndex { lane, from, bins: indices, bits: bins.first };
        found.whole =
            search::<LINEAR, _, _, _, _>(position, grid, rows, sites, arrivals, begins, memory, &mut (), &mut count)
                && found.whole;
        let (bin, before, _) = bin_of(memory, lane, from, found.rank);
        found.rank -= before;
        found.before += before;
        found.index = indices.first + (bin << indices.shift);
        searching = indices.shift > 0 && found.whole;
        indices = indices.inside(bin);
        if !searching {
            found.rank = 0;
        }
    }
    found
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
pub(super) fn take_first<const N: usize>(
    memory: &mut [u32; N],
    lane: u32,
    word: u32,
    len: u32,
    position: [f32; 3],
    sites: &Input<Site>,
) -> (Place, u32) {
    let mut first = Place::ALL;
    let mut slot = 0;
    let mut n = word;
    let mut taken = word;
    while n < word + len {
        let other = memory[at(n, lane)];
        let site = sites[other as usize];
        let bits = distance2(position, site.position()).to_bits();
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
    let found = find::<LINEAR, _, _>(lane, memory, position, params.k + 1, params, grid, rows, sites, arrivals, begins);
    let counted = if found.enough { params.k } else { found.before };
    let mut collect = Collect {
        lane,
        from: if found.enough { Place { bits: found.bins.first, index: found.index } } else { Place::ALL },
        end: if found.enough { found.bins.end } else { grid.radius2.to_bits() + 1 },
        power: Power::new(),
        len: 0,
    };
    let whole =
        search::<LINEAR, _, _, _, _>(position, grid, rows, sites, arrivals, begins, memory, &mut (), &mut collect)
            && found.whole;
    // Those of the list up to the last, which the disc reaches to.
    let mut last = collect.from;
    let mut n = 0;
    while n < found.rank && n < collect.len {
        let (first, slot) = take_first(memory, lane, 0, collect.len - n, position, sites);
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
