//! The techniques by name.

use crate::brute::{BruteForce, BruteSort};
use crate::cells::CellsIndex;
use crate::hash::HashIndex;
use crate::jensen::JensenTree;
use crate::kd::{KdSearch, KdTree};
use crate::{Cells, PhotonIndex, Photons};
use caustic_device::Device;
use caustic_photon_map::{Gather, Hash, MapError, MapOptions};

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
    /// Brute force (section 2.2).
    Brute {
        /// How distances are sorted.
        sort: BruteSort,
    },
    /// Jensen's kd-tree, built by the CPU on any device (sections 2.1.2 and 4.3).
    Jensen,
    /// Spatial hashing with each cell in a thread of its own (section 5.6).
    Cells {
        /// The hash function.
        hash: Hash,
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
        Self::Brute { sort: BruteSort::Insertion },
        Self::Brute { sort: BruteSort::Comb },
        Self::Jensen,
        Self::Cells { hash: Hash::Linear },
        Self::Cells { hash: Hash::Teschner },
        Self::Cells { hash: Hash::Morton },
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
            Self::Brute { sort } => Ok(Box::new(BruteForce::new(photons, radius, sort, None)?)),
            Self::Jensen => Ok(Box::new(JensenTree::build(device, photons, radius)?)),
            Self::Cells { hash } => {
                // As wide as the radius: the thesis has 27 cells to share out.
                let options = MapOptions { radius, hash, table: None, cell: Some(radius) };
                Ok(Box::new(CellsIndex::build(device, photons, &options)?))
            }
            Self::KdTree { search } => Ok(Box::new(KdTree::build(device, photons, radius, search)?)),
        }
    }

    /// Whether a device can run it: some are of the CPU alone.
    #[must_use]
    pub fn runs_on(self, _device: &Device) -> bool {
        match self {
            Self::Hash { .. } | Self::Brute { .. } | Self::Jensen | Self::Cells { .. } | Self::KdTree { .. } => true,
        }
    }
}
