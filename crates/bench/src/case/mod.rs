//! Cases: what is measured, at which sizes, and what has to come out.

mod bless;
mod builtin;
mod check;
mod error;
mod file;

#[cfg(test)]
mod tests;

pub use bless::bless;
pub use builtin::{BUILT_IN, built_in};
pub use error::CaseError;
pub use file::{Output, load, load_folder, parse};

use crate::points::Distribution;
use caustic_photon_map::{Gather, Hash};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Most records of a case: photons, keys or paths.
pub const MAX_N: u32 = 1 << 28;

/// A case.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its name.
    pub name: String,
    /// What it is, in one line.
    pub description: String,
    /// What is done.
    pub kind: Kind,
    /// The sizes N, ascending.
    pub sizes: Vec<u32>,
    /// What it is meant to reach where.
    pub targets: Vec<Target>,
    /// SHA-256 of the result's bytes, by N.
    pub expected: BTreeMap<u32, String>,
    /// The file it is from; none for built-in ones.
    pub path: Option<PathBuf>,
}

/// What a case does. A new kind is an arm here, one in `check`, and one in `work::prepare`.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// Sorts N keys of some bits.
    Sort {
        /// Bits of a key.
        bits: u32,
        /// Whether the indices they came from go with them.
        pairs: bool,
    },
    /// Builds a photon map of N photons.
    Build(Map),
    /// Builds a photon map of N photons and searches it.
    Gather {
        /// The map.
        map: Map,
        /// Queries, at most; as many as photons where those are fewer.
        queries: u32,
        /// What a query gives.
        output: Output,
        /// How the nearest are found.
        gather: Gather,
    },
    /// Emits N photons in a scene, follows them, and stores them where they land.
    Trace {
        /// A built-in scene.
        scene: String,
    },
    /// Renders a scene with N global photons and as many caustic ones.
    Frame {
        /// A built-in scene.
        scene: String,
        /// Pixels.
        size: [u32; 2],
        /// Samples a pixel.
        spp: u32,
        /// Photons of an estimate.
        k: u32,
    },
}

impl Kind {
    /// Its name in case files.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sort { .. } => "sort",
            Self::Build(_) => "build",
            Self::Gather { .. } => "gather",
            Self::Trace { .. } => "trace",
            Self::Frame { .. } => "frame",
        }
    }

    /// What N counts.
    #[must_use]
    pub fn counts(&self) -> &'static str {
        match self {
            Self::Sort { pairs: true, .. } => "pairs",
            Self::Sort { pairs: false, .. } => "keys",
            Self::Build(_) | Self::Gather { .. } => "photons",
            Self::Trace { .. } => "paths",
            Self::Frame { .. } => "photons a map",
        }
    }

    /// Queries at size `n`.
    #[must_use]
    pub fn queries(&self, n: u32) -> Option<u32> {
        match self {
            // A picture has its pixels however many photons there are.
            Self::Gather { queries, output: Output::Density, .. } => Some(*queries),
            Self::Gather { queries, .. } => Some(n.min(*queries)),
            _ => None,
        }
    }

    /// How long it takes in arbitrary units, to tell the time left.
    #[must_use]
    pub fn effort(&self, n: u32) -> f64 {
        let n = f64::from(n);
        let pixels = |[width, height]: [u32; 2]| f64::from(width) * f64::from(height);
        match self {
            Self::Sort { .. } => n,
            Self::Build(_) => 4.0 * n,
            Self::Gather { map, queries, .. } => {
                let each = if map.distribution == Distribution::Cell { n } else { 8.0 * f64::from(map.k) };
                4.0 * n + n.min(f64::from(*queries)) * each
            }
            Self::Trace { .. } => 60.0 * n,
            Self::Frame { size, spp, k, .. } => 200.0 * n + pixels(*size) * f64::from(*spp) * 16.0 * f64::from(*k),
        }
    }
}

/// The map of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Where the photons are.
    pub distribution: Distribution,
    /// Neighbours of a query.
    pub k: u32,
    /// Largest distance of a neighbour, m; if not given, one within which 2·k photons are expected.
    pub radius: Option<f32>,
    /// The hash function.
    pub hash: Hash,
}

impl Map {
    /// The radius at `n` photons, m.
    #[must_use]
    pub fn radius(&self, n: u32) -> f32 {
        self.radius.unwrap_or_else(|| self.distribution.radius(n, self.k))
    }
}

/// What a case is meant to reach on some device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// Which device: `h100` for a GPU with that in its name, `cpu2` for a CPU with two threads.
    pub device: String,
    /// The size that it is about.
    pub n: u32,
    /// Milliseconds, at most.
    pub ms: Option<f64>,
    /// Units a second, at least.
    pub per_second: Option<f64>,
    /// Peers that have to take longer.
    #[serde(default)]
    pub faster_than: Vec<String>,
    /// What the milliseconds are of: `all`, or one of the row's parts.
    #[serde(default = "all")]
    pub counts: String,
}

fn all() -> String {
    "all".to_string()
}
