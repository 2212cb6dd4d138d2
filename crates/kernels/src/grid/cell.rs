//! From positions to cells.

use super::Grid;
use crate::num::floor_to_i32;

/// The cell of a position (eq. 3.1), in 1 ..= cells − 2 along each axis.
///
/// Photons lie inside the grid. A query outside it is moved to the nearest inner cell: the neighbourhood of that cell
/// holds every photon within r_max of the query, since cells are as wide as r_max, and distance rejects the others.
#[inline]
#[must_use]
pub fn cell_of(grid: &Grid, position: [f32; 3]) -> [u32; 3] {
    [
        axis_cell(position[0], grid.origin[0], grid.inverse_cell, grid.cells[0]),
        axis_cell(position[1], grid.origin[1], grid.inverse_cell, grid.cells[1]),
        axis_cell(position[2], grid.origin[2], grid.inverse_cell, grid.cells[2]),
    ]
}

#[inline]
fn axis_cell(x: f32, origin: f32, inverse_cell: f32, cells: u32) -> u32 {
    let inner = floor_to_i32((x - origin) * inverse_cell);
    let last = cells as i32 - 3;
    if inner < 0 {
        1
    } else if inner > last {
        (last + 1) as u32
    } else {
        (inner + 1) as u32
    }
}

/// The `n`-th of the 27 cells around an inner cell: the neighbour offset table, computed. The cell itself comes first, in
/// exchange for the place it would have, which saved 15 % in the thesis (section 5.3.3): near photons come early, and far
/// ones are then rejected. All of them lie in the grid; the border cells exist so that this needs no check (section 3.1.3).
#[inline]
#[must_use]
pub fn neighbour_cell(cell: [u32; 3], n: u32) -> [u32; 3] {
    let place = if n == 0 {
        13
    } else if n == 13 {
        0
    } else {
        n
    };
    [cell[0] + place % 3 - 1, cell[1] + place / 3 % 3 - 1, cell[2] + place / 9 - 1]
}

/// A lower bound on the squared distance, m², from a position in inner cell `from` to whatever lies in neighbour cell `to`.
///
/// With c = (x − origin)·s in cells, every point of the next cell has a c of at least the border between the two, and the
/// difference of two such c is wrong by [`Grid::slack`] at most.
#[inline]
#[must_use]
pub fn least_distance2(grid: &Grid, position: [f32; 3], from: [u32; 3], to: [u32; 3]) -> f32 {
    let x = axis_gap(grid, position[0], grid.origin[0], from[0], to[0]);
    let y = axis_gap(grid, position[1], grid.origin[1], from[1], to[1]);
    let z = axis_gap(grid, position[2], grid.origin[2], from[2], to[2]);
    x * x + y * y + z * z
}

#[inline]
fn axis_gap(grid: &Grid, x: f32, origin: f32, from: u32, to: u32) -> f32 {
    if from == to {
        return 0.0;
    }
    // Inner cell n spans c from n − 1 to n.
    let c = (x - origin) * grid.inverse_cell;
    let cells = if to > from { from as f32 - c } else { c - (from as f32 - 1.0) };
    let gap = (cells - grid.slack) * grid.cell_width;
    // A query outside the grid was moved into it: there, no bound is known.
    if gap > 0.0 && gap <= grid.cell_width { gap } else { 0.0 }
}
