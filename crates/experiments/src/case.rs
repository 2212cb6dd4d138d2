//! What is measured: one technique under one set of circumstances.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Which photons (section 4.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Map {
    /// All that land on diffuse surfaces.
    Global,
    /// Those that come there through mirrors and glass alone.
    Caustic,
}

impl Map {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Global, Self::Caustic];

    /// For people.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Global => "global",
            Self::Caustic => "caustic",
        }
    }
}

/// What is measured of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum What {
    /// Times and bytes of construction and search.
    Speed,
    /// Memory accesses of the kernels.
    Access,
    /// The picture that the photons make.
    Picture,
    /// How far the radius of a search by histogram is from that of the k-th neighbour.
    Radius,
}

/// A case.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Case {
    /// What is measured.
    pub what: What,
    /// Name of the [subject](crate::subject::Subject).
    pub subject: String,
    /// Which photons.
    pub map: Map,
    /// How many photons.
    pub photons: u32,
    /// Neighbours sought a query.
    pub k: u32,
    /// Largest distance of a neighbour, mm.
    pub radius_mm: u32,
    /// Width and height of the picture whose pixels ask.
    pub size: [u32; 2],
}

impl Case {
    /// Largest distance of a neighbour, m.
    #[must_use]
    pub fn radius(&self) -> f32 {
        self.radius_mm as f32 * 1e-3
    }

    /// Number of queries.
    #[must_use]
    pub fn queries(&self) -> u32 {
        self.size[0] * self.size[1]
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, subject, map, photons, k, radius_mm, size: [width, height] } = self;
        let what = format!("{what:?}").to_lowercase();
        write!(f, "{what} {subject} {} {photons} k{k} r{radius_mm} {width}x{height}", map.name())
    }
}
