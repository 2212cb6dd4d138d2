//! What can be wrong with a map's input.

/// An error of a photon map, in one sentence with the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// The query radius is not a usable length.
    #[error(
        "the radius is {radius} but must be a number from 1e-9 to 1e18 m; scale the scene if it is that small or large"
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
    /// A photon of a chunk is more powerful than was said of all.
    #[error(
        "the photon at index {index} of a chunk has the power {power:?} W, but {largest:?} W was said to be the largest; look at all photons before the first chunk"
    )]
    AboveLargest {
        /// Index of the first in its chunk.
        index: usize,
        /// Its power, W.
        power: [f32; 3],
        /// What was given, W.
        largest: [f32; 3],
    },
    /// The box of the photons is too large for differences of coordinates to be finite.
    #[error("the photons span {extent:e} m along an axis but at most {max:e} are possible; remove those far away")]
    Extent {
        /// Longest side of the bounding box, m.
        extent: f64,
        /// Longest that works, m.
        max: f64,
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
    /// A compact map does not know enough of its photons.
    #[error("a compact map has no {what}: its photons have neither a direction nor a surface; build a whole one")]
    Compact {
        /// What was asked for.
        what: &'static str,
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
