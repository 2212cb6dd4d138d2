//! Spatial hashing (thesis, chapter 3): caustic's own photon map as one technique among others, and as the thesis has it.

use crate::{PhotonIndex, Photons};
use caustic_device::{Buffer, Device, Plan};
use caustic_kernels::grid::{MAX_REACH, Row};
use caustic_photon_map::{Gather, Hash, MapError, MapOptions, Neighbours, PhotonMap, plan_grid, rows};

/// The cells of a grid, and the order in which a search visits them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cells {
    /// As caustic has them: as wide as the crowding of photons asks for, nearest first.
    Crowding,
    /// As wide as the radius (section 3.1.3), nearest first.
    Radius,
    /// As wide as the radius, the query's own row of cells first and the others in the order of their offsets (section 5.3.3).
    CentreFirst,
    /// As wide as the radius, in the order of their offsets, as the thesis had them at first (figure 8).
    InOrder,
}

/// A photon map, with the gather by which it is searched.
pub(crate) struct HashIndex {
    map: PhotonMap,
    gather: Gather,
}

impl HashIndex {
    pub(crate) fn build(
        device: &Device,
        photons: &Photons,
        radius: f32,
        hash: Hash,
        table: Option<u32>,
        cells: Cells,
        gather: Gather,
    ) -> Result<Self, MapError> {
        let cell = (cells != Cells::Crowding).then_some(radius);
        let options = MapOptions { radius, hash, table, cell };
        Ok(Self { map: build_map(device, photons, &options, cells)?, gather })
    }
}

/// Puts rows in the order of their offsets. No row says then that those after it are farther.
fn in_order(rows: &mut [Row], centre_first: bool) {
    for row in rows.iter_mut() {
        row.least2 = 0.0;
    }
    let is_centre = |row: &Row| row.y == MAX_REACH && row.z == MAX_REACH;
    rows.sort_by_key(|row| (!(centre_first && is_centre(row)), row.z, row.y));
}

impl PhotonIndex for HashIndex {
    fn search(&self, device: &Device, queries: &Buffer, count: u32, k: u32) -> Result<Neighbours, MapError> {
        let mut plan = Plan::new();
        let found = self.map.plan_neighbours(device, &mut plan, queries, count, k, self.gather)?;
        device.run(&plan)?;
        Ok(found)
    }

    fn bytes(&self) -> u64 {
        self.map.bytes()
    }
}

/// Builds a photon map.
pub(crate) fn build_map(
    device: &Device,
    photons: &Photons,
    options: &MapOptions,
    cells: Cells,
) -> Result<PhotonMap, MapError> {
    let grid = plan_grid(photons.low, photons.high, u64::from(photons.count), &photons.sample, options)?;
    let mut rows = rows(&grid);
    if matches!(cells, Cells::CentreFirst | Cells::InOrder) {
        in_order(&mut rows, cells == Cells::CentreFirst);
    }
    let mut plan = Plan::new();
    let map = PhotonMap::plan_with_rows(device, &mut plan, &photons.buffer, grid, &rows)?;
    device.run(&plan)?;
    Ok(map)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_in_order_begin_where_they_should() {
        let options = MapOptions { radius: 1.0, hash: Hash::Linear, table: None, cell: Some(1.0) };
        let grid = plan_grid([0.0; 3], [9.0; 3], 1, &[], &options).unwrap();
        let mut all = rows(&grid);
        in_order(&mut all, false);
        assert!(all.is_sorted_by_key(|row| (row.z, row.y)) && all.iter().all(|row| row.least2 == 0.0));
        assert_ne!((all[0].y, all[0].z), (MAX_REACH, MAX_REACH));
        in_order(&mut all, true);
        assert_eq!((all[0].y, all[0].z), (MAX_REACH, MAX_REACH));
        assert!(all[1..].is_sorted_by_key(|row| (row.z, row.y)));
    }
}
