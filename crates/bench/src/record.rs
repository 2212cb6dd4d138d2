//! Records: what was measured where and when, as files that are kept, and the table that is made of them.

mod date;
mod table;

pub use date::now;
pub use table::{BEGIN, END, into_text, replace_in, table};

use crate::files;
use crate::report::{Growth, growth};
use crate::row::{Machine, Row};
use crate::suite::Suite;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Version of the format of records.
const FORMAT: u32 = 1;
/// Digits that are kept of a number: more than a clock can tell.
const DIGITS: usize = 6;

/// A record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Version of this format.
    pub format: u32,
    /// When it ended, UTC: `2026-11-22T23:59:59Z`.
    pub date: String,
    /// The command.
    pub command: String,
    /// The machine.
    pub machine: Machine,
    /// Bytes a second of a copy, read and written ones together.
    pub copy_bytes_per_second: Option<f64>,
    /// Whether all that was asked for is in it.
    pub complete: bool,
    /// The rows.
    pub rows: Vec<Row>,
    /// How times grow with N.
    pub growth: Vec<Growth>,
}

impl Record {
    /// The record of a suite that has just ended.
    #[must_use]
    pub fn new(suite: &Suite, command: &str) -> Self {
        Self {
            format: FORMAT,
            date: date::now(),
            command: command.to_string(),
            machine: suite.machine.clone(),
            copy_bytes_per_second: suite.copy_bytes_per_second,
            complete: !suite.interrupted,
            rows: suite.rows.clone(),
            growth: growth(&suite.rows),
        }
    }

    /// Its text.
    #[must_use]
    pub fn json(&self) -> String {
        let value = serde_json::to_value(self).map(rounded).unwrap_or(Value::Null);
        format!("{value:#}\n")
    }

    /// Writes it to a file named by date and device in `folder`, and returns the file.
    ///
    /// # Errors
    /// If the folder or file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, String> {
        let words: Vec<String> = self
            .machine
            .title()
            .split(|c: char| !c.is_ascii_alphanumeric())
            .filter(|word| !word.is_empty())
            .map(str::to_lowercase)
            .collect();
        let day = self.date.split('T').next().unwrap_or_default();
        let name = format!("{day}-{}", words.join("-"));
        let place = |i: u32| folder.join(if i == 1 { format!("{name}.json") } else { format!("{name}-{i}.json") });
        // A second one of the same day does not take the first one's place.
        let path = (1..).map(place).find(|path| !path.exists()).unwrap_or_else(|| place(1));
        write(&path, &self.json())?;
        Ok(path)
    }

    /// Reads a record.
    ///
    /// # Errors
    /// If the file cannot be read or is no record.
    pub fn read(path: &Path) -> Result<Self, String> {
        let file = path.display();
        let remedy = "give a file that `caustic bench --record` or --json wrote";
        let text = std::fs::read_to_string(path).map_err(|error| format!("cannot read `{file}`: {error}; {remedy}"))?;
        let record: Self =
            serde_json::from_str(&text).map_err(|error| format!("`{file}` is no record ({error}); {remedy}"))?;
        if record.format != FORMAT {
            return Err(format!("`{file}` is a record of format {}, and this program reads {FORMAT}", record.format));
        }
        Ok(record)
    }
}

/// Writes a file whole.
///
/// # Errors
/// If it cannot be written; the sentence names it.
pub fn write(path: &Path, text: &str) -> Result<(), String> {
    files::replace(path, text.as_bytes()).map_err(|error| format!("cannot write `{}`: {error}", path.display()))
}

/// The value with every fraction rounded: records are read by people, too.
fn rounded(value: Value) -> Value {
    match value {
        Value::Number(number) if number.is_f64() => {
            let x = number.as_f64().unwrap_or_default();
            format!("{x:.*e}", DIGITS - 1).parse::<f64>().map_or(Value::Null, Value::from)
        }
        Value::Array(all) => all.into_iter().map(rounded).collect(),
        Value::Object(all) => all.into_iter().map(|(key, value)| (key, rounded(value))).collect(),
        other => other,
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::report::tests::rows;

    pub fn record() -> Record {
        let text = |text: &str| text.to_string();
        let machine = Machine {
            device: text("CPU, 2 threads"),
            driver: String::new(),
            exact: true,
            cpu: text("Some (R) CPU"),
            threads: 2,
            caustic: text("0.1.0"),
            commit: text("abc"),
            rustc: text("rustc 1"),
            system: text("linux"),
        };
        Record {
            format: FORMAT,
            date: text("2026-11-22T01:02:03Z"),
            command: text("caustic bench"),
            machine,
            copy_bytes_per_second: Some(1.5e10),
            complete: true,
            rows: rows(),
            growth: growth(&rows()),
        }
    }

    #[test]
    fn a_record_is_read_as_it_was_written_and_none_takes_anothers_place() {
        let folder = tempfile::tempdir().unwrap();
        let paths = [0, 1].map(|_| record().write(folder.path()).unwrap());
        let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
        assert_eq!(name(&paths[0]), "2026-11-22-cpu-2-threads-some-r-cpu.json");
        assert_eq!(name(&paths[1]), "2026-11-22-cpu-2-threads-some-r-cpu-2.json");
        let read = Record::read(&paths[0]).unwrap();
        assert_eq!(read.json(), record().json());
        assert_eq!((read.machine, read.rows.len()), (record().machine, 2));
    }

    #[test]
    fn what_is_no_record_is_refused_with_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        for (text, part) in [("{", "no record"), ("{\"format\": 1}", "missing field"), ("[]", "no record")] {
            std::fs::write(&path, text).unwrap();
            let error = Record::read(&path).unwrap_err();
            assert!(error.contains(part) && error.contains("a.json"), "{error}");
        }
        let other = Record { format: 2, ..record() };
        std::fs::write(&path, other.json()).unwrap();
        assert!(Record::read(&path).unwrap_err().contains("format 2"));
        assert!(Record::read(&folder.path().join("none")).unwrap_err().contains("cannot read"));
    }

    #[test]
    fn numbers_are_rounded_and_whole_ones_kept() {
        let value = serde_json::json!({ "a": [0.123_456_789, 16_777_217, 1e9 + 0.5] });
        assert_eq!(rounded(value).to_string(), r#"{"a":[0.123457,16777217,1000000000.0]}"#);
    }
}
