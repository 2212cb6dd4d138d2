//! The walk through the 27 cells around a query.

use super::Candidates;
use crate::grid::{Grid, HASH_LINEAR, cell_of, hash_cell, least_distance2, neighbour_cell};
use crate::layout::Photon;

/// Squared distance of two points, m². A difference below 2⁻⁶³ m along an axis counts as none: its square would be subnormal,
/// and not every device has such numbers.
#[inline]
#[must_use]
pub fn distance2(a: [f32; 3], b: [f32; 3]) -> f32 {
    let x = square(a[0] - b[0]);
    let y = square(a[1] - b[1]);
    let z = square(a[2] - b[2]);
    x + y + z
}

/// The square of `x`, zero or normal: (2⁻⁶³)² is the smallest normal number.
#[inline]
fn square(x: f32) -> f32 {
    const LEAST: u32 = (127 - 63) << 23;
    if x.to_bits() & 0x7fff_ffff < LEAST { 0.0 } else { x * x }
}

/// Offers `candidates` every photon within the grid's radius of `position` (section 3.1.3) that is not beyond their bound.
///
/// Returns whether the walk came to its end. It always does, unless the device ends loops early, as llvmpipe does after
/// 65,535 iterations.
#[inline]
#[must_use]
pub fn search<C: Candidates>(
    position: [f32; 3],
    grid: &Grid,
    photons: &[Photon],
    order: &[u32],
    starts: &[u32],
    ends: &[u32],
    candidates: &mut C,
) -> bool {
    let centre = cell_of(grid, position);
    let mut whole = true;
    let mut n = 0;
    while n < 27 {
        let cell = neighbour_cell(centre, n);
        // Once enough is found, cells that are farther away are left out.
        let mut slot = 0;
        let mut end = 0;
        if least_distance2(grid, position, centre, cell) <= candidates.bound() {
            let entry = hash_cell(grid, cell) as usize;
            slot = starts[entry];
            end = ends[entry];
        }
        while slot < end {
            consider(slot, end, position, cell, grid, photons, order, candidates);
            if C::SHORT {
                consider(slot + 1, end, position, cell, grid, photons, order, candidates);
                consider(slot + 2, end, position, cell, grid, photons, order, candidates);
                consider(slot + 3, end, position, cell, grid, photons, order, candidates);
                consider(slot + 4, end, position, cell, grid, photons, order, candidates);
                consider(slot + 5, end, position, cell, grid, photons, order, candidates);
                consider(slot + 6, end, position, cell, grid, photons, order, candidates);
                consider(slot + 7, end, position, cell, grid, photons, order, candidates);
            }
            slot += if C::SHORT { 8 } else { 1 };
        }
        candidates.settle();
        whole = whole && slot >= end;
        n += 1;
    }
    whole && n >= 27
}

/// Offers the photon at `slot` of `cell`'s table entry, which stops before `end`.
#[inline]
fn consider<C: Candidates>(
    slot: u32,
    end: u32,
    position: [f32; 3],
    cell: [u32; 3],
    grid: &Grid,
    photons: &[Photon],
    order: &[u32],
    candidates: &mut C,
) {
    if slot < end {
        let other = photons[slot as usize].position;
        let d2 = distance2(position, other);
        // Several cells may share a table entry: a photon counts only where it lies, hence never twice.
        if d2 <= candidates.bound() && (grid.hash == HASH_LINEAR || same_cell(cell_of(grid, other), cell)) {
            candidates.offer(d2, slot, order, photons);
        }
    }
}

#[inline]
fn same_cell(a: [u32; 3], b: [u32; 3]) -> bool {
    a[0] == b[0] && a[1] == b[1] && a[2] == b[2]
}
