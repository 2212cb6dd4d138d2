//! Parts of a render that were computed anywhere, merged into what one process would have made.

use crate::checkpoint::{difference, identity};
use crate::output::{Image, Layer, LayerKind, Metadata, OutputError, place};
use crate::render::notes;
use crate::scene::Scene;
use crate::state_file::{self, About, Fault, Header};
use crate::work::Part;
use crate::{ProgressState, Settings};
use std::path::{Path, PathBuf};

/// Why parts cannot be merged, in one sentence with the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// No file was given.
    #[error("there are no parts to merge; give the files that `caustic render --part I/N -o FILE` wrote")]
    Nothing,
    /// A file cannot be read.
    #[error("the part {} cannot be read: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// It is another kind of file, or of another version.
    #[error(
        "{} is no part of a render by this version of caustic; give files that its `caustic render --part I/N -o FILE` wrote", path.display()
    )]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// It is not what was written.
    #[error("the part {} is damaged: its checksum is wrong; copy or render it again", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
    },
    /// Two files are parts of different pictures.
    #[error(
        "{} was made with {name} {found}, but {} with {expected}; merge parts of one picture", path.display(), first.display()
    )]
    Different {
        /// The file that differs.
        path: PathBuf,
        /// The first file.
        first: PathBuf,
        /// What differs.
        name: String,
        /// What the file has.
        found: String,
        /// What the first file has.
        expected: String,
    },
    /// Two files hold the same.
    #[error(
        "{} (part {}/{}) holds what another of the files holds already, from pixel {pixel} of pass {pass} on; give each part once",
        path.display(), part.number, part.of
    )]
    Duplicate {
        /// The second of them.
        path: PathBuf,
        /// Which part it says it is.
        part: Part,
        /// The first pass that both have.
        pass: u32,
        /// The first of its pixels that both have.
        pixel: u32,
    },
    /// There are too few files.
    #[error("{what} missing{parts}; render {them} and merge again")]
    Missing {
        /// Passes and pixels that no file has.
        what: String,
        /// The parts that are not there.
        parts: String,
        /// it or them.
        them: &'static str,
    },
}

/// Writes what a render of one part came to.
///
/// # Errors
/// If the disk fails.
pub fn write_part(
    path: &Path,
    scene: &Scene,
    settings: &Settings,
    exact: bool,
    about: &About,
    state: &ProgressState,
) -> Result<(), OutputError> {
    place::replace(path, &state_file::encode(&identity(scene, settings, exact), Some(about), state))
}

/// A picture that was merged from parts.
pub struct Merged {
    /// The passes.
    pub state: ProgressState,
    /// The layers that the render was asked for.
    pub layers: Vec<LayerKind>,
    /// What the picture's file is to say.
    pub metadata: Metadata,
}

impl Merged {
    /// The picture: that of one process.
    #[must_use]
    pub fn image(&self) -> Image {
        self.state.image()
    }

    /// What is worth a look.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        notes(&self.state.all_counts())
    }

    /// Some of its layers.
    #[must_use]
    pub fn layers_of(&self, kinds: &[LayerKind]) -> Vec<Layer> {
        self.state.layers(kinds)
    }
}

/// Merges the parts in these files, which may come in any order.
///
/// # Errors
/// If a file cannot be used, two do not belong together or hold the same, or something is missing.
pub fn merge(paths: &[PathBuf]) -> Result<Merged, MergeError> {
    let Joined { about, state, .. } = join(paths)?;
    let missing = state.missing(about.passes);
    if !missing.is_empty() {
        return Err(lack(&missing, &about.parts()));
    }
    Ok(Merged { state, layers: about.layers, metadata: about.metadata })
}

/// Parts that were merged and may be parts of more.
pub struct Joined {
    identity: Vec<(String, String)>,
    about: About,
    state: ProgressState,
}

impl Joined {
    /// Writes a part that has all that these had. Passes are added up in the order of their numbers, so that the picture has the same bits as if
    /// all parts were merged at once.
    ///
    /// # Errors
    /// If the disk fails.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        place::replace(path, &state_file::encode(&self.identity, Some(&self.about), &self.state))
    }
}

/// Merges the parts in these files, which may come in any order and need not be all.
///
/// # Errors
/// If a file cannot be used, or two do not belong together or hold the same.
pub fn join(paths: &[PathBuf]) -> Result<Joined, MergeError> {
    let mut merged: Option<(Header, About, ProgressState)> = None;
    let mut parts = Vec::new();
    for path in paths {
        let (header, about, state) = read(path)?;
        parts.extend(about.parts());
        let Some((first, first_about, sum)) = &mut merged else {
            merged = Some((header, about, state));
            continue;
        };
        if let Some((name, expected, found)) = differences((first, first_about, sum), (&header, &about, &state)) {
            let (path, first) = (path.clone(), paths[0].clone());
            return Err(MergeError::Different { path, first, name, found, expected });
        }
        if let Err(unit) = sum.absorb(state) {
            let (path, part) = (path.clone(), about.part);
            return Err(MergeError::Duplicate { path, part, pass: unit.pass, pixel: unit.first_pixel });
        }
    }
    let Some((header, about, state)) = merged else { return Err(MergeError::Nothing) };
    // In order, so that the file does not depend on that of its parts.
    parts.sort_by_key(|part| (part.of, part.number));
    let about = About { part: parts[0], merged: parts.split_off(1), ..about };
    Ok(Joined { identity: header.identity, about, state })
}

impl About {
    /// Every part that this one has.
    fn parts(&self) -> Vec<Part> {
        std::iter::once(self.part).chain(self.merged.iter().copied()).collect()
    }
}

fn read(path: &Path) -> Result<(Header, About, ProgressState), MergeError> {
    let path = || path.to_path_buf();
    let bytes = std::fs::read(path()).map_err(|error| MergeError::Read { path: path(), reason: error.to_string() })?;
    let (header, state) = state_file::decode(&bytes).map_err(|fault| match fault {
        Fault::Foreign => MergeError::Foreign { path: path() },
        Fault::Damaged => MergeError::Damaged { path: path() },
    })?;
    let own = |header: &Header| header.identity.iter().any(|(_, value)| value == env!("CARGO_PKG_VERSION"));
    match header.about.clone().filter(|_| own(&header)) {
        Some(about) => Ok((header, about, state)),
        None => Err(MergeError::Foreign { path: path() }),
    }
}

/// What differs between two parts first: its name and both values.
fn differences(
    (a, about_a, state_a): (&Header, &About, &ProgressState),
    (b, about_b, state_b): (&Header, &About, &ProgressState),
) -> Option<(String, String, String)> {
    let names = |about: &About| about.layers.iter().map(|layer| layer.name()).collect::<Vec<_>>().join(",");
    let more = |about: &About, state: &ProgressState| {
        [
            ("passes", about.passes.to_string()),
            ("aov", names(about)),
            ("radius of the first pass", state.first_radius.to_string()),
            ("name of the scene", about.metadata.scene.clone()),
        ]
        .map(|(name, value)| (name.to_string(), value))
    };
    difference(&a.identity, &b.identity)
        .or_else(|| difference(&more(about_a, state_a), &more(about_b, state_b)))
        .or_else(|| difference(&about_a.metadata.settings, &about_b.metadata.settings))
}

/// What is missing, with the parts that would have it.
fn lack(missing: &[String], parts: &[Part]) -> MergeError {
    const MOST: usize = 8;
    let mut what = missing.iter().take(MOST).cloned().collect::<Vec<_>>().join(", ");
    if missing.len() > MOST {
        what += &format!(" and {} more", missing.len() - MOST);
    }
    let one = missing.len() == 1 && missing[0].starts_with("pass ");
    what += if one { " is" } else { " are" };
    // If all were split alike.
    let of = parts.first().map_or(0, |part| part.of);
    let alike = parts.iter().all(|part| part.of == of);
    let absent = |number: &u32| alike && !parts.iter().any(|part| part.number == *number);
    let absent: Vec<_> = (1..=of).filter(absent).map(|number| format!("{number}/{of}")).collect();
    let parts = match &absent[..] {
        [] => String::new(),
        [part] => format!(": part {part} is not among the files"),
        _ => format!(": parts {} are not among the files", absent.join(", ")),
    };
    MergeError::Missing { what, parts, them: if one || absent.len() == 1 { "it" } else { "them" } }
}
