//! Rows as a Markdown table.

use super::{hash, milliseconds, peers, percent, rate, size, targets};
use crate::row::{Outcome, Row};

/// A table of rows.
#[must_use]
pub fn markdown(rows: &[Row]) -> String {
    let mut text = "| case | N | time | middle half | runs | throughput | of a copy | result | target | peers (their time over ours) |\n\
                    | --- | --: | --: | --: | --: | --: | --: | --- | --- | --- |\n"
        .to_string();
    for row in rows {
        let (name, n) = (&row.case, size(row.n));
        match &row.outcome {
            Outcome::Skipped(reason) => {
                text += &format!("| {name} | {n} | – | – | – | – | – | skipped: {} | | |\n", cell(reason));
            }
            Outcome::Measured(m) => {
                let time = m.time();
                text += &format!(
                    "| {name} | {n} | {} | {} … {} | {} | {} | {} | {} | {} | {} |\n",
                    milliseconds(time.median),
                    milliseconds(time.low).trim_end_matches(" ms"),
                    milliseconds(time.high),
                    m.runs,
                    rate(m.per_second, &m.unit),
                    percent(m.of_copy),
                    hash(m),
                    targets(m),
                    peers(m),
                );
            }
        }
    }
    text
}

/// Text that does not end its cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::rows;

    #[test]
    fn the_table_has_a_line_each_and_ten_columns() {
        let text = markdown(&rows());
        assert_eq!(text.lines().count(), 4, "{text}");
        for line in text.lines() {
            assert_eq!(line.replace("\\|", "").matches('|').count(), 11, "{line}");
        }
        assert!(text.contains("| case-a | 1 M | 12.3 ms |") && text.contains("other 24.6 ms (2.00×)"), "{text}");
    }
}
