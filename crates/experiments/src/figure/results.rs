//! Results, as figures look at them.

use crate::case::{Case, Map};
use crate::scope::Scope;
use crate::store::{Outcome, Store};
use crate::subject;
use std::path::Path;

/// Results of a range.
pub struct Results<'a> {
    /// All of them.
    pub store: &'a Store,
    /// The range.
    pub scope: Scope,
    /// Where pictures are.
    pub folder: &'a Path,
}

impl Results<'_> {
    /// The base case of a map for a subject.
    #[must_use]
    pub fn base(&self, map: Map, subject: &str) -> Case {
        Case { subject: subject.to_string(), ..self.scope.base(map) }
    }

    /// Why there are no numbers for some of these cases, once for each reason and subject.
    #[must_use]
    pub fn skipped(&self, cases: &[Case]) -> Vec<String> {
        let mut notes: Vec<String> = Vec::new();
        for case in cases {
            if let Some(Outcome::Skipped(reason)) = self.store.outcome(case) {
                let label = subject::named(&case.subject).map_or(case.subject.as_str(), |subject| subject.label);
                notes.push(format!("{label}, {case}: {reason}"));
            }
        }
        notes.sort();
        notes.dedup();
        notes
    }
}

/// Time of a construction by the wall clock, ms: what a renderer waits for.
pub(super) fn build_ms(results: &Results, case: &Case) -> Option<f64> {
    results.store.value(case, "build_ms")
}

/// Time of a search, ms: what a GPU worked, or the wall clock on a CPU.
pub(super) fn search_ms(results: &Results, case: &Case) -> Option<f64> {
    let on_cpu = subject::named(&case.subject).is_some_and(|subject| subject.on_cpu);
    results.store.value(case, if results.scope.gpu && !on_cpu { "search_stages_ms" } else { "search_ms" })
}
