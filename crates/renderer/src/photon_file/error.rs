//! Why photons cannot be read or used, in one sentence with the remedy.

use crate::output::OutputError;

/// Why a file of photons cannot be written, read or used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PhotonFileError {
    /// The system does not let it be read.
    #[error("cannot read the photon map `{file}`: {reason}; give a file that `caustic photons SCENE -o FILE` wrote")]
    Unreadable {
        /// The file.
        file: String,
        /// The system's words.
        reason: String,
    },
    /// It is something else.
    #[error("`{file}` is not a photon map; give a file that `caustic photons SCENE -o FILE` wrote")]
    NotOne {
        /// The file.
        file: String,
    },
    /// Another version of the program wrote it.
    #[error(
        "`{file}` has version {found} of the format of photon maps, and this program reads version {known}; write it again with `caustic photons`"
    )]
    Version {
        /// The file.
        file: String,
        /// Its version.
        found: u32,
        /// The version there is.
        known: u32,
    },
    /// Bytes are missing or have changed.
    #[error("`{file}` is damaged: {reason}; copy it again, or write it again with `caustic photons`")]
    Damaged {
        /// The file.
        file: String,
        /// How that shows.
        reason: String,
    },
    /// The photons are of another scene.
    #[error(
        "`{file}` holds photons of the scene `{holds}`, whose surfaces, materials or lights are not those of `{scene}`; write them again with `caustic photons {scene} -o FILE`"
    )]
    OtherScene {
        /// The file.
        file: String,
        /// The scene whose photons it holds.
        holds: String,
        /// The scene they were wanted for.
        scene: String,
    },
    /// Writing failed.
    #[error(transparent)]
    Write(#[from] OutputError),
}
