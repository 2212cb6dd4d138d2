//! The README's table of performance, made of records.

use super::Record;
use crate::report::{markdown, size};
use crate::row::Row;
use std::path::Path;

/// The line before the table.
pub const BEGIN: &str = "<!-- bench:begin -->";
/// The line after it.
pub const END: &str = "<!-- bench:end -->";

/// The table of records, in the order of their dates: of each, a line a case, at the size that its target is about or else at the
/// largest that was measured.
#[must_use]
pub fn table(records: &[Record]) -> String {
    let mut records: Vec<&Record> = records.iter().collect();
    records.sort_by_key(|record| (&record.date, &record.machine.device));
    let mut text = String::new();
    for record in records {
        let machine = &record.machine;
        let day = record.date.split('T').next().unwrap_or_default();
        let commit = if machine.commit.is_empty() { String::new() } else { format!(" at `{}`", machine.commit) };
        text += &format!("**{}**, {day}, caustic {}{commit}", machine.title(), machine.caustic);
        if let Some(copy) = record.copy_bytes_per_second {
            text += &format!("; a copy reads and writes {:.0} GB/s", copy / 1e9);
        }
        let interrupted = if record.complete { "" } else { ", interrupted before its end" };
        text += &format!(" (`{}`{interrupted})\n\n", record.command);
        text += &markdown(&chosen(&record.rows));
        let growth: Vec<_> = record
            .growth
            .iter()
            .filter(|growth| growth.who == "caustic")
            .map(|growth| format!("{} {:.2}", growth.case, growth.exponent))
            .collect();
        if !growth.is_empty() {
            text += &format!("\nTime grows with N to the power of: {}.\n", growth.join(", "));
        }
        text += &skipped(&record.rows);
        text.push('\n');
    }
    format!("{}\n", text.trim_end())
}

/// A row a case.
fn chosen(rows: &[Row]) -> Vec<Row> {
    let mut chosen: Vec<&Row> = Vec::new();
    for row in rows.iter().filter(|row| row.measured().is_some()) {
        let has_target = |row: &Row| row.measured().is_some_and(|measured| !measured.targets.is_empty());
        match chosen.iter_mut().find(|known| known.case == row.case) {
            // Sizes ascend: the last with a target, or the last.
            Some(known) if has_target(row) || !has_target(known) => *known = row,
            Some(_) => {}
            None => chosen.push(row),
        }
    }
    chosen.into_iter().cloned().collect()
}

/// A sentence on what was skipped.
fn skipped(rows: &[Row]) -> String {
    let all: Vec<_> =
        rows.iter().filter(|r| r.measured().is_none()).map(|r| format!("{} at {}", r.case, size(r.n))).collect();
    if all.is_empty() { String::new() } else { format!("\nSkipped, with reasons in the record: {}.\n", all.join(", ")) }
}

/// `text` with `table` between its markers.
///
/// # Errors
/// If it has not just one pair of markers; `file` is its name in the sentence.
pub fn into_text(file: &str, text: &str, table: &str) -> Result<String, String> {
    let places = |marker: &str| text.match_indices(marker).map(|(at, _)| at).collect::<Vec<_>>();
    match (places(BEGIN).as_slice(), places(END).as_slice()) {
        (&[begin], &[end]) if begin < end => {
            let before = &text[..begin + BEGIN.len()];
            Ok(format!("{before}\n\n{}\n\n{}", table.trim_end(), &text[end..]))
        }
        _ => Err(format!(
            "`{file}` needs the lines {BEGIN} and {END} once each, in this order: the table goes between them"
        )),
    }
}

/// Puts `table` between the markers of the file at `path`.
///
/// # Errors
/// If the file cannot be read or written, or has no markers.
pub fn replace_in(path: &Path, table: &str) -> Result<(), String> {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path).map_err(|error| format!("cannot read `{file}`: {error}"))?;
    super::write(path, &into_text(&file, &text, table)?)
}

#[cfg(test)]
mod tests {
    use super::super::tests::record;
    use super::*;
    use crate::report::tests::{measured, row};
    use crate::row::{Outcome, Reached};

    #[test]
    fn the_table_says_where_when_and_what() {
        let later = Record { date: "2026-11-23T00:00:00Z".to_string(), ..record() };
        let text = table(&[later, record()]);
        assert!(text.starts_with("**CPU, 2 threads (Some (R) CPU)**, 2026-11-22, caustic 0.1.0 at `abc`"), "{text}");
        assert!(text.find("2026-11-22") < text.find("2026-11-23"), "by date: {text}");
        for part in ["15 GB/s", "| case-a | 1 M | 12.3 ms |", "Skipped, with reasons in the record: case-b at 2 M."] {
            assert!(text.contains(part), "no {part} in {text}");
        }
    }

    #[test]
    fn a_case_has_one_line_that_of_its_target_or_its_largest() {
        let of = |case: &str, n: u32, target: bool| {
            let target = target.then(|| Reached { target: "≤ 1 ms".to_string(), met: Some(true) });
            let measured = crate::row::Measured { targets: target.into_iter().collect(), ..measured(1.0) };
            row(case, n, Outcome::Measured(Box::new(measured)))
        };
        let rows = [of("a", 1, false), of("a", 2, true), of("a", 3, false), of("b", 1, false), of("b", 2, false)];
        let found: Vec<_> = chosen(&rows).iter().map(|row| (row.case.clone(), row.n)).collect();
        assert_eq!(found, [("a".to_string(), 2), ("b".to_string(), 2)]);
    }

    #[test]
    fn a_table_takes_the_place_of_the_one_before() {
        let text = format!("# Title\n{BEGIN}\nold\n{END}\nrest\n");
        let first = into_text("x.md", &text, "| new |\n").unwrap();
        assert_eq!(first, format!("# Title\n{BEGIN}\n\n| new |\n\n{END}\nrest\n"));
        assert_eq!(into_text("x.md", &first, "| new |\n").unwrap(), first);
        for bad in ["nothing".to_string(), format!("{END}{BEGIN}"), format!("{BEGIN}{BEGIN}{END}")] {
            assert!(into_text("x.md", &bad, "t").unwrap_err().contains("x.md"));
        }
    }
}
