//! The construction kernels of section 3.1.3 that stand around the sort.

use super::{Grid, cell_of, hash_cell};
use crate::exec::{Batch, Input, Store, Turns};
use crate::layout::{Arrival, Photon, Query, Site};
use crate::num::Limbs;

/// Photons or table entries that one workgroup handles.
pub const GRID_BLOCK: u32 = crate::sort::SORT_BLOCK;

/// Shared memory of a workgroup that looks for the largest of its numbers.
pub type LargestShared = [u32; 768];

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
fn put(shared: &mut LargestShared, lane: u32, numbers: [u32; 3]) {
    shared[(3 * lane) as usize] = numbers[0];
    shared[(3 * lane + 1) as usize] = numbers[1];
    shared[(3 * lane + 2) as usize] = numbers[2];
}

#[inline]
fn get(shared: &LargestShared, lane: u32) -> [u32; 3] {
    [shared[(3 * lane) as usize], shared[(3 * lane + 1) as usize], shared[(3 * lane + 2) as usize]]
}

/// Leaves the largest of the lanes' numbers at the beginning of `shared`.
#[inline]
fn largest<const N: usize, L: Turns<GridRegisters<N>>>(lanes: &mut L, shared: &mut LargestShared) {
    let mut half = lanes.lanes() / 2;
    while half > 0 {
        lanes.each(shared, move |lane, _, shared: &mut LargestShared| {
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
    shared: &mut LargestShared,
    grid: &Grid,
    keys: &Input<u32>,
    powers: &Input<u32>,
    begins: &mut B,
    power: &mut P,
) {
    let count = lanes.lanes();
    if group == 0 {
        lanes.each(shared, move |lane, r: &mut GridRegisters<N>, shared: &mut LargestShared| {
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
        lanes.each(shared, move |lane, _, shared: &mut LargestShared| {
            if lane == 0 {
                power.set(0, shared[0]);
                power.set(1, shared[1]);
                power.set(2, shared[2]);
            }
        });
    }
    lanes.each(shared, move |lane, _, _: &mut LargestShared| {
        let mut entry = group * GRID_BLOCK + lane * N as u32;
        let end = entry + N as u32;
        let mut place = 0;
        while entry < end && entry <= grid.table {
            place = first_from(keys, place, grid.photons, entry);
            begins.set(entry, place);
            entry += 1;
        }
    });
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
    index: u32,
    photon: Photon,
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
