//! Which photons can be of use: those that some query is near enough to count.
//!
//! Queries mark the cells of a grid that they lie in. A photon that is farther than the radius from each marked cell is farther than that from
//! each query, so that no estimate knows it, and need not be kept: what is estimated has the same bits without it.

use super::{Grid, axis_cell, coordinates, gap, linear};
use crate::exec::{Input, Store, Update};
use crate::layout::Photon;
use crate::sort::SCAN_BLOCK;

/// Marks cell `i` of a linear grid if a query of this tile lies in it, by where each cell begins among the sorted queries. What other tiles
/// marked stays so.
#[inline]
pub fn mark_cells<S: Update<u32> + ?Sized>(i: u32, grid: &Grid, begins: &Input<u32>, seen: &mut S) {
    if i < grid.table && begins[(i + 1) as usize] > begins[i as usize] {
        seen.set(i, 1);
    }
}

/// Says of photon `i` whether a marked cell is within the grid's radius: 1 or 0. Cells are no narrower than that radius, so that none but its own
/// and those around it can be.
#[inline]
pub fn see_photons<N: Store<u32> + ?Sized>(
    i: u32,
    grid: &Grid,
    seen: &Input<u32>,
    photons: &Input<Photon>,
    near: &mut N,
) {
    if i >= grid.photons {
        return;
    }
    let at = coordinates(grid, photons[i as usize].position);
    let cells = grid.cells;
    let centre = [axis_cell(at[0], cells[0]), axis_cell(at[1], cells[1]), axis_cell(at[2], cells[2])];
    let mut found = 0;
    let mut n = 0;
    while n < 27 {
        // A coordinate one less than 0 wraps round, and is outside as well.
        let x = centre[0].wrapping_add(n % 3).wrapping_sub(1);
        let y = centre[1].wrapping_add(n / 3 % 3).wrapping_sub(1);
        let z = centre[2].wrapping_add(n / 9).wrapping_sub(1);
        if x < cells[0] && y < cells[1] && z < cells[2] {
            let (gap_x, gap_y, gap_z) = (gap(grid, at[0], x), gap(grid, at[1], y), gap(grid, at[2], z));
            let least2 = gap_x * gap_x + gap_y * gap_y + gap_z * gap_z;
            if least2 <= grid.radius2 && seen[linear([x, y, z], cells) as usize] != 0 {
                found = 1;
            }
        }
        n += 1;
    }
    near.set(i, found);
}

/// Copies photon `i` to its place among those that are kept: its offset in its scan block, plus the offset of that block.
#[inline]
pub fn keep_photons<P: Store<Photon> + ?Sized>(
    i: u32,
    grid: &Grid,
    photons: &Input<Photon>,
    near: &Input<u32>,
    offsets: &Input<u32>,
    block_offsets: &Input<u32>,
    kept: &mut P,
) {
    if i < grid.photons && near[i as usize] != 0 {
        let place = offsets[i as usize] + block_offsets[(i / SCAN_BLOCK) as usize];
        kept.set(place, photons[i as usize]);
    }
}
