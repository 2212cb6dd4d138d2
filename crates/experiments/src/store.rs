//! Results as a file that grows by a line a case, so that whoever is interrupted goes on from there.

use crate::case::Case;
use caustic_bench::row::Machine;
use caustic_renderer::Part;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};
use std::fs::{self, File, OpenOptions};
use std::hash::Hash;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

mod merge;

/// Version of the format.
const FORMAT: u32 = 2;

/// What came of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// Numbers by name; the ending of a name is its unit.
    Values(BTreeMap<String, f64>),
    /// Why there are none.
    Skipped(String),
}

/// The first line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Version of the format.
    pub format: u32,
    /// Where it was measured, and with what.
    pub machine: Machine,
    /// Whether ranges were cut short.
    pub quick: bool,
    /// Which part of the cases, if they were shared out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<Part>,
    /// When it began, UTC.
    pub date: String,
    /// The commands that measured it.
    pub command: String,
}

impl Header {
    /// Whose results they are, for people.
    fn whose(&self) -> String {
        let quick = if self.quick { " with --quick" } else { "" };
        let part = self.part.map_or(String::new(), |part| format!(", part {part}"));
        format!("results of {} at commit {}{quick}{part}", self.machine.title(), self.machine.commit)
    }
}

/// A line.
#[derive(Serialize, Deserialize)]
struct Line<C> {
    case: C,
    outcome: Outcome,
    /// SHA-256 of what was found, where something was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    found: Option<String>,
}

/// What results are kept by.
pub trait Key: Clone + Eq + Hash + Serialize + DeserializeOwned {}

impl<C: Clone + Eq + Hash + Serialize + DeserializeOwned> Key for C {}

/// The results of the thesis's experiments.
pub type Store = StoreOf<Case>;

/// Results in a file, by cases of any kind.
pub struct StoreOf<C> {
    path: PathBuf,
    file: Option<File>,
    /// Where and how they were measured.
    pub header: Header,
    outcomes: HashMap<C, Outcome>,
    found: HashMap<C, String>,
    order: Vec<C>,
}

impl<C: Key> StoreOf<C> {
    /// Opens the results in `folder`, or begins them.
    ///
    /// # Errors
    /// If they cannot be read or written, or are those of another machine, version, range or part.
    pub fn open(
        folder: &Path,
        machine: &Machine,
        quick: bool,
        part: Option<Part>,
        command: &str,
    ) -> Result<Self, String> {
        let (machine_now, date) = (machine.clone(), caustic_bench::record::now());
        let header = Header { format: FORMAT, machine: machine_now, quick, part, date, command: command.to_string() };
        fs::create_dir_all(folder)
            .map_err(|error| format!("-o {}: it cannot be a folder: {error}", folder.display()))?;
        let path = path_in(folder);
        let mut store = match Self::read(folder) {
            Ok(store) => store,
            Err(None) => Self::empty(path.clone(), header.clone()),
            Err(Some(error)) => return Err(error),
        };
        let before = (&store.header.machine, store.header.quick, store.header.part);
        if before != (machine, quick, part) {
            return Err(format!(
                "`{}` has {}; give another folder with -o, or delete that file",
                path.display(),
                store.header.whose()
            ));
        }
        if !store.header.command.split("; ").any(|known| known == command) {
            store.header.command += &format!("; {command}");
        }
        // What was cut off in the middle of a line is written anew.
        store.rewrite()?;
        let file = OpenOptions::new().append(true).open(&path).map_err(|error| unwritable(&path, &error))?;
        store.file = Some(file);
        Ok(store)
    }

    /// Reads the results in the folder that `flag` names.
    ///
    /// # Errors
    /// If there are none, or they are unreadable.
    pub fn existing(flag: &str, folder: &Path) -> Result<Self, String> {
        let nothing = || format!("{flag} {}: there are no results in this folder", folder.display());
        Self::read(folder).map_err(|error| error.unwrap_or_else(nothing))
    }

    /// Reads the results in a folder. `None` if there are none.
    ///
    /// # Errors
    /// If they are unreadable.
    fn read(folder: &Path) -> Result<Self, Option<String>> {
        let path = path_in(folder);
        let text = fs::read_to_string(&path).map_err(|error| {
            (error.kind() != ErrorKind::NotFound).then(|| format!("cannot read `{}`: {error}", path.display()))
        })?;
        let mut lines = text.lines();
        let bad = |line: usize, error: &dyn std::fmt::Display| {
            Some(format!("line {line} of `{}` is no result ({error}); delete the file", path.display()))
        };
        let header: Header = match lines.next().map(serde_json::from_str) {
            Some(Ok(header)) => header,
            Some(Err(error)) => return Err(bad(1, &error)),
            None => return Err(None),
        };
        if header.format != FORMAT {
            return Err(bad(1, &format!("its format is {}, and this program reads {FORMAT}", header.format)));
        }
        let mut store = Self::empty(path.clone(), header);
        let whole = text.ends_with('\n');
        let last = text.lines().count();
        for (line, number) in lines.zip(2..) {
            match serde_json::from_str(line) {
                Ok(Line { case, outcome, found }) => store.insert(case, outcome, found),
                // Interrupted while it was written.
                Err(_) if number == last && !whole => {}
                Err(error) => return Err(bad(number, &error)),
            }
        }
        Ok(store)
    }

    fn empty(path: PathBuf, header: Header) -> Self {
        Self { path, file: None, header, outcomes: HashMap::new(), found: HashMap::new(), order: Vec::new() }
    }

    fn insert(&mut self, case: C, outcome: Outcome, found: Option<String>) {
        if let Some(found) = found {
            self.found.insert(case.clone(), found);
        }
        if self.outcomes.insert(case.clone(), outcome).is_none() {
            self.order.push(case);
        }
    }

    fn rewrite(&self) -> Result<(), String> {
        caustic_bench::record::write(&self.path, &self.text()?)
    }

    /// The file.
    fn text(&self) -> Result<String, String> {
        let mut text = line_of(&self.header)?;
        for case in &self.order {
            let (outcome, found) = (self.outcomes[case].clone(), self.found.get(case).cloned());
            text += &line_of(&Line { case: case.clone(), outcome, found })?;
        }
        Ok(text)
    }

    /// Adds what came of a case.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn add(&mut self, case: &C, outcome: Outcome, found: Option<String>) -> Result<(), String> {
        let text = line_of(&Line { case: case.clone(), outcome: outcome.clone(), found: found.clone() })?;
        if let Some(file) = &mut self.file {
            file.write_all(text.as_bytes())
                .and_then(|()| file.flush())
                .map_err(|error| unwritable(&self.path, &error))?;
        }
        self.insert(case.clone(), outcome, found);
        Ok(())
    }

    /// What came of a case.
    #[must_use]
    pub fn outcome(&self, case: &C) -> Option<&Outcome> {
        self.outcomes.get(case)
    }

    /// A number of a case.
    #[must_use]
    pub fn value(&self, case: &C, name: &str) -> Option<f64> {
        match self.outcome(case)? {
            Outcome::Values(values) => values.get(name).copied(),
            Outcome::Skipped(_) => None,
        }
    }

    /// SHA-256 of what a case found.
    #[must_use]
    pub fn found(&self, case: &C) -> Option<&str> {
        self.found.get(case).map(String::as_str)
    }

    /// All cases, in the order in which they were measured.
    pub fn cases(&self) -> impl Iterator<Item = (&C, &Outcome)> {
        self.order.iter().map(|case| (case, &self.outcomes[case]))
    }
}

fn path_in(folder: &Path) -> PathBuf {
    folder.join("results.jsonl")
}

fn line_of(value: &impl Serialize) -> Result<String, String> {
    serde_json::to_string(value).map(|text| text + "\n").map_err(|error| error.to_string())
}

fn unwritable(path: &Path, error: &std::io::Error) -> String {
    format!("cannot write `{}`: {error}", path.display())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::case::{Map, What};
    use caustic_device::Device;

    pub fn case(photons: u32) -> Case {
        let subject = "linear-list".to_string();
        Case { what: What::Speed, subject, map: Map::Global, photons, k: 50, radius_mm: 74, size: [64, 48] }
    }

    pub fn values(all: &[(&str, f64)]) -> Outcome {
        Outcome::Values(all.iter().map(|&(name, value)| (name.to_string(), value)).collect())
    }

    #[test]
    fn results_are_found_again_and_half_a_line_is_forgotten() {
        let folder = tempfile::tempdir().unwrap();
        let machine = Machine::of(&Device::cpu());
        let mut store = Store::open(folder.path(), &machine, true, None, "caustic experiments").unwrap();
        store.add(&case(10), values(&[("build_ms", 1.5)]), Some("ab".to_string())).unwrap();
        store.add(&case(20), Outcome::Skipped("too long".to_string()), None).unwrap();
        drop(store);
        let path = path_in(folder.path());
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, format!("{text}{{\"case\": {{\"wh")).unwrap();
        let mut store = Store::open(folder.path(), &machine, true, None, "caustic experiments").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
        assert_eq!((store.value(&case(10), "build_ms"), store.found(&case(10))), (Some(1.5), Some("ab")));
        assert_eq!((store.value(&case(20), "build_ms"), store.cases().count()), (None, 2));
        store.add(&case(30), values(&[]), None).unwrap();
        drop(store);
        let store = Store::open(folder.path(), &machine, true, None, "caustic experiments --only fig16").unwrap();
        assert_eq!(store.header.command, "caustic experiments; caustic experiments --only fig16");
        assert_eq!(Store::read(folder.path()).ok().unwrap().cases().count(), 3);
    }

    #[test]
    fn results_of_other_circumstances_are_refused_with_a_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let machine = Machine::of(&Device::cpu());
        drop(Store::open(folder.path(), &machine, true, None, "caustic experiments").unwrap());
        let error = |machine: &Machine, quick| {
            Store::open(folder.path(), machine, quick, None, "caustic experiments").err().unwrap()
        };
        assert!(error(&machine, false).contains("with --quick; give another folder"));
        let other = Machine { commit: "another".to_string(), ..machine.clone() };
        assert!(error(&other, true).contains("results.jsonl` has results of"));
        fs::write(path_in(folder.path()), "rubbish\n").unwrap();
        assert!(error(&machine, true).contains("line 1 of"));
    }
}
