//! What can go wrong in a render.

use crate::photon_file::PhotonFileError;
use caustic_photon_map::MapError;

/// An error of a render, in one sentence with the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A setting is out of its range.
    #[error("{name} is {value} but must be {range}")]
    Setting {
        /// The setting: the name of its flag and of its field in a scene file.
        name: &'static str,
        /// Its value.
        value: String,
        /// What it may be.
        range: String,
    },
    /// A map that was asked for holds nothing.
    #[error("the {map} map stored no photons of {emitted} emitted: {remedy}")]
    NoPhotons {
        /// The map.
        map: &'static str,
        /// Photons emitted.
        emitted: u32,
        /// What to do about it.
        remedy: &'static str,
    },
    /// More photons than a map can hold.
    #[error("the {map} map would store {stored} photons but can hold {max}; use --{flag} {emitted} or less")]
    TooManyPhotons {
        /// The map.
        map: &'static str,
        /// Photons to store.
        stored: u64,
        /// Most a map can hold.
        max: u32,
        /// The flag that helps.
        flag: &'static str,
        /// A value at which they would fit.
        emitted: u64,
    },
    /// The device did not run loops to their end, so the image is wrong.
    #[error(
        "{device} ended {searches} searches before their end, as llvmpipe does after 65,535 steps; use --device cpu, or fewer photons or a smaller --radius"
    )]
    CutShort {
        /// The device.
        device: String,
        /// Searches and shadow rays that it ended early.
        searches: u64,
    },
    /// The caller asked to stop before there was an image.
    #[error("interrupted before there was an image")]
    Interrupted,
    /// No radius could be found from the density of photons.
    #[error("no radius could be found: {reason}; give one with --radius")]
    NoRadius {
        /// Why.
        reason: String,
    },
    /// Another process, or a thread of this one, could not compute its units.
    #[error("worker {worker}: {reason}")]
    Elsewhere {
        /// Which one.
        worker: usize,
        /// What it says.
        reason: String,
    },
    /// What is done after a pass went wrong.
    #[error("{0}")]
    AfterPass(String),
    /// A file of photons lacks a map.
    #[error(
        "`{file}` does not hold the photons of the {map} map that this picture needs; write it with `caustic photons` and the same --show"
    )]
    NotInFile {
        /// The file.
        file: String,
        /// The map.
        map: &'static str,
    },
    /// A layer that the picture cannot have.
    #[error("the layer `{layer}` is not there: {reason}")]
    NoLayer {
        /// The layer.
        layer: &'static str,
        /// Why, and what to do.
        reason: &'static str,
    },
    /// A file of photons is not to be used.
    #[error(transparent)]
    PhotonFile(#[from] PhotonFileError),
    /// The photon map refused its input.
    #[error(transparent)]
    Map(#[from] MapError),
}

impl RenderError {
    /// Whether another device may be able to do what this one could not.
    pub(crate) fn is_of_device(&self) -> bool {
        matches!(
            self,
            Self::CutShort { .. } | Self::Elsewhere { .. } | Self::Map(MapError::CutShort { .. } | MapError::Device(_))
        )
    }
}

impl From<caustic_device::Error> for RenderError {
    fn from(error: caustic_device::Error) -> Self {
        Self::Map(MapError::Device(error))
    }
}
