//! Why a case does not run: because it does not fit, which is reported, or because something failed, which is an error.

use caustic_device::Error;
use caustic_photon_map::MapError;
use caustic_renderer::RenderError;

/// Why a case does not run.
#[derive(Debug)]
pub enum Trouble {
    /// The device or the machine is too small for it.
    Skip(String),
    /// The user stopped it.
    Interrupted,
    /// It failed.
    Fail(String),
}

impl From<Error> for Trouble {
    fn from(error: Error) -> Self {
        match error {
            Error::BufferTooLarge { .. } | Error::OutOfMemory { .. } => Self::Skip(error.to_string()),
            _ => Self::Fail(error.to_string()),
        }
    }
}

impl From<MapError> for Trouble {
    fn from(error: MapError) -> Self {
        match error {
            MapError::Device(error) => error.into(),
            MapError::TooMany { .. } | MapError::CutShort { .. } => Self::Skip(error.to_string()),
            _ => Self::Fail(error.to_string()),
        }
    }
}

impl From<RenderError> for Trouble {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Map(error) => error.into(),
            RenderError::Interrupted => Self::Interrupted,
            RenderError::CutShort { .. } | RenderError::TooManyPhotons { .. } => Self::Skip(error.to_string()),
            _ => Self::Fail(error.to_string()),
        }
    }
}
