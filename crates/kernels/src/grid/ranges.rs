//! The construction kernels of section 3.1.3 that stand around the sort.

use super::{Grid, cell_of, hash_cell};
use crate::exec::{Batch, Input, Store, Turns};
use crate::layout::{Arrival, Photon, Query, Site};
use crate::num::Limbs;

/// Photons or table entries that one workgroup handles.
pub const GRID_BLOCK: u32 = crate::sort::SORT_BLOCK;

/// Shared memory of a workgroup that looks for the largest of its numbers.
pub type LargestShared = [u32; 768];

/// Table entries that one workgroup handles.
pub const BEGINS_BLOCK: u32 = 1024;
/// Most keys of these entries that are looked at one by one. Where photons crowd, each entry's begin is searched for.
const MOST_KEYS: u32 = 1 << 14;
/// An entry without a key.
const NO_KEY: u32 = 0xffff_ffff;
/// Shared memory of a workgroup that finds begins: the entries' own, …
pub type BeginsShared = [u32; 1538];
/// … two copies of the lanes' least, …
const LANE_PLACES: u32 = BEGINS_BLOCK;
/// … and the limits of their keys.
const LOW: usize = 1536;
const HIGH: usize = 1537;

/// Registers of a lane that handles `N` items.
#[derive(Clone, Copy, Default)]
pub struct GridRegisters<const N: usize> {
    largest: [u32; 3],
}

/// The unsorted list of hash values, and the largest power in each block and channel, as bits: those of floats that are not
/// negative are in the order of the floats. The photon's index that belongs to a hash value is its place, so only keys are stored.
#[inline]
pub fn hash_photons<const N: usize, L: Turns<GridRegisters<N>>, K: Store<u32> + ?Sized, P: Store<u32> + ?Sized>(
    lanes: &mut L,
    group: u32,
    shared: &mut LargestShared,
    grid: &Grid,
    photons: &Input<Photon>,
    keys: &mut K,
    powers: &mut P,
) {
    let first = group * GRID_BLOCK;
    if first >= grid.photons {
        return;
    }
    let count = lanes.lanes();
    lanes.each(shared, move |lane, r: &mut GridRegisters<N>, shared: &mut LargestShared| {
        r.largest = [0; 3];
        let mut item = 0;
        while item < N as u32 {
            let i = first + item * count + lane;
            if i < grid.photons {
                let photon = photons[i as usize];
                keys.set(i, hash_cell(grid, cell_of(grid, photon.position)));
                let power = photon.power;
                r.largest = larger(r.largest, [power[0].to_bits(), power[1].to_bits(), power[2].to_bits()]);
            }
            item += 1;
        }
        put(shared, lane, r.largest);
    });
    largest(lanes, shared);
    lanes.each(shared, move |lane, _, shared: &mut LargestShared| {
        if lane == 0 {
            powers.set(3 * group, shared[0]);
            powers.set(3 * group + 1, shared[1]);
            powers.set(3 * group + 2, shared[2]);
        }
    });
}

#[inline]
fn larger(a: [u32; 3], b: [u32; 3]) -> [u32; 3] {
    [
        if a[0] < b[0] { b[0] } else { a[0] },
        if a[1] < b[1] { b[1] } else { a[1] },
        if a[2] < b[2] { b[2] } else { a[2] },
    ]
}

#[inline]
fn put<const W: usize>(shared: &mut [u32; W], lane: u32, numbers: [u32; 3]) {
    shared[(3 * lane) as usize] = numbers[0];
    shared[(3 * lane + 1) as usize] = numbers[1];
    shared[(3 * lane + 2) as usize] = numbers[2];
}

#[inline]
fn get<const W: usize>(shared: &[u32; W], lane: u32) -> [u32; 3] {
    [shared[(3 * lane) as usize], shared[(3 * lane + 1) as usize], shared[(3 * lane + 2) as usize]]
}

/// Leaves the largest of the lanes' numbers at the beginning of `shared`.
#[inline]
fn largest<const N: usize, const W: usize, L: Turns<GridRegisters<N>>>(lanes: &mut L, shared: &mut [u32; W]) {
    let mut half = lanes.lanes() / 2;
    while half > 0 {
        lanes.each(shared, move |lane, _, shared: &mut [u32; W]| {
            if lane < half {
                let numbers = larger(get(shared, lane), get(shared, lane + half));
                put(shared, lane, numbers);
            }
        });
        half /= 2;
    }
}

/// Where each table entry begins in the sorted list: the first place whose key is not below it. An entry ends where the next
/// begins, neighbouring entries are one run, and entries without photons need no clearing. There is one begin more than entries.
///
/// The first workgroup also finds the largest of all `powers` in each channel.
#[inline]
pub fn cell_begins<const N: usize, L: Turns<GridRegisters<N>>, B: Store<u32> + ?Sized, P: Store<u32> + ?Sized>(
    lanes: &mut L,
    group: u32,
    shared: &mut BeginsShared,
    grid: &Grid,
    keys: &Input<u32>,
    powers: &Input<u32>,
    begins: &mut B,
    power: &mut P,
) {
    let count = lanes.lanes();
    if group == 0 {
        lanes.each(shared, move |lane, r: &mut GridRegisters<N>, shared: &mut BeginsShared| {
            r.largest = [0; 3];
            let mut block = lane;
            while block * GRID_BLOCK < grid.photons {
                let first = (3 * block) as usize;
                r.largest = larger(r.largest, [powers[first], powers[first + 1], powers[first + 2]]);
                block += count;
            }
            put(shared, lane, r.largest);
        });
        largest(lanes, shared);
        lanes.each(shared, move |lane, _, shared: &mut BeginsShared| {
            if lane == 0 {
                power.set(0, shared[0]);
                power.set(1, shared[1]);
                power.set(2, shared[2]);
            }
        });
    }
    let first = group * BEGINS_BLOCK;
    if count == 1 {
        // With nobody beside it, a lane goes from entry to entry.
        lanes.each(shared, move |_, _, _: &mut BeginsShared| {
            let mut place = 0;
            let mut entry = first;
            while entry < first + BEGINS_BLOCK && entry <= grid.table {
                place = first_from(keys, place, grid.photons, entry);
                begins.set(entry, place);
                entry += 1;
            }
        });
        return;
    }
    let end = first + BEGINS_BLOCK;
    // 1. Which keys belong to these entries.
    lanes.each(shared, move |lane, _, shared: &mut BeginsShared| {
        if lane == 0 {
            shared[LOW] = first_of(keys, grid.photons, first);
        } else if lane == count / 2 {
            shared[HIGH] = first_of(keys, grid.photons, end);
        }
    });
    // 2. Where keys change, an entry begins.
    lanes.each(shared, move |lane, _, shared: &mut BeginsShared| {
        let mut entry = lane;
        while entry < BEGINS_BLOCK {
            shared[entry as usize] = NO_KEY;
            entry += count;
        }
    });
    lanes.each(shared, move |lane, _, shared: &mut BeginsShared| {
        let low = shared[LOW];
        let high = shared[HIGH];
        let mut i = low + lane;
        while high - low <= MOST_KEYS && i < high {
            let key = keys[i as usize];
            if i == low || keys[(i - 1) as usize] != key {
                shared[(key - first) as usize] = i;
            }
            i += count;
        }
    });
    // 3. Entries without a key begin where the next with one does.
    let each = BEGINS_BLOCK / count;
    lanes.each(shared, move |lane, _, shared: &mut BeginsShared| {
        let mut place = NO_KEY;
        let mut j = each;
        while j > 0 {
            j -= 1;
            let entry = (lane * each + j) as usize;
            place = if shared[entry] < place { shared[entry] } else { place };
            shared[entry] = place;
        }
        shared[(LANE_PLACES + lane) as usize] = place;
    });
    // The least of the lanes after each (Hillis and Steele 1986), from one copy into the other.
    let mut from = LANE_PLACES;
    let mut step = 1;
    while step < count {
        let to = 2 * LANE_PLACES + count - from;
        lanes.each(shared, move |lane, _, shared: &mut BeginsShared| {
            let mut place = shared[(from + lane) as usize];
            if lane + step < count {
                let other = shared[(from + lane + step) as usize];
                place = if other < place { other } else { place };
            }
            shared[(to + lane) as usize] = place;
        });
        from = to;
        step *= 2;
    }
    lanes.each(shared, move |lane, _, shared: &mut BeginsShared| {
        let high = shared[HIGH];
        let crowded = high - shared[LOW] > MOST_KEYS;
        let mut entry = lane;
        while entry < BEGINS_BLOCK && first + entry <= grid.table {
            let mut place = shared[entry as usize];
            let after = entry / each + 1;
            if place == NO_KEY && after < count {
                place = shared[(from + after) as usize];
            }
            if place > high {
                place = high;
            }
            if crowded {
                place = first_from(keys, shared[LOW], high, first + entry);
            }
            begins.set(first + entry, place);
            entry += count;
        }
    });
}

/// The first place whose key is not below `key`, by halves.
#[inline]
fn first_of(keys: &Input<u32>, end: u32, key: u32) -> u32 {
    let mut low = 0;
    let mut high = end;
    while low < high {
        let middle = low + (high - low) / 2;
        if keys[middle as usize] < key {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}

/// The first place from `place` on whose key is not below `key`: by steps that double, then by halves, so that near ones are
/// found as fast as far ones can be.
#[inline]
fn first_from(keys: &Input<u32>, place: u32, end: u32, key: u32) -> u32 {
    if place >= end || keys[place as usize] >= key {
        return place;
    }
    let mut below = place;
    let mut step = 1;
    let mut above = below + step;
    while above < end && keys[above as usize] < key {
        below = above;
        step *= 2;
        above = below + step;
    }
    if above > end {
        above = end;
    }
    while above - below > 1 {
        let middle = below + (above - below) / 2;
        if keys[middle as usize] < key {
            below = middle;
        } else {
            above = middle;
        }
    }
    above
}

/// A photon on its way to its place.
#[derive(Clone, Copy, Default)]
pub struct Moved {
    pub(crate) index: u32,
    pub(crate) photon: Photon,
}

/// Copies the photons into sorted order, so that a cell's photons lie side by side: what a search tests apart from what it
/// reads of those that count. `power` are the largest powers, as bits, to which powers are aligned.
#[inline]
pub fn reorder_photons<B: Batch<Moved>, S: Store<Site> + ?Sized, A: Store<Arrival> + ?Sized>(
    batch: &mut B,
    grid: &Grid,
    order: &Input<u32>,
    photons: &Input<Photon>,
    power: &Input<u32>,
    sites: &mut S,
    arrivals: &mut A,
) {
    batch.each(move |i, moved| {
        if i < grid.photons {
            let index = order[i as usize];
            *moved = Moved { index, photon: photons[index as usize] };
        }
    });
    batch.each(move |i, moved| {
        if i < grid.photons {
            let Moved { index, photon } = *moved;
            let red = Limbs::of(photon.power[0], f32::from_bits(power[0]));
            let green = Limbs::of(photon.power[1], f32::from_bits(power[1]));
            let blue = Limbs::of(photon.power[2], f32::from_bits(power[2]));
            sites.set(i, Site::new(photon.position, index));
            arrivals.set(i, Arrival::new(red.0, green.0, blue.0, photon.direction, photon.primitive));
        }
    });
}

/// The table entry of each query, by which queries are sorted so that neighbouring lanes walk the same cells. Those that seek
/// nothing come last.
#[inline]
pub fn hash_queries<K: Store<u32> + ?Sized>(
    i: u32,
    params: &crate::gather::GatherParams,
    grid: &Grid,
    queries: &Input<Query>,
    keys: &mut K,
) {
    if i < params.queries {
        let query = queries[i as usize];
        let entry = hash_cell(grid, cell_of(grid, query.position));
        keys.set(i, if query.active != 0 { entry } else { grid.table - 1 });
    }
}
