//! Rows: one case at one size on one device.

pub use crate::machine::Machine;
pub use crate::measure::Spread;
use caustic_device::StageTime;
use serde::{Deserialize, Serialize};

/// One case at one size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The case.
    pub case: String,
    /// Its kind.
    pub kind: String,
    /// The size.
    pub n: u32,
    /// What the size counts.
    pub counts: String,
    /// Queries, of a gather.
    pub queries: Option<u32>,
    /// What was measured; or why nothing was.
    #[serde(flatten)]
    pub outcome: Outcome,
}

/// What became of a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// It ran.
    Measured(Box<Measured>),
    /// It did not, for this reason.
    Skipped(String),
}

/// Which clock the headline time is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Clock {
    /// The sum of the stages' times on the device.
    Stages,
    /// The wall clock around submission, execution and waiting.
    Wall,
}

/// The time of a part: the stages of one scope.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its name.
    pub part: String,
    /// Median of the sum of its stages, ms.
    pub ms: f64,
}

/// The median time of one stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// The stage, with its scope.
    pub stage: String,
    /// How often it runs.
    pub runs: u32,
    /// Median of its time in all, ms.
    pub ms: f64,
}

/// What a run of a row took: the stages, and the wall clock.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sample {
    pub wall_ms: f64,
    pub stages: Vec<StageTime>,
}

/// What was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// How many runs the times are of.
    pub runs: usize,
    /// Which clock counts.
    pub clock: Clock,
    /// Sum of the stages' times, ms; none where the device has no time stamps.
    pub stages_ms: Option<Spread>,
    /// Wall clock, ms.
    pub wall_ms: Spread,
    /// Times of parts, such as build and query.
    pub parts: Vec<Part>,
    /// Times of stages.
    pub stages: Vec<Stage>,
    /// Units a second …
    pub per_second: f64,
    /// … of these: pairs, photons, queries, segments, pixels.
    pub unit: String,
    /// Least bytes that have to be moved, by the model of the kind; none where bytes are not what bounds it.
    pub bytes: Option<u64>,
    /// Bytes a second over those of a copy that was measured in the same run.
    pub of_copy: Option<f64>,
    /// SHA-256 of the result.
    pub sha256: String,
    /// Whether that is the one of the case file; none where the file has none for this size.
    pub as_expected: Option<bool>,
    /// Results that were checked against brute force …
    pub checked: usize,
    /// … and how many of them differ.
    pub differ: usize,
    /// Whether targets for this device and size are met.
    pub targets: Vec<Reached>,
    /// Others on the same data.
    pub peers: Vec<Peer>,
}

/// How a target was met.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reached {
    /// What was to be reached.
    pub target: String,
    /// Whether it was; none if it could not be judged.
    pub met: Option<bool>,
}

/// Another library on the same data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Peer {
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    /// How many runs the time is of.
    pub runs: usize,
    /// Wall clock, ms; none if it did not run.
    pub wall_ms: Option<Spread>,
    /// By the device's time stamps, ms.
    pub stages_ms: Option<Spread>,
    /// Median times of its parts.
    pub parts: Vec<Part>,
    /// Its time over ours by the same clock; above 1 we are faster.
    pub over_ours: Option<f64>,
    /// How many of the compared results agree …
    pub agree: usize,
    /// … of how many.
    pub compared: usize,
    /// What to know: threads, or why it did not run.
    pub note: String,
}

impl Measured {
    /// The headline time.
    #[must_use]
    pub fn time(&self) -> Spread {
        match self.clock {
            Clock::Stages => self.stages_ms.unwrap_or(self.wall_ms),
            Clock::Wall => self.wall_ms,
        }
    }

    /// Median of a part, or of `all`.
    #[must_use]
    pub fn part(&self, name: &str) -> Option<f64> {
        if name == "all" {
            return Some(self.time().median);
        }
        self.parts.iter().find(|part| part.part == name).map(|part| part.ms)
    }
}

impl Row {
    /// What was measured, if anything was.
    #[must_use]
    pub fn measured(&self) -> Option<&Measured> {
        match &self.outcome {
            Outcome::Measured(measured) => Some(measured),
            Outcome::Skipped(_) => None,
        }
    }
}
