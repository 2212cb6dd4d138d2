//! The walk through the 27 cells around a query.

use super::Selection;
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

/// Offers `selection` every photon within the grid's radius of `position` (section 3.1.3).
#[inline]
pub fn search<S: Selection>(
    position: [f32; 3],
    grid: &Grid,
    photons: &[Photon],
    order: &[u32],
    starts: &[u32],
    ends: &[u32],
    selection: &mut S,
) {
    let centre = cell_of(grid, position);
    let mut n = 0;
    while n < 27 {
        let cell = neighbour_cell(centre, n);
        // Once enough is found, cells that are farther away are left out.
        let mut slot = 0;
        let mut end = 0;
        if least_distance2(grid, position, centre, cell) <= selection.bound() {
            let entry = hash_cell(grid, cell) as usize;
            slot = starts[entry];
            end = ends[entry];
        }
        while slot < end {
            let other = photons[slot as usize].position;
            let d2 = distance2(position, other);
            // Several cells may share a table entry: a photon counts only where it lies, hence never twice.
            if d2 <= selection.bound() && (grid.hash == HASH_LINEAR || same_cell(cell_of(grid, other), cell)) {
                selection.offer(d2, slot, order);
            }
            slot += 1;
        }
        n += 1;
    }
}

#[inline]
fn same_cell(a: [u32; 3], b: [u32; 3]) -> bool {
    a[0] == b[0] && a[1] == b[1] && a[2] == b[2]
}
