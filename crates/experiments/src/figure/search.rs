//! Figures 16, 18, 20 to 23, 25 and 27: search time (section 5.3).

use super::results::search_ms;
use super::sweep::{Sweep, Vary, ratios, rise, span};
use super::{Axis, Figure, Page, Results};
use crate::case::Map;
use crate::claim::{Claim, Verdict, all};
use crate::subject::{
    CAUSTIC, CAUSTIC_MORTON, JENSEN, KD, KD_NEAREST, LINEAR, LINEAR_HEAP, LINEAR_IN_ORDER, TESCHNER, TESCHNER_HEAP,
    TESCHNER_IN_ORDER, TESCHNER_LARGE,
};
use caustic_bench::power;

const RIVALS: &[&str] = &[JENSEN, KD, KD_NEAREST, LINEAR, TESCHNER, CAUSTIC];
const SIZES: &[&str] = &[JENSEN, KD, KD_NEAREST, LINEAR, TESCHNER, TESCHNER_LARGE, CAUSTIC, CAUSTIC_MORTON];
const KS: &[&str] = &[JENSEN, KD, KD_NEAREST, LINEAR, LINEAR_HEAP, TESCHNER, TESCHNER_HEAP, CAUSTIC];
const RADII: &[&str] = &[JENSEN, KD, KD_NEAREST, LINEAR, LINEAR_IN_ORDER, TESCHNER, TESCHNER_IN_ORDER, CAUSTIC];

const fn sweep(map: Map, vary: Vary, subjects: &'static [&'static str]) -> Sweep {
    Sweep { map, vary, subjects }
}

const PHOTONS_GLOBAL: Sweep = sweep(Map::Global, Vary::Photons, SIZES);
const PHOTONS_CAUSTIC: Sweep = sweep(Map::Caustic, Vary::Photons, SIZES);
const K_GLOBAL: Sweep = sweep(Map::Global, Vary::K, KS);
const K_CAUSTIC: Sweep = sweep(Map::Caustic, Vary::K, KS);
const RADIUS_GLOBAL: Sweep = sweep(Map::Global, Vary::Radius, RADII);
const RADIUS_CAUSTIC: Sweep = sweep(Map::Caustic, Vary::Radius, RADII);
const SIZE_GLOBAL: Sweep = sweep(Map::Global, Vary::Size, RIVALS);
const SIZE_CAUSTIC: Sweep = sweep(Map::Caustic, Vary::Size, RIVALS);

type Judged = Option<(Verdict, String)>;

fn page(results: &Results, sweep: &Sweep, over: &str, claims: Vec<Claim>) -> Page {
    let map = sweep.map.name();
    let name = format!("search-{}-{map}", over.replace(' ', "-"));
    let title = format!("Search time over {over}, {map} map");
    let chart = sweep.chart(results, &name, &title, Axis::Time, search_ms);
    Page { charts: vec![chart], claims, ..Page::default() }
}

fn points(results: &Results, sweep: &Sweep, subject: &str) -> Vec<(f64, f64)> {
    sweep.thesis_points(results, subject, search_ms)
}

/// How many times the time of one subject another takes, least and greatest.
fn times(results: &Results, sweep: &Sweep, slow: &str, fast: &str) -> Option<(f64, f64)> {
    Some(span(&ratios(&points(results, sweep, slow), &points(results, sweep, fast))?))
}

fn faster(results: &Results, sweep: &Sweep, slow: &str, fast: &str) -> Judged {
    let (low, high) = times(results, sweep, slow, fast)?;
    Some((all(&[low > 1.0, high > 1.0]), format!("the other takes {low:.2} to {high:.2} times as long.")))
}

pub(super) const FIG_16: Figure = Figure {
    id: "fig16",
    title: "Search time with different map sizes, global photon map",
    section: "5.3.1",
    cases: |scope| PHOTONS_GLOBAL.cases(scope),
    page: |results| {
        let collisions = || {
            let beyond = |subject| {
                let points = points(results, &PHOTONS_GLOBAL, subject);
                power(&points.into_iter().filter(|point| point.0 >= 200_000.0).collect::<Vec<_>>())
            };
            let (teschner, linear) = (beyond(TESCHNER)?, beyond(LINEAR)?);
            let text = format!("beyond 200,000 photons it grows as N^{teschner:.2}, the linear hash as N^{linear:.2}.");
            Some((all(&[teschner > linear + 0.02]), text))
        };
        let larger = || {
            let (low, high) = times(results, &PHOTONS_GLOBAL, TESCHNER, TESCHNER_LARGE)?;
            let text =
                format!("2¹⁶ entries take {low:.2} to {high:.2} times as long as 2²⁰; greatly is at least 1.2 times.");
            Some((all(&[high > 1.0, high > 1.2]), text))
        };
        let steady = || {
            let p = power(&points(results, &PHOTONS_GLOBAL, LINEAR))?;
            Some((all(&[p > 0.0]), format!("its time grows as N^{p:.2}.")))
        };
        let claims = vec![
            Claim::judge(
                "Teschner: “a slight increase in search time with photon maps larger than 200,000 … caused by collisions” (5.3.1)",
                collisions(),
            ),
            Claim::judge(
                "“the performance with bigger photon maps can be greatly improved by simply using a larger hash table size” (5.3.1)",
                larger(),
            ),
            Claim::judge(
                "“using the linear hashing function … we have a steady growth in search time for larger photon maps” (5.3.1)",
                steady(),
            ),
            Claim::judge(
                "The linear hash is faster than the kd-tree at every size (figure 16)",
                faster(results, &PHOTONS_GLOBAL, KD, LINEAR),
            ),
        ];
        page(results, &PHOTONS_GLOBAL, "map size", claims)
    },
};

pub(super) const FIG_18: Figure = Figure {
    id: "fig18",
    title: "Search time with different map sizes, caustic photon map",
    section: "5.3.1",
    cases: |scope| [PHOTONS_GLOBAL.cases(scope), PHOTONS_CAUSTIC.cases(scope)].concat(),
    page: |results| {
        let slower = || {
            let of = |subject| {
                let both = [PHOTONS_CAUSTIC, PHOTONS_GLOBAL].map(|sweep| points(results, &sweep, subject));
                let [caustic, global] = both;
                // Beyond a handful of photons.
                Some(ratios(&caustic, &global)?.last()?.1)
            };
            let [kd, linear, teschner] = [of(KD)?, of(LINEAR)?, of(TESCHNER)?];
            let text = format!(
                "on the largest map of the thesis's range the kd-tree takes {kd:.2}, the linear hash {linear:.2} and Teschner's {teschner:.2} times as long as on the global one."
            );
            Some((all(&[kd > 1.0, linear > 1.0, teschner > 1.0]), text))
        };
        let claims = vec![
            Claim::judge(
                "“all methods … need more time to find photons, than they need with a global photon map” (5.3.1)",
                slower(),
            ),
            Claim::judge(
                "“Teschner's hashing function … is significantly faster than the kD-Tree technique” (5.3.1)",
                faster(results, &PHOTONS_CAUSTIC, KD, TESCHNER),
            ),
            Claim::judge(
                "The linear hash, without collisions, “performs better” than Teschner's (5.3.1)",
                faster(results, &PHOTONS_CAUSTIC, TESCHNER, LINEAR),
            ),
        ];
        page(results, &PHOTONS_CAUSTIC, "map size", claims)
    },
};

pub(super) const FIG_20: Figure = Figure {
    id: "fig20",
    title: "Search time with different k, global photon map",
    section: "5.3.2",
    cases: |scope| K_GLOBAL.cases(scope),
    page: |results| page(results, &K_GLOBAL, "k", by_k(results, &K_GLOBAL)),
};

pub(super) const FIG_21: Figure = Figure {
    id: "fig21",
    title: "Search time with different k, caustic photon map",
    section: "5.3.2",
    cases: |scope| K_CAUSTIC.cases(scope),
    page: |results| {
        let mut claims = by_k(results, &K_CAUSTIC);
        let jump = |subject, from: f64, to: f64| {
            let points = points(results, &K_CAUSTIC, subject);
            let at = |x: f64| points.iter().find(|point| point.0 == x).map(|point| point.1);
            // What the step costs beside the dearest other step.
            let step = at(to)? / at(from)?;
            let others = points.windows(2).filter(|pair| pair[0].0 != from).map(|pair| pair[1].1 / pair[0].1);
            let dearest = others.fold(0.0, f64::max);
            let text = format!(
                "from {from} to {to} it takes {step:.2} times as long; the dearest other step of ten is {dearest:.2}."
            );
            Some((all(&[step > dearest]), text))
        };
        claims.push(Claim::judge(
            "The linear hash has “a significant performance drop when changing the sample size from 30 to 40” (5.3.2)",
            jump(LINEAR, 30.0, 40.0),
        ));
        claims.push(Claim::judge(
            "Teschner's hash has “a significant performance drop, this time between sample sizes of 10 and 20” (5.3.2)",
            jump(TESCHNER, 10.0, 20.0),
        ));
        page(results, &K_CAUSTIC, "k", claims)
    },
};

fn by_k(results: &Results, sweep: &Sweep) -> Vec<Claim> {
    let big = || {
        let (kd, linear) = (rise(&points(results, sweep, KD))?, rise(&points(results, sweep, LINEAR))?);
        let text = format!(
            "from k = 10 to 50 the kd-tree takes {kd:.2} times and the linear hash with its list {linear:.2} times as long; pretty big is at least 1.3."
        );
        Some((all(&[kd > 1.3, linear > 1.3]), text))
    };
    let heap = || {
        let linear = ratios(&points(results, sweep, LINEAR), &points(results, sweep, LINEAR_HEAP))?;
        let (low, high) = span(&linear);
        let at_most = linear.last()?;
        let text = format!(
            "the list takes {low:.2} to {high:.2} times as long as the heap, {:.2} times at k = {}.",
            at_most.1, at_most.0
        );
        Some((all(&[low > 1.0, high > 1.0]), text))
    };
    vec![
        Claim::judge(
            "“the k parameter has a pretty big influence on the performance with both techniques” (5.3.2)",
            big(),
        ),
        Claim::judge(
            "“better performance can be achieved with … a heap data structure” than with the sorted list (3.1.3)",
            heap(),
        ),
        Claim::judge(
            "The linear hash is faster than the kd-tree (figures 20 and 21)",
            faster(results, sweep, KD, LINEAR),
        ),
    ]
}

pub(super) const FIG_22: Figure = Figure {
    id: "fig22",
    title: "Search time with different query radii, global photon map",
    section: "5.3.3",
    cases: |scope| RADIUS_GLOBAL.cases(scope),
    page: |results| {
        let steady = || {
            let rises = [KD, LINEAR, TESCHNER].map(|subject| rise(&points(results, &RADIUS_GLOBAL, subject)));
            let [kd, linear, teschner] = [rises[0]?, rises[1]?, rises[2]?];
            let text = format!(
                "over the range of radii the kd-tree takes {kd:.2}, the linear hash {linear:.2} and Teschner's {teschner:.2} times as long."
            );
            Some((all(&[kd > 1.0, linear > 1.0, teschner > 1.0]), text))
        };
        let claims = vec![
            Claim::judge(
                "“all techniques have an almost steady increase in search time with an increasing query radius” (5.3.3)",
                steady(),
            ),
            Claim::judge(
                "“the spatial hashing method, using the linear hashing function, is faster” (5.3.3)",
                faster(results, &RADIUS_GLOBAL, KD, LINEAR),
            ),
        ];
        page(results, &RADIUS_GLOBAL, "query radius", claims)
    },
};

pub(super) const FIG_23: Figure = Figure {
    id: "fig23",
    title: "Search time with different query radii, caustic photon map",
    section: "5.3.3",
    cases: |scope| [RADIUS_GLOBAL.cases(scope), RADIUS_CAUSTIC.cases(scope)].concat(),
    page: |results| {
        let steeper = || {
            let of = |sweep: &Sweep| rise(&points(results, sweep, KD));
            let (caustic, global) = (of(&RADIUS_CAUSTIC)?, of(&RADIUS_GLOBAL)?);
            let text = format!(
                "the kd-tree takes {caustic:.2} times as long over the range of radii here, and {global:.2} times on the global map."
            );
            Some((all(&[caustic > global]), text))
        };
        let centre = |sweep: Sweep| {
            let mut all_ratios = ratios(&points(results, &sweep, LINEAR_IN_ORDER), &points(results, &sweep, LINEAR))?;
            all_ratios.extend(ratios(&points(results, &sweep, TESCHNER_IN_ORDER), &points(results, &sweep, TESCHNER))?);
            let saved = |ratio: f64| 100.0 * (1.0 - 1.0 / ratio);
            let (low, high) = span(&all_ratios);
            let mean = all_ratios.iter().map(|point| saved(point.1)).sum::<f64>() / all_ratios.len() as f64;
            let text = format!(
                "{:.0} to {:.0} %, {mean:.0} % on average over radii and both hashes. Our walk leaves cells out that the farthest candidate does not reach, and a near one found first leaves out more.",
                saved(low),
                saved(high)
            );
            Some((all(&[mean > 0.0, mean >= 10.0]), text))
        };
        let claims = vec![
            Claim::judge(
                "The kd-tree shows “a steeper increase of search time with an increasing search radius” (5.3.3)",
                steeper(),
            ),
            Claim::judge(
                "Visiting the centre cell first “improves search time by around 15 percent” (5.3.3)",
                centre(RADIUS_CAUSTIC),
            ),
            Claim::judge("… and on global maps, too (5.3.3: “generally”)", centre(RADIUS_GLOBAL)),
            Claim::judge(
                "“Our spatial hashing technique is dealing better with the high photon density” (5.3.3)",
                faster(results, &RADIUS_CAUSTIC, KD, LINEAR),
            ),
        ];
        page(results, &RADIUS_CAUSTIC, "query radius", claims)
    },
};

pub(super) const FIG_25: Figure = Figure {
    id: "fig25",
    title: "Search time with different query sizes, global photon map",
    section: "5.3.4",
    cases: |scope| SIZE_GLOBAL.cases(scope),
    page: |results| {
        let close = || {
            let ratios = ratios(&points(results, &SIZE_GLOBAL, KD), &points(results, &SIZE_GLOBAL, LINEAR))?;
            let (first, last) = (ratios.first()?.1, ratios.last()?.1);
            let text = format!(
                "the kd-tree takes {first:.2} times as long at the lowest resolution and {last:.2} times at the highest; hardly any difference is up to 1.25, a growing gap at least a tenth more."
            );
            Some((all(&[first < 1.25, last > 1.1 * first]), text))
        };
        let same = || {
            let (low, high) = times(results, &SIZE_GLOBAL, TESCHNER, LINEAR)?;
            let text = format!("Teschner's takes {low:.2} to {high:.2} times as long; almost identical is 0.9 to 1.1.");
            Some((all(&[low > 0.9, high < 1.1]), text))
        };
        let claims = vec![
            Claim::judge(
                "“for low resolutions, there is hardly any difference … the higher the resolution gets, the bigger grows the gap” (5.3.4)",
                close(),
            ),
            Claim::judge("“Both hashing functions obtain almost identical results” (5.3.4)", same()),
        ];
        page(results, &SIZE_GLOBAL, "query size", claims)
    },
};

pub(super) const FIG_27: Figure = Figure {
    id: "fig27",
    title: "Search time with different query sizes, caustic photon map",
    section: "5.3.4",
    cases: |scope| SIZE_CAUSTIC.cases(scope),
    page: |results| {
        let gap = || {
            let at = |subject| points(results, &SIZE_CAUSTIC, subject).last().copied();
            let (kd, linear, teschner) = (at(KD)?, at(LINEAR)?, at(TESCHNER)?);
            let (linear, teschner) = (kd.1 / linear.1, kd.1 / teschner.1);
            let text = format!(
                "the kd-tree takes {linear:.2} times the linear hash's time and {teschner:.2} times Teschner's with {} queries; 75 % faster is 1.75 times.",
                kd.0
            );
            Some((all(&[linear > 1.75, teschner > 1.75]), text))
        };
        let says =
            "“the spatial hashing methods being more than 75% faster at a resolution of 1280 x 1024 pixels” (5.3.4)";
        page(results, &SIZE_CAUSTIC, "query size", vec![Claim::judge(says, gap())])
    },
};
