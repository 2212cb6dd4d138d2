//! The kd-tree on the GPU (thesis, section 2.3): construction by Zhou et al. 2008, and two searches. `caustic_kernels::rivals::kd`
//! says how.

mod build;
mod error;
mod large;
mod search;
mod small;

pub use error::{RadiusError, radius_error};

use crate::{PhotonIndex, Photons};
use caustic_device::{Buffer, Device, Plan};
use caustic_kernels::rivals::kd::KD_MAX_PHOTONS;
use caustic_photon_map::{MapError, Neighbours, RADII};

/// Histograms after which [`KdSearch::Range`] collects: two leave a radius that is off by less than 0.1 % of the one to begin with.
pub const KD_HISTOGRAMS: u32 = 2;

/// How the tree is searched. Both are exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KdSearch {
    /// For the k nearest at once, in a max-heap whose last is the bound of the walk.
    Nearest,
    /// As Zhou et al. do: histograms narrow the radius down, then all photons within it are collected. Those that are too many,
    /// which theirs keeps or loses, a heap leaves out.
    Range,
}

/// A kd-tree over photons.
pub struct KdTree {
    tree: Buffer,
    photons: u32,
    radius: f32,
    levels: [u32; 2],
    search: KdSearch,
}

impl KdTree {
    /// Builds a tree over photons for searches within `radius` (m), which is also the R of its cost function.
    ///
    /// # Errors
    /// [`MapError::Radius`], [`MapError::TooMany`] and [`MapError::Device`].
    pub fn build(device: &Device, photons: &Photons, radius: f32, search: KdSearch) -> Result<Self, MapError> {
        if !RADII.contains(&radius) {
            return Err(MapError::Radius { radius });
        }
        if photons.count > KD_MAX_PHOTONS {
            let count = u64::from(photons.count);
            return Err(MapError::TooMany { what: "photons", count, max: KD_MAX_PHOTONS });
        }
        let (tree, levels) = build::tree(device, photons, radius)?;
        Ok(Self { tree, photons: photons.count, radius, levels, search })
    }

    /// The tree: quads in preorder, of which an inner node takes two and a photon one
    /// ([`KdInner`](caustic_kernels::rivals::kd::KdInner)).
    #[must_use]
    pub fn quads(&self) -> &Buffer {
        &self.tree
    }

    /// Levels of large nodes, and of small ones below them.
    #[must_use]
    pub fn levels(&self) -> [u32; 2] {
        self.levels
    }
}

impl PhotonIndex for KdTree {
    fn search(&self, device: &Device, queries: &Buffer, count: u32, k: u32) -> Result<Neighbours, MapError> {
        let mut plan = Plan::new();
        let found = self.plan_neighbours(device, &mut plan, queries, count, k, self.search)?;
        device.run(&plan)?;
        Ok(found)
    }

    fn bytes(&self) -> u64 {
        self.tree.bytes()
    }
}
