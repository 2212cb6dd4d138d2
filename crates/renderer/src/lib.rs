//! From a scene to an image: photon passes, photon maps, camera paths and film, as plans on a [`Device`](caustic_device::Device).

pub mod output;
pub mod scene;

mod accumulate;
mod buffers;
mod checkpoint;
mod crowd;
mod error;
mod frame;
mod ledger;
mod pace;
mod passes;
mod photon_file;
mod photons;
mod radius;
mod render;
mod report;
mod settings;
mod verify;

pub use accumulate::ProgressState;
pub use buffers::{SceneBuffers, Tracers};
pub use checkpoint::{Checkpoint, CheckpointError};
pub use error::RenderError;
pub use ledger::LightLedger;
pub use passes::{View, trace_photons};
pub use photon_file::{Header, MapHeader, PhotonFile, PhotonFileError};
pub use render::{Given, Rendered, render, render_on};
pub use report::{MapReport, Progress, RenderReport};
pub use settings::{DEFAULT_PASSES, Integrator, Keep, MAX_FINAL_GATHER, MAX_PASSES, MAX_PIXELS, Settings, Show, Stop};
pub use verify::{ImageComparison, Verification, verify};
