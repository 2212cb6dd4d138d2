//! Figures 14, 15 and 24: memory (sections 5.2 and 5.3.3).

use super::sweep::{Sweep, Vary, ratios, span};
use super::{Axis, Chart, Figure, Line, Page, Results};
use crate::case::{Case, Map};
use crate::claim::{Claim, all};
use crate::scope::Scope;
use crate::subject::{CAUSTIC, CAUSTIC_MORTON, JENSEN, KD, LINEAR, TESCHNER};

const SUBJECTS: &[&str] = &[JENSEN, KD, LINEAR, TESCHNER, CAUSTIC, CAUSTIC_MORTON];
const GLOBAL: Sweep = Sweep { map: Map::Global, vary: Vary::Photons, subjects: SUBJECTS };
const CAUSTIC_MAP: Sweep = Sweep { map: Map::Caustic, ..GLOBAL };
const NOTE: &str = "Bytes of buffers on the device beyond the photons as they were given (32 bytes each), which all techniques have alike.";

pub(super) const FIG_14: Figure = Figure {
    id: "fig14",
    title: "Memory after construction",
    section: "5.2",
    cases,
    page: |results| {
        let ratios = || {
            let [kd, linear, teschner] = points(results, memory);
            let all_ratios = [ratios(&kd, &linear)?, ratios(&kd, &teschner)?].concat();
            let (low, high) = span(&all_ratios);
            let text = format!("the kd-tree takes {low:.2} to {high:.2} times the memory of the hashes.");
            Some((all(&[low > 1.0, high > 1.0]), text))
        };
        let says = "“our spatial hashing technique consumes significantly less memory than the kD-Tree approach” (5.2)";
        page(results, "memory", "Memory after construction", memory, Claim::judge(says, ratios()))
    },
};

pub(super) const FIG_15: Figure = Figure {
    id: "fig15",
    title: "Peak memory during construction",
    section: "5.2",
    cases,
    page: |results| {
        let ratio = || {
            let [kd, linear, _] = points(results, peak);
            let last = *ratios(&kd, &linear)?.last()?;
            let text = format!("{:.1} times lower at {} photons; almost 8 is at least 6.", last.1, last.0);
            Some((all(&[last.1 > 1.0, last.1 >= 6.0]), text))
        };
        let says = "“an almost 8 times lower peak consumption at 500,000 photons” (5.2)";
        page(results, "peak", "Peak memory during construction", peak, Claim::judge(says, ratio()))
    },
};

fn cases(scope: &Scope) -> Vec<Case> {
    [GLOBAL.cases(scope), CAUSTIC_MAP.cases(scope)].concat()
}

fn memory(results: &Results, case: &Case) -> Option<f64> {
    results.store.value(case, "memory_bytes")
}

fn peak(results: &Results, case: &Case) -> Option<f64> {
    results.store.value(case, "peak_bytes")
}

type Value = fn(&Results, &Case) -> Option<f64>;

fn points(results: &Results, value: Value) -> [Vec<(f64, f64)>; 3] {
    [KD, LINEAR, TESCHNER].map(|subject| GLOBAL.thesis_points(results, subject, value))
}

fn page(results: &Results, name: &str, title: &str, value: Value, claim: Claim) -> Page {
    let chart = |sweep: Sweep| {
        let map = sweep.map.name();
        sweep.chart(results, &format!("{name}-{map}"), &format!("{title}, {map} map"), Axis::Bytes, value)
    };
    Page { charts: [GLOBAL, CAUSTIC_MAP].map(chart).into(), claims: vec![claim], note: NOTE, ..Page::default() }
}

/// Numbers of photons of figure 24.
fn sizes(scope: &Scope) -> &'static [u32] {
    if scope.quick { &[10_000, 50_000] } else { &[10_000, 50_000, 100_000, 500_000] }
}

pub(super) const FIG_24: Figure = Figure {
    id: "fig24",
    title: "Memory of the linear hash with different query radii",
    section: "5.3.3",
    cases: |scope| {
        let of = |&photons: &u32| {
            let base = |subject: &str| Case { photons, subject: subject.to_string(), ..scope.base(Map::Global) };
            let mut cases = Vary::Radius.range(scope, &base(LINEAR));
            cases.push(base(KD));
            cases
        };
        sizes(scope).iter().flat_map(of).collect()
    },
    page: |results| {
        let all_points: Vec<_> =
            sizes(&results.scope).iter().map(|&photons| (photons, of_size(results, photons))).collect();
        let lines = all_points.iter().zip(0..).map(|((photons, points), i)| Line {
            subject: i,
            label: format!("{photons} photons"),
            points: points.clone(),
        });
        let chart = Chart {
            name: "memory-radius".to_string(),
            title: "Memory over query radius, linear hash, global map".to_string(),
            axes: [Axis::Radius, Axis::Bytes],
            thesis_to: (!results.scope.quick).then_some(Vary::Radius.thesis_to()),
            lines: lines.collect(),
        };
        let smallest = || {
            let points = &all_points.first()?.1;
            let at = |mm: f64| points.iter().find(|point| point.0 == mm).map(|point| point.1);
            let ratio = at(37.0)? / at(148.0)?;
            let text = format!(
                "{ratio:.1} times at {} photons, between radii of 37 and 148 mm. The thesis's ratio is what these radii were inferred from.",
                all_points[0].0
            );
            Some((all(&[ratio > 1.0, ratio > 4.0]), text))
        };
        let as_kd = || {
            let kd = memory(results, &Case { photons: 50_000, ..results.base(Map::Global, KD) })?;
            let points = &all_points.iter().find(|points| points.0 == 50_000)?.1;
            let (low, high) = span(&points.iter().map(|&(x, y)| (x, y / kd)).collect::<Vec<_>>());
            let text = format!(
                "the hash takes {low:.2} to {high:.2} of the kd-tree's memory at 50,000 photons, depending on the radius; the same is 0.8 to 1.25."
            );
            Some((all(&[low < 1.25, high > 0.8]), text))
        };
        Page {
            charts: vec![chart],
            claims: vec![
                Claim::judge(
                    "“Using the smallest radius 0.5, we need more than 4 times the memory, required with a radius of 1.5 or 2” (5.3.3)",
                    smallest(),
                ),
                Claim::judge(
                    "“At around 50,000 photons, the memory requirement is roughly the same as for the kD-Tree technique” (5.3.3)",
                    as_kd(),
                ),
            ],
            note: NOTE,
            ..Page::default()
        }
    },
};

fn of_size(results: &Results, photons: u32) -> Vec<(f64, f64)> {
    let base = Case { photons, ..results.base(Map::Global, LINEAR) };
    let cases = Vary::Radius.range(&results.scope, &base);
    cases.iter().filter_map(|case| Some((Vary::Radius.of(case), memory(results, case)?))).collect()
}
