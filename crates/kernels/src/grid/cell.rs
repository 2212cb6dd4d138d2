//! From positions to cells, and how far a cell is at least.

use super::Grid;

/// A position in cells, within the grid: what lies outside counts as on its border.
#[inline]
#[must_use]
pub fn coordinates(grid: &Grid, position: [f32; 3]) -> [f32; 3] {
    [
        axis_coordinate(position[0], grid.origin[0], grid.inverse_cell, grid.cells[0]),
        axis_coordinate(position[1], grid.origin[1], grid.inverse_cell, grid.cells[1]),
        axis_coordinate(position[2], grid.origin[2], grid.inverse_cell, grid.cells[2]),
    ]
}

#[inline]
fn axis_coordinate(x: f32, origin: f32, inverse_cell: f32, cells: u32) -> f32 {
    let c = (x - origin) * inverse_cell;
    let end = cells as f32;
    // Whatever is not inside, be it infinite.
    if c > 0.0 { if c < end { c } else { end } } else { 0.0 }
}

/// The cell of a coordinate (eq. 3.1); the grid's far border belongs to the last cell.
#[inline]
#[must_use]
pub fn axis_cell(coordinate: f32, cells: u32) -> u32 {
    let cell = coordinate as u32;
    if cell < cells { cell } else { cells - 1 }
}

/// The cell of a position: the nearest one if it lies outside of the grid.
#[inline]
#[must_use]
pub fn cell_of(grid: &Grid, position: [f32; 3]) -> [u32; 3] {
    let c = coordinates(grid, position);
    [axis_cell(c[0], grid.cells[0]), axis_cell(c[1], grid.cells[1]), axis_cell(c[2], grid.cells[2])]
}

/// A lower bound on the distance along an axis, m, from a coordinate to whatever lies in a cell.
///
/// The difference of two coordinates is wrong by [`Grid::slack`] at most.
#[inline]
#[must_use]
pub fn gap(grid: &Grid, coordinate: f32, cell: u32) -> f32 {
    let low = cell as f32;
    let cells = if low > coordinate { low - coordinate } else { coordinate - (low + 1.0) };
    let gap = (cells - grid.slack) * grid.cell_width;
    if gap > 0.0 { gap } else { 0.0 }
}
