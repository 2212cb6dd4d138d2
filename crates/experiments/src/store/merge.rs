//! Parts of a set of cases, measured anywhere, merged into what one process would have kept.

use super::{Header, Key, StoreOf, path_in};
use caustic_renderer::Part;
use std::collections::{HashMap, HashSet};
use std::fmt::Display;
use std::fs;
use std::path::PathBuf;

impl<C: Key + Display> StoreOf<C> {
    /// Writes the results in these folders, which may be given in any order, into `folder`: those of `cases`, in their order, so that the file does
    /// not depend on who measured what.
    ///
    /// # Errors
    /// A sentence, if results cannot be used, are of different machines, versions or ranges, or of other cases, two folders have the same, something
    /// is missing, or `folder` has other results.
    pub fn merge(folder: &std::path::Path, parts: &[PathBuf], cases: &[C]) -> Result<Self, String> {
        let known: HashSet<&C> = cases.iter().collect();
        let mut stores: Vec<(&PathBuf, Self)> = Vec::new();
        let mut holders: HashMap<C, &PathBuf> = HashMap::new();
        for part in parts {
            let store = Self::existing("--merge", part)?;
            if let Some((first, of_first)) = stores.first() {
                let same = |header: &Header| (header.machine.clone(), header.quick, header.part.map(|part| part.of));
                if same(&store.header) != same(&of_first.header) {
                    return Err(format!(
                        "{} has {}, but {} has {}; merge parts of one command, measured on machines of one kind",
                        part.display(),
                        store.header.whose(),
                        first.display(),
                        of_first.header.whose()
                    ));
                }
            }
            for case in &store.order {
                if !known.contains(case) {
                    return Err(format!(
                        "{} has a case that is none of these ({case}); merge with the arguments that its part was measured with",
                        part.display()
                    ));
                }
                if let Some(first) = holders.insert(case.clone(), part) {
                    let (first, second) = (first.display(), part.display());
                    return Err(format!("{first} and {second} both have {case}; give each part once"));
                }
            }
            stores.push((part, store));
        }
        let missing: Vec<&C> = cases.iter().filter(|case| !holders.contains_key(case)).collect();
        if let Some(first) = missing.first() {
            let headers: Vec<&Header> = stores.iter().map(|(_, store)| &store.header).collect();
            return Err(format!(
                "{} of {} cases are missing, such as {first}: {}, and merge again",
                missing.len(),
                cases.len(),
                remedy(&headers)
            ));
        }
        stores.sort_by_key(|(_, store)| store.header.part);
        let Some((_, first)) = stores.first() else { return Err("--merge: there is no folder".to_string()) };
        let commands = stores.iter().map(|(_, store)| store.header.command.as_str()).collect::<Vec<_>>().join("; ");
        let date = stores.iter().map(|(_, store)| &store.header.date).min().cloned().unwrap_or_default();
        let header = Header { part: None, command: commands, date, ..first.header.clone() };
        let path = path_in(folder);
        let mut merged = Self::empty(path.clone(), header);
        for case in cases {
            for (_, store) in &stores {
                if let Some(outcome) = store.outcome(case) {
                    merged.insert(case.clone(), outcome.clone(), store.found.get(case).cloned());
                }
            }
        }
        if fs::read_to_string(&path).is_ok_and(|text| merged.text().as_ref() != Ok(&text)) {
            return Err(format!("-o {}: this folder has other results; give another one", folder.display()));
        }
        fs::create_dir_all(folder)
            .map_err(|error| format!("-o {}: it cannot be a folder: {error}", folder.display()))?;
        merged.rewrite()?;
        Ok(merged)
    }
}

/// What to do about missing cases.
fn remedy(headers: &[&Header]) -> String {
    let numbers: Vec<Part> = headers.iter().filter_map(|header| header.part).collect();
    let of = numbers.first().map_or(0, |part| part.of);
    let absent = (1..=of).map(|number| Part { number, of }).filter(|part| !numbers.contains(part));
    match absent.map(|part| part.to_string()).collect::<Vec<_>>().join(", ") {
        none if none.is_empty() => "run what was interrupted to its end".to_string(),
        parts => format!("measure or add part {parts}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::Store;
    use crate::store::tests::{case, values};
    use caustic_bench::row::Machine;
    use caustic_device::Device;

    #[test]
    fn parts_in_any_order_are_the_results_of_one_process() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let machine = Machine::of(&Device::cpu());
        let cases: Vec<_> = (1..=7).map(|n| case(10 * n)).collect();
        let measured = |name: &str, machine: &Machine, part: Option<Part>, most: usize| {
            let mut store = Store::open(&at(name), machine, true, part, "caustic experiments").unwrap();
            for (i, case) in Part::share(part, cases.iter().enumerate()).take(most) {
                store.add(case, values(&[("build_ms", i as f64)]), Some(format!("{i:x}"))).unwrap();
            }
        };
        let part = |number| Some(Part { number, of: 3 });
        for (number, name) in [(1, "a"), (2, "b"), (3, "c")] {
            measured(name, &machine, part(number), 9);
        }
        measured("whole", &machine, None, 9);
        let merge = |into: &str, names: &[&str]| {
            let parts: Vec<_> = names.iter().map(|name| at(name)).collect();
            Store::merge(&at(into), &parts, &cases).map(|_| fs::read_to_string(path_in(&at(into))).unwrap())
        };
        let merged = merge("all", &["c", "a", "b"]).unwrap();
        assert_eq!(merge("all", &["a", "b", "c"]).unwrap(), merged);
        let whole = fs::read_to_string(path_in(&at("whole"))).unwrap();
        assert!(merged.lines().skip(1).eq(whole.lines().skip(1)), "{merged}");

        let error = |into: &str, names: &[&str]| merge(into, names).err().unwrap();
        assert!(error("new", &["a", "c"]).contains("2 of 7 cases are missing"));
        assert!(error("new", &["a", "c"]).contains("part 2/3"));
        assert!(error("new", &["a", "b", "c", "a"]).contains("give each part once"));
        assert!(error("a", &["a", "b", "c"]).contains("other results"));
        assert!(error("new", &["nowhere"]).contains("no results"));
        measured("late", &machine, part(3), 1);
        assert!(error("new", &["a", "b", "late"]).contains("interrupted"));
        measured("other", &Machine { commit: "another".to_string(), ..machine.clone() }, part(3), 9);
        assert!(error("new", &["a", "b", "other"]).contains("machines of one kind"));
        let fewer = Store::merge(&at("new"), &[at("a")], &cases[1..]).err().unwrap();
        assert!(fewer.contains("none of these"), "{fewer}");
        assert!(!at("new").exists(), "nothing is half written");
        // A folder of one part goes on as that part alone.
        let refused = Store::open(&at("a"), &machine, true, None, "caustic experiments").err().unwrap();
        assert!(refused.contains("part 1/3") && refused.contains("another folder"), "{refused}");
    }
}
