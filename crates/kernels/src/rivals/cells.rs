//! Each cell in a thread of its own (thesis, section 5.6): "process each cell in a different thread, where each thread will search for the k
//! closest photons in its cell, for a given query point", and then "the sorting or collecting has to be parallelized as well".
//!
//! A workgroup has a query, and each of its lanes some rows of the cells around it, of which it keeps the k nearest in a heap of its own. What
//! the lanes kept is collected without any lane going through another's: a radix selection, in which a lane counts its own by digit and
//! the counts are added up, tells each lane how many of its nearest are among the k nearest of all; they lay these side by side in shared memory;
//! and each of these photons finds its place by searching how many of each lane's come before it.
//!
//! The thesis tried this with one thread that sorted in the end, which was slower than its sorted list.

use super::SearchParams;
use crate::exec::{Input, Lanes, Store};
use crate::gather::{CUT_SHORT, Heap, Selection, search_share};
use crate::grid::{Grid, HASH_LINEAR, Row};
use crate::layout::{Neighbour, Query, Site};

/// Lanes of a workgroup.
pub const CELLS_LANES: u32 = 32;
/// Bits of a digit of the selection.
const DIGIT_BITS: u32 = 4;
const DIGITS: u32 = 1 << DIGIT_BITS;
/// Digits of a squared distance.
const DISTANCE_DIGITS: u32 = 32 / DIGIT_BITS;

/// Where shared memory has the sums of the counts, after a row of counts of all lanes for each digit.
const SUMS: u32 = DIGITS * CELLS_LANES;
/// Where it has a number of each lane.
const SHARES: u32 = SUMS + DIGITS;
/// Where it has what is collected: bits of squared distances, then indices of photons.
const COLLECTED: u32 = SHARES + CELLS_LANES;

/// Words of shared memory of a workgroup that collects up to `n` photons.
#[must_use]
pub const fn cells_words(n: usize) -> usize {
    COLLECTED as usize + 2 * n
}

/// Registers of a lane, and its heap, which is in the lane's private memory.
#[derive(Clone)]
pub struct CellsRegisters<const N: usize> {
    heap: Heap<N>,
    /// Whether its loops came to their ends.
    whole: bool,
    /// From here to `high` are its photons that have the digits of the k-th so far; those before are nearer.
    low: u32,
    high: u32,
    /// Which of those the k-th is, counting those of all lanes, from 1.
    wanted: u32,
    /// Photons that all lanes collected.
    total: u32,
}

impl<const N: usize> Default for CellsRegisters<N> {
    #[inline]
    fn default() -> Self {
        Self { heap: Heap::new(), whole: false, low: 0, high: 0, wanted: 0, total: 0 }
    }
}

impl<const N: usize> CellsRegisters<N> {
    /// Digit `round` of the key of its `i`-th photon: of the squared distance first, then of the photon's index.
    #[inline]
    fn digit(&self, i: u32, round: u32, index_digits: u32, sites: &Input<Site>) -> u32 {
        let (word, place) = if round < DISTANCE_DIGITS {
            (self.heap.distance2(i).to_bits(), DISTANCE_DIGITS - 1 - round)
        } else {
            (sites[self.heap.slot(i) as usize].photon(), DISTANCE_DIGITS + index_digits - 1 - round)
        };
        (word >> (DIGIT_BITS * place)) & (DIGITS - 1)
    }
}

/// Writes the k nearest neighbours of the workgroup's query within the grid's radius, nearest first, to `neighbours[q·k ..]`, and how many there
/// are, or [`CUT_SHORT`], to `counts[q]`. `S` is [`cells_words`] of `N`, and k at most `N`.
#[inline]
pub fn cells_neighbours<
    const N: usize,
    const S: usize,
    L: Lanes<CellsRegisters<N>>,
    O: Store<Neighbour> + ?Sized,
    C: Store<u32> + ?Sized,
>(
    lanes: &mut L,
    q: u32,
    shared: &mut [u32; S],
    params: &SearchParams,
    grid: &Grid,
    rows: &Input<Row>,
    queries: &Input<Query>,
    sites: &Input<Site>,
    begins: &Input<u32>,
    neighbours: &mut O,
    counts: &mut C,
) {
    if q >= params.queries {
        return;
    }
    let query = queries[q as usize];
    lanes.each(shared, move |lane, r: &mut CellsRegisters<N>, _: &mut [u32; S]| {
        r.heap.reset(params.k, grid.radius2);
        r.whole = true;
        if query.active != 0 {
            r.whole = search_rows(lane, query.position, grid, rows, sites, begins, &mut r.heap);
        }
        r.heap.sort(sites);
        r.low = 0;
        r.high = r.heap.count();
        r.wanted = params.k;
    });
    let index_digits = (u32::BITS - grid.photons.leading_zeros()).div_ceil(DIGIT_BITS);
    let mut round = 0;
    while round < DISTANCE_DIGITS + index_digits {
        select(lanes, shared, round, index_digits, sites);
        round += 1;
    }
    collect(lanes, shared, sites);
    lanes.each(shared, move |lane, r: &mut CellsRegisters<N>, shared: &mut [u32; S]| {
        let mut n = lane;
        while n < r.total {
            let distance2 = shared[(COLLECTED + n) as usize];
            let photon = shared[(COLLECTED + N as u32 + n) as usize];
            let (place, whole) = place_of::<N, S>(distance2, photon, shared);
            r.whole = r.whole && whole;
            neighbours.set(q * params.k + place, Neighbour { distance2: f32::from_bits(distance2), photon });
            n += CELLS_LANES;
        }
        r.whole = r.whole && n >= r.total;
    });
    lanes.each(shared, move |lane, r: &mut CellsRegisters<N>, shared: &mut [u32; S]| {
        shared[(SHARES + lane) as usize] = if r.whole { 0 } else { 1 };
    });
    lanes.each(shared, move |lane, r: &mut CellsRegisters<N>, shared: &mut [u32; S]| {
        if lane == 0 {
            let mut cut = 0;
            let mut other = 0;
            while other < CELLS_LANES {
                cut += shared[(SHARES + other) as usize];
                other += 1;
            }
            counts.set(q, if cut == 0 && other >= CELLS_LANES { r.total } else { CUT_SHORT });
        }
    });
}

/// A lane's rows.
#[inline]
fn search_rows<const N: usize>(
    lane: u32,
    position: [f32; 3],
    grid: &Grid,
    rows: &Input<Row>,
    sites: &Input<Site>,
    begins: &Input<u32>,
    heap: &mut Heap<N>,
) -> bool {
    let (memory, output, step) = (&mut (), &mut (), CELLS_LANES);
    if grid.hash == HASH_LINEAR {
        search_share::<true, _, _, _, _, _>(lane, step, position, grid, rows, sites, &(), begins, memory, output, heap)
    } else {
        search_share::<false, _, _, _, _, _>(lane, step, position, grid, rows, sites, &(), begins, memory, output, heap)
    }
}

/// One round: the next digit of the k-th, and with it which photons of each lane are still in question. Where there are fewer
/// than k, none are after the first round, and all are before.
#[inline]
fn select<const N: usize, const S: usize, L: Lanes<CellsRegisters<N>>>(
    lanes: &mut L,
    shared: &mut [u32; S],
    round: u32,
    index_digits: u32,
    sites: &Input<Site>,
) {
    lanes.each(shared, move |lane, r: &mut CellsRegisters<N>, shared: &mut [u32; S]| {
        let mut digit = 0;
        while digit < DIGITS {
            shared[(digit * CELLS_LANES + lane) as usize] = 0;
            digit += 1;
        }
        let mut i = r.low;
        while i < r.high {
            shared[(r.digit(i, round, index_digits, sites) * CELLS_LANES + lane) as usize] += 1;
            i += 1;
        }
    });
    lanes.each(shared, move |lane, _: &mut CellsRegisters<N>, shared: &mut [u32; S]| {
        if lane < DIGITS {
            let mut sum = 0;
            let mut other = 0;
            while other < CELLS_LANES {
                sum += shared[(lane * CELLS_LANES + other) as usize];
                other += 1;
            }
            shared[(SUMS + lane) as usize] = sum;
        }
    });
    lanes.each(shared, move |lane, r: &mut CellsRegisters<N>, shared: &mut [u32; S]| {
        let mut digit = 0;
        while digit < DIGITS {
            let all = shared[(SUMS + digit) as usize];
            let own = shared[(digit * CELLS_LANES + lane) as usize];
            if all >= r.wanted {
                r.high = r.low + own;
                digit = DIGITS;
            } else {
                r.wanted -= all;
                r.low += own;
                digit += 1;
            }
        }
    });
}

/// Lays the photons of all lanes that are among the k nearest side by side, each lane's in their order.
#[inline]
fn collect<const N: usize, const S: usize, L: Lanes<CellsRegisters<N>>>(
    lanes: &mut L,
    shared: &mut [u32; S],
    sites: &Input<Site>,
) {
    lanes.each(shared, move |lane, r: &mut CellsRegisters<N>, shared: &mut [u32; S]| {
        shared[(SHARES + lane) as usize] = r.high;
    });
    lanes.each(shared, move |lane, r: &mut CellsRegisters<N>, shared: &mut [u32; S]| {
        let mut first = 0;
        let mut total = 0;
        let mut other = 0;
        while other < CELLS_LANES {
            let share = shared[(SHARES + other) as usize];
            first += if other < lane { share } else { 0 };
            total += share;
            other += 1;
        }
        let mut n = 0;
        while n < r.high {
            let at = COLLECTED + first + n;
            shared[at as usize] = r.heap.distance2(n).to_bits();
            shared[at as usize + N] = sites[r.heap.slot(n) as usize].photon();
            n += 1;
        }
        r.total = total;
        // Loops that were ended early took these with them.
        r.whole = r.whole && other >= CELLS_LANES && n >= r.high;
    });
}

/// How many of the collected photons come before one, and whether they were counted to the end: half by half in each lane's.
#[inline]
fn place_of<const N: usize, const S: usize>(distance2: u32, photon: u32, shared: &[u32; S]) -> (u32, bool) {
    let mut place = 0;
    let mut whole = true;
    let mut first = 0;
    let mut lane = 0;
    while lane < CELLS_LANES {
        let end = first + shared[(SHARES + lane) as usize];
        let mut low = first;
        let mut high = end;
        while low < high {
            let middle = low + (high - low) / 2;
            let other = shared[(COLLECTED + middle) as usize];
            let before =
                other < distance2 || (other == distance2 && shared[(COLLECTED + N as u32 + middle) as usize] < photon);
            if before {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        whole = whole && low >= high;
        place += low - first;
        first = end;
        lane += 1;
    }
    (place, whole && lane >= CELLS_LANES)
}

#[cfg(test)]
mod tests;
