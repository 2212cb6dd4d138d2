//! The techniques by name.

use crate::hash::HashIndex;
use crate::kd::{KdSearch, KdTree};
use crate::{Cells, PhotonIndex, Photons};
use caustic_device::Device;
use caustic_photon_map::{Gather, Hash, MapError};

/// A way to find photons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Technique {
    /// Spatial hashing (chapter 3).
    Hash {
        /// The hash function.
        hash: Hash,
        /// Entries of its table, a power of two; chosen from the number of photons if not given. The linear hash has none.
        table: Option<u32>,
        /// Its cells.
        cells: Cells,
        /// How the nearest are selected.
        gather: Gather,
    },
    /// A kd-tree (section 2.3).
    KdTree {
        /// How it is searched.
        search: KdSearch,
    },
}

impl Technique {
    /// Each technique once, with every variant that searches in its own way.
    pub const ALL: &[Self] = &[
        Self::hash(Hash::Linear, Cells::Crowding, Gather::Histogram),
        Self::hash(Hash::Linear, Cells::Crowding, Gather::Heap),
        Self::hash(Hash::Linear, Cells::Radius, Gather::List),
        Self::hash(Hash::Linear, Cells::CentreFirst, Gather::List),
        Self::hash(Hash::Linear, Cells::InOrder, Gather::List),
        Self::hash(Hash::Teschner, Cells::Crowding, Gather::Histogram),
        Self::hash(Hash::Teschner, Cells::Radius, Gather::Heap),
        Self::hash(Hash::Teschner, Cells::InOrder, Gather::List),
        Self::hash(Hash::Morton, Cells::Crowding, Gather::Histogram),
        Self::hash(Hash::Morton, Cells::Radius, Gather::Heap),
        Self::hash(Hash::Morton, Cells::CentreFirst, Gather::List),
        Self::KdTree { search: KdSearch::Nearest },
        Self::KdTree { search: KdSearch::Range },
    ];

    /// Spatial hashing with a table of the size that caustic chooses.
    #[must_use]
    pub const fn hash(hash: Hash, cells: Cells, gather: Gather) -> Self {
        Self::Hash { hash, table: None, cells, gather }
    }

    /// Builds an index over photons for searches within `radius` (m).
    ///
    /// # Errors
    /// All of [`MapError`] but those of queries.
    pub fn build(self, device: &Device, photons: &Photons, radius: f32) -> Result<Box<dyn PhotonIndex>, MapError> {
        match self {
            Self::Hash { hash, table, cells, gather } => {
                Ok(Box::new(HashIndex::build(device, photons, radius, hash, table, cells, gather)?))
            }
            Self::KdTree { search } => Ok(Box::new(KdTree::build(device, photons, radius, search)?)),
        }
    }

    /// Whether a device can run it: some are of the CPU alone.
    #[must_use]
    pub fn runs_on(self, _device: &Device) -> bool {
        match self {
            Self::Hash { .. } | Self::KdTree { .. } => true,
        }
    }
}
