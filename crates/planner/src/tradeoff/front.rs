//! Which points are worth having.

/// Points by what they cost and how wrong they are.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Front {
    /// Indices of those of which no other costs less and is less wrong, from the cheapest on (Pareto).
    pub worth: Vec<usize>,
    /// The one of them after which less error costs most more, and before which less cost most more error.
    pub knee: Option<usize>,
}

/// The front of points of (cost, error), both positive.
///
/// The knee is the point of the front that lies farthest below the line through its ends, in logarithms (Satopää et al., "Finding a
/// Kneedle in a Haystack", 2011, on a discrete convex curve).
#[must_use]
pub fn front(points: &[(f64, f64)]) -> Front {
    let mut order: Vec<usize> = (0..points.len()).filter(|&i| points[i].0 > 0.0 && points[i].1 > 0.0).collect();
    order.sort_by(|&a, &b| points[a].partial_cmp(&points[b]).unwrap_or(std::cmp::Ordering::Equal).then(a.cmp(&b)));
    let mut worth: Vec<usize> = Vec::new();
    for i in order {
        if worth.last().is_none_or(|&last| points[i].1 < points[last].1) {
            worth.push(i);
        }
    }
    let place = |i: usize| (points[i].0.ln(), points[i].1.ln());
    let knee = (worth.len() > 2).then(|| {
        let (first, last) = (place(worth[0]), place(worth[worth.len() - 1]));
        let below = |i: usize| {
            let at = place(i);
            let along = (at.0 - first.0) / (last.0 - first.0);
            first.1 + along * (last.1 - first.1) - at.1
        };
        worth.iter().copied().max_by(|&a, &b| below(a).total_cmp(&below(b)))
    });
    Front { worth, knee: knee.flatten() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_has_what_nothing_beats_and_a_knee() {
        // 1 and 3 are beaten; 4 costs as much as 2 and is worse; 6 is no result.
        let points = [(1.0, 1.0), (2.0, 2.0), (2.0, 0.1), (5.0, 0.2), (2.0, 0.3), (100.0, 0.05), (0.0, 0.0)];
        let found = front(&points);
        assert_eq!(found, Front { worth: vec![0, 2, 5], knee: Some(2) });
        assert_eq!(front(&[]), Front::default());
        assert_eq!(front(&points[..1]), Front { worth: vec![0], knee: None });
        // Of equals, the first.
        assert_eq!(front(&[(1.0, 1.0), (1.0, 1.0)]).worth, [0]);
    }
}
