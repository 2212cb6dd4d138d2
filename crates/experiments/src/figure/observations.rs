//! What the thesis observes or passes on without a figure: section 5.6 on collecting photons, and section 2.3.3 on the kd-tree's radius.

use super::results::search_ms;
use super::sweep::{Sweep, Vary, ratios, span};
use super::{Axis, Figure, Page, Table};
use crate::case::{Case, Map, What};
use crate::claim::{Claim, all};
use crate::subject::{CAUSTIC, CAUSTIC_MORTON, CAUSTIC_TESCHNER, CELLS, KD, LINEAR, LINEAR_HEAP};
use caustic_rivals::KD_HISTOGRAMS;

const COLLECTION: Sweep = Sweep {
    map: Map::Global,
    vary: Vary::K,
    subjects: &[CELLS, LINEAR, LINEAR_HEAP, CAUSTIC, CAUSTIC_TESCHNER, CAUSTIC_MORTON],
};

pub(super) const SECTION_5_6: Figure = Figure {
    id: "sec5.6",
    title: "Collecting photons: list, heap, a lane a cell, and caustic's counting",
    section: "5.6",
    cases: |scope| COLLECTION.cases(scope),
    page: |results| {
        let points = |subject| COLLECTION.thesis_points(results, subject, search_ms);
        let parallel = || {
            let (low, high) = span(&ratios(&points(CELLS), &points(LINEAR))?);
            let text = format!("it takes {low:.2} to {high:.2} times as long as the sorted list.");
            Some((all(&[low > 1.0, high > 1.0]), text))
        };
        let heap = || {
            let (low, high) = span(&ratios(&points(LINEAR), &points(LINEAR_HEAP))?);
            Some((
                all(&[low > 1.0, high > 1.0]),
                format!("the list takes {low:.2} to {high:.2} times as long as the heap."),
            ))
        };
        let ours = || {
            let (low, high) = span(&ratios(&points(LINEAR), &points(CAUSTIC))?);
            let text = format!(
                "the thesis's linear hash with its list takes {low:.1} to {high:.1} times as long as caustic's search."
            );
            Some((all(&[low > 1.0, high > 1.0]), text))
        };
        Page {
            charts: vec![COLLECTION.chart(
                results,
                "collection",
                "Search time over k by way of collecting, global map",
                Axis::Time,
                search_ms,
            )],
            claims: vec![
                Claim::judge(
                    "Processing each cell in a thread and merging “was slower than our sorted list implementation” (5.6)",
                    parallel(),
                ),
                Claim::judge(
                    "A solution to the sorted list's problem “is to use a different data structure for the photon list, like a max heap” (5.6)",
                    heap(),
                ),
                Claim::judge("There are faster ways to collect (5.6)", ours()),
            ],
            ..Page::default()
        }
    },
};

fn radius_cases(scope: &crate::scope::Scope) -> Vec<Case> {
    let case = |map| Case { what: What::Radius, subject: KD.to_string(), ..scope.base(map) };
    Map::ALL.map(case).into()
}

pub(super) const SECTION_2_3_3: Figure = Figure {
    id: "sec2.3.3",
    title: "Error of the kd-tree's search radius",
    section: "2.3.3",
    cases: radius_cases,
    page: |results| {
        let error = |case: &Case, rounds: u32, of: &str| results.store.value(case, &format!("{of}_error_{rounds}"));
        let cases = radius_cases(&results.scope);
        let row = |case: &Case| {
            let cells = (1..=4).flat_map(|rounds| ["mean", "most"].map(|of| error(case, rounds, of)));
            let cells = cells.map(|error| error.map_or("–".to_string(), |error| format!("{:.4} %", 100.0 * error)));
            std::iter::once(case.map.name().to_string()).chain(cells).collect::<Vec<_>>()
        };
        let columns = (1..=4).flat_map(|rounds| ["mean", "most"].map(|of| format!("{of}, {rounds} rounds")));
        let judged = || {
            let worst = |of: &str| {
                let errors: Option<Vec<f64>> = cases.iter().map(|case| error(case, KD_HISTOGRAMS, of)).collect();
                Some(errors?.into_iter().fold(0.0, f64::max))
            };
            let (mean, most) = (worst("mean")?, worst("most")?);
            let text = format!(
                "after {KD_HISTOGRAMS} rounds of 32 shells it is {:.3} % on average and {:.3} % at most; neither number is in the thesis.",
                100.0 * mean,
                100.0 * most
            );
            Some((all(&[mean < 1e-3, most < 1e-3]), text))
        };
        Page {
            tables: vec![Table {
                title: "Relative error of the radius against that of the k-th neighbour".to_string(),
                columns: std::iter::once("map".to_string()).chain(columns).collect(),
                rows: cases.iter().map(row).collect(),
            }],
            claims: vec![Claim::judge(
                "“the resulting error of the final kNN radius is less than 0.1%” (2.3.3, of Zhou et al.)",
                judged(),
            )],
            note: "Without the last step that makes our search exact.",
            ..Page::default()
        }
    },
};
