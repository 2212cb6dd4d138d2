//! Figures 29 and 30: the quality of pictures (section 5.5).

use super::{Figure, Page, Picture, Results, Table};
use crate::case::{Case, Map, What};
use crate::claim::{Claim, all};
use crate::picture;
use crate::scope::Scope;
use crate::subject::{BRUTE, CAUSTIC, CELLS, JENSEN, KD, KD_NEAREST, LINEAR, TESCHNER, named};

/// Who makes pictures; all are compared with the first.
const SUBJECTS: &[&str] = &[BRUTE, JENSEN, KD, KD_NEAREST, LINEAR, TESCHNER, CELLS, CAUSTIC];
/// Numbers of photons.
const SIZES: &[u32] = &[10_000, 50_000];
/// Whose pictures are shown, as in the thesis.
const SHOWN: [&str; 2] = [LINEAR, KD];

fn case(scope: &Scope, map: Map, photons: u32, subject: &str) -> Case {
    Case {
        what: What::Picture,
        subject: subject.to_string(),
        photons,
        radius_mm: 148,
        size: if scope.quick { [160, 120] } else { [400, 300] },
        ..scope.base(map)
    }
}

fn cases(scope: &Scope, map: Map, sizes: &[u32]) -> Vec<Case> {
    let of = |&photons: &u32| SUBJECTS.iter().map(move |subject| case(scope, map, photons, subject));
    sizes.iter().flat_map(of).collect()
}

pub(super) const FIG_29: Figure = Figure {
    id: "fig29",
    title: "Image quality, global photon map of 10,000 and 50,000 photons",
    section: "5.5",
    cases: |scope| cases(scope, Map::Global, SIZES),
    page: |results| page(results, Map::Global, SIZES),
};

pub(super) const FIG_30: Figure = Figure {
    id: "fig30",
    title: "Image quality, caustic photon map of 10,000 and 50,000 photons",
    section: "5.5",
    cases: |scope| cases(scope, Map::Caustic, SIZES),
    page: |results| page(results, Map::Caustic, SIZES),
};

fn page(results: &Results, map: Map, sizes: &[u32]) -> Page {
    let mut page = Page {
        note: "Direct visualisation of the map, a sample a pixel, k = 50 within 148 mm. Each picture is compared with that of brute force: by SHA-256 of its floats, and by Yee's metric.",
        ..Page::default()
    };
    let mut rows = Vec::new();
    let (mut equal, mut compared, mut seen) = (0, 0, Some(0.0));
    for &photons in sizes {
        let case = |subject: &str| case(&results.scope, map, photons, subject);
        let reference = results.store.found(&case(BRUTE));
        for subject in SUBJECTS {
            let case = case(subject);
            let label = named(subject).map_or(*subject, |subject| subject.label);
            let Some(found) = results.store.found(&case) else { continue };
            let differing = picture::perceptibly_different(results, &case, BRUTE);
            if let (Some(reference), false) = (reference, *subject == BRUTE) {
                compared += 1;
                equal += usize::from(found == reference);
                seen = seen.zip(differing).map(|(sum, pixels)| sum + pixels);
            }
            if SHOWN.contains(subject)
                && let Some(png) = picture::png(results, &case)
            {
                page.pictures.push(Picture { caption: format!("{label}, {photons} photons"), png });
            }
            let pixels = differing.map_or("–".to_string(), |pixels| format!("{pixels:.0}"));
            rows.push(vec![photons.to_string(), label.to_string(), found[..16].to_string(), pixels]);
        }
    }
    let columns = ["photons", "technique", "SHA-256 begins", "pixels that look different"];
    page.tables.push(Table {
        title: "Pictures compared with that of brute force".to_string(),
        columns: columns.map(str::to_string).into(),
        rows,
    });
    let judged = (compared > 0).then(|| {
        let looks = seen.map_or("Yee's metric was not computed".to_string(), |pixels| {
            format!("{pixels:.0} of their pixels look different")
        });
        let text = format!("{equal} of {compared} pictures have the bits of brute force's; {looks}.");
        (all(&[equal == compared, seen == Some(0.0)]), text)
    });
    page.claims
        .push(Claim::judge("“both techniques are identical in terms of quality and visual appearance” (5.5)", judged));
    page
}
