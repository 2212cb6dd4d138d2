//! The ways to find photons that the thesis compares (section 4.3), behind one interface: all return the same neighbours, in the
//! same order, and the same irradiance, bit for bit.
//!
//! ```
//! use caustic_device::Device;
//! use caustic_kernels::layout::{Photon, Query};
//! use caustic_photon_map::{Gather, Hash};
//! use caustic_rivals::{Cells, Photons, Technique};
//!
//! let photons: Vec<_> = (0..1000)
//!     .map(|i| Photon { position: [i as f32 * 0.001, 0.0, 0.0], power: [1e-3; 3], ..Photon::default() })
//!     .collect();
//! let device = Device::cpu();
//! let photons = Photons::upload(&device, &photons)?;
//! let (hash, table, cells, gather) = (Hash::Teschner, Some(1 << 10), Cells::Radius, Gather::List);
//! let technique = Technique::Hash { hash, table, cells, gather };
//! let index = technique.build(&device, &photons, 0.1)?;
//! let queries = [Query { position: [0.5, 0.0, 0.0], active: 1 }];
//! let nearest = caustic_rivals::k_nearest(&device, index.as_ref(), &queries, 3)?;
//! assert_eq!(nearest[0].iter().map(|n| n.photon).collect::<Vec<_>>(), [500, 499, 501]);
//! # Ok::<(), caustic_photon_map::MapError>(())
//! ```

mod brute;
mod cells;
mod hash;
mod jensen;
mod kd;
mod photons;
mod search;
mod technique;

pub use brute::{BruteForce, BruteSort};
pub use hash::Cells;
pub use kd::{KD_HISTOGRAMS, KdSearch, KdTree, RadiusError, radius_error};
pub use photons::Photons;
pub use search::{irradiance, k_nearest};
pub use technique::Technique;

use caustic_device::{Buffer, Device};
use caustic_photon_map::{MapError, Neighbours};

/// Photons arranged so that those near a point are found.
pub trait PhotonIndex {
    /// Finds the `k` nearest photons of each of the `count` queries in `queries` (records of
    /// [`Query`](caustic_kernels::layout::Query)) within the radius that the index was built for: nearest first, those at the same distance by
    /// their index. A query that is not active has none.
    ///
    /// # Errors
    /// [`MapError::K`], [`MapError::TooMany`] and [`MapError::Device`].
    fn search(&self, device: &Device, queries: &Buffer, count: u32, k: u32) -> Result<Neighbours, MapError>;

    /// Bytes on the device that the index takes once it is built. Photons that it searches where they lay when they were given to it do not
    /// count.
    fn bytes(&self) -> u64;
}
