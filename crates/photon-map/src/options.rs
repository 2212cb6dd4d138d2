//! The choices that a map leaves to its user.

use crate::MapError;
use caustic_device::Kernel;
use caustic_kernels::gather::CAPACITIES;
use caustic_kernels::grid::{HASH_LINEAR, HASH_MORTON, HASH_TESCHNER};

/// Most neighbours that a query can ask for.
pub const MAX_K: u32 = CAPACITIES[CAPACITIES.len() - 1] - 1;

/// The hash function.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hash {
    /// [`Hash::Linear`], unless its table is too small for how the photons crowd: then [`Hash::Teschner`].
    Auto,
    /// Linear cell number (eq. 3.2): no collisions, but a table as large as the grid.
    #[default]
    Linear,
    /// Teschner et al. 2003 (eq. 3.3): a table of any power of two, for scenes of any extent.
    Teschner,
    /// Z-order curve: neighbouring cells lie near each other in memory.
    Morton,
}

/// How the nearest photons are found. All give the same bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gather {
    /// The fastest: by counting on a GPU, with a heap on the CPU.
    #[default]
    Auto,
    /// By counting distances, without a container.
    Histogram,
    /// A max-heap in a fixed-size array (thesis, section 5.6).
    Heap,
    /// The sorted list of the thesis (section 3.1.3).
    List,
}

impl Hash {
    /// Its number in [`Grid::hash`](caustic_kernels::grid::Grid::hash); of [`Hash::Auto`], which a grid chooses for, that of the linear hash.
    #[must_use]
    pub fn code(self) -> u32 {
        match self {
            Self::Auto | Self::Linear => HASH_LINEAR,
            Self::Teschner => HASH_TESCHNER,
            Self::Morton => HASH_MORTON,
        }
    }
}

/// How to build a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapOptions {
    /// Largest query radius, m.
    pub radius: f32,
    /// The hash function.
    pub hash: Hash,
    /// Entries of the table of [`Hash::Teschner`] and [`Hash::Morton`], a power of two; most entries of that of
    /// [`Hash::Linear`]. Chosen from the cells that photons lie in if not given.
    pub table: Option<u32>,
    /// Width of a cell, m, or more where there would be too many; chosen from how the photons crowd if not given. Results do not
    /// depend on it.
    pub cell: Option<f32>,
}

/// The compiled capacity that serves a request for `k` candidates: the smallest that holds them.
///
/// # Errors
/// [`MapError::K`] if there is none, or if `k` is 0.
pub fn capacity(k: u32) -> Result<u32, MapError> {
    let fits = CAPACITIES.into_iter().find(|&capacity| capacity >= k && k > 0);
    fits.ok_or(MapError::K { k: u64::from(k), max: MAX_K })
}

/// What [`Gather::Auto`] stands for: a cache holds a heap; what a GPU has for a lane does not.
fn automatic(gather: Gather, gpu: bool) -> Gather {
    match gather {
        Gather::Auto if gpu => Gather::Histogram,
        Gather::Auto => Gather::Heap,
        chosen => chosen,
    }
}

/// The kernel that estimates irradiance from `k` photons.
pub(crate) fn irradiance_kernel(gather: Gather, k: u32, gpu: bool, linear: bool) -> Result<Kernel, MapError> {
    if k == 0 || k > MAX_K {
        return Err(MapError::K { k: u64::from(k), max: MAX_K });
    }
    Ok(match (automatic(gather, gpu), capacity(k + 1)?) {
        (Gather::Histogram, _) if linear => Kernel::IrradianceHistogram,
        (Gather::Histogram, _) => Kernel::IrradianceHistogramHashed,
        (Gather::Heap, 17) => Kernel::IrradianceHeap17,
        (Gather::Heap, 65) => Kernel::IrradianceHeap65,
        (Gather::Heap, 257) => Kernel::IrradianceHeap257,
        (Gather::Heap, _) => Kernel::IrradianceHeap1025,
        (_, 17) => Kernel::IrradianceList17,
        (_, 65) => Kernel::IrradianceList65,
        (_, 257) => Kernel::IrradianceList257,
        (_, _) => Kernel::IrradianceList1025,
    })
}

/// The kernel that returns the `k` nearest neighbours.
pub(crate) fn neighbours_kernel(gather: Gather, k: u32, gpu: bool, linear: bool) -> Result<Kernel, MapError> {
    if k > MAX_K {
        return Err(MapError::K { k: u64::from(k), max: MAX_K });
    }
    Ok(match (automatic(gather, gpu), capacity(k)?) {
        (Gather::Histogram, _) if linear => Kernel::NeighboursHistogram,
        (Gather::Histogram, _) => Kernel::NeighboursHistogramHashed,
        (Gather::Heap, 17) => Kernel::NeighboursHeap17,
        (Gather::Heap, 65) => Kernel::NeighboursHeap65,
        (Gather::Heap, 257) => Kernel::NeighboursHeap257,
        (Gather::Heap, _) => Kernel::NeighboursHeap1025,
        (_, 17) => Kernel::NeighboursList17,
        (_, 65) => Kernel::NeighboursList65,
        (_, 257) => Kernel::NeighboursList257,
        (_, _) => Kernel::NeighboursList1025,
    })
}
