//! A spatial hash in which each cell has a thread of its own (thesis, section 5.6).

use crate::hash::{Cells, build_map};
use crate::{PhotonIndex, Photons};
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::rivals::SearchParams;
use caustic_photon_map::{MapError, MapOptions, Neighbours, PhotonMap, capacity};

/// A photon map that is searched by a workgroup a query, whose lanes share out the cells around it.
pub(crate) struct CellsIndex {
    map: PhotonMap,
}

impl CellsIndex {
    pub(crate) fn build(device: &Device, photons: &Photons, options: &MapOptions) -> Result<Self, MapError> {
        Ok(Self { map: build_map(device, photons, options, Cells::Radius)? })
    }
}

impl PhotonIndex for CellsIndex {
    fn search(&self, device: &Device, queries: &Buffer, count: u32, k: u32) -> Result<Neighbours, MapError> {
        let found = Neighbours::new(device, count, k)?;
        let kernel = match capacity(k)? {
            17 => Kernel::CellsNeighbours17,
            65 => Kernel::CellsNeighbours65,
            257 => Kernel::CellsNeighbours257,
            _ => Kernel::CellsNeighbours1025,
        };
        let grid = self.map.grid();
        let params = SearchParams { queries: count, k, photons: grid.photons, radius2: grid.radius2 };
        let params = device.upload("cells: params", &[params])?;
        let [grid, rows, sites, begins] = self.map.search_buffers();
        let mut plan = Plan::new();
        let buffers = [&params, grid, rows, queries, sites, begins, &found.neighbours, &found.counts];
        plan.groups(kernel, count, &buffers);
        device.run(&plan)?;
        Ok(found)
    }

    fn bytes(&self) -> u64 {
        self.map.bytes()
    }
}
