//! Figures 17 and 26: memory accesses of the kernels, by a recorder (sections 5.3.1 and 5.3.4).

use super::sweep::{Sweep, Vary, ratios, rise, span};
use super::{Axis, Chart, Figure, Page, Results};
use crate::case::{Case, Map, What};
use crate::claim::{Claim, all};
use crate::scope::Scope;
use crate::subject::{CAUSTIC, KD, KD_NEAREST, LINEAR, TESCHNER};
use caustic_bench::power;

const NOTE: &str = "Counted by a recorder that runs the kernels on the CPU, 32 lanes together, and counts the 32-byte sectors that they touch at once beyond the \
    fewest that their loads and stores could take; the same whatever the device. Of many queries some are recorded, and counts are scaled to all.";

const TREES: Sweep = Sweep { map: Map::Global, vary: Vary::Photons, subjects: &[KD] };
const SIZES: Sweep =
    Sweep { map: Map::Global, vary: Vary::Size, subjects: &[KD, KD_NEAREST, LINEAR, TESCHNER, CAUSTIC] };
const CONSTRUCTION: Sweep = Sweep { map: Map::Global, vary: Vary::Photons, subjects: &[KD, LINEAR, TESCHNER, CAUSTIC] };

type Value = fn(&Results, &Case) -> Option<f64>;

/// A sweep over each map.
fn of_maps(sweep: Sweep) -> [Sweep; 2] {
    Map::ALL.map(|map| Sweep { map, ..sweep })
}

/// A plot for each map; claims are judged by the global one, of which the thesis speaks.
fn charts(results: &Results, sweep: Sweep, name: &str, title: &str, axis: Axis, value: Value) -> [Chart; 2] {
    of_maps(sweep).map(|sweep| {
        let map = sweep.map.name();
        sweep.chart(results, &format!("{name}-{map}"), &format!("{title}, {map} map"), axis, value)
    })
}

pub(super) const FIG_17: Figure = Figure {
    id: "fig17",
    title: "Local memory accesses of the kd-tree's traversal",
    section: "5.3.1",
    cases: |scope| recorded(TREES, scope),
    page: |results| {
        let local: Value = |results, case| results.store.value(&recording(case), "search_local/kd_radii");
        let grows = || {
            let rise = rise(&TREES.thesis_points(results, KD, local))?;
            Some((
                all(&[rise > 1.0]),
                format!("{rise:.2} times as many with the largest map of the range as with the smallest."),
            ))
        };
        Page {
            charts: charts(
                results,
                TREES,
                "local-accesses",
                "Accesses to the stack of the kd-tree's traversal over map size",
                Axis::Accesses,
                local,
            )
            .into(),
            claims: vec![Claim::judge(
                "Local memory accesses of the traversal “become significantly more with a larger photon map size” (5.3.1)",
                grows(),
            )],
            note: NOTE,
            ..Page::default()
        }
    },
};

pub(super) const FIG_26: Figure = Figure {
    id: "fig26",
    title: "Non-coalesced memory accesses",
    section: "5.3.4 and 5.1",
    cases: |scope| [recorded(SIZES, scope), recorded(CONSTRUCTION, scope)].concat(),
    page: |results| {
        let search: Value = |results, case| results.store.value(&recording(case), "search_excess_sectors");
        let build: Value = |results, case| results.store.value(&recording(case), "build_excess_sectors");
        let far = || {
            let of = |subject| SIZES.thesis_points(results, subject, search);
            let (kd, linear, teschner) = (of(KD), of(LINEAR), of(TESCHNER));
            let (low, high) = span(&[ratios(&kd, &linear)?, ratios(&kd, &teschner)?].concat());
            let text = format!(
                "a search in the kd-tree touches {low:.1} to {high:.1} times as many sectors beyond the fewest as one by the hashes; far more is at least 1.5 times."
            );
            Some((all(&[low > 1.0, low > 1.5]), text))
        };
        let linear_power = || {
            let kd = power(&SIZES.thesis_points(results, KD, search))?;
            let linear = power(&SIZES.thesis_points(results, LINEAR, search))?;
            Some((all(&[kd > linear]), format!("the kd-tree's grow as Q^{kd:.2}, the linear hash's as Q^{linear:.2}.")))
        };
        let construction = || {
            let of = |subject| CONSTRUCTION.thesis_points(results, subject, build);
            let (low, high) = span(&ratios(&of(KD), &of(LINEAR))?);
            Some((
                all(&[low > 1.0]),
                format!("construction of the kd-tree touches {low:.1} to {high:.1} times as many."),
            ))
        };
        Page {
            charts: [
                (SIZES, "uncoalesced-search", "Sectors beyond the fewest, search, over query size", search),
                (
                    CONSTRUCTION,
                    "uncoalesced-construction",
                    "Sectors beyond the fewest, construction, over map size",
                    build,
                ),
            ]
            .into_iter()
            .flat_map(|(sweep, name, title, value)| charts(results, sweep, name, title, Axis::Sectors, value))
            .collect(),
            claims: vec![
                Claim::judge(
                    "“the kD-Tree technique suffers from a far higher … non-coalesced memory accesses than our spatial hashing approach” (5.3.4)",
                    far(),
                ),
                Claim::judge("… and its increase with the query size is higher (5.3.4)", linear_power()),
                Claim::judge(
                    "“Another reason for the longer creation time is non-coalesced memory access” (5.1)",
                    construction(),
                ),
            ],
            note: NOTE,
            ..Page::default()
        }
    },
};

/// The recording of what a case does.
fn recording(case: &Case) -> Case {
    Case { what: What::Access, ..case.clone() }
}

/// Recordings of a sweep, up to what a recorder can do in its time.
fn recorded(sweep: Sweep, scope: &Scope) -> Vec<Case> {
    let (photons, queries) = if scope.quick { (50_000, 80_000) } else { (500_000, 800 * 600) };
    let affordable = |case: &Case| case.photons <= photons && case.queries() <= queries;
    let cases = of_maps(sweep).iter().flat_map(|sweep| sweep.cases(scope)).collect::<Vec<_>>();
    cases.iter().map(recording).filter(affordable).collect()
}
