//! Photon maps by spatial hashing (thesis, chapter 3), built and searched on the CPU or on a GPU with the same bits.
//!
//! ```
//! use caustic_device::Device;
//! use caustic_kernels::layout::{Photon, Query};
//! use caustic_photon_map::{Gather, Hash, MapOptions, PhotonMap};
//!
//! let photons: Vec<_> = (0..1000)
//!     .map(|i| Photon { position: [i as f32 * 0.001, 0.0, 0.0], power: [1e-3; 3], ..Photon::default() })
//!     .collect();
//! let device = Device::cpu();
//! let map = PhotonMap::build(&device, &photons, &MapOptions { radius: 0.1, hash: Hash::Linear, table: None, cell: None })?;
//! let queries = [Query { position: [0.5, 0.0, 0.0], active: 1 }];
//! let nearest = map.k_nearest(&device, &queries, 3, Gather::Auto)?;
//! assert_eq!(nearest[0].iter().map(|n| n.photon).collect::<Vec<_>>(), [500, 499, 501]);
//! # Ok::<(), caustic_photon_map::MapError>(())
//! ```

mod crowding;
mod error;
mod grid;
mod health;
mod map;
mod options;
mod seen;
mod sort;
mod streamed;

pub use error::MapError;
pub use grid::{MAX_TABLE, RADII, bounds, most_entries, plan_grid, rows};
pub use health::Health;
pub use map::{Estimate, Filter, Nearest, Neighbours, PhotonMap, Seen, Surface, query_count, sample, whole};
pub use options::{Gather, Hash, MAX_K, MapOptions, capacity};
pub use seen::SeenCells;
pub use sort::{RadixSort, scan};
pub use streamed::{
    DensityStreamed, DensitySums, LargestPower, MAX_K_IN_CHUNKS, NEIGHBOURS_AT_ONCE, NearestPower, NearestStreamed,
    Points,
};
