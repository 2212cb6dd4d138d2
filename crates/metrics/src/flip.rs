//! FLIP, by the crate `flip-rs`.

use crate::score::{check_sizes, mean};
use crate::{Image, MetricsError, Range, to_srgb};
use flip_rs::{HdrOptions, RgbImage};

/// How FLIP's pictures are looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlipOptions {
    /// Pixels in a degree of the visual field, 1 to 1000. By default 67.02, as of the paper: a monitor 0.7 m wide with 3840 pixels a
    /// row, seen from 0.7 m.
    pub pixels_per_degree: f32,
}

impl Default for FlipOptions {
    fn default() -> Self {
        Self { pixels_per_degree: flip_rs::DEFAULT_PPD }
    }
}

/// Mean, and error of each pixel from 0 to 1, of FLIP: the difference that is seen when two pictures alternate in one place. Symmetric
/// for displays; of scenes, the reference says which exposures are looked at.
///
/// Pictures of [`Range::Display`]: LDR-FLIP (Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference
/// Evaluator for Alternating Images", HPG 2020, sections 4.1 to 4.3: colour filtered by contrast sensitivity, HyAB distance, edges
/// and points as an exponent). Any other: HDR-FLIP (Andersson, Nilsson, Shirley and Akenine-Möller, "Visualizing Errors in Rendered
/// High Dynamic Range Images", Eurographics 2021 Short Papers, section 3: the largest LDR-FLIP over exposures from that at which the
/// brightest pixel of the reference keeps its details to that at which its median does, ACES tone mapping).
///
/// A reference that is black has no such exposures, so the other picture's are taken; two black pictures do not differ. Negative light is
/// black. Pictures dimmer than 2⁻²⁰ throughout are brought to 1 first, since the automatic exposures have a floor.
///
/// # Errors
/// If the sizes differ, the parameter is out of bounds, the pictures have more pixels than `flip-rs` takes (28 million by default), or
/// span more light than 128 exposures.
pub fn flip(test: &Image, reference: &Image, options: &FlipOptions) -> Result<(f64, Vec<f32>), MetricsError> {
    check_sizes(test, reference)?;
    let pixels_per_degree = options.pixels_per_degree;
    if !(1.0..=1000.0).contains(&pixels_per_degree) {
        let value = f64::from(pixels_per_degree);
        return Err(MetricsError::Parameter { name: "pixels per degree", value, range: "from 1 to 1000" });
    }
    let failed = |error: flip_rs::FlipError| MetricsError::Flip {
        test: test.name().to_string(),
        reference: reference.name().to_string(),
        reason: error.to_string(),
    };
    let displays = test.range() == Range::Display && reference.range() == Range::Display;
    let errors = if displays {
        let codes = |image: &Image| planes(image, |value| to_srgb(f64::from(value)) as f32);
        flip_rs::ldr_flip(&codes(reference).map_err(failed)?, &codes(test).map_err(failed)?, pixels_per_degree)
            .map_err(failed)?
    } else {
        let brightest = [reference, test].map(|image| image.rgb().as_flattened().iter().copied().fold(0.0, f32::max));
        let (base, peak) = if brightest[0] > 0.0 { (reference, brightest[0]) } else { (test, brightest[1]) };
        if peak == 0.0 {
            return Ok((0.0, vec![0.0; reference.rgb().len()]));
        }
        let other = if std::ptr::eq(base, reference) { test } else { reference };
        let scale = if peak < DIM { 1.0 / f64::from(peak) } else { 1.0 };
        // What is so much brighter than the base is white at all its exposures, and must not overflow when it is squared.
        let most = f64::from(peak) * scale * 1e4;
        let light = |value: f32| (f64::from(value) * scale).clamp(0.0, most) as f32;
        let mut hdr = HdrOptions::default();
        hdr.ppd = pixels_per_degree;
        hdr.return_exposure_map = false;
        flip_rs::hdr_flip(&planes(base, light).map_err(failed)?, &planes(other, light).map_err(failed)?, hdr)
            .map_err(failed)?
            .error_map
    };
    let map = errors.into_pixels();
    if map.iter().any(|error| !error.is_finite()) {
        return Err(MetricsError::Flip {
            test: test.name().to_string(),
            reference: reference.name().to_string(),
            reason: "they are so bright that its numbers overflow".to_string(),
        });
    }
    Ok((mean(&map.iter().map(|&error| f64::from(error)).collect::<Vec<_>>(), reference.width()), map))
}

/// Below this, the floor of the automatic exposures, 2⁻²³, could be reached.
const DIM: f32 = 1.0 / 1_048_576.0;

fn planes(image: &Image, number: impl Fn(f32) -> f32) -> Result<RgbImage<f32>, flip_rs::FlipError> {
    let numbers = image.rgb().as_flattened().iter().map(|&value| number(value)).collect();
    RgbImage::new(image.width(), image.height(), numbers)
}

#[cfg(test)]
mod tests;
