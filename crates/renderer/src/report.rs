//! What a render says of itself.

use crate::LightLedger;
use caustic_device::{BufferBytes, StageTime};
use caustic_kernels::grid::HASH_LINEAR;
use caustic_photon_map::{Health, PhotonMap};
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
    /// Those of them that the map keeps: fewer with [`Keep::Visible`](crate::Keep::Visible).
    pub photons_kept: u32,
    /// Segments of all paths: rays traced, each from one surface to the next.
    pub segments: u64,
    /// Paths that were given up after too many bounces; their light is missing.
    pub paths_cut: u32,
    /// Where the power of each light went, in the order of the scene's lights.
    pub ledger: Vec<LightLedger>,
    /// Entries of the hash table.
    pub table_entries: u32,
    /// Whether it is that of the linear hash.
    pub linear: bool,
    /// Bytes of the finished map; of the largest, if it is one of each chunk.
    pub bytes: u64,
    /// Maps that it came in one after another: more than one with [`Settings::chunk`](crate::Settings::chunk) only.
    pub chunks: u32,
    /// Most bytes that the host kept while there were chunks.
    pub host_bytes: u64,
    /// How its photons lie in the table, if [`Settings::health`](crate::Settings::health) asks for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub health: Option<Health>,
}

impl MapReport {
    /// The report of a map for which nothing has been traced yet.
    pub(crate) fn new(map: &'static str, photons_emitted: u32) -> Self {
        Self {
            map,
            photons_emitted,
            photons_stored: 0,
            photons_kept: 0,
            segments: 0,
            paths_cut: 0,
            ledger: Vec::new(),
            table_entries: 0,
            linear: false,
            bytes: 0,
            chunks: 1,
            host_bytes: 0,
            health: None,
        }
    }

    /// Says what a map that is built is like.
    pub(crate) fn tell(&mut self, map: &PhotonMap) {
        self.table_entries = self.table_entries.max(map.grid().table);
        self.linear = map.grid().hash == HASH_LINEAR;
        self.bytes = self.bytes.max(map.bytes());
    }
}

/// What a render did.
#[derive(Clone, Debug, Serialize)]
pub struct RenderReport {
    /// The device.
    pub device: String,
    /// Whether the image is whole: false if the caller stopped the render.
    pub complete: bool,
    /// Passes whose mean the image is; 0 if the caller stopped the first one, of which the image then has some rows.
    pub passes: u32,
    /// Why there are not more.
    pub stopped_by: &'static str,
    /// Radius of the last pass's photon maps, m.
    pub radius_m: f32,
    /// Estimate of the image's relMSE that is noise, from how passes differ ([`ProgressState::noise`](crate::ProgressState::noise)).
    pub noise: Option<f64>,
    /// Photons emitted for all maps of all passes.
    pub photons_emitted: u64,
    /// Time in all, s.
    pub seconds: f64,
    /// The maps of the last pass.
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
    /// Most bytes that all buffers took together, and with them what the host kept of chunks.
    pub peak_bytes: u64,
    /// Mean radiance of the image, W·sr⁻¹·m⁻², for each of red, green and blue.
    pub mean_radiance: [f64; 3],
}
