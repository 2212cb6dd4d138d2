//! The neighbours themselves, by counting: two stages.
//!
//! The first writes the k nearest in the order of the bins in which they were counted, the second puts each bin in order, a
//! lane an element: no lane ever sorts a list of its own.

use super::bins::{BINS, Bins, COLUMN_LANES, WORDS, at, count_of};
use super::counting::{Place, is_before, take_first};
use super::kth::find;
use super::seen::Seen;
use super::{CUT_SHORT, Candidates, GatherParams, search};
use crate::exec::{Input, Store};
use crate::grid::{Grid, Row};
use crate::layout::{Neighbour, Query, Site};

/// Shared memory of a workgroup: columns for counters, then columns for lists.
pub type WideColumns = [u32; (2 * WORDS * COLUMN_LANES) as usize];

/// Puts the candidates before a place where their bin has room, and lists those from there on up to an end.
struct ByBin {
    lane: u32,
    /// Index of the query's first neighbour.
    row: u32,
    counted: Bins,
    /// How many of those nearer than all bins have come.
    nearer: u32,
    before: Place,
    end: u32,
    len: u32,
}

impl<const N: usize, A: ?Sized, O: Store<Neighbour> + ?Sized> Candidates<[u32; N], A, O> for ByBin {
    const SHORT: bool = true;

    #[inline]
    fn bound(&self) -> f32 {
        f32::from_bits(self.end - 1)
    }

    #[inline]
    fn offer(
        &mut self,
        memory: &mut [u32; N],
        output: &mut O,
        distance2: f32,
        slot: u32,
        sites: &Input<Site>,
        _arrivals: &A,
    ) {
        let bits = distance2.to_bits();
        if is_before(bits, slot, self.before, sites) {
            let mut place = self.nearer;
            if bits < self.counted.first {
                self.nearer += 1;
            } else {
                let bin = (bits - self.counted.first) >> self.counted.shift;
                place = count_of(memory, self.lane, 0, bin);
                memory[at(bin % WORDS, self.lane)] += 1 << (bin & WORDS);
            }
            output.set(self.row + place, Neighbour { distance2, photon: sites[slot as usize].photon() });
        } else if self.len < WORDS {
            memory[at(WORDS + self.len, self.lane)] = slot;
            self.len += 1;
        }
    }
}

/// Writes the k nearest neighbours of the `i`-th query within the grid's radius to `unordered[q·k ..]`, where `q =
/// query_order[i]` is the query's index: in the order of bins, but in any order in a bin. `counts[q]` says how many there are, or
/// [`CUT_SHORT`], and `windows[2q ..]` where bins begin, as bits of a squared distance, and the binary logarithm of their width.
#[inline]
pub fn gather_neighbours_by_counting<
    const LINEAR: bool,
    N: Store<Neighbour> + ?Sized,
    C: Store<u32> + ?Sized,
    W: Store<u32> + ?Sized,
>(
    i: u32,
    lane: u32,
    memory: &mut WideColumns,
    params: &GatherParams,
    grid: &Grid,
    rows: &Input<Row>,
    queries: &Input<Query>,
    query_order: &Input<u32>,
    sites: &Input<Site>,
    begins: &Input<u32>,
    unordered: &mut N,
    counts: &mut C,
    windows: &mut W,
) {
    if i >= params.queries {
        return;
    }
    let q = query_order[i as usize];
    let query = queries[q as usize];
    if query.active == 0 {
        counts.set(q, 0);
        return;
    }
    let position = query.position;
    let mut seen = Seen::new();
    let found =
        find::<LINEAR, _, _, _>(lane, memory, position, params.k, params, grid, rows, sites, sites, begins, &mut seen);
    // From numbers in bins to the places of their first. Those after the last bin that is wanted do not matter: all they have to
    // do is fit.
    let mut sum = found.nearer;
    let mut bin = 0;
    while bin < BINS {
        let inside = count_of(memory, lane, 0, bin);
        let word = at(bin % WORDS, lane);
        memory[word] = memory[word] - (inside << (bin & WORDS)) + ((sum & 0xffff) << (bin & WORDS));
        sum += inside;
        bin += 1;
    }
    let mut before = Place::ALL;
    if found.enough {
        before = Place { bits: found.bins.first, index: found.index };
        if found.rank == 0 {
            // The last that is wanted is known: it is one of them.
            before.index += 1;
        }
    }
    let mut by_bin = ByBin {
        lane,
        row: q * params.k,
        counted: found.counted,
        nearer: 0,
        before,
        end: if found.enough { found.bins.end } else { grid.radius2.to_bits() + 1 },
        len: 0,
    };
    let mut whole = found.whole;
    if seen.is_whole() {
        seen.offer(position, grid, sites, sites, memory, unordered, &mut by_bin);
    } else {
        whole =
            search::<LINEAR, _, _, _, _, _>(position, grid, rows, sites, sites, begins, memory, unordered, &mut by_bin)
                && whole;
    }
    let mut n = 0;
    while n < found.rank && n < by_bin.len {
        let (first, _) = take_first(memory, lane, WORDS, by_bin.len - n, position, grid, sites);
        let neighbour = Neighbour { distance2: f32::from_bits(first.bits), photon: first.index };
        unordered.set(q * params.k + found.before + n, neighbour);
        n += 1;
    }
    let count = if found.enough { params.k } else { found.before };
    counts.set(q, if whole { count } else { CUT_SHORT });
    windows.set(2 * q, found.counted.first);
    windows.set(2 * q + 1, found.counted.shift);
}

/// Puts neighbour `i` of all where it belongs: its bin is in its place, so it only has to be counted which of its bin come before.
#[inline]
pub fn order_neighbours<N: Store<Neighbour> + ?Sized>(
    i: u32,
    params: &GatherParams,
    counts: &Input<u32>,
    windows: &Input<u32>,
    unordered: &Input<Neighbour>,
    neighbours: &mut N,
) {
    let q = i / params.k;
    if q >= params.queries {
        return;
    }
    let count = counts[q as usize];
    let row = q * params.k;
    let place = i - row;
    if count == CUT_SHORT || place >= count {
        return;
    }
    let mine = unordered[i as usize];
    let bin = Bin::of(mine, windows[(2 * q) as usize], windows[(2 * q + 1) as usize]);
    let mut moves = 0;
    let mut other = i;
    while other > row {
        other -= 1;
        let neighbour = unordered[other as usize];
        if !bin.has(neighbour) {
            other = row;
        } else if precedes(mine, neighbour) {
            moves -= 1;
        }
    }
    other = i + 1;
    while other < row + count {
        let neighbour = unordered[other as usize];
        if !bin.has(neighbour) {
            other = row + count;
        } else if precedes(neighbour, mine) {
            moves += 1;
        }
        other += 1;
    }
    neighbours.set((i as i32 + moves) as u32, mine);
}

/// The bin of a neighbour, as bits of squared distances.
#[derive(Clone, Copy)]
struct Bin {
    begin: u32,
    width: u32,
}

impl Bin {
    /// Bins begin at `first` and are 2^`shift` wide; what is nearer is a bin of its own.
    #[inline]
    fn of(neighbour: Neighbour, first: u32, shift: u32) -> Self {
        let bits = neighbour.distance2.to_bits();
        if bits < first {
            Self { begin: 0, width: first }
        } else {
            Self { begin: first + (((bits - first) >> shift) << shift), width: 1 << shift }
        }
    }

    #[inline]
    fn has(self, neighbour: Neighbour) -> bool {
        neighbour.distance2.to_bits().wrapping_sub(self.begin) < self.width
    }
}

/// Whether a neighbour comes before another: bits of distances are in the order of the distances, and take fewer instructions.
#[inline]
fn precedes(a: Neighbour, b: Neighbour) -> bool {
    let (a_bits, b_bits) = (a.distance2.to_bits(), b.distance2.to_bits());
    a_bits < b_bits || (a_bits == b_bits && a.photon < b.photon)
}
