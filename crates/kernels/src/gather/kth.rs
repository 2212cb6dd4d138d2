//! Where the k-th nearest lies, by counting candidates by squared distance in a few bins: which bin it is in, how many are before that,
//! and which of the bin it is.
//!
//! A first radius is guessed from how many photons are in the cells around; it only has to be likely, for the count shows whether it
//! was enough. Everything is compared as integers: the bits of positive floats are in the order of the floats.
#![allow(clippy::implicit_saturating_sub)] // rust-gpu 0.10 cannot compile `saturating_sub`

use super::bins::{BINS, Bins, COLUMN_LANES, WORDS, bin_of, clear, count, count_of};
use super::seen::Seen;
use super::{Candidates, GatherParams, Placed, search};
use crate::exec::Input;
use crate::grid::{Grid, MAX_REACH, Row, cell_of, linear};

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

impl<const N: usize, A: ?Sized, S: Placed> Candidates<[u32; N], A, Seen, S> for ByDistance {
    const SHORT: bool = true;

    #[inline]
    fn bound(&self) -> f32 {
        self.bound
    }

    #[inline]
    fn offer(
        &mut self,
        memory: &mut [u32; N],
        seen: &mut Seen,
        distance2: f32,
        slot: u32,
        _sites: &Input<S>,
        _arrivals: &A,
    ) {
        seen.add(slot);
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

impl<const N: usize, A: ?Sized, O: ?Sized, S: Placed> Candidates<[u32; N], A, O, S> for ByIndex {
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
        sites: &Input<S>,
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

/// Finds where the `wanted`-th nearest photon lies, as closely as a list of [`WORDS`] candidates can finish. `seen` remembers all
/// candidates up to there.
#[inline]
pub(super) fn find<const LINEAR: bool, const N: usize, S: Placed, A: ?Sized>(
    lane: u32,
    memory: &mut [u32; N],
    position: [f32; 3],
    wanted: u32,
    params: &GatherParams,
    grid: &Grid,
    rows: &Input<Row>,
    sites: &Input<S>,
    arrivals: &A,
    begins: &Input<u32>,
    seen: &mut Seen,
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
        seen.clear();
        let mut count = ByDistance::new(lane, bins, wanted);
        found.whole =
            search::<LINEAR, _, _, _, _, _>(position, grid, rows, sites, arrivals, begins, memory, seen, &mut count)
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
            search::<LINEAR, _, _, _, _, _>(position, grid, rows, sites, arrivals, begins, memory, &mut (), &mut count)
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
