//! One metric of two pictures.

use crate::{FlipOptions, Image, MetricsError, Range, YeeOptions, flip, relmse, rmse, yee};
use rayon::prelude::*;

/// How pictures are compared, with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Metric {
    /// [`flip`](crate::flip()): the difference that is seen when the pictures alternate, 0 to 1.
    Flip(FlipOptions),
    /// [`yee`](crate::yee()): the number of pixels that differ visibly.
    Yee(YeeOptions),
    /// [`relmse`](crate::relmse()): the mean square error, relative to the reference.
    RelMse,
    /// [`rmse`](crate::rmse()): the root of the mean square error.
    Rmse,
}

impl Metric {
    /// All metrics, with their default parameters.
    #[must_use]
    pub fn all() -> [Self; 4] {
        [Self::Flip(FlipOptions::default()), Self::Yee(YeeOptions::default()), Self::RelMse, Self::Rmse]
    }

    /// Its name: `flip`, `yee`, `relmse` or `rmse`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Flip(_) => "flip",
            Self::Yee(_) => "yee",
            Self::RelMse => "relmse",
            Self::Rmse => "rmse",
        }
    }
}

/// What a metric says of two pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// The metric.
    pub metric: Metric,
    /// 0 for pictures without a difference, and larger the more they differ; what it counts is the metric's.
    pub value: f64,
    /// Each pixel's part, row by row from the top left: FLIP's error from 0 to 1; for Yee, the difference over the least visible
    /// one, so that pixels above 1 count; the relative square error; the root of the square error.
    pub map: Vec<f32>,
}

impl Score {
    /// The number in the map that a picture of it should show brightest: FLIP's largest error, 1; twice the least visible
    /// difference; and else the largest there is.
    #[must_use]
    pub fn full_scale(&self) -> f32 {
        match self.metric {
            Metric::Flip(_) => 1.0,
            Metric::Yee(_) => 2.0,
            Metric::RelMse | Metric::Rmse => self.map.iter().copied().fold(0.0, f32::max),
        }
    }
}

/// Compares a picture with a reference.
///
/// If one is of [`Range::Display`] and the other of [`Range::Scene`], the latter is compared as a display shows it
/// ([`Image::displayed`] at exposure 0): of light above white, the other holds nothing.
///
/// # Errors
/// If the sizes differ, a parameter is out of bounds, or FLIP cannot compare them.
pub fn compare(test: &Image, reference: &Image, metric: Metric) -> Result<Score, MetricsError> {
    check_sizes(test, reference)?;
    let mixed = test.range() != reference.range();
    let shown = |image: &Image| (mixed && image.range() == Range::Scene).then(|| image.displayed(0.0));
    let (shown_test, shown_reference) = (shown(test), shown(reference));
    let (test, reference) = (shown_test.as_ref().unwrap_or(test), shown_reference.as_ref().unwrap_or(reference));
    let (value, map) = match metric {
        Metric::Flip(options) => flip(test, reference, &options),
        Metric::Yee(options) => yee(test, reference, &options).map(|(count, map)| (count as f64, map)),
        Metric::RelMse => relmse(test, reference),
        Metric::Rmse => rmse(test, reference),
    }?;
    Ok(Score { metric, value, map })
}

/// Refuses pictures of different sizes.
pub(crate) fn check_sizes(test: &Image, reference: &Image) -> Result<(), MetricsError> {
    let size = |image: &Image| (image.name().to_string(), image.width(), image.height());
    if (test.width(), test.height()) == (reference.width(), reference.height()) {
        return Ok(());
    }
    Err(MetricsError::Sizes { test: size(test), reference: size(reference) })
}

/// The mean of an error over the channels of each pixel.
pub(crate) fn per_pixel(
    test: &Image,
    reference: &Image,
    error: impl Fn(f64, f64) -> f64 + Sync,
) -> Result<Vec<f64>, MetricsError> {
    check_sizes(test, reference)?;
    let pixels = test.rgb().par_iter().zip(reference.rgb());
    let channel = |(&a, &b): (&f32, &f32)| error(f64::from(a), f64::from(b));
    Ok(pixels.map(|(a, b)| a.iter().zip(b).map(channel).sum::<f64>() / 3.0).collect())
}

/// The mean of all values, added row by row and then the rows: in one order, whatever the number of threads.
pub(crate) fn mean(values: &[f64], width: usize) -> f64 {
    let rows: Vec<f64> = values.par_chunks(width).map(|row| row.iter().sum()).collect();
    rows.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_that_differ_are_named() {
        let a = Image::from_linear(3, 2, vec![[0.0; 3]; 6]).unwrap().named("`a.exr`");
        let b = Image::from_linear(2, 3, vec![[0.0; 3]; 6]).unwrap().named("`b.exr`");
        for metric in Metric::all() {
            let error = compare(&a, &b, metric).unwrap_err().to_string();
            assert!(error.contains("`a.exr` has 3 × 2 pixels and `b.exr` has 2 × 3"), "{error}");
        }
    }

    #[test]
    fn a_display_and_a_scene_are_compared_as_displayed() {
        let scene = Image::from_linear(4, 1, vec![[7.0; 3], [1.0; 3], [0.5; 3], [-1.0; 3]]).unwrap();
        let display = scene.displayed(0.0);
        for metric in Metric::all() {
            for (a, b) in [(&scene, &display), (&display, &scene)] {
                assert_eq!(compare(a, b, metric).unwrap().value, 0.0, "{}", metric.name());
            }
        }
        let brighter = Image::from_linear(4, 1, vec![[8.0; 3], [1.0; 3], [0.5; 3], [-1.0; 3]]).unwrap();
        assert!(
            compare(&brighter, &scene, Metric::Rmse).unwrap().value > 0.4,
            "two scenes are compared without bounds"
        );
    }
}
