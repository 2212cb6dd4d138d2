//! Yee's perceptual metric: which pixels of two pictures differ visibly.
//!
//! Written from Yee, "Spatiotemporal sensitivity and visual attention for efficient rendering of dynamic environments" (master's
//! thesis, Cornell, 2000, and Yee, Pattanaik and Greenberg, ACM Transactions on Graphics 20(1), 2001), of which this is the spatial
//! part; Yee and Newman, "A perceptual metric for production testing" (SIGGRAPH 2004 sketches); and the model that both build
//! on: Ramasubramanian, Pattanaik and Greenberg, "A perceptually based physical error metric for realistic image synthesis" (SIGGRAPH
//! 1999).

mod bands;
mod colour;
pub mod sensitivity;

#[cfg(test)]
mod tests;

use crate::score::check_sizes;
use crate::{Image, MetricsError};
use bands::{Blurred, local_mean};
use rayon::prelude::*;
use sensitivity::{DARKNESS, contrast_sensitivity, frequency_factor, masking, threshold_versus_intensity};

/// How the pictures are looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YeeOptions {
    /// The angle that a row of the picture spans, in degrees, 0.1 to 170. By default 45: a monitor 0.6 m wide seen from 0.72 m.
    pub field_of_view: f64,
    /// The luminance of white, the linear number 1, in cd/m², 0.01 to 10⁶. By default 100, as of monitors that are graded on.
    ///
    /// There is no gamma: PNGs are decoded as sRGB, and EXR and HDR hold linear light.
    pub white: f64,
}

impl Default for YeeOptions {
    fn default() -> Self {
        Self { field_of_view: 45.0, white: 100.0 }
    }
}

impl YeeOptions {
    /// Pixels in a degree at the middle of a picture, which is flat: w · (π / 180) / (2 tan(φ / 2)) for w pixels over φ.
    #[must_use]
    pub fn pixels_per_degree(&self, width: usize) -> f64 {
        width as f64 * 1f64.to_radians() / (2.0 * (self.field_of_view.to_radians() / 2.0).tan())
    }

    fn check(&self) -> Result<(), MetricsError> {
        let angle = ("field of view in degrees", self.field_of_view, 0.1..=170.0, "from 0.1 to 170");
        let white = ("luminance of white in cd/m²", self.white, 0.01..=1e6, "from 0.01 to 1e6");
        for (name, value, bounds, range) in [angle, white] {
            if !bounds.contains(&value) {
                return Err(MetricsError::Parameter { name, value, range });
            }
        }
        Ok(())
    }
}

/// Number of pixels that differ visibly, and by how much each differs: its difference over the least that is visible. Symmetric.
///
/// A pixel differs visibly if its luminances do, |Y_a − Y_b| > F · TVI(L_a) (Yee and Newman 2004; Ramasubramanian et al. 1999), or
/// its colours do, s(L_a) · √(Δa*² + Δb*²) > F (Yee and Newman 2004), where
///
/// * Y is luminance in cd/m² (linear sRGB by the second row of IEC 61966-2-1's matrix, times [`YeeOptions::white`]; negative
///   light is black);
/// * L_a, what the eye has adapted to, is the mean luminance of both pictures within the degree around the pixel (Ward Larson et al.
///   1997, foveal adaptation);
/// * TVI is [`sensitivity::threshold_versus_intensity`];
/// * F, how far what is there raises the threshold, is the mean of Fcsf · Fmask over bands, weighted by the bands' contrasts
///   (Yee, Pattanaik and Greenberg 2001): Fcsf by [`sensitivity::frequency_factor`], Fmask by [`sensitivity::masking`];
/// * bands are the levels of a Laplacian pyramid (Burt and Adelson 1983) down to half a cycle a degree, and a band's contrast is
///   |G_k − G_(k+1)| / G_(k+2) (Peli 1990, as Ramasubramanian et al. take it);
/// * a* and b* are CIELAB's, and s takes colour away where it is too dark to see it ([`sensitivity::colour_vision`]).
///
/// Two pictures are compared where the papers judge one, so three things are added, each of which only makes more differences visible.
/// A difference is masked by what both pictures have (Daly 1993, mutual masking): noise that is in one of them
/// does not hide itself. F is never raised by bands whose contrast cannot be seen: the least visible contrast counts as a
/// band without elevation, so on even fields F is 1. And Fcsf is 1 at the frequency that is seen best at L_a.
///
/// What it forgives, as published: F is a mean over bands, so that where a degree has many pixels the finest bands, which hardly
/// anyone sees, raise the threshold of all; and a strong texture of both hides differences as large as itself. FLIP sees those.
///
/// # Errors
/// If the sizes differ or a parameter is out of bounds.
pub fn yee(test: &Image, reference: &Image, options: &YeeOptions) -> Result<(usize, Vec<f32>), MetricsError> {
    check_sizes(test, reference)?;
    options.check()?;
    let (width, height) = (test.width(), test.height());
    let pixels_per_degree = options.pixels_per_degree(width);
    let luminances = [test, reference].map(|image| luminance(image, options.white));
    let both: Vec<f64> =
        luminances[0].par_iter().zip(&luminances[1]).map(|(&a, &b)| (f64::from(a) + f64::from(b)) / 2.0).collect();
    let adapted = local_mean(&both, width, height, pixels_per_degree);
    let elevations = elevations(&luminances, &adapted, width, pixels_per_degree);
    let map: Vec<f32> = (0..width * height)
        .into_par_iter()
        .map(|i| {
            let bright = f64::from((luminances[0][i] - luminances[1][i]).abs());
            let chroma = colour::chroma_difference(test.rgb()[i], reference.rgb()[i]);
            let by_luminance = bright / (elevations[i] * threshold_versus_intensity(adapted[i]));
            let by_colour = sensitivity::colour_vision(adapted[i]) * chroma / elevations[i];
            by_luminance.max(by_colour).min(f64::from(f32::MAX)) as f32
        })
        .collect();
    Ok((map.iter().filter(|&&times| times > 1.0).count(), map))
}

/// Luminance in cd/m². It is cut off above the sun's, 1.6·10⁹, where sums over a degree would lose what is dark.
fn luminance(image: &Image, white: f64) -> Vec<f32> {
    let luminance = |rgb: &[f32; 3]| (white * colour::luminance(*rgb)).clamp(0.0, 1e10) as f32;
    image.rgb().par_iter().map(luminance).collect()
}

/// F of each pixel.
fn elevations(luminances: &[Vec<f32>; 2], adapted: &[f64], width: usize, pixels_per_degree: f64) -> Vec<f64> {
    // Sums over bands of contrast, and of contrast times elevation.
    let mut sums = vec![[0.0f64; 2]; adapted.len()];
    // The finest band is between half the sampling frequency and a quarter, each other an octave below.
    let frequencies = (0..MAX_BANDS).map(|band| 0.5 * pixels_per_degree / f64::from(1u32 << band));
    let mut levels = luminances.each_ref().map(|plane| Blurred::new(plane, width));
    for frequency in frequencies.take_while(|&frequency| frequency >= LOWEST_FREQUENCY) {
        sums.par_iter_mut().enumerate().for_each(|(i, [contrasts, raised])| {
            let luminance = adapted[i].max(DARKNESS);
            let found = levels.each_ref().map(|levels| levels.contrast(i));
            let seen = found.map(|contrast| contrast * contrast_sensitivity(frequency, luminance));
            let contrast = found[0].max(found[1]);
            *contrasts += contrast;
            *raised += contrast * frequency_factor(frequency, luminance) * masking(seen[0].min(seen[1]));
        });
        levels.iter_mut().for_each(Blurred::next);
    }
    let elevation = |(&[contrasts, raised], &luminance): (&[f64; 2], &f64)| {
        let least = 1.0 / sensitivity::highest_contrast_sensitivity(luminance.max(DARKNESS));
        (least + raised) / (least + contrasts)
    };
    sums.par_iter().zip(adapted).map(elevation).collect()
}

/// Coarser bands are left out, in cycles a degree: a difference that wide is seen by its outline.
const LOWEST_FREQUENCY: f64 = 0.5;

/// More bands than any eye has pixels for: 2¹⁶ · 0.5 cycles a degree.
const MAX_BANDS: u32 = 16;
