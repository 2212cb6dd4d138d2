//! From a scene to an image: photon passes, photon maps, camera paths and film, as plans on a [`Device`](caustic_device::Device).

pub mod output;
pub mod scene;

mod buffers;
mod crowd;
mod error;
mod ledger;
mod pace;
mod passes;
mod photons;
mod render;
mod report;
mod settings;
mod verify;

pub use buffers::{SceneBuffers, Tracers};
pub use error::RenderError;
pub use ledger::LightLedger;
pub use passes::{View, trace_photons};
pub use render::{Rendered, render};
pub use report::{MapReport, Progress, RenderReport};
pub use settings::{MAX_PIXELS, Settings, Show};
pub use verify::{ImageComparison, Verification, verify};
