//! Results for other programs.

use super::Made;
use crate::store::{Outcome, Store};
use serde_json::{Value, json as value};
use std::collections::BTreeSet;

/// A line for each case; a column for each number that some case has.
#[must_use]
pub fn csv(store: &Store) -> String {
    let mut names = BTreeSet::new();
    for (_, outcome) in store.cases() {
        if let Outcome::Values(values) = outcome {
            names.extend(values.keys().map(String::as_str));
        }
    }
    let mut text = "what,subject,map,photons,k,radius_mm,width,height".to_string();
    for name in &names {
        text += &format!(",{name}");
    }
    text += ",sha256,skipped\n";
    for (case, outcome) in store.cases() {
        let what = format!("{:?}", case.what).to_lowercase();
        let [width, height] = case.size;
        let map = case.map.name();
        text +=
            &format!("{what},{},{map},{},{},{},{width},{height}", case.subject, case.photons, case.k, case.radius_mm);
        for name in &names {
            let number = store.value(case, name).map_or(String::new(), |number| format!("{}", rounded(number)));
            text += &format!(",{number}");
        }
        let skipped = match outcome {
            Outcome::Skipped(reason) => format!("\"{}\"", reason.replace('"', "\"\"")),
            Outcome::Values(_) => String::new(),
        };
        text += &format!(",{},{skipped}\n", store.found(case).map_or("", |found| &found[..found.len().min(16)]));
    }
    text
}

/// Six digits: more than a clock can tell. Whole numbers stay whole.
fn rounded(number: f64) -> f64 {
    if number.fract() == 0.0 { number } else { format!("{number:.5e}").parse().unwrap_or(number) }
}

/// Where it was measured, what was claimed and what holds, and every case.
#[must_use]
pub fn json(store: &Store, made: &[Made]) -> String {
    let figure = |made: &Made| {
        value!({
            "id": made.figure.id,
            "title": made.figure.title,
            "section": made.figure.section,
            "claims": made.page.claims,
            "charts": made.page.charts,
            "tables": made.page.tables,
            "skipped": made.skipped,
        })
    };
    let case = |(case, outcome): (&crate::case::Case, &Outcome)| value!({ "case": case, "outcome": outcome, "sha256": store.found(case) });
    let all: Value = value!({
        "header": store.header,
        "figures": made.iter().map(figure).collect::<Vec<_>>(),
        "cases": store.cases().map(case).collect::<Vec<_>>(),
    });
    format!("{all:#}\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::tests::{case, values};
    use caustic_bench::row::Machine;
    use caustic_device::Device;

    #[test]
    fn every_line_has_every_column() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(folder.path(), &Machine::of(&Device::cpu()), true, None, "").unwrap();
        store.add(&case(10), values(&[("build_ms", 1.234_567_89), ("a", 3.0)]), Some("f".repeat(64))).unwrap();
        store.add(&case(20), values(&[("search_ms", 2.0)]), None).unwrap();
        store.add(&case(30), Outcome::Skipped("it says \"no\"".to_string()), None).unwrap();
        let text = csv(&store);
        let columns: Vec<_> = text.lines().map(|line| line.split(',').count()).collect();
        assert_eq!(columns, [13; 4], "{text}");
        assert!(text.contains(",3,1.23457,,ffffffffffffffff,") && text.contains("\"it says \"\"no\"\"\""), "{text}");
        assert!(json(&store, &[]).contains("\"photons\": 10"));
    }
}
