//! Spatial hashing (thesis, chapter 3): caustic's own photon map as one technique among others.

use crate::{PhotonIndex, Photons};
use caustic_device::{Buffer, Device, Plan};
use caustic_photon_map::{Gather, MapError, MapOptions, Neighbours, PhotonMap, plan_grid};

/// A photon map, with the gather by which it is searched.
pub(crate) struct HashIndex {
    map: PhotonMap,
    gather: Gather,
}

impl HashIndex {
    pub(crate) fn build(
        device: &Device,
        photons: &Photons,
        options: &MapOptions,
        gather: Gather,
    ) -> Result<Self, MapError> {
        Ok(Self { map: build_map(device, photons, options)?, gather })
    }
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
pub(crate) fn build_map(device: &Device, photons: &Photons, options: &MapOptions) -> Result<PhotonMap, MapError> {
    let grid = plan_grid(photons.low, photons.high, u64::from(photons.count), &photons.sample, options)?;
    let mut plan = Plan::new();
    let map = PhotonMap::plan(device, &mut plan, &photons.buffer, grid)?;
    device.run(&plan)?;
    Ok(map)
}
