//! Numbers as people read them.

use crate::row::Measured;

/// A time, with three digits that count.
pub(crate) fn milliseconds(ms: f64) -> String {
    match ms {
        ms if ms >= 10_000.0 => format!("{:.1} s", ms / 1e3),
        ms if ms >= 1000.0 => format!("{:.2} s", ms / 1e3),
        ms if ms >= 100.0 => format!("{ms:.0} ms"),
        ms if ms >= 10.0 => format!("{ms:.1} ms"),
        ms if ms >= 1.0 => format!("{ms:.2} ms"),
        ms => format!("{ms:.3} ms"),
    }
}

/// A number of things a second.
pub(crate) fn rate(per_second: f64, unit: &str) -> String {
    match per_second {
        x if x >= 1e9 => format!("{:.2} G {unit}/s", x / 1e9),
        x if x >= 1e6 => format!("{:.2} M {unit}/s", x / 1e6),
        x if x >= 1e3 => format!("{:.1} k {unit}/s", x / 1e3),
        x => format!("{x:.1} {unit}/s"),
    }
}

/// N, short where it is round.
pub(crate) fn size(n: u32) -> String {
    match n {
        n if n >= 1_000_000 && n % 1_000_000 == 0 => format!("{} M", n / 1_000_000),
        n if n >= 1024 && n % 1024 == 0 => format!("{} Ki", n / 1024),
        n if n >= 1000 && n % 1000 == 0 => format!("{} k", n / 1000),
        n => n.to_string(),
    }
}

/// A share, or a dash.
pub(crate) fn percent(share: Option<f64>) -> String {
    share.map_or("–".to_string(), |share| format!("{:.1} %", 100.0 * share))
}

/// What the hash says.
pub(crate) fn hash(measured: &Measured) -> &'static str {
    match measured.as_expected {
        Some(true) => "right",
        Some(false) => "WRONG",
        None => "no hash yet",
    }
}

/// Targets, met or not.
pub(crate) fn targets(measured: &Measured) -> String {
    let one = |reached: &crate::row::Reached| {
        let met = match reached.met {
            Some(true) => "met",
            Some(false) => "missed",
            None => "not measured",
        };
        format!("{}: {met}", reached.target)
    };
    measured.targets.iter().map(one).collect::<Vec<_>>().join("; ")
}

/// Peers: their medians, and how many times our time that is.
pub(crate) fn peers(measured: &Measured) -> String {
    let one = |peer: &crate::row::Peer| match peer.stages_ms.or(peer.wall_ms).zip(peer.over_ours) {
        Some((time, over)) => format!("{} {} ({over:.2}×)", peer.name, milliseconds(time.median)),
        None => format!("{} –", peer.name),
    };
    measured.peers.iter().map(one).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_three_digits() {
        assert_eq!(
            [0.0123, 1.234, 12.34, 123.4, 1234.0, 12345.0].map(milliseconds).join(" "),
            "0.012 ms 1.23 ms 12.3 ms 123 ms 1.23 s 12.3 s"
        );
        assert_eq!(
            [1 << 16, 1_000_000, 30_000_000, 100_000, 1500, 7].map(size).join(" "),
            "64 Ki 1 M 30 M 100 k 1500 7"
        );
        assert_eq!(rate(2.5e9, "pairs"), "2.50 G pairs/s");
        assert_eq!(percent(None), "–");
    }
}
