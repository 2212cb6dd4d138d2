//! Measuring all cases of some figures.

use crate::case::{Case, What};
use crate::figure::Figure;
use crate::measure::measure;
use crate::picture;
use crate::scope::Scope;
use crate::stage::Stage;
use crate::store::{Outcome, Store};
use crate::subject;
use caustic_bench::Trouble;
use caustic_device::Device;
use caustic_renderer::Part;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// What to measure.
pub struct Options<'a> {
    /// Where results are kept.
    pub folder: &'a Path,
    /// The figures.
    pub figures: &'a [&'a Figure],
    /// How far they go.
    pub scope: Scope,
    /// Which part of the cases; all if none.
    pub part: Option<Part>,
    /// Longest that a single run of a case may be expected to take, s; cases beyond are skipped.
    pub patience_s: f64,
}

/// What happens.
pub enum Event<'a> {
    /// A case begins; so much of all is done.
    Begin(&'a Case, f64),
    /// A case is over.
    Done(&'a Case, &'a Outcome),
}

/// Measures what the store does not have yet. Returns whether all is there: false if `watch` returned false.
///
/// # Errors
/// If a device or the disk fails.
pub fn run(
    options: &Options,
    device: &Device,
    store: &mut Store,
    watch: &mut dyn FnMut(Event) -> bool,
) -> Result<bool, String> {
    let cases: Vec<Case> = Part::share(options.part, cases(options)).collect();
    let mut stage = Stage::new(device).map_err(told)?;
    let mut pace = Pace::default();
    let total: f64 = cases.iter().map(weight).sum();
    let mut done = 0.0;
    for case in &cases {
        if let Some(outcome) = store.outcome(case) {
            pace.learn(case, outcome);
            done += weight(case);
            continue;
        }
        if !watch(Event::Begin(case, done / total)) {
            return Ok(false);
        }
        let (outcome, found) = match pace.expected_s(case) {
            Some(seconds) if seconds > options.patience_s => {
                (Outcome::Skipped(format!("one run would take about {seconds:.0} s")), None)
            }
            _ => match subject::named(&case.subject) {
                Some(subject) => match measure(&mut stage, subject, case, options.folder, options.scope.quick) {
                    Err(Trouble::Interrupted) => return Ok(false),
                    measured => measured.map_err(told)?,
                },
                None => (Outcome::Skipped("there is no such technique".to_string()), None),
            },
        };
        pace.learn(case, &outcome);
        store.add(case, outcome.clone(), found)?;
        done += weight(case);
        if !watch(Event::Done(case, &outcome)) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Merges the results in these folders, which may be parts in any order, into `options.folder`, with the pictures.
///
/// # Errors
/// As [`StoreOf::merge`](crate::store::StoreOf::merge), and if a picture cannot be copied.
pub fn merge(options: &Options, parts: &[PathBuf]) -> Result<Store, String> {
    let store = Store::merge(options.folder, parts, &cases(options))?;
    for part in parts {
        picture::copy(part, options.folder)?;
    }
    Ok(store)
}

fn told(trouble: Trouble) -> String {
    match trouble {
        Trouble::Skip(text) | Trouble::Fail(text) => text,
        Trouble::Interrupted => "interrupted".to_string(),
    }
}

/// All cases of the figures, each once, in an order in which photons and pictures are made seldom; smaller ones first, so that the pace
/// of larger ones is known.
#[must_use]
pub fn cases(options: &Options) -> Vec<Case> {
    let mut seen = HashSet::new();
    let all = options.figures.iter().flat_map(|figure| (figure.cases)(&options.scope));
    let mut cases: Vec<Case> = all.filter(|case| seen.insert(case.clone())).collect();
    cases.sort_by_key(|case| {
        let on_cpu = subject::named(&case.subject).is_some_and(|subject| subject.on_cpu);
        (case.map, case.photons, on_cpu, case.queries(), case.what, case.subject.clone(), case.k, case.radius_mm)
    });
    cases
}

/// What a case costs beside others: a guess for the progress bar.
fn weight(case: &Case) -> f64 {
    let (photons, queries) = (f64::from(case.photons), f64::from(case.queries()));
    3e5 + photons
        + queries * (20.0 + f64::from(case.k)).sqrt()
        + if is_brute(case) { 0.02 * photons * queries } else { 0.0 }
}

fn is_brute(case: &Case) -> bool {
    case.subject.starts_with("brute")
}

/// How long each subject took so far.
#[derive(Default)]
struct Pace(HashMap<(String, What), (f64, f64)>);

impl Pace {
    fn learn(&mut self, case: &Case, outcome: &Outcome) {
        if let Outcome::Values(values) = outcome {
            let ms: f64 = ["build_ms", "search_ms", "case_ms"].iter().filter_map(|name| values.get(*name)).sum();
            self.0.insert((case.subject.clone(), case.what), (ms * 1e-3, work(case)));
        }
    }

    /// What one run may take, by what the last one took.
    fn expected_s(&self, case: &Case) -> Option<f64> {
        let &(seconds, of) = self.0.get(&(case.subject.clone(), case.what))?;
        // A fixed part does not grow.
        Some(if seconds < 0.05 { 0.05 } else { seconds } * work(case) / of)
    }
}

/// Work of a case: distances, or candidates near queries.
fn work(case: &Case) -> f64 {
    let (photons, queries) = (f64::from(case.photons), f64::from(case.queries()));
    // Of searches about equally many workgroups are recorded, whatever the picture: construction takes longer.
    if case.what == What::Access {
        return photons;
    }
    if is_brute(case) {
        return photons * queries;
    }
    let within = photons * f64::from(case.radius()).powi(2);
    queries * (f64::from(case.k) + within) + 10.0 * photons
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::FIGURES;
    use crate::store::tests::{case, values};

    #[test]
    fn every_case_is_there_once_and_every_subject_is_known() {
        let figures: Vec<&Figure> = FIGURES.iter().collect();
        for (quick, gpu) in [(true, false), (false, true)] {
            let scope = Scope { quick, gpu };
            let options = Options { folder: Path::new("."), figures: &figures, scope, part: None, patience_s: 1.0 };
            let cases = cases(&options);
            let different: HashSet<_> = cases.iter().collect();
            assert_eq!(different.len(), cases.len());
            assert!(cases.len() > 100, "{}", cases.len());
            let unknown: HashSet<_> = cases.iter().filter(|case| subject::named(&case.subject).is_none()).collect();
            assert!(unknown.is_empty(), "{unknown:?}");
        }
    }

    #[test]
    fn the_time_of_a_larger_case_is_foreseen() {
        let mut pace = Pace::default();
        assert_eq!(pace.expected_s(&case(1000)), None);
        pace.learn(&case(1000), &values(&[("build_ms", 500.0), ("search_ms", 1500.0)]));
        let brute = |photons| Case { subject: "brute".to_string(), ..case(photons) };
        pace.learn(&brute(1000), &values(&[("search_ms", 1000.0)]));
        assert!((pace.expected_s(&brute(5000)).unwrap() - 5.0).abs() < 1e-9);
        let picture = |photons| Case { what: What::Picture, ..brute(photons) };
        assert_eq!(pace.expected_s(&picture(1000)), None);
        pace.learn(&picture(1000), &values(&[("case_ms", 3000.0)]));
        assert!((pace.expected_s(&picture(5000)).unwrap() - 15.0).abs() < 1e-9);
        let expected = pace.expected_s(&case(100_000)).unwrap();
        assert!(expected > 2.0 && expected < 200.0, "{expected}");
    }
}
