//! The figures and tables of chapter 5, each with the cases that it is made of and what it shows of them.

mod access;
mod brute;
mod construction;
mod memory;
mod observations;
mod pictures;
mod results;
mod search;
mod sweep;

pub use results::Results;

use crate::case::Case;
use crate::claim::Claim;
use crate::scope::Scope;
use caustic_renderer::scene::suggestion;
use serde::Serialize;

/// A figure or table of the thesis.
pub struct Figure {
    /// Its name on the command line.
    pub id: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// Where it is in the thesis.
    pub section: &'static str,
    /// What has to be measured for it.
    pub cases: fn(&Scope) -> Vec<Case>,
    /// What is made of it.
    pub page: fn(&Results) -> Page,
}

/// What a figure shows.
#[derive(Default, Serialize)]
pub struct Page {
    /// Plots.
    pub charts: Vec<Chart>,
    /// Tables.
    pub tables: Vec<Table>,
    /// Pictures side by side.
    pub pictures: Vec<Picture>,
    /// What the thesis claims about it.
    pub claims: Vec<Claim>,
    /// How it was measured, where that is not as everywhere.
    pub note: &'static str,
}

/// What an axis counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// Photons.
    Photons,
    /// Neighbours.
    K,
    /// Millimetres.
    Radius,
    /// Queries.
    Queries,
    /// Milliseconds.
    Time,
    /// Bytes.
    Bytes,
    /// Sectors.
    Sectors,
    /// Loads and stores.
    Accesses,
    /// Relative mean square error.
    RelMse,
}

impl Axis {
    /// What it counts, with its unit.
    #[must_use]
    pub fn description(self) -> &'static str {
        match self {
            Self::Photons => "photons",
            Self::K => "k, neighbours a query",
            Self::Radius => "query radius, mm",
            Self::Queries => "queries",
            Self::Time => "time, ms",
            Self::Bytes => "bytes",
            Self::Sectors => "32-byte sectors beyond the fewest",
            Self::Accesses => "loads and stores",
            Self::RelMse => "relMSE",
        }
    }
}

/// A plot.
#[derive(Serialize)]
pub struct Chart {
    /// Name of its file.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// Its axes, horizontal first; both logarithmic.
    pub axes: [Axis; 2],
    /// Where the thesis's range ends.
    pub thesis_to: Option<f64>,
    /// Its lines.
    pub lines: Vec<Line>,
}

/// A line of a plot.
#[derive(Serialize)]
pub struct Line {
    /// Place of its subject among all: what gives it its colour.
    pub subject: usize,
    /// What it is of.
    pub label: String,
    /// Its points.
    pub points: Vec<(f64, f64)>,
}

/// A table.
#[derive(Serialize)]
pub struct Table {
    /// What it shows.
    pub title: String,
    /// Names of columns.
    pub columns: Vec<String>,
    /// Cells as text.
    pub rows: Vec<Vec<String>>,
}

/// A picture.
#[derive(Serialize)]
pub struct Picture {
    /// What it shows.
    pub caption: String,
    /// PNG.
    #[serde(skip)]
    pub png: Vec<u8>,
}

/// All figures, in the order of the thesis.
pub const FIGURES: &[Figure] = &[
    construction::FIG_12,
    construction::FIG_13,
    memory::FIG_14,
    memory::FIG_15,
    search::FIG_16,
    access::FIG_17,
    search::FIG_18,
    search::FIG_20,
    search::FIG_21,
    search::FIG_22,
    search::FIG_23,
    memory::FIG_24,
    search::FIG_25,
    access::FIG_26,
    search::FIG_27,
    brute::FIG_28,
    brute::TABLE_3,
    pictures::FIG_29,
    pictures::FIG_30,
    observations::SECTION_5_6,
    observations::SECTION_2_3_3,
];

/// The figures of these names; all if there are none.
///
/// # Errors
/// If a name is of no figure; the sentence has those that are.
pub fn named(names: &[String]) -> Result<Vec<&'static Figure>, String> {
    let known = || FIGURES.iter().map(|figure| figure.id).collect::<Vec<_>>().join(", ");
    if let Some(name) = names.iter().find(|name| !FIGURES.iter().any(|figure| figure.id == **name)) {
        let meant = suggestion(name, FIGURES.iter().map(|figure| figure.id));
        return Err(format!("--only: there is no figure `{name}`{meant}; there are {}", known()));
    }
    let wanted = |figure: &&Figure| names.is_empty() || names.iter().any(|name| name == figure.id);
    Ok(FIGURES.iter().filter(wanted).collect())
}
