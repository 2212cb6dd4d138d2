//! How far the k nearest photons probably are, from how many photons the cells around hold: no photon is looked at.
#![allow(clippy::implicit_saturating_sub)] // rust-gpu 0.10 cannot compile `saturating_sub`

use super::reach::ALL_COUNT;
use super::{CUT_SHORT, GatherParams, Placed, Reach};
use crate::exec::{Input, Store};
use crate::grid::{Grid, cell_of, hash_cell, linear};
use crate::layout::Query;
use crate::num::div;

/// 1 / π.
const PER_PI: f32 = core::f32::consts::FRAC_1_PI;

/// The probable reach of the `i`-th query: an approximation of [`gather_reach`](super::gather_reach).
///
/// A cube of (2h + 1)³ cells about the query's holds n photons; h = 1, 2, 3, 4, 8, 16 … is the first for which n ≥ k. Photons lie on
/// surfaces, and one through the cube has an area of (2h + 1)²·c², if it lies along the grid, and up to √2 of it across: so that k photons are
/// expected on the disc πr² = (2h + 1)²·c²·k/n. All photons on it count, however many they are, so that an
/// estimate over the disc is as right as any of another radius; only its noise and its blur are not quite those that k stands for.
#[inline]
pub fn likely_reach<R: Store<Reach> + ?Sized>(
    i: u32,
    params: &GatherParams,
    grid: &Grid,
    queries: &Input<Query>,
    query_order: &Input<u32>,
    begins: &Input<u32>,
    reaches: &mut R,
) {
    let within = move |centre, half| runs(centre, half, grid, begins);
    reach(i, params, grid, queries, query_order, within, reaches);
}

/// The same in a table that scatters cells, so that it looks at which photons are in which cell.
#[inline]
pub fn likely_reach_hashed<S: Placed, R: Store<Reach> + ?Sized>(
    i: u32,
    params: &GatherParams,
    grid: &Grid,
    queries: &Input<Query>,
    query_order: &Input<u32>,
    sites: &Input<S>,
    begins: &Input<u32>,
    reaches: &mut R,
) {
    let within = move |centre, half| cells(centre, half, grid, sites, begins);
    reach(i, params, grid, queries, query_order, within, reaches);
}

/// The probable reach, where `within` counts the photons of a cube and says whether it came to an end.
#[inline]
fn reach<R: Store<Reach> + ?Sized, F: Fn([u32; 3], u32) -> (u32, bool)>(
    i: u32,
    params: &GatherParams,
    grid: &Grid,
    queries: &Input<Query>,
    query_order: &Input<u32>,
    within: F,
    reaches: &mut R,
) {
    if i >= params.queries {
        return;
    }
    let q = query_order[i as usize];
    let query = queries[q as usize];
    let mut reach = Reach { radius2: grid.radius2, photon: ALL_COUNT, photons: 0 };
    if query.active != 0 {
        let centre = cell_of(grid, query.position);
        let mut half = 1;
        let mut searching = true;
        while searching {
            let (photons, whole) = within(centre, half);
            let side = (2 * half + 1) as f32 * grid.cell_width;
            let square = side * side * PER_PI;
            if !whole {
                reach.photons = CUT_SHORT;
                searching = false;
            } else if photons >= params.k {
                let radius2 = square * div(params.k as f32, photons as f32);
                reach.radius2 = if radius2 < grid.radius2 { radius2 } else { grid.radius2 };
                searching = false;
            } else {
                searching = square < grid.radius2;
                half += if half < 4 { 1 } else { half };
            }
        }
    }
    reaches.set(q, reach);
}

/// Photons in the cube of cells that reaches `half` cells to each side of `centre`, and whether they were counted to the end: in a linear
/// table a row of cells is a run.
#[inline]
fn runs(centre: [u32; 3], half: u32, grid: &Grid, begins: &Input<u32>) -> (u32, bool) {
    let across = range(centre[0], half, grid.cells[0]);
    let up = range(centre[1], half, grid.cells[1]);
    let deep = range(centre[2], half, grid.cells[2]);
    let mut photons = 0;
    let mut whole = true;
    let mut z = deep[0];
    while z <= deep[1] {
        let mut y = up[0];
        while y <= up[1] {
            let first = linear([across[0], y, z], grid.cells);
            photons += begins[(first + across[1] - across[0] + 1) as usize] - begins[first as usize];
            y += 1;
        }
        whole = whole && y > up[1];
        z += 1;
    }
    (photons, whole && z > deep[1])
}

/// The same where each cell has a table entry of its own, which others may share.
#[inline]
fn cells<S: Placed>(centre: [u32; 3], half: u32, grid: &Grid, sites: &Input<S>, begins: &Input<u32>) -> (u32, bool) {
    let across = range(centre[0], half, grid.cells[0]);
    let up = range(centre[1], half, grid.cells[1]);
    let deep = range(centre[2], half, grid.cells[2]);
    let mut photons = 0;
    let mut whole = true;
    let mut z = deep[0];
    while z <= deep[1] {
        let mut y = up[0];
        while y <= up[1] {
            let mut x = across[0];
            while x <= across[1] {
                let cell = [x, y, z];
                let entry = hash_cell(grid, cell);
                let mut slot = begins[entry as usize];
                let end = begins[(entry + 1) as usize];
                while slot < end {
                    let other = cell_of(grid, sites[slot as usize].position(grid));
                    photons += u32::from(other[0] == cell[0] && other[1] == cell[1] && other[2] == cell[2]);
                    slot += 1;
                }
                whole = whole && slot >= end;
                x += 1;
            }
            whole = whole && x > across[1];
            y += 1;
        }
        whole = whole && y > up[1];
        z += 1;
    }
    (photons, whole && z > deep[1])
}

/// First and last cell of an axis of so many `cells`, at most `half` from the `centre`.
#[inline]
fn range(centre: u32, half: u32, cells: u32) -> [u32; 2] {
    let low = if centre > half { centre - half } else { 0 };
    let high = centre + half;
    [low, if high < cells { high } else { cells - 1 }]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{HASH_LINEAR, HASH_TESCHNER};
    use crate::layout::Site;
    use std::vec;
    use std::vec::Vec;

    /// 2 × 2 photons in each cell of a plane of 9 × 9 cells of 1 m, and their map, whose hash has one entry for all if it is not linear.
    fn plane(hash: u32) -> (Grid, Vec<Site>, Vec<u32>) {
        let cells = [9, 9, 1];
        let table = if hash == HASH_LINEAR { 81 } else { 1 };
        let grid =
            Grid { inverse_cell: 1.0, cells, hash, table, radius2: 16.0, cell_width: 1.0, rows: 9, ..Grid::default() };
        let place = |n: u32| ((n / 4) % 9) as f32 + (n % 2) as f32 * 0.5 + 0.25;
        let across = |n: u32| (n / 36) as f32 + (n / 2 % 2) as f32 * 0.5 + 0.25;
        let sites = (0..4 * 81).map(|n| Site::new([place(n), across(n), 0.5], n)).collect();
        let begins = if hash == HASH_LINEAR { (0..=81).map(|cell| 4 * cell).collect() } else { vec![0, 4 * 81] };
        (grid, sites, begins)
    }

    fn reach(hash: u32, k: u32, position: [f32; 3]) -> Reach {
        let (grid, sites, begins) = plane(hash);
        let mut reaches = [Reach::default()];
        let params = GatherParams { queries: 1, k, guess: 0.0 };
        let queries = [Query { position, active: 1 }];
        let out = reaches.as_mut_slice();
        if hash == HASH_LINEAR {
            likely_reach(0, &params, &grid, &queries, &[0], &begins, out);
        } else {
            likely_reach_hashed(0, &params, &grid, &queries, &[0], &sites, &begins, out);
        }
        reaches[0]
    }

    #[test]
    fn an_even_plane_has_the_radius_of_its_density() {
        for hash in [HASH_LINEAR, HASH_TESCHNER] {
            // 4 photons a square metre: the first cube with 9 cells, and a larger one with 25.
            for k in [1, 20, 36, 37, 100] {
                let reach = reach(hash, k, [4.4, 4.9, 0.5]);
                let expected = k as f32 / 4.0 / core::f32::consts::PI;
                assert!((reach.radius2 / expected - 1.0).abs() < 1e-6, "k = {k}: {reach:?}");
                assert_eq!((reach.photon, reach.photons), (ALL_COUNT, 0));
            }
            // More than there are.
            assert_eq!(reach(hash, 1000, [4.4, 4.9, 0.5]).radius2, 16.0);
        }
    }

    #[test]
    fn at_a_corner_half_of_a_cube_is_empty() {
        // 2 × 2 of the 9 cells hold photons, so that the disc is taken for 9/4 larger.
        let radius2 = reach(HASH_LINEAR, 16, [0.1, 0.1, 0.5]).radius2;
        assert!((radius2 - 9.0 / core::f32::consts::PI).abs() < 1e-5, "{radius2}");
    }
}
