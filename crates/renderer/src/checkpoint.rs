//! Passes in a file, to go on from: whenever the program is killed, at most the units in flight are lost.

use crate::ProgressState;
use crate::output::place;
use crate::output::{LayerKind, OutputError};
use crate::scene::{Scene, hex};
use crate::state_file::{self, Fault};
use crate::{Integrator, Settings};
use sha2::{Digest, Sha256};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

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
        Ok(place::replace(&self.path, &state_file::encode(&self.identity, None, state))?)
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
        let (header, state) = state_file::decode(&bytes).map_err(|fault| match fault {
            Fault::Foreign => CheckpointError::Foreign { path: path() },
            Fault::Damaged => CheckpointError::Damaged { path: path() },
        })?;
        match difference(&self.identity, &header.identity) {
            None => Ok(state),
            Some((name, expected, found)) => Err(CheckpointError::Different { path: path(), name, found, expected }),
        }
    }
}

/// The first name whose values differ, and both values.
pub(crate) fn difference(
    expected: &[(String, String)],
    found: &[(String, String)],
) -> Option<(String, String, String)> {
    expected.iter().find_map(|(name, value)| {
        let other = found.iter().find(|(found, _)| found == name).map_or("(nothing)", |(_, value)| value);
        (other != value).then(|| (name.clone(), value.clone(), other.to_string()))
    })
}

/// SHA-256 of everything that the bits of passes depend on: equal where two would render the same.
#[must_use]
pub fn digest(scene: &Scene, settings: &Settings, exact: bool) -> [u8; 32] {
    let lines = identity(scene, settings, exact).into_iter().map(|(name, value)| format!("{name}={value}\n"));
    Sha256::digest(lines.collect::<String>()).into()
}

/// Everything that the bits of a pass depend on. Hash and gather are not among it, and of the stops none.
pub(crate) fn identity(scene: &Scene, settings: &Settings, exact: bool) -> Vec<(String, String)> {
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
            ("compact", settings.compact.to_string()),
            ("thin", settings.thin.to_string()),
            ("nearest", format!("{:?}", settings.nearest).to_lowercase()),
            ("interpolate", settings.interpolate.to_string()),
        ]);
    }
    identity.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::Piece;
    use crate::work::WorkUnit;
    use caustic_kernels::trace::{LayerPixel, Pixel};

    fn checkpoint(folder: &Path, settings: &Settings) -> Checkpoint {
        let scene = Scene::load("plane").unwrap();
        Checkpoint::new(&folder.join("state"), &scene, settings, true)
    }

    fn settings() -> Settings {
        Settings { size: [3, 2], ..Settings::of(&Scene::load("plane").unwrap()) }
    }

    /// Seven passes and some pixels of another.
    fn state(layers: bool) -> ProgressState {
        let mut state = ProgressState::new([3, 2], 0.123, layers);
        for pass in 0..8 {
            let pixels = if pass == 7 { 2 } else { 6 };
            let unit = WorkUnit { pass, first_pixel: 0, pixels };
            let value = |i: u32| (pass * 10 + i) as f32 + 0.1;
            let film: Vec<_> = (0..pixels)
                .map(|i| Pixel { rgb: [value(i), -1.0 / value(i), 1e30], rays: 3, lost: 1, ..Pixel::default() })
                .collect();
            let layer = |i: u32| LayerPixel { depth: value(i) / 7.0, ..LayerPixel::default() };
            let films: Vec<_> = (0..if layers { pixels } else { 0 }).map(layer).collect();
            state.add(Piece::new(unit, &film, &films, 1 << 40));
        }
        state
    }

    #[test]
    fn a_state_comes_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let checkpoint = checkpoint(folder.path(), &settings());
        assert!(matches!(checkpoint.load(), Err(CheckpointError::Missing { .. })));
        checkpoint.begin().unwrap();
        for state in [state(true), state(false)] {
            checkpoint.save(&state).unwrap();
            assert_eq!(checkpoint.load().unwrap(), state);
        }
        assert!(matches!(checkpoint.begin(), Err(CheckpointError::Exists { .. })));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left behind");
    }

    #[test]
    fn whatever_is_wrong_with_a_file_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let checkpoint = checkpoint(folder.path(), &settings());
        checkpoint.save(&state(true)).unwrap();
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
        // A size that does not fit, with a checksum that does.
        let at = whole.windows(12).position(|bytes| bytes == b"\"size\":[3,2]").unwrap();
        let mut lying = whole[..whole.len() - 32].to_vec();
        lying[at + 8] = b'9';
        let sum = Sha256::digest(&lying);
        lying.extend(sum);
        assert!(matches!(load(&lying), Err(CheckpointError::Damaged { .. })));
        assert!(load(&whole).is_ok());
    }

    #[test]
    fn a_file_of_another_picture_is_refused_and_says_what_differs() {
        let folder = tempfile::tempdir().unwrap();
        checkpoint(folder.path(), &settings()).save(&state(true)).unwrap();
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
