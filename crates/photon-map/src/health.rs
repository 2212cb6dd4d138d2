//! How well a hash spreads its photons.

use crate::grid::rows;
use crate::{MapError, PhotonMap};
use caustic_device::Device;
use caustic_kernels::gather::{Candidates, search};
use caustic_kernels::grid::{Grid, HASH_LINEAR, Row, cell_of};
use caustic_kernels::layout::Site;
use serde::Serialize;
use std::cell::Cell;

/// Queries that are tried: photons' own positions, evenly from all.
const QUERIES: usize = 1024;

/// How photons lie in the table of a map, and what a search meets there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Health {
    /// Entries of the table.
    pub entries: u32,
    /// Share of them that have photons, 0 to 1.
    pub load: f64,
    /// Cells that have photons.
    pub cells: u32,
    /// Photons of such a cell, on average.
    pub mean_cell: f64,
    /// Photons of the fullest cell.
    pub longest_cell: u32,
    /// Cells that have photons beyond the first of each entry: 0 of a linear hash.
    pub collisions: u32,
    /// Queries that were tried, at photons of the map.
    pub queries: u32,
    /// Photons whose distance a search of the whole radius computes, those of other cells of its entries included, on average over queries. A
    /// search for the nearest k looks at fewer where k are near.
    pub candidates_per_query: f64,
    /// Most that a query looks at.
    pub most_candidates: u32,
    /// Photons within the radius of a query, on average.
    pub found_per_query: f64,
}

impl PhotonMap {
    /// Looks at the whole map, on the host.
    ///
    /// # Errors
    /// [`MapError::Device`].
    pub fn health(&self, device: &Device) -> Result<Health, MapError> {
        let grid = *self.grid();
        let [_, _, begins] = self.buffers();
        let sites = self.sites(device)?;
        let begins: Vec<u32> = device.read(begins, u64::from(grid.table) + 1)?;
        let mut health = spread(&grid, &sites, &begins);
        let rows = rows(&grid);
        let step = sites.len().div_ceil(QUERIES).max(1);
        let (mut candidates, mut found) = (0, 0);
        for site in sites.iter().step_by(step) {
            let met = meet(site.position(), &grid, &rows, &sites, &begins);
            candidates += u64::from(met[0]);
            found += u64::from(met[1]);
            health.most_candidates = health.most_candidates.max(met[0]);
            health.queries += 1;
        }
        let queries = f64::from(health.queries.max(1));
        health.candidates_per_query = candidates as f64 / queries;
        health.found_per_query = found as f64 / queries;
        Ok(health)
    }
}

fn spread(grid: &Grid, sites: &[Site], begins: &[u32]) -> Health {
    let (mut used, mut cells, mut longest) = (0u32, 0u32, 0u32);
    let mut entry = Vec::new();
    for ends in begins.windows(2).filter(|ends| ends[0] < ends[1]) {
        used += 1;
        entry.clear();
        entry.extend(sites[ends[0] as usize..ends[1] as usize].iter().map(|site| cell_of(grid, site.position())));
        entry.sort_unstable();
        for cell in entry.chunk_by(|a, b| a == b) {
            cells += 1;
            longest = longest.max(cell.len() as u32);
        }
    }
    Health {
        entries: grid.table,
        load: f64::from(used) / f64::from(grid.table),
        cells,
        mean_cell: f64::from(grid.photons) / f64::from(cells.max(1)),
        longest_cell: longest,
        collisions: cells - used,
        queries: 0,
        candidates_per_query: 0.0,
        most_candidates: 0,
        found_per_query: 0.0,
    }
}

/// Counts what the search asks: its bound once for each photon that it looks at, and once for each row of cells.
struct Asked {
    radius2: f32,
    bounds: Cell<u32>,
    offers: u32,
}

impl Candidates<(), (), ()> for Asked {
    fn bound(&self) -> f32 {
        self.bounds.set(self.bounds.get() + 1);
        self.radius2
    }

    fn offer(&mut self, _: &mut (), _: &mut (), _: f32, _: u32, _: &[Site], _: &()) {
        self.offers += 1;
    }
}

/// How many photons a search of the whole radius looks at, and how many it finds.
fn meet(position: [f32; 3], grid: &Grid, rows: &[Row], sites: &[Site], begins: &[u32]) -> [u32; 2] {
    let mut asked = Asked { radius2: grid.radius2, bounds: Cell::new(0), offers: 0 };
    let all = (&mut (), &mut (), &mut asked);
    let whole = if grid.hash == HASH_LINEAR {
        search::<true, _, _, _, _, _>(position, grid, rows, sites, &(), begins, all.0, all.1, all.2)
    } else {
        search::<false, _, _, _, _, _>(position, grid, rows, sites, &(), begins, all.0, all.1, all.2)
    };
    debug_assert!(whole, "the CPU ends no loop early");
    // The first row that is beyond the radius is asked for too; it is the last.
    let asked_rows = rows.iter().position(|row| row.least2 > grid.radius2).map_or(rows.len(), |beyond| beyond + 1);
    [asked.bounds.get() - asked_rows as u32, asked.offers]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Hash, MapOptions};
    use caustic_kernels::layout::Photon;

    fn map(positions: &[[f32; 3]], hash: Hash, table: Option<u32>) -> Health {
        let photons: Vec<Photon> =
            positions.iter().map(|&position| Photon { position, power: [1.0; 3], ..Photon::default() }).collect();
        let device = Device::cpu();
        let options = MapOptions { radius: 1.0, hash, table, cell: Some(1.0) };
        PhotonMap::build(&device, &photons, &options).unwrap().health(&device).unwrap()
    }

    #[test]
    fn photons_of_one_cell_are_all_looked_at() {
        let health = map(&[[0.5; 3]; 70], Hash::Linear, None);
        assert_eq!((health.cells, health.longest_cell, health.collisions, health.queries), (1, 70, 0, 70));
        assert_eq!((health.candidates_per_query, health.most_candidates, health.found_per_query), (70.0, 70, 70.0));
        assert_eq!(health.load, 1.0);
    }

    /// Cells three apart along x: a search looks at its own alone, unless they share an entry.
    #[test]
    fn collisions_are_counted_and_cost_candidates() {
        let positions: Vec<[f32; 3]> = (0..40).flat_map(|i| [[3.0 * i as f32 + 0.5, 0.5, 0.5]; 3]).collect();
        let linear = map(&positions, Hash::Linear, None);
        assert_eq!((linear.cells, linear.longest_cell, linear.collisions), (40, 3, 0));
        assert_eq!((linear.candidates_per_query, linear.found_per_query, linear.mean_cell), (3.0, 3.0, 3.0));
        // All cells share the one entry, which each of the cells of a row looks through.
        let one = map(&positions, Hash::Teschner, Some(1));
        assert_eq!((one.cells, one.longest_cell, one.collisions, one.load), (40, 3, 39, 1.0));
        assert_eq!(one.found_per_query, 3.0);
        assert!(one.candidates_per_query >= 120.0, "{one:?}");
    }
}
