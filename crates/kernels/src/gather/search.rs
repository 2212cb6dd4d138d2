//! The walk through the cells around a query.

use super::{Candidates, Placed};
use crate::exec::Input;
use crate::grid::{Grid, MAX_REACH, Row, axis_cell, cell_of, coordinates, gap, hash_cell, linear};

/// Squared distances below 2⁻⁷⁴ m² count as none: then it does not show whether a device flushes products that are subnormal.
///
/// In a larger sum the largest product is at least 2⁻⁷⁶, so that half its last place is at least 2⁻¹⁰⁰. A product below 2⁻¹⁰² beside
/// it rounds away, with one below 2⁻¹²⁶ or without; and one from 2⁻¹⁰² on does not change by adding one below 2⁻¹²⁶.
const LEAST_DISTANCE2: f32 = 5.293_956e-23;

/// Squared distance of two points, m²; 0 for points closer than 2⁻³⁷ m, which is 7 pm.
#[inline]
#[must_use]
pub fn distance2(a: [f32; 3], b: [f32; 3]) -> f32 {
    let x = a[0] - b[0];
    let y = a[1] - b[1];
    let z = a[2] - b[2];
    let sum = x * x + y * y + z * z;
    if sum < LEAST_DISTANCE2 { 0.0 } else { sum }
}

/// A number not below √x, and at most 9 % above it: half the exponent, raised by as much as that may be too low.
#[inline]
#[must_use]
pub fn root_above(x: f32) -> f32 {
    f32::from_bits((x.to_bits() >> 1) + 0x1fbd_1df5) * 1.0361
}

/// Offers `candidates` every photon within the grid's radius of `position` (section 3.1.3) that is not beyond their bound.
///
/// Rows of cells come nearest first, each trimmed to the cells that the bound reaches. In a table of linear cell numbers what is
/// left of a row is one run of photons; otherwise each of its cells has its own.
///
/// `LINEAR` says that the table has linear cell numbers.
///
/// Returns whether the walk came to its end. It always does, unless the device ends loops early, as llvmpipe does after
/// 65,535 iterations.
#[inline]
#[must_use]
pub fn search<const LINEAR: bool, S: Placed, M: ?Sized, A: ?Sized, O: ?Sized, C: Candidates<M, A, O, S>>(
    position: [f32; 3],
    grid: &Grid,
    rows: &Input<Row>,
    sites: &Input<S>,
    arrivals: &A,
    begins: &Input<u32>,
    memory: &mut M,
    output: &mut O,
    candidates: &mut C,
) -> bool {
    search_share::<LINEAR, _, _, _, _, _>(
        0, 1, position, grid, rows, sites, arrivals, begins, memory, output, candidates,
    )
}

/// The share of a [`search`] that has each `step`-th row from row `first` on: as many shares as `step` are the whole.
#[inline]
#[must_use]
pub fn search_share<const LINEAR: bool, S: Placed, M: ?Sized, A: ?Sized, O: ?Sized, C: Candidates<M, A, O, S>>(
    first: u32,
    step: u32,
    position: [f32; 3],
    grid: &Grid,
    rows: &Input<Row>,
    sites: &Input<S>,
    arrivals: &A,
    begins: &Input<u32>,
    memory: &mut M,
    output: &mut O,
    candidates: &mut C,
) -> bool {
    let c = coordinates(grid, position);
    let centre_y = axis_cell(c[1], grid.cells[1]) as i32 - MAX_REACH as i32;
    let centre_z = axis_cell(c[2], grid.cells[2]) as i32 - MAX_REACH as i32;
    let last = (grid.cells[0] - 1) as f32;
    let mut whole = true;
    let mut n = first;
    let mut end_of_rows = grid.rows;
    while n < end_of_rows {
        let row = rows[n as usize];
        let bound = candidates.bound();
        // Wraps where the grid ends.
        let y = (centre_y + row.y as i32) as u32;
        let z = (centre_z + row.z as i32) as u32;
        if row.least2 > bound {
            // All rows from here on are farther still.
            end_of_rows = 0;
        } else if y < grid.cells[1] && z < grid.cells[2] {
            let gap_y = gap(grid, c[1], y);
            let gap_z = gap(grid, c[2], z);
            // The margin covers the rounding of the difference.
            let rest = bound * (1.0 + 9.536_743e-7) - (gap_y * gap_y + gap_z * gap_z);
            if rest >= 0.0 {
                let half = root_above(rest) * grid.inverse_cell + grid.slack;
                let low = c[0] - half;
                let high = c[0] + half;
                let mut x = if low > 0.0 { low as u32 } else { 0 };
                let end_x = if high < last { high as u32 } else { grid.cells[0] - 1 };
                while x <= end_x {
                    let cell = [x, y, z];
                    let entry = if LINEAR { linear(cell, grid.cells) } else { hash_cell(grid, cell) };
                    let entries = if LINEAR { end_x - x + 1 } else { 1 };
                    x += entries;
                    macro_rules! consider {
                        ($slot:expr, $site:expr) => {
                            consider::<LINEAR, _, _, _, _, _>(
                                $slot, $site, position, cell, grid, sites, arrivals, memory, output, candidates,
                            )
                        };
                    }
                    let mut slot = begins[entry as usize];
                    let end = begins[(entry + entries) as usize];
                    while C::SHORT && slot < end {
                        // All four are on their way before the first is needed.
                        let last = end - 1;
                        let one = sites[slot as usize];
                        let two = sites[(if slot + 1 < last { slot + 1 } else { last }) as usize];
                        let three = sites[(if slot + 2 < last { slot + 2 } else { last }) as usize];
                        let four = sites[(if slot + 3 < last { slot + 3 } else { last }) as usize];
                        consider!(slot, one);
                        if slot < last {
                            consider!(slot + 1, two);
                        }
                        if slot + 1 < last {
                            consider!(slot + 2, three);
                        }
                        if slot + 2 < last {
                            consider!(slot + 3, four);
                        }
                        slot += 4;
                    }
                    while slot < end {
                        consider!(slot, sites[slot as usize]);
                        slot += 1;
                    }
                    whole = whole && slot >= end;
                }
                whole = whole && x > end_x;
                candidates.settle(memory);
            }
        }
        n += step;
    }
    whole && n >= end_of_rows
}

/// Offers the photon at `slot` of `cell`'s table entry, whose site is `site`.
#[inline]
fn consider<const LINEAR: bool, S: Placed, M: ?Sized, A: ?Sized, O: ?Sized, C: Candidates<M, A, O, S>>(
    slot: u32,
    site: S,
    position: [f32; 3],
    cell: [u32; 3],
    grid: &Grid,
    sites: &Input<S>,
    arrivals: &A,
    memory: &mut M,
    output: &mut O,
    candidates: &mut C,
) {
    let d2 = distance2(position, site.position(grid));
    // Several cells may share a table entry: a photon counts only where it lies, hence never twice.
    if d2 <= candidates.bound() && (LINEAR || same_cell(cell_of(grid, site.position(grid)), cell)) {
        candidates.offer(memory, output, d2, slot, sites, arrivals);
    }
}

#[inline]
fn same_cell(a: [u32; 3], b: [u32; 3]) -> bool {
    a[0] == b[0] && a[1] == b[1] && a[2] == b[2]
}
