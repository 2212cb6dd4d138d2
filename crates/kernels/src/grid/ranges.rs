//! The three construction kernels of section 3.1.3 that stand around the sort.

use super::{Grid, cell_of, hash_cell};
use crate::exec::Store;
use crate::layout::Photon;

/// The unsorted list of hash values. The photon's index that belongs to each is its place, so only the keys are stored.
#[inline]
pub fn hash_photons<K: Store<u32> + ?Sized>(i: u32, grid: &Grid, photons: &[Photon], keys: &mut K) {
    if i < grid.photons {
        keys.set(i, hash_cell(grid, cell_of(grid, photons[i as usize].position)));
    }
}

/// Where each hash value begins and ends in the sorted list. Entries without photons keep the zeros they were cleared to.
#[inline]
pub fn cell_ranges<S: Store<u32> + ?Sized, E: Store<u32> + ?Sized>(
    i: u32,
    grid: &Grid,
    keys: &[u32],
    starts: &mut S,
    ends: &mut E,
) {
    if i < grid.photons {
        let key = keys[i as usize];
        if i == 0 {
            starts.set(key, 0);
        } else {
            let previous = keys[(i - 1) as usize];
            if previous != key {
                ends.set(previous, i);
                starts.set(key, i);
            }
        }
        if i == grid.photons - 1 {
            ends.set(key, i + 1);
        }
    }
}

/// Copies the photons into sorted order, so that a cell's photons lie side by side.
#[inline]
pub fn reorder_photons<P: Store<Photon> + ?Sized>(
    i: u32,
    grid: &Grid,
    order: &[u32],
    photons: &[Photon],
    sorted: &mut P,
) {
    if i < grid.photons {
        sorted.set(i, photons[order[i as usize] as usize]);
    }
}
