//! How time grows with N.

/// The smallest N that counts: below, fixed costs hide the growth.
const FROM: u32 = 1_000_000;

/// The exponent p of time ∝ Nᵖ of all N from a million on. None if those are fewer than two.
#[must_use]
pub(crate) fn exponent(points: &[(u32, f64)]) -> Option<f64> {
    let usable = points.iter().filter(|(n, _)| *n >= FROM);
    power(&usable.map(|&(n, ms)| (f64::from(n), ms)).collect::<Vec<_>>())
}

/// The exponent p of y ∝ xᵖ: the slope of the least-squares line through (log x, log y), of positive numbers. None if there are not two
/// different x.
#[must_use]
pub fn power(points: &[(f64, f64)]) -> Option<f64> {
    let usable = points.iter().filter(|(x, y)| *x > 0.0 && *y > 0.0);
    let logs: Vec<(f64, f64)> = usable.map(|&(x, y)| (x.ln(), y.ln())).collect();
    let count = logs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let across: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let along: f64 = logs.iter().map(|p| (p.0 - x).powi(2)).sum();
    (logs.len() >= 2 && along > 0.0).then(|| across / along)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_have_their_exponent() {
        let sizes = [65_536, 1_000_000, 4_000_000, 10_000_000, 100_000_000];
        for p in [0.5, 1.0, 1.25, 2.0] {
            // What is below a million is far off the line and must not matter.
            let time = |n: u32| if n < FROM { 1e9 } else { 3e-6 * f64::from(n).powf(p) };
            let points: Vec<_> = sizes.iter().map(|&n| (n, time(n))).collect();
            assert!((exponent(&points).unwrap() - p).abs() < 1e-9, "{p}");
        }
    }

    #[test]
    fn the_line_is_that_of_least_squares() {
        // By hand: x = ln N / ln 10 of 6, 7, 8 and y of 0, 2, 3 has the slope (−1·0 + 0·2 + 1·3) / 2.
        let points = [(1_000_000, 1.0), (10_000_000, 100.0), (100_000_000, 1000.0)];
        assert!((exponent(&points).unwrap() - 1.5).abs() < 1e-9);
        assert_eq!(exponent(&points[..1]), None);
        assert_eq!(exponent(&[(1000, 1.0), (2_000_000, 2.0)]), None);
        assert_eq!(exponent(&[(2_000_000, 2.0), (2_000_000, 3.0)]), None);
    }
}
