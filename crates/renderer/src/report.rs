//! What a render says of itself.

use crate::LightLedger;
use caustic_device::{BufferBytes, StageTime};
use serde::Serialize;

/// How far a render is.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// What it does.
    pub phase: &'static str,
    /// Work of this phase that is done …
    pub done: u64,
    /// … out of this much.
    pub total: u64,
}

/// What became of one photon map.
#[derive(Clone, Debug, Serialize)]
pub struct MapReport {
    /// Which map.
    pub map: &'static str,
    /// Photons emitted.
    pub photons_emitted: u32,
    /// Photons stored.
    pub photons_stored: u32,
    /// Segments of all paths: rays traced, each from one surface to the next.
    pub segments: u64,
    /// Paths that were given up after too many bounces; their light is missing.
    pub paths_cut: u32,
    /// Where the power of each light went, in the order of the scene's lights.
    pub ledger: Vec<LightLedger>,
    /// Entries of the hash table.
    pub table_entries: u32,
    /// Bytes of the finished map.
    pub bytes: u64,
}

/// What a render did.
#[derive(Clone, Debug, Serialize)]
pub struct RenderReport {
    /// The device.
    pub device: String,
    /// Whether the image is whole: false if the caller stopped the render.
    pub complete: bool,
    /// Time in all, s.
    pub seconds: f64,
    /// The maps that were built.
    pub maps: Vec<MapReport>,
    /// Rays of the image: of camera paths, and towards the lights.
    pub camera_rays: u64,
    /// What was left out and why, and what is worth a look.
    pub notes: Vec<String>,
    /// What makes the picture doubtful: power that cannot be accounted for, numbers that are not finite, paths that were given up.
    pub problems: Vec<String>,
    /// Time a stage.
    pub stages: Vec<StageTime>,
    /// Bytes a buffer, now and at the most.
    pub buffers: Vec<BufferBytes>,
    /// Most bytes that all buffers took together.
    pub peak_bytes: u64,
    /// Mean radiance of the image, W·sr⁻¹·m⁻², for each of red, green and blue.
    pub mean_radiance: [f64; 3],
}
