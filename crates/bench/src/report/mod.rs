//! Rows for people and for other programs.

mod csv;
mod format;
mod markdown;
mod plot;
mod text;

pub use csv::csv;
pub use markdown::markdown;
pub use plot::{COLOURS, plots};
pub use text::{footer, header, line};

pub(crate) use format::{hash, milliseconds, peers, percent, rate, size, targets};

use crate::fit::exponent;
use crate::row::Row;
use serde::{Deserialize, Serialize};

/// Times of one series over N.
pub(crate) struct Series<'a> {
    /// The case.
    pub case: &'a str,
    /// Whose: `caustic` or a peer.
    pub who: &'a str,
    /// What N counts.
    pub counts: &'a str,
    /// N and median milliseconds.
    pub points: Vec<(u32, f64)>,
}

/// How the time of one series grows with N.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Growth {
    /// The case.
    pub case: String,
    /// Whose: `caustic` or a peer.
    pub who: String,
    /// p of time ∝ Nᵖ, from a million on.
    pub exponent: f64,
}

/// What rows call our own times.
pub(crate) const OURS: &str = "caustic";

/// The series of rows: ours of each case first, then its peers.
pub(crate) fn series(rows: &[Row]) -> Vec<Series<'_>> {
    let mut all: Vec<Series<'_>> = Vec::new();
    for row in rows {
        let Some(measured) = row.measured() else { continue };
        let peers = measured.peers.iter().filter_map(|peer| {
            let ms = peer.stages_ms.or(peer.wall_ms)?.median;
            Some((peer.name.as_str(), ms))
        });
        for (who, ms) in std::iter::once((OURS, measured.time().median)).chain(peers) {
            match all.iter_mut().find(|series| series.case == row.case && series.who == who) {
                Some(series) => series.points.push((row.n, ms)),
                None => all.push(Series { case: &row.case, who, counts: &row.counts, points: vec![(row.n, ms)] }),
            }
        }
    }
    // Stable: ours stays before the peers, and cases stay together.
    let order: Vec<&str> = rows.iter().map(|row| row.case.as_str()).collect();
    all.sort_by_key(|series| order.iter().position(|case| *case == series.case));
    all
}

/// The exponents of all series that have one.
#[must_use]
pub fn growth(rows: &[Row]) -> Vec<Growth> {
    let of = |series: Series<'_>| {
        let exponent = exponent(&series.points)?;
        Some(Growth { case: series.case.to_string(), who: series.who.to_string(), exponent })
    };
    series(rows).into_iter().filter_map(of).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::row::{Clock, Measured, Outcome, Peer, Spread};

    pub fn spread(median: f64) -> Spread {
        Spread { median, low: 0.9 * median, high: 1.1 * median, least: 0.8 * median, most: 2.0 * median }
    }

    pub fn measured(ms: f64) -> Measured {
        let peer = |name: &str, time: Option<f64>| Peer {
            name: name.to_string(),
            version: "1".to_string(),
            runs: 5,
            wall_ms: time.map(spread),
            stages_ms: None,
            parts: Vec::new(),
            over_ours: time.map(|time| time / ms),
            agree: 4,
            compared: 4,
            note: "it says \"no\"".to_string(),
        };
        Measured {
            runs: 5,
            clock: Clock::Wall,
            stages_ms: Some(spread(0.9 * ms)),
            wall_ms: spread(ms),
            parts: Vec::new(),
            stages: Vec::new(),
            per_second: 1e9 / ms,
            unit: "photons".to_string(),
            bytes: Some(1000),
            of_copy: Some(0.5),
            sha256: "ab".to_string(),
            as_expected: Some(true),
            checked: 64,
            differ: 0,
            targets: Vec::new(),
            peers: vec![peer("other", Some(2.0 * ms)), peer("absent", None)],
        }
    }

    pub fn row(case: &str, n: u32, outcome: Outcome) -> Row {
        let (kind, counts) = ("build".to_string(), "photons".to_string());
        Row { case: case.to_string(), kind, n, counts, queries: None, outcome }
    }

    /// One that ran and one that did not.
    pub fn rows() -> Vec<Row> {
        vec![
            row("case-a", 1_000_000, Outcome::Measured(Box::new(measured(12.3)))),
            row("case-b", 2_000_000, Outcome::Skipped("no | room".to_string())),
        ]
    }

    #[test]
    fn growth_is_told_of_ours_and_of_peers() {
        let at = |n: u32, ms| row("case-a", n, Outcome::Measured(Box::new(measured(ms))));
        let all = growth(&[at(1_000_000, 1.0), at(4_000_000, 8.0)]);
        let found: Vec<_> = all.iter().map(|g| (g.who.as_str(), (g.exponent * 1e6).round() / 1e6)).collect();
        assert_eq!(found, [("caustic", 1.5), ("other", 1.5)]);
    }
}
