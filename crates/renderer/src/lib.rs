//! From a scene to an image: photon passes, photon maps, camera paths and film, as plans on a [`Device`](caustic_device::Device).

pub mod output;
pub mod scene;

mod accumulate;
mod buffers;
mod checkpoint;
mod chunk;
mod chunked;
mod crew;
mod crowd;
mod error;
mod feature;
mod film;
mod footprint;
mod frame;
mod gather;
mod lattice;
mod ledger;
mod message;
mod pace;
mod parts;
mod passes;
mod photon_file;
mod photons;
mod queue;
mod radius;
mod record;
mod render;
mod report;
mod settings;
mod state_file;
mod sums;
mod trace;
mod verify;
mod work;
mod worker;

pub use accumulate::ProgressState;
pub use buffers::{SceneBuffers, Tracers};
pub use checkpoint::{Checkpoint, CheckpointError, digest};
pub use chunk::Chunk;
pub use crew::{Order, Remote, compute_for};
pub use error::RenderError;
pub use feature::{Decision, Feature, decide};
pub use footprint::{ExpectedMap, peak_bytes};
pub use ledger::LightLedger;
pub use parts::{Joined, MergeError, Merged, join, merge, write_part};
pub use passes::{View, trace_photons};
pub use photon_file::{Header, MapHeader, PhotonFile, PhotonFileError, SavedPhotons};
pub use render::{Given, Rendered, render, render_across, render_on};
pub use report::{MapReport, Progress, RenderReport};
pub use settings::{
    DEFAULT_PASSES, Integrator, Keep, MAX_FINAL_GATHER, MAX_INTERPOLATE, MAX_PASSES, MAX_PIXELS, MAX_THIN, Settings,
    Show, Stop,
};
pub use state_file::About;
pub use verify::{ImageComparison, Verification, verify};
pub use work::{Part, WorkUnit};
