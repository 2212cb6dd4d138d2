//! The spatial hash of the thesis (chapter 3): a grid of cells as wide as the largest query radius, a hash of the cell,
//! photons sorted by hash, and a table of where each hash value begins and ends.

mod cell;
mod hash;
mod ranges;

pub use cell::{cell_of, neighbour_cell};
pub use hash::{HASH_LINEAR, HASH_MORTON, HASH_TESCHNER, hash_cell, linear, morton, teschner};
pub use ranges::{cell_ranges, hash_photons, reorder_photons};

use bytemuck::{Pod, Zeroable};

/// Lanes of a workgroup of the stages that handle one photon an invocation.
pub const GRID_LANES: u32 = 256;
/// Most cells an axis may have, border included. A coordinate in cells then has an error below 2⁻², which the margin
/// of [`Grid::inverse_cell`] covers.
pub const MAX_CELLS_PER_AXIS: u32 = 1 << 20;

/// A grid over the photons' bounding box.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Grid {
    /// Lowest corner of the photons' bounding box, the "world origin" of section 3.1.3, m.
    pub origin: [f32; 3],
    /// The scaling factor s of eq. 3.1, m⁻¹: a little less than 1 / r_max, by the rounding errors of a coordinate, so that
    /// two points at most r_max apart are never more than one cell apart.
    pub inverse_cell: f32,
    /// Cells along each axis, two border cells included.
    pub cells: [u32; 3],
    /// Which hash: [`HASH_LINEAR`], [`HASH_TESCHNER`] or [`HASH_MORTON`].
    pub hash: u32,
    /// Entries of the hash table; a power of two unless the hash is linear.
    pub table: u32,
    /// Photons in the map.
    pub photons: u32,
    /// Largest query radius, squared, m².
    pub radius2: f32,
}

const _: () = assert!(size_of::<Grid>() == 44);
