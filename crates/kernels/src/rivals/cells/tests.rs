use super::*;
use crate::exec::Workgroup;
use crate::grid::{MAX_REACH, cell_of, linear};
use crate::num::pcg4d;
use std::vec;
use std::vec::Vec;

const SIDE: u32 = 5;

/// Photons in a linear grid of unit cells, in the order of their cells, and where those begin.
struct Map {
    grid: Grid,
    rows: Vec<Row>,
    sites: Vec<Site>,
    begins: Vec<u32>,
}

impl Map {
    /// `n` photons on a lattice of quarters, so that distances are exact and many are equal; with `crowd`, all in one point.
    fn new(n: u32, crowd: bool, radius2: f32) -> Self {
        let grid = Grid {
            inverse_cell: 1.0,
            cells: [SIDE; 3],
            hash: HASH_LINEAR,
            table: SIDE * SIDE * SIDE,
            photons: n,
            radius2,
            cell_width: 0.999,
            slack: 1e-4,
            ..Grid::default()
        };
        let mut sites: Vec<Site> = (0..n)
            .map(|i| {
                let random = pcg4d([i, 5, 6, if crowd { 1 } else { 0 }]);
                let place = |word: u32| if crowd { 2.25 } else { (word % (4 * SIDE)) as f32 / 4.0 };
                Site::new([place(random[0]), place(random[1]), place(random[2])], i)
            })
            .collect();
        let cell = |site: &Site| linear(cell_of(&grid, site.position()), grid.cells);
        // In a cell photons lie in any order.
        sites.sort_by_key(|site| (cell(site), pcg4d([site.photon(), 1, 2, 3])[0]));
        let begins = (0..=grid.table).map(|entry| sites.partition_point(|site| cell(site) < entry) as u32).collect();
        let places = || (0..2 * SIDE).map(|n| n + MAX_REACH - SIDE);
        let rows: Vec<Row> = places().flat_map(|z| places().map(move |y| Row { y, z, least2: 0.0 })).collect();
        Self { grid: Grid { rows: rows.len() as u32, ..grid }, rows, sites, begins }
    }

    /// The first k of all within the radius, by sorting them.
    fn expected(&self, query: Query, k: u32) -> Vec<(u32, u32)> {
        let distance2 = |site: &Site| {
            let [x, y, z]: [f32; 3] = core::array::from_fn(|axis| query.position[axis] - site.position()[axis]);
            x * x + y * y + z * z
        };
        let mut all: Vec<_> = self.sites.iter().map(|site| (distance2(site).to_bits(), site.photon())).collect();
        all.retain(|&(bits, _)| query.active != 0 && f32::from_bits(bits) <= self.grid.radius2);
        all.sort_unstable();
        all.truncate(k as usize);
        all
    }
}

/// Searches a map for all queries with heaps of `N`, and holds what is found against what was expected.
fn check<const N: usize, const S: usize>(map: &Map, ks: &[u32], order: &[u32]) {
    let queries: Vec<Query> = (0..12)
        .map(|i| {
            let random = pcg4d([i, 7, 7, 7]);
            let position = core::array::from_fn(|axis| (random[axis] % 32) as f32 / 4.0 - 1.0);
            Query { position: if i == 0 { [2.25; 3] } else { position }, active: u32::from(i != 3) }
        })
        .collect();
    // Registers and shared memory are those that the query before left, and rubbish at first.
    let mut registers = vec![CellsRegisters::<N>::default(); CELLS_LANES as usize];
    let mut shared = [0xa5a5_a5a5; S];
    for &k in ks {
        let params = SearchParams { queries: 12, k, photons: map.grid.photons, radius2: map.grid.radius2 };
        let unwritten = Neighbour { distance2: -1.0, photon: 7 };
        let mut neighbours = vec![unwritten; 12 * k as usize];
        let mut counts = vec![99; 12];
        // A workgroup too many, which must do nothing.
        for q in 0..13 {
            let mut lanes = Workgroup { registers: &mut registers, order, subgroup_lanes: 1 };
            cells_neighbours(
                &mut lanes,
                q,
                &mut shared,
                &params,
                &map.grid,
                &map.rows,
                &queries,
                &map.sites,
                &map.begins,
                neighbours.as_mut_slice(),
                counts.as_mut_slice(),
            );
        }
        for (q, &query) in queries.iter().enumerate() {
            let row = &neighbours[q * k as usize..][..k as usize];
            let (found, rest) = row.split_at(counts[q] as usize);
            let found: Vec<_> = found.iter().map(|n| (n.distance2.to_bits(), n.photon)).collect();
            assert_eq!(found, map.expected(query, k), "{} photons, k = {k}, query {q}", map.grid.photons);
            assert!(rest.iter().all(|&neighbour| neighbour == unwritten));
        }
    }
}

#[test]
fn what_lanes_found_is_collected_in_order_with_ties_by_index() {
    let forward: Vec<u32> = (0..CELLS_LANES).collect();
    let reversed: Vec<u32> = forward.iter().rev().copied().collect();
    for order in [forward, reversed] {
        for n in [0, 1, 15, 16, 17, 1000] {
            for radius2 in [1.0, 100.0] {
                let map = Map::new(n, false, radius2);
                check::<17, { cells_words(17) }>(&map, &[1, 2, 16, 17], &order);
                check::<257, { cells_words(257) }>(&map, &[50, 257], &order);
            }
        }
    }
}

/// One lane has them all, and the index alone decides.
#[test]
fn a_crowd_in_one_point_is_ordered_by_index() {
    let order: Vec<u32> = (0..CELLS_LANES).collect();
    for n in [16, 17, 300] {
        check::<65, { cells_words(65) }>(&Map::new(n, true, 1.0), &[1, 16, 64], &order);
    }
}

#[test]
fn shared_memory_stays_below_16_kib() {
    assert!(4 * cells_words(crate::gather::CAPACITIES[3] as usize) <= 16 << 10);
}
