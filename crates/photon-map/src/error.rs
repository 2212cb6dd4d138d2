//! What can be wrong with a map's input.

/// An error of a photon map, in one sentence with the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// The query radius is not a usable length.
    #[error(
        "the radius is {radius} but must be a number from 1e-18 to 1e18 m; scale the scene if it is that small or large"
    )]
    Radius {
        /// What was given, m.
        radius: f32,
    },
    /// The number of neighbours is out of range.
    #[error("k is {k} but must be 1 to {max}")]
    K {
        /// What was given.
        k: u64,
        /// Most neighbours that kernels are compiled for.
        max: u32,
    },
    /// Positions that are no numbers.
    #[error("{count} of the {what} have a position that is NaN or infinite, the first at index {first}; remove them")]
    NotFinite {
        /// Photons or queries.
        what: &'static str,
        /// How many.
        count: usize,
        /// Index of the first.
        first: usize,
    },
    /// Powers that photons cannot have.
    #[error(
        "{count} of the photons have a power that is negative, NaN or infinite, the first at index {first}; remove them"
    )]
    Power {
        /// How many.
        count: usize,
        /// Index of the first.
        first: usize,
    },
    /// The radius is too small for the extent of the photons.
    #[error(
        "the radius {radius} m cuts the map's {extent:e} m into {cells:e} cells along an axis but at most {max} are possible; use a --radius of at least {least:.4e} m"
    )]
    TooManyCells {
        /// Radius, m.
        radius: f32,
        /// Longest side of the bounding box, m.
        extent: f64,
        /// Cells that it would take.
        cells: f64,
        /// Most cells an axis may have.
        max: u32,
        /// Smallest radius that works, m.
        least: f64,
    },
    /// The hash table would be too large.
    #[error(
        "the linear hash needs a table of {entries} cells but at most {max} are possible; use --hash teschner or a larger --radius"
    )]
    TableTooLarge {
        /// Entries that it would take.
        entries: u128,
        /// Most entries a table may have.
        max: u32,
    },
    /// A table size that is no power of two.
    #[error("the hash table has {entries} entries but must have a power of two, at most {max}")]
    TableSize {
        /// What was given.
        entries: u32,
        /// Most entries a table may have.
        max: u32,
    },
    /// More photons or queries than 32 bits count.
    #[error("there are {count} {what} but at most {max} are possible at once; lower their number")]
    TooMany {
        /// Photons or queries.
        what: &'static str,
        /// How many.
        count: u64,
        /// Most there may be.
        max: u32,
    },
    /// The device did not run loops to their end.
    #[error(
        "{device} ended {searches} searches before their end, as llvmpipe does after 65,535 steps; use --device cpu, or fewer photons or a smaller radius"
    )]
    CutShort {
        /// The device.
        device: String,
        /// Searches that it ended early.
        searches: usize,
    },
    /// The device failed.
    #[error(transparent)]
    Device(#[from] caustic_device::Error),
}
