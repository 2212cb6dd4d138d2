//! One circumstance varies, everything else stays.

use super::{Axis, Chart, Line, Results};
use crate::case::{Case, Map};
use crate::scope::{self, Scope};
use crate::subject::SUBJECTS;

/// What varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Vary {
    Photons,
    K,
    Radius,
    Size,
}

/// A sweep of some subjects.
#[derive(Clone, Copy)]
pub(super) struct Sweep {
    pub map: Map,
    pub vary: Vary,
    pub subjects: &'static [&'static str],
}

impl Vary {
    pub(super) fn axis(self) -> Axis {
        match self {
            Self::Photons => Axis::Photons,
            Self::K => Axis::K,
            Self::Radius => Axis::Radius,
            Self::Size => Axis::Queries,
        }
    }

    /// Where the thesis's range ends.
    pub(super) fn thesis_to(self) -> f64 {
        f64::from(match self {
            Self::Photons => scope::MOST_PHOTONS,
            Self::K => scope::MOST_K,
            Self::Radius => scope::MOST_RADIUS,
            Self::Size => scope::MOST_QUERIES,
        })
    }

    /// The number that varies.
    pub(super) fn of(self, case: &Case) -> f64 {
        f64::from(match self {
            Self::Photons => case.photons,
            Self::K => case.k,
            Self::Radius => case.radius_mm,
            Self::Size => case.queries(),
        })
    }

    /// A case with each of the range.
    pub(super) fn range(self, scope: &Scope, base: &Case) -> Vec<Case> {
        let base = || base.clone();
        match self {
            Self::Photons => scope.photons().iter().map(|&photons| Case { photons, ..base() }).collect(),
            Self::K => scope.ks().iter().map(|&k| Case { k, ..base() }).collect(),
            Self::Radius => scope.radii().iter().map(|&radius_mm| Case { radius_mm, ..base() }).collect(),
            Self::Size => scope.sizes().iter().map(|&size| Case { size, ..base() }).collect(),
        }
    }
}

impl Sweep {
    pub(super) fn cases(&self, scope: &Scope) -> Vec<Case> {
        let of = |subject: &&str| {
            let base = Case { subject: (*subject).to_string(), ..scope.base(self.map) };
            self.vary.range(scope, &base)
        };
        self.subjects.iter().flat_map(of).collect()
    }

    /// What was measured of a subject.
    pub(super) fn points(
        &self,
        results: &Results,
        subject: &str,
        value: impl Fn(&Results, &Case) -> Option<f64>,
    ) -> Vec<(f64, f64)> {
        let base = results.base(self.map, subject);
        let cases = self.vary.range(&results.scope, &base);
        cases.iter().filter_map(|case| Some((self.vary.of(case), value(results, case)?))).collect()
    }

    /// The same within the thesis's range.
    pub(super) fn thesis_points(
        &self,
        results: &Results,
        subject: &str,
        value: impl Fn(&Results, &Case) -> Option<f64>,
    ) -> Vec<(f64, f64)> {
        let mut points = self.points(results, subject, value);
        points.retain(|point| point.0 <= self.vary.thesis_to());
        points
    }

    pub(super) fn chart(
        &self,
        results: &Results,
        name: &str,
        title: &str,
        axis: Axis,
        value: impl Fn(&Results, &Case) -> Option<f64> + Copy,
    ) -> Chart {
        let line = |name: &&str| {
            let place = SUBJECTS.iter().position(|subject| subject.name == *name)?;
            let points = self.points(results, name, value);
            let label = SUBJECTS[place].label.to_string();
            (!points.is_empty()).then_some(Line { subject: place, label, points })
        };
        let lines: Vec<Line> = self.subjects.iter().filter_map(line).collect();
        let to = self.vary.thesis_to();
        let beyond = lines.iter().any(|line| line.points.iter().any(|point| point.0 > to));
        Chart {
            name: name.to_string(),
            title: title.to_string(),
            axes: [self.vary.axis(), axis],
            thesis_to: beyond.then_some(to),
            lines,
        }
    }
}

/// y of the last point over y of the first.
pub(super) fn rise(points: &[(f64, f64)]) -> Option<f64> {
    (points.len() > 1).then(|| points[points.len() - 1].1 / points[0].1)
}

/// y of one line over y of another wherever both have points.
pub(super) fn ratios(above: &[(f64, f64)], below: &[(f64, f64)]) -> Option<Vec<(f64, f64)>> {
    let at = |x: f64| below.iter().find(|point| point.0 == x);
    let ratios: Vec<_> = above.iter().filter_map(|&(x, y)| Some((x, y / at(x)?.1))).collect();
    (!ratios.is_empty()).then_some(ratios)
}

/// The least and the greatest y.
pub(super) fn span(points: &[(f64, f64)]) -> (f64, f64) {
    points.iter().fold((f64::INFINITY, 0.0), |(low, high), point| (low.min(point.1), high.max(point.1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rises_and_ratios_are_those_of_a_power() {
        let cubes: Vec<(f64, f64)> = [1.0, 2.0, 5.0].iter().map(|&x: &f64| (x, 4.0 * x.powi(3))).collect();
        assert_eq!((rise(&cubes), rise(&[])), (Some(125.0), None));
        let squares: Vec<(f64, f64)> = [2.0, 5.0, 7.0].iter().map(|&x: &f64| (x, x * x)).collect();
        assert_eq!(ratios(&cubes, &squares), Some(vec![(2.0, 8.0), (5.0, 20.0)]));
        assert_eq!((ratios(&cubes, &[]), span(&squares)), (None, (4.0, 49.0)));
    }
}
