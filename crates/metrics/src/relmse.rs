//! The relative mean square error.

use crate::score::{mean, per_pixel};
use crate::{Image, MetricsError};

/// What keeps black pixels from dividing by zero. The measure is that of Rousselle, Knaus and Zwicker, "Adaptive sampling and
/// reconstruction using greedy error minimization" (SIGGRAPH Asia 2011); 0.01 is what papers report with, such as Kalantari, Bako and
/// Sen, "A machine learning approach for filtering Monte Carlo noise" (SIGGRAPH 2015).
pub const EPSILON: f64 = 0.01;

/// Mean over pixels and channels of (a − b)² / (b² + ε), where b is the reference and ε is [`EPSILON`].
///
/// An error counts by its share of what should be there, so dark parts count as much as bright ones. Not symmetric.
///
/// # Errors
/// If the sizes differ.
pub fn relmse(test: &Image, reference: &Image) -> Result<(f64, Vec<f32>), MetricsError> {
    let errors = per_pixel(test, reference, |a, b| (a - b) * (a - b) / (b * b + EPSILON))?;
    Ok((mean(&errors, reference.width()), errors.iter().map(|&error| error.min(f64::from(f32::MAX)) as f32).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(value: f32) -> Image {
        Image::from_linear(5, 3, vec![[value; 3]; 15]).unwrap()
    }

    #[test]
    fn closed_forms() {
        // 0.5² / (0.5² + 0.01), and with the roles changed 0.5² / (1 + 0.01).
        assert!((relmse(&flat(1.0), &flat(0.5)).unwrap().0 - 0.25 / 0.26).abs() < 1e-12);
        assert!((relmse(&flat(0.5), &flat(1.0)).unwrap().0 - 0.25 / 1.01).abs() < 1e-12);
        // Against black, only ε is left: 0.1² / 0.01 = 1, but for the rounding of 0.1.
        assert!((relmse(&flat(0.1), &flat(0.0)).unwrap().0 - 1.0).abs() < 1e-6);
        // The largest numbers do not overflow.
        let (value, map) = relmse(&flat(f32::MAX), &flat(0.0)).unwrap();
        assert!(value.is_finite() && value > 1e70 && map[0] == f32::MAX);
    }

    #[test]
    fn scaling_both_changes_little_where_it_is_bright() {
        let dim = relmse(&flat(11.0), &flat(10.0)).unwrap().0;
        let bright = relmse(&flat(1100.0), &flat(1000.0)).unwrap().0;
        assert!((dim - bright).abs() < 1e-5 && (dim - 0.01).abs() < 1e-5, "{dim} {bright}");
    }
}
