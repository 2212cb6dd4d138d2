//! Passes in a file, to go on from.
//!
//! A file is a line with the version, the length of a text as a `u32`, the text that says what the picture depends on (a line
//! `name=value` each), the numbers of the state in little-endian order, and the SHA-256 of all that. It is written beside its place, brought to
//! the disk and renamed, so that there is always a whole one: whenever the program is killed, at most the pass in flight is lost.

use crate::accumulate::{LAYER_WORDS, ProgressState};
use crate::output::place;
use crate::output::{LayerKind, OutputError};
use crate::scene::{Scene, hex};
use crate::{Integrator, Settings};
use sha2::{Digest, Sha256};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// First line of a file.
const VERSION: &[u8] = b"caustic checkpoint 2\n";
/// Bytes of a SHA-256.
const SUM: usize = 32;

/// Why a checkpoint cannot be used, in one sentence with the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// There is none.
    #[error("there is no checkpoint {}; leave out --resume to begin one", path.display())]
    Missing {
        /// Where it should be.
        path: PathBuf,
    },
    /// There is one that nobody asked for.
    #[error("the checkpoint {} exists already; add --resume to go on from it, or remove it", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// It cannot be read.
    #[error("the checkpoint {} cannot be read: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// It is another kind of file, or of another version.
    #[error("{} is no checkpoint of this version of caustic; render without --resume into another file", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// It is not what was written.
    #[error("the checkpoint {} is damaged: its checksum is wrong; remove it and render anew", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
    },
    /// It is of another picture.
    #[error(
        "the checkpoint {} was made with {name} {found}, but this render has {expected}; render with the same, or into another file", path.display()
    )]
    Different {
        /// The file.
        path: PathBuf,
        /// What differs.
        name: String,
        /// What the file has.
        found: String,
        /// What the render has.
        expected: String,
    },
    /// It cannot be written.
    #[error(transparent)]
    Write(#[from] OutputError),
}

/// Where a render leaves its passes.
pub struct Checkpoint {
    path: PathBuf,
    /// What the picture depends on.
    identity: Vec<(String, String)>,
}

impl Checkpoint {
    /// The checkpoint of a render at `path`. `exact` says whether the device is.
    #[must_use]
    pub fn new(path: &Path, scene: &Scene, settings: &Settings, exact: bool) -> Self {
        Self { path: path.to_path_buf(), identity: identity(scene, settings, exact) }
    }

    /// Checks, before the first pass, that there is no file yet and that there can be one.
    ///
    /// # Errors
    /// [`CheckpointError::Exists`] and [`CheckpointError::Write`].
    pub fn begin(&self) -> Result<(), CheckpointError> {
        place::check(&self.path)?;
        if self.path.exists() { Err(CheckpointError::Exists { path: self.path.clone() }) } else { Ok(()) }
    }

    /// Writes what there is.
    ///
    /// # Errors
    /// [`CheckpointError::Write`].
    pub fn save(&self, state: &ProgressState) -> Result<(), CheckpointError> {
        Ok(place::replace(&self.path, &self.encode(state))?)
    }

    /// Reads what there was.
    ///
    /// # Errors
    /// If there is no file, it is damaged, or of another picture.
    pub fn load(&self) -> Result<ProgressState, CheckpointError> {
        let path = || self.path.clone();
        let bytes = fs::read(&self.path).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => CheckpointError::Missing { path: path() },
            _ => CheckpointError::Read { path: path(), reason: error.to_string() },
        })?;
        if !bytes.starts_with(VERSION) {
            return Err(CheckpointError::Foreign { path: path() });
        }
        let damaged = || CheckpointError::Damaged { path: path() };
        let (body, sum) = bytes.split_last_chunk::<SUM>().ok_or_else(damaged)?;
        if Sha256::digest(body).as_slice() != sum {
            return Err(damaged());
        }
        let mut rest = Reader(&body[VERSION.len()..]);
        let length = rest.u32().ok_or_else(damaged)?;
        let text = rest.take(length as usize).and_then(|text| std::str::from_utf8(text).ok()).ok_or_else(damaged)?;
        self.compare(text)?;
        rest.state().ok_or_else(damaged)
    }

    /// Refuses a file that was made with something else.
    fn compare(&self, text: &str) -> Result<(), CheckpointError> {
        let found: Vec<_> = text.lines().filter_map(|line| line.split_once('=')).collect();
        for (name, expected) in &self.identity {
            let value = found.iter().find(|(found, _)| found == name).map_or("(nothing)", |(_, value)| *value);
            if value != expected {
                return Err(CheckpointError::Different {
                    path: self.path.clone(),
                    name: name.clone(),
                    found: value.to_string(),
                    expected: expected.clone(),
                });
            }
        }
        Ok(())
    }

    fn encode(&self, state: &ProgressState) -> Vec<u8> {
        let text: String = self.identity.iter().map(|(name, value)| format!("{name}={value}\n")).collect();
        let mut bytes = VERSION.to_vec();
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text.as_bytes());
        bytes.extend(
            [state.size[0], state.size[1], state.passes, state.first_radius.to_bits()].map(u32::to_le_bytes).concat(),
        );
        bytes.extend([state.photons, state.rays, state.lost, state.not_finite].map(u64::to_le_bytes).concat());
        for values in [state.sum.as_flattened(), state.squares.as_flattened(), state.layers.as_flattened()] {
            bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        }
        let sum = Sha256::digest(&bytes);
        bytes.extend(sum);
        bytes
    }
}

/// Takes numbers from the front of bytes.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.take(4)?.try_into().ok()?))
    }

    fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }

    fn state(&mut self) -> Option<ProgressState> {
        let size = [self.u32()?, self.u32()?];
        let (passes, first_radius) = (self.u32()?, f32::from_bits(self.u32()?));
        let [photons, rays, lost, not_finite] = [self.u64()?, self.u64()?, self.u64()?, self.u64()?];
        let pixels = usize::try_from(u64::from(size[0]) * u64::from(size[1])).ok()?;
        // Before room is made for them.
        let light = pixels.checked_mul(2 * 3 * 8)?;
        let has_layers = self.0.len() != light;
        if has_layers && self.0.len() != light.checked_add(pixels.checked_mul(LAYER_WORDS * 8)?)? {
            return None;
        }
        let (sum, squares) = (self.values(pixels)?, self.values(pixels)?);
        let layers = self.values(if has_layers { pixels } else { 0 })?;
        Some(ProgressState { size, passes, first_radius, photons, rays, lost, not_finite, sum, squares, layers })
    }

    /// `N` numbers for each pixel.
    fn values<const N: usize>(&mut self, pixels: usize) -> Option<Vec<[f64; N]>> {
        let bytes = self.take(pixels.checked_mul(N * 8)?)?;
        let value = |bytes: &[u8]| f64::from_le_bytes(std::array::from_fn(|i| bytes[i]));
        Some(bytes.chunks_exact(N * 8).map(|pixel| std::array::from_fn(|c| value(&pixel[8 * c..]))).collect())
    }
}

/// Everything that the bits of a pass depend on. Hash and gather are not among it, and of the stops none.
fn identity(scene: &Scene, settings: &Settings, exact: bool) -> Vec<(String, String)> {
    let [width, height] = settings.size;
    let camera = hex(&Sha256::digest(bytemuck::bytes_of(&scene.camera(width, height))));
    let radius = if settings.automatic_radius { "auto".to_string() } else { settings.radius.to_string() };
    // Those that are not asked for are zeros or means of other things: they cannot be had later.
    let layers = match (settings.needs_layers(), settings.layers.contains(&LayerKind::Bias)) {
        (false, _) => "none",
        (true, false) => "some",
        (true, true) => "with bias",
    };
    let mut identity = vec![
        ("version", env!("CARGO_PKG_VERSION").to_string()),
        ("precision", if exact { "exact" } else { "fast" }.to_string()),
        ("scene", scene.compile().sha256()),
        ("camera", camera),
        ("size", format!("{width}x{height}")),
        ("seed", settings.seed.to_string()),
        ("integrator", format!("{:?}", settings.integrator).to_lowercase()),
        ("show", format!("{:?}", settings.show).to_lowercase()),
        ("spp", settings.spp.to_string()),
        ("layers", layers.to_string()),
    ];
    if matches!(settings.integrator, Integrator::Photon | Integrator::Progressive) {
        identity.extend([
            ("photons", settings.photons.to_string()),
            ("caustic-photons", settings.caustic_photons.to_string()),
            ("k", settings.k.to_string()),
            ("radius", radius),
            ("filter", format!("{:?}", settings.filter).to_lowercase()),
            ("surface", format!("{:?}", settings.surface).to_lowercase()),
            ("alpha", settings.alpha.to_string()),
            ("final-gather", settings.final_gather.to_string()),
        ]);
    }
    identity.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checkpoint(folder: &Path, settings: &Settings) -> Checkpoint {
        let scene = Scene::load("plane").unwrap();
        Checkpoint::new(&folder.join("state"), &scene, settings, true)
    }

    fn settings() -> Settings {
        Settings { size: [3, 2], ..Settings::of(&Scene::load("plane").unwrap()) }
    }

    fn state() -> ProgressState {
        let value = |i: usize| [i as f64 + 0.1, -1.0 / (i as f64 + 3.0), 1e300];
        ProgressState {
            size: [3, 2],
            passes: 7,
            first_radius: 0.123,
            photons: 1 << 40,
            rays: 3,
            lost: 2,
            not_finite: 1,
            sum: (0..6).map(value).collect(),
            squares: (6..12).map(value).collect(),
            layers: (0..6).map(|i| std::array::from_fn(|word| (i * LAYER_WORDS + word) as f64 / 7.0)).collect(),
        }
    }

    #[test]
    fn a_state_comes_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let checkpoint = checkpoint(folder.path(), &settings());
        assert!(matches!(checkpoint.load(), Err(CheckpointError::Missing { .. })));
        checkpoint.begin().unwrap();
        checkpoint.save(&state()).unwrap();
        assert_eq!(checkpoint.load().unwrap(), state());
        let plain = ProgressState { layers: Vec::new(), ..state() };
        checkpoint.save(&plain).unwrap();
        assert_eq!(checkpoint.load().unwrap(), plain);
        assert!(matches!(checkpoint.begin(), Err(CheckpointError::Exists { .. })));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left behind");
    }

    #[test]
    fn whatever_is_wrong_with_a_file_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let checkpoint = checkpoint(folder.path(), &settings());
        checkpoint.save(&state()).unwrap();
        let whole = fs::read(folder.path().join("state")).unwrap();
        let load = |bytes: &[u8]| {
            fs::write(folder.path().join("state"), bytes).unwrap();
            checkpoint.load()
        };
        for at in (0..whole.len()).step_by(7) {
            let mut bytes = whole.clone();
            bytes[at] ^= 1;
            assert!(load(&bytes).is_err(), "byte {at}");
        }
        for length in [0, 5, 21, 30, whole.len() - 33, whole.len() - 1] {
            assert!(load(&whole[..length]).is_err(), "{length} bytes");
        }
        // Sizes that do not fit, with a checksum that does.
        let mut lying = whole[..whole.len() - SUM].to_vec();
        let text = u32::from_le_bytes(lying[VERSION.len()..][..4].try_into().unwrap()) as usize;
        lying[VERSION.len() + 4 + text] = 200;
        let sum = Sha256::digest(&lying);
        lying.extend(sum);
        assert!(matches!(load(&lying), Err(CheckpointError::Damaged { .. })));
        assert!(load(&whole).is_ok());
    }

    #[test]
    fn a_file_of_another_picture_is_refused_and_says_what_differs() {
        let folder = tempfile::tempdir().unwrap();
        checkpoint(folder.path(), &settings()).save(&state()).unwrap();
        for (other, name) in [
            (Settings { seed: 1, ..settings() }, "seed"),
            (Settings { photons: 77, ..settings() }, "photons"),
            (Settings { radius: 0.5, ..settings() }, "radius"),
            (Settings { integrator: Integrator::Progressive, ..settings() }, "integrator"),
        ] {
            let error = checkpoint(folder.path(), &other).load().unwrap_err().to_string();
            assert!(error.contains(&format!("was made with {name} ")), "{error}");
        }
        let other = Checkpoint::new(&folder.path().join("state"), &Scene::load("cornell").unwrap(), &settings(), true);
        assert!(other.load().unwrap_err().to_string().contains("made with scene"));
        let stops = crate::Stop { passes: Some(9), ..crate::Stop::default() };
        assert!(checkpoint(folder.path(), &Settings { stop: stops, ..settings() }).load().is_ok());
    }
}
