//! Photons in files: traced once, used by many renders.
//!
//! A file holds the photons as the passes left them, in the order of their paths, and not the tables of a map: a map is built of them in
//! milliseconds, for any hash, radius and device, and has the bits that it would have had without the file.
//!
//! The file: `CAUSTICM`, the version of the format and the length of the header (u32 each, little-endian like all), the header (JSON), the photons
//! of each map (32 bytes each: position, direction, power, primitive), and the SHA-256 of everything before.

mod dump;
mod error;
mod record;
mod saved;
#[cfg(test)]
mod tests;
mod window;

pub use error::PhotonFileError;
pub use saved::SavedPhotons;

use crate::buffers::SceneBuffers;
use crate::photons::PassKind;
use crate::report::{MapReport, Progress};
use crate::scene::Scene;
use crate::trace::trace;
use crate::{RenderError, Settings};
use caustic_device::{Buffer, Device};
use caustic_kernels::layout::Photon;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The photons of a scene, by map.
#[derive(Clone, Debug, PartialEq)]
pub struct PhotonFile {
    /// Where they come from, for messages: the file, or the scene.
    pub source: String,
    /// What the file says of them.
    pub header: Header,
    /// The photons of each map of the header, in the order of their paths.
    pub photons: Vec<Vec<Photon>>,
}

/// What a file says of its photons.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Version of the program that traced them.
    pub version: String,
    /// Name of the scene.
    pub scene: String,
    /// What of the scene they depend on: [`CompiledScene::sha256`](crate::scene::CompiledScene::sha256).
    pub scene_sha256: String,
    /// Where the origin of their coordinates lies in the scene's, m.
    pub origin: [f64; 3],
    /// Seed of the random numbers.
    pub seed: u32,
    /// Whether the device was exact: then every device would have traced the same.
    pub exact: bool,
    /// The setting: photons to emit for the global map.
    pub photons: u32,
    /// The setting: photons to emit for the caustic map.
    pub caustic_photons: u32,
    /// The setting: largest radius of an estimate, m. Photons do not depend on it.
    pub radius: f32,
    /// The maps.
    pub maps: Vec<MapHeader>,
}

/// What a file says of a map.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapHeader {
    /// Which map.
    pub map: String,
    /// Photons emitted.
    pub emitted: u32,
    /// Photons stored.
    pub stored: u32,
    /// Diffuse reflections from which on photons were stored: 1 where direct light comes from shadow rays.
    pub stored_from: u32,
    /// Segments of all paths.
    pub segments: u64,
    /// Paths that were given up.
    pub paths_cut: u32,
}

impl PhotonFile {
    /// Traces the photons that a render with these settings needs.
    ///
    /// # Errors
    /// All of [`RenderError`].
    pub fn trace(
        scene: &Scene,
        settings: &Settings,
        device: &Device,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Self, RenderError> {
        settings.validate()?;
        let compiled = scene.compile();
        let buffers = SceneBuffers::new(device, &compiled)?;
        let mut maps = Vec::new();
        let mut photons = Vec::new();
        for kind in PassKind::of(settings, &compiled).into_iter().flatten() {
            let (traced, report) = trace(device, &compiled, &buffers, settings.seed, &kind, progress)?;
            maps.push(MapHeader {
                map: kind.map.to_string(),
                emitted: report.photons_emitted,
                stored: report.photons_stored,
                stored_from: kind.stored_from,
                segments: report.segments,
                paths_cut: report.paths_cut,
            });
            photons.push(match traced {
                Some(traced) => device.read(&traced, u64::from(report.photons_stored))?,
                None => Vec::new(),
            });
        }
        let header = Header {
            version: env!("CARGO_PKG_VERSION").to_string(),
            scene: scene.name.clone(),
            scene_sha256: compiled.sha256(),
            origin: scene.origin(),
            seed: settings.seed,
            exact: device.is_exact(),
            photons: settings.photons,
            caustic_photons: settings.caustic_photons,
            radius: settings.radius,
            maps,
        };
        Ok(Self { source: scene.name.clone(), header, photons })
    }

    /// Writes the file: at once and whole, or not at all.
    ///
    /// # Errors
    /// [`PhotonFileError::Write`].
    pub fn write(&self, path: &Path) -> Result<(), PhotonFileError> {
        record::write(self, path)
    }

    /// Reads a file, all of it.
    ///
    /// # Errors
    /// All of [`PhotonFileError`] but [`PhotonFileError::Write`] and [`PhotonFileError::OtherScene`].
    pub fn read(path: &Path) -> Result<Self, PhotonFileError> {
        let saved = SavedPhotons::open(path)?;
        let mut photons = Vec::new();
        let mut begin = 0;
        for map in &saved.header().maps {
            let end = begin + u64::from(map.stored);
            photons.push(saved.read(begin..end)?);
            begin = end;
        }
        Ok(Self { source: saved.name().to_string(), header: saved.header().clone(), photons })
    }

    /// Whether a file begins as photon files do.
    #[must_use]
    pub fn is_one(path: &Path) -> bool {
        record::is_one(path)
    }

    /// Checks that the photons are those of this scene.
    ///
    /// # Errors
    /// [`PhotonFileError::OtherScene`].
    pub fn check_scene(&self, scene: &Scene) -> Result<(), PhotonFileError> {
        if self.header.scene_sha256 == scene.compile().sha256() {
            return Ok(());
        }
        Err(PhotonFileError::OtherScene {
            file: self.source.clone(),
            holds: self.header.scene.clone(),
            scene: scene.name.clone(),
        })
    }

    /// Puts the photons of a pass on a device, as if they had been traced there.
    pub(crate) fn upload(&self, device: &Device, kind: &PassKind) -> Result<(Option<Buffer>, MapReport), RenderError> {
        let is = |header: &&MapHeader| header.map == kind.map && header.stored_from == kind.stored_from;
        let found = self.header.maps.iter().zip(&self.photons).find(|(header, _)| is(header));
        let Some((header, photons)) = found else {
            return Err(RenderError::NotInFile { file: self.source.clone(), map: kind.map });
        };
        let report = MapReport {
            photons_stored: header.stored,
            photons_kept: header.stored,
            segments: header.segments,
            paths_cut: header.paths_cut,
            ..MapReport::new(kind.map, header.emitted)
        };
        let buffer = if photons.is_empty() { None } else { Some(device.upload("photons", photons)?) };
        Ok((buffer, report))
    }
}
