//! From a scene to an image: photon passes, photon maps, camera paths and film, as plans on a [`Device`](caustic_device::Device).

pub mod output;
pub mod scene;

mod crowd;
mod error;
mod pace;
mod passes;
mod photon_file;
mod photons;
mod render;
mod report;
mod settings;
mod verify;

pub use error::RenderError;
pub use passes::{View, trace_photons};
pub use photon_file::{Header, MapHeader, PhotonFile, PhotonFileError};
pub use render::{Rendered, render, render_with};
pub use report::{MapReport, Progress, RenderReport};
pub use settings::{MAX_PIXELS, Settings, Show};
pub use verify::{ImageComparison, Verification, verify};
