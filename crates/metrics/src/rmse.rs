//! The root of the mean square error.

use crate::score::{mean, per_pixel};
use crate::{Image, MetricsError};

/// Root of the mean over pixels and channels of (a − b)², in linear light and the pictures' own unit; symmetric.
///
/// The map has the same of each pixel: √((Δr² + Δg² + Δb²) / 3).
///
/// # Errors
/// If the sizes differ.
pub fn rmse(test: &Image, reference: &Image) -> Result<(f64, Vec<f32>), MetricsError> {
    let squares = per_pixel(test, reference, |a, b| (a - b) * (a - b))?;
    Ok((mean(&squares, reference.width()).sqrt(), squares.iter().map(|square| square.sqrt() as f32).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_forms() {
        let a = Image::from_linear(2, 2, vec![[0.25, 0.5, 4.0]; 4]).unwrap();
        // The same offset everywhere is the error.
        let b = Image::from_linear(2, 2, vec![[0.5, 0.75, 4.25]; 4]).unwrap();
        assert_eq!(rmse(&a, &b).unwrap(), (0.25, vec![0.25; 4]));
        assert_eq!(rmse(&b, &a).unwrap().0, 0.25);
        // One channel of one pixel of four: √(3² / 12).
        let mut rgb = a.rgb().to_vec();
        rgb[2][1] += 3.0;
        let (value, map) = rmse(&a, &Image::from_linear(2, 2, rgb).unwrap()).unwrap();
        assert!((value - 0.75f64.sqrt()).abs() < 1e-15);
        assert_eq!(map, [0.0, 0.0, 3f32.sqrt(), 0.0]);
        // The largest numbers do not overflow.
        let huge = Image::from_linear(1, 1, vec![[f32::MAX; 3]]).unwrap();
        let zero = Image::from_linear(1, 1, vec![[0.0; 3]]).unwrap();
        assert!((rmse(&huge, &zero).unwrap().0 / f64::from(f32::MAX) - 1.0).abs() < 1e-12);
    }
}
