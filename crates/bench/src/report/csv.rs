//! Rows as comma-separated values.

use crate::row::{Clock, Outcome, Row};

/// A line for each row, and one for each peer of it. Numbers are as they are; what there is none of is empty.
#[must_use]
pub fn csv(rows: &[Row]) -> String {
    let mut text =
        "case,n,queries,who,runs,clock,median_ms,low_ms,high_ms,least_ms,most_ms,wall_ms,per_second,unit,bytes,\
                    of_copy,as_expected,checked,differ,sha256,skipped\n"
            .to_string();
    for row in rows {
        let queries = row.queries.map_or(String::new(), |queries| queries.to_string());
        let start = format!("{},{},{queries}", row.case, row.n);
        match &row.outcome {
            Outcome::Skipped(reason) => text += &format!("{start},caustic{}{}\n", ",".repeat(17), quoted(reason)),
            Outcome::Measured(m) => {
                let time = m.time();
                let clock = if m.clock == Clock::Wall { "wall" } else { "stages" };
                text += &format!(
                    "{start},caustic,{},{clock},{},{},{},{},{},{},{},{},{},{},{},{},{},{},\n",
                    m.runs,
                    time.median,
                    time.low,
                    time.high,
                    time.least,
                    time.most,
                    m.wall_ms.median,
                    m.per_second,
                    m.unit,
                    m.bytes.map_or(String::new(), |bytes| bytes.to_string()),
                    m.of_copy.map_or(String::new(), |share| share.to_string()),
                    m.as_expected.map_or("", |right| if right { "yes" } else { "no" }),
                    m.checked,
                    m.differ,
                    m.sha256,
                );
                for peer in &m.peers {
                    let Some(time) = peer.stages_ms.or(peer.wall_ms) else {
                        text += &format!("{start},{}{}{}\n", peer.name, ",".repeat(17), quoted(&peer.note));
                        continue;
                    };
                    let clock = if peer.stages_ms.is_some() { "stages" } else { "wall" };
                    text += &format!(
                        "{start},{},{},{clock},{},{},{},{},{},{},,,,,,{},{},,\n",
                        peer.name,
                        peer.runs,
                        time.median,
                        time.low,
                        time.high,
                        time.least,
                        time.most,
                        peer.wall_ms.map_or(String::new(), |wall| wall.median.to_string()),
                        peer.compared,
                        peer.compared - peer.agree,
                    );
                }
            }
        }
    }
    text
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::rows;

    #[test]
    fn every_line_has_every_column() {
        let text = csv(&rows());
        let columns: Vec<_> = text.lines().map(|line| line.split(',').count()).collect();
        // A row of ours, one of a peer that ran, one of a peer that did not, one that was skipped.
        assert_eq!(columns, [21; 5], "{text}");
        assert!(text.contains("\"it says \"\"no\"\"\""), "{text}");
    }
}
