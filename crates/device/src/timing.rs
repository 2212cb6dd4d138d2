//! Time a stage.

use std::sync::{Mutex, PoisonError};

/// How long one stage took in all.
#[derive(Clone, Debug, serde::Serialize)]
pub struct StageTime {
    /// The stage, with its scope.
    pub stage: String,
    /// How often it ran.
    pub runs: u32,
    /// Time in all, ms: GPU time stamps, or wall clock on the CPU.
    pub ms: f64,
}

#[derive(Default)]
pub(crate) struct Timings(Mutex<Vec<StageTime>>);

impl Timings {
    pub(crate) fn add(&self, stage: &str, ms: f64) {
        let mut rows = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(row) = rows.iter_mut().find(|row| row.stage == stage) {
            row.runs += 1;
            row.ms += ms;
        } else {
            rows.push(StageTime { stage: stage.to_string(), runs: 1, ms });
        }
    }

    pub(crate) fn report(&self) -> Vec<StageTime> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(crate) fn reset(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }
}
