//! Figures 12 and 13: construction time (section 5.1).

use super::results::build_ms;
use super::sweep::{Sweep, Vary, ratios, span};
use super::{Axis, Figure, Page, Results};
use crate::case::{Case, Map};
use crate::claim::{Claim, all};
use crate::scope::Scope;
use crate::subject::{BRUTE, CAUSTIC, CAUSTIC_MORTON, JENSEN, KD, LINEAR, TESCHNER};
use caustic_bench::power;

const SUBJECTS: &[&str] = &[BRUTE, JENSEN, KD, LINEAR, TESCHNER, CAUSTIC, CAUSTIC_MORTON];
const GLOBAL: Sweep = Sweep { map: Map::Global, vary: Vary::Photons, subjects: SUBJECTS };
const CAUSTIC_MAP: Sweep = Sweep { map: Map::Caustic, ..GLOBAL };

pub(super) const FIG_12: Figure = Figure {
    id: "fig12",
    title: "Construction time, global photon map",
    section: "5.1",
    cases: |scope| cases(scope, &GLOBAL),
    page: |results| page(results, &GLOBAL),
};

pub(super) const FIG_13: Figure = Figure {
    id: "fig13",
    title: "Construction time, caustic photon map",
    section: "5.1",
    cases: |scope| [cases(scope, &GLOBAL), cases(scope, &CAUSTIC_MAP)].concat(),
    page: |results| {
        let mut page = page(results, &CAUSTIC_MAP);
        page.claims.push(same_for_both(results));
        page
    },
};

/// Brute force builds nothing, and its search of large maps is for figure 28 to show.
fn cases(scope: &Scope, sweep: &Sweep) -> Vec<Case> {
    let most = if scope.gpu { 50_000 } else { 10_000 };
    let affordable = |case: &Case| case.subject != BRUTE || case.photons <= most;
    sweep.cases(scope).into_iter().filter(affordable).collect()
}

fn page(results: &Results, sweep: &Sweep) -> Page {
    let name = format!("construction-{}", sweep.map.name());
    let title = format!("Construction time over map size, {} map", sweep.map.name());
    // What takes no time has no place on a logarithmic axis.
    let built = |results: &Results, case: &Case| build_ms(results, case).filter(|_| case.subject != BRUTE);
    let chart = sweep.chart(results, &name, &title, Axis::Time, built);
    let points = |subject| sweep.thesis_points(results, subject, build_ms);
    let (linear, teschner, kd) = (points(LINEAR), points(TESCHNER), points(KD));
    let constant = || {
        let (linear, teschner) = (power(&linear)?, power(&teschner)?);
        let text = format!(
            "time grows as N^{linear:.2} (linear) and N^{teschner:.2} (Teschner); constant is N^0, and we say almost up to N^0.25."
        );
        Some((all(&[linear < 0.25, teschner < 0.25]), text))
    };
    let faster = || {
        let ratios = [ratios(&kd, &linear)?, ratios(&kd, &teschner)?].concat();
        let (low, high) = span(&ratios);
        let text =
            format!("the kd-tree takes {low:.1} to {high:.1} times as long as the hashes; much is at least twice.");
        Some((all(&[low > 1.0, low > 2.0]), text))
    };
    let increases = || {
        let kd = power(&kd)?;
        Some((all(&[kd > 0.25]), format!("its time grows as N^{kd:.2}.")))
    };
    Page {
        charts: vec![chart],
        claims: vec![
            Claim::judge("“our hash table creation takes almost constant time” (5.1)", constant()),
            Claim::judge("“spatial hashing … is much faster than the kD-Tree approach” (5.1)", faster()),
            Claim::judge("“The kD-Tree construction cost increases with the amount of photons” (5.1)", increases()),
        ],
        note: "From photons on the device to an index that can be searched, by the wall clock: allocations, all stages and waiting for them. Brute force builds nothing.",
        ..Page::default()
    }
}

fn same_for_both(results: &Results) -> Claim {
    let judge = || {
        let mut all_ratios = Vec::new();
        for subject in [LINEAR, TESCHNER, KD] {
            let [caustic, global] = [CAUSTIC_MAP, GLOBAL].map(|sweep| sweep.thesis_points(results, subject, build_ms));
            all_ratios.extend(ratios(&caustic, &global)?);
        }
        let (low, high) = span(&all_ratios);
        let text = format!(
            "caustic maps take {low:.2} to {high:.2} times the time of global ones of the same size; almost is 0.8 to 1.25."
        );
        Some((all(&[low > 0.8, high < 1.25]), text))
    };
    Claim::judge("“the measurements are almost identical for caustic photon maps” (5.1)", judge())
}
