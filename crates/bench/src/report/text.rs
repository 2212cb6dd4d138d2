//! A table for a terminal, line by line as rows come.

use super::{growth, hash, milliseconds, peers, percent, rate, size, targets};
use crate::row::{Outcome, Row};
use crate::suite::Suite;

/// The line above the rows.
#[must_use]
pub fn header() -> String {
    format!(
        "{:<24} {:>7} {:>9} {:>19} {:>5} {:>9} {:>17} {:>7}  {:<11} brute force",
        "case", "N", "median", "middle half", "runs", "wall", "", "of copy", "SHA-256"
    )
}

/// A row, with a line for each peer and for its targets.
#[must_use]
pub fn line(row: &Row) -> String {
    let measured = match &row.outcome {
        Outcome::Skipped(reason) => return format!("{:<24} {:>7} skipped: {reason}", row.case, size(row.n)),
        Outcome::Measured(measured) => measured,
    };
    let time = measured.time();
    let mut text = format!(
        "{:<24} {:>7} {:>9} {:>19} {:>5} {:>9} {:>17} {:>7}  {:<11} {} of {} differ",
        row.case,
        size(row.n),
        milliseconds(time.median),
        format!("{} … {}", milliseconds(time.low).trim_end_matches(" ms"), milliseconds(time.high)),
        measured.runs,
        milliseconds(measured.wall_ms.median),
        rate(measured.per_second, &measured.unit),
        percent(measured.of_copy),
        hash(measured),
        measured.differ,
        measured.checked,
    );
    for peer in &measured.peers {
        let (Some(peer_time), Some(over)) = (peer.stages_ms.or(peer.wall_ms), peer.over_ours) else {
            text += &format!("\n{:<32} {} {}", "", peer.name, peer.note);
            continue;
        };
        text += &format!(
            "\n{:<32} {:>9} {:>19} {:>5} {} {}: {over:.2}× our time; {} of {} agree; {}",
            "",
            milliseconds(peer_time.median),
            format!("{} … {}", milliseconds(peer_time.low).trim_end_matches(" ms"), milliseconds(peer_time.high)),
            peer.runs,
            peer.name,
            peer.version,
            peer.agree,
            peer.compared,
            peer.note,
        );
    }
    if !measured.targets.is_empty() {
        text += &format!("\n{:<32} target {}", "", targets(measured));
    }
    text
}

/// What is said below the rows.
#[must_use]
pub fn footer(suite: &Suite) -> String {
    let mut text = String::new();
    if let Some(copy) = suite.copy_bytes_per_second {
        text += &format!("copy: {:.1} GB/s, read and written bytes together\n", copy / 1e9);
    }
    for growth in growth(&suite.rows) {
        text +=
            &format!("{} ({}): time grows with N to the power of {:.2}\n", growth.case, growth.who, growth.exponent);
    }
    let measured = suite.rows.iter().filter_map(Row::measured);
    let right = measured.clone().filter(|m| m.as_expected == Some(true)).count();
    let [rows, checked, differ] =
        measured.clone().fold([0, 0, 0], |sum, m| [sum[0] + 1, sum[1] + m.checked, sum[2] + m.differ]);
    let skipped = suite.rows.len() - rows;
    text += &format!(
        "{rows} rows, {right} of them with the recorded result, {skipped} skipped; {differ} of {checked} checked results differ; {}",
        suite.machine.title()
    );
    if measured.clone().any(|m| m.peers.iter().any(|peer| peer.over_ours.is_some())) {
        let all: Vec<_> = suite
            .rows
            .iter()
            .filter_map(|row| Some((row, row.measured().filter(|m| !m.peers.is_empty())?)))
            .map(|(row, m)| format!("{} {}: {}", row.case, size(row.n), peers(m)))
            .collect();
        text += &format!("\npeers (their time over ours):\n  {}", all.join("\n  "));
    }
    text
}
