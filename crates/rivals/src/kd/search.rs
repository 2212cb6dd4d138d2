//! Both searches as plans.

use super::{KD_HISTOGRAMS, KdSearch, KdTree};
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::rivals::SearchParams;
use caustic_kernels::rivals::kd::KdRadius;
use caustic_photon_map::{MapError, Neighbours, capacity};

impl KdTree {
    /// Appends the search for the `k` nearest photons of `count` queries to a plan.
    pub(super) fn plan_neighbours(
        &self,
        device: &Device,
        plan: &mut Plan,
        queries: &Buffer,
        count: u32,
        k: u32,
        search: KdSearch,
    ) -> Result<Neighbours, MapError> {
        let Neighbours { neighbours, counts } = Neighbours::new(device, count, k)?;
        let capacity = capacity(k)?;
        let params = SearchParams { queries: count, k, photons: self.photons, radius2: self.radius * self.radius };
        let params = device.upload("search: params", &[params])?;
        match search {
            KdSearch::Nearest => {
                let kernel = match capacity {
                    17 => Kernel::KdNearest17,
                    65 => Kernel::KdNearest65,
                    257 => Kernel::KdNearest257,
                    _ => Kernel::KdNearest1025,
                };
                plan.each(kernel, count, &[&params, queries, &self.tree, &neighbours, &counts]);
            }
            KdSearch::Range => {
                let kernel = match capacity {
                    17 => Kernel::KdRange17,
                    65 => Kernel::KdRange65,
                    257 => Kernel::KdRange257,
                    _ => Kernel::KdRange1025,
                };
                let radii2 = self.plan_radii(device, plan, queries, count, k, KD_HISTOGRAMS)?;
                plan.each(kernel, count, &[&params, queries, &radii2, &self.tree, &neighbours, &counts]);
            }
        }
        Ok(Neighbours { neighbours, counts })
    }

    /// Appends the search for radii by histograms to a plan: their squares, m², of which each holds `k` photons if the tree's radius does.
    pub(super) fn plan_radii(
        &self,
        device: &Device,
        plan: &mut Plan,
        queries: &Buffer,
        count: u32,
        k: u32,
        iterations: u32,
    ) -> Result<Buffer, MapError> {
        let params = KdRadius { queries: count, k, photons: self.photons, iterations, radius: self.radius };
        let params = device.upload("kd: radius", &[params])?;
        let radii2 = device.scratch::<f32>("kd: radii", u64::from(count))?;
        plan.each(Kernel::KdRadii, count, &[&params, queries, &self.tree, &radii2]);
        Ok(radii2)
    }
}
