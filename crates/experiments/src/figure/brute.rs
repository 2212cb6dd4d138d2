//! Figure 28 and Table 3: brute force (section 5.4).

use super::results::search_ms;
use super::sweep::{Vary, rise, span};
use super::{Axis, Chart, Figure, Line, Page, Results, Table};
use crate::case::{Case, Map};
use crate::claim::{Claim, all};
use crate::scope::Scope;
use crate::subject::{BRUTE, BRUTE_COMB, KD, LINEAR, SUBJECTS, named};

/// Photons of figure 28: the thesis had at most 2¹⁶.
const PHOTONS: u32 = 10_000;
/// Photons, and queries as a picture, of Table 3: 4800 each.
const TABLE: (u32, [u32; 2]) = (4800, [80, 60]);
/// Its k. The thesis's copies at hand have lost the first.
const TABLE_KS: [u32; 3] = [5, 10, 20];

const VARIED: [(Vary, &str); 3] = [(Vary::Radius, "query radius"), (Vary::K, "k"), (Vary::Size, "query size")];

fn base(scope: &Scope, subject: &str) -> Case {
    Case { photons: PHOTONS, subject: subject.to_string(), ..scope.base(Map::Global) }
}

/// Within the thesis's ranges: what is beyond takes hours.
fn range(scope: &Scope, vary: Vary, subject: &str) -> Vec<Case> {
    let mut cases = vary.range(scope, &base(scope, subject));
    cases.retain(|case| vary.of(case) <= vary.thesis_to());
    cases
}

fn points(results: &Results, vary: Vary, subject: &str) -> Vec<(f64, f64)> {
    let cases = range(&results.scope, vary, subject);
    cases.iter().filter_map(|case| Some((vary.of(case), search_ms(results, case)?))).collect()
}

pub(super) const FIG_28: Figure = Figure {
    id: "fig28",
    title: "Brute force with different radii, k and query sizes",
    section: "5.4",
    cases: |scope| {
        let of = |subject| VARIED.iter().flat_map(move |(vary, _)| range(scope, *vary, subject));
        let beside = [KD, LINEAR].map(|subject| base(scope, subject));
        let beside = beside.into_iter().chain(range(scope, Vary::Size, LINEAR));
        of(BRUTE).chain(beside).collect()
    },
    page: |results| {
        let chart = |&(vary, over): &(Vary, &str)| {
            let line = |name: &str| {
                let place = SUBJECTS.iter().position(|subject| subject.name == name)?;
                let points = points(results, vary, name);
                (!points.is_empty()).then_some(Line {
                    subject: place,
                    label: SUBJECTS[place].label.to_string(),
                    points,
                })
            };
            Chart {
                name: format!("brute-{}", over.replace(' ', "-")),
                title: format!("Brute force over {over}, {PHOTONS} photons"),
                axes: [vary.axis(), Axis::Time],
                thesis_to: None,
                lines: line(BRUTE).into_iter().collect(),
            }
        };
        let independent = || {
            let (low, high) = span(&points(results, Vary::Radius, BRUTE));
            let change = high / low;
            (low > 0.0).then(|| {
                (
                    all(&[change < 1.1]),
                    format!(
                        "its slowest radius takes {change:.2} times as long as its fastest; independent is up to 1.1."
                    ),
                )
            })
        };
        let by_k = || {
            let rise = rise(&points(results, Vary::K, BRUTE))?;
            let text =
                format!("from k = 10 to 50 it takes {:.0} % longer; roughly 20 is 10 to 40.", 100.0 * (rise - 1.0));
            Some((all(&[rise > 1.0, (1.1..1.4).contains(&rise)]), text))
        };
        let size = || {
            let (brute, linear) = (points(results, Vary::Size, BRUTE), points(results, Vary::Size, LINEAR));
            let queries = brute.last()?.0 / brute.first()?.0;
            let (brute, linear) = (rise(&brute)?, rise(&linear)?);
            let text = format!(
                "{queries:.0} times the queries take brute force {brute:.1} times and the linear hash {linear:.1} times as long."
            );
            Some((all(&[brute > linear]), text))
        };
        let ten = || {
            let at = |subject: &str| search_ms(results, &base(&results.scope, subject));
            let (brute, kd, linear) = (at(BRUTE)?, at(KD)?, at(LINEAR)?);
            let text = format!(
                "with {PHOTONS} photons it takes {:.1} times as long as the kd-tree and {:.1} times as long as the linear hash.",
                brute / kd,
                brute / linear
            );
            Some((all(&[brute > 8.0 * kd, brute > 8.0 * linear]), text))
        };
        Page {
            charts: VARIED.iter().map(chart).collect(),
            claims: vec![
                Claim::judge("“the technique is completely independent from the query radius” (5.4)", independent()),
                Claim::judge(
                    "“between … 10 and 50 photons per sample, computation time still rises by roughly 20%” (5.4)",
                    by_k(),
                ),
                Claim::judge("Larger query sizes cost brute force more than they cost hashing (5.4)", size()),
                Claim::judge(
                    "“In a best case scenario the brute force approach was almost 10 times slower than the kD-Tree and the spatial hashing methods” (5.3)",
                    ten(),
                ),
            ],
            note: "By the stages' own clock on a GPU, by the wall clock on a CPU. Queries are searched in parts that fit the memory for distances, without the limit of 2¹⁶.",
            ..Page::default()
        }
    },
};

fn table_case(scope: &Scope, k: u32, subject: &str) -> Case {
    let (photons, size) = TABLE;
    Case { photons, k, size, ..base(scope, subject) }
}

pub(super) const TABLE_3: Figure = Figure {
    id: "table3",
    title: "Decomposition of brute force",
    section: "5.4",
    cases: |scope| {
        // What comb sort takes does not depend on k.
        let comb = table_case(scope, TABLE_KS[1], BRUTE_COMB);
        TABLE_KS.iter().map(|&k| table_case(scope, k, BRUTE)).chain([comb]).collect()
    },
    page: |results| {
        let share = |k: u32, subject: &str, part: &str| {
            let case = table_case(&results.scope, k, subject);
            let of = |stage: &str| results.store.value(&case, &format!("search/{stage}_ms"));
            let parts = parts();
            let sum: f64 = parts.iter().flat_map(|(_, stages)| stages.iter()).filter_map(|stage| of(stage)).sum();
            let stages = parts.iter().find(|(name, _)| *name == part)?.1;
            let values: Vec<f64> = stages.iter().filter_map(|stage| of(stage)).collect();
            (sum > 0.0 && !values.is_empty()).then(|| values.iter().sum::<f64>() / sum)
        };
        let row = |(subject, part): (&'static str, &'static str)| {
            let label = named(subject).map_or(subject, |subject| subject.label);
            let cells = TABLE_KS
                .iter()
                .map(|&k| share(k, subject, part).map_or("–".to_string(), |share| format!("{:.0} %", 100.0 * share)));
            [label.to_string(), part.to_string()].into_iter().chain(cells).collect::<Vec<_>>()
        };
        let rows = [BRUTE, BRUTE_COMB]
            .into_iter()
            .flat_map(|subject| ["distance", "sort", "copy"].map(|part| (subject, part)));
        let grows = || {
            let [first, .., last] = TABLE_KS;
            let [least, most] = [share(first, BRUTE, "sort")?, share(last, BRUTE, "sort")?];
            let text = format!(
                "sorting takes {:.0} % at k = {first} and {:.0} % at k = {last}; the thesis has 15 % and 47 %.",
                100.0 * least,
                100.0 * most
            );
            Some((all(&[most > least, most < 0.5]), text))
        };
        Page {
            tables: vec![Table {
                title: "Share of each step, 4800 photons and 4800 queries".to_string(),
                columns: ["technique", "step"]
                    .into_iter()
                    .map(str::to_string)
                    .chain(TABLE_KS.iter().map(|k| format!("k = {k}")))
                    .collect(),
                rows: rows.map(row).collect(),
            }],
            claims: vec![Claim::judge(
                "Table 3: the share of sorting grows with k, that of distances stays the largest (5.4)",
                grows(),
            )],
            note: "Shares of the stages' time. The k of the thesis's first column is illegible; 5 is assumed. A lane sorts a column, so that sorting has 4800 lanes: \
                150 for each of the 32 cores of the thesis's GeForce 9600M GT, less than a third of one for each of an H100's 16,896.",
            ..Page::default()
        }
    },
};

/// The stages of each step.
fn parts() -> [(&'static str, &'static [&'static str]); 3] {
    [
        ("distance", &["brute_distance"]),
        ("sort", &["brute_insertion_sort", "brute_comb_sort"]),
        ("copy", &["brute_copy"]),
    ]
}
