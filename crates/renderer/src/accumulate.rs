//! Passes of a picture, added up.

use crate::output::Image;
use caustic_kernels::num::pcg4d;
use caustic_kernels::trace::{LayerPixel, Pixel};

/// Key with which the seeds of passes are drawn.
const PASS_KEY: u32 = 0x9a55_0000;

/// What the passes of a render have come to. Sums are in f64 and in the order of the passes, so that a render that went on from
/// here has the bits of one that was never stopped.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProgressState {
    /// Pixels in a row and in a column.
    pub size: [u32; 2],
    /// Passes that are in the sums.
    pub passes: u32,
    /// Radius of the first pass, m.
    pub first_radius: f32,
    /// Photons emitted for all maps of all passes.
    pub photons: u64,
    /// Rays of camera paths and towards lights.
    pub rays: u64,
    /// Camera paths that were given up.
    pub lost: u64,
    /// Camera samples that were not finite.
    pub not_finite: u64,
    /// Sum of the pixels of all passes, W·sr⁻¹·m⁻².
    pub sum: Vec<[f64; 3]>,
    /// Sum of their squares.
    pub squares: Vec<[f64; 3]>,
    /// Sum of the layers of all passes, the words of a [`LayerPixel`] each; empty if there are none.
    pub layers: Vec<[f64; LAYER_WORDS]>,
}

/// Words of a [`LayerPixel`].
pub const LAYER_WORDS: usize = size_of::<LayerPixel>() / size_of::<f32>();

impl ProgressState {
    /// No pass yet, of a picture with or without layers.
    #[must_use]
    pub fn new(size: [u32; 2], first_radius: f32, has_layers: bool) -> Self {
        let pixels = size[0] as usize * size[1] as usize;
        let none = vec![[0.0; 3]; pixels];
        let layers = vec![[0.0; LAYER_WORDS]; if has_layers { pixels } else { 0 }];
        Self { size, first_radius, sum: none.clone(), squares: none, layers, ..Self::default() }
    }

    /// Adds a pass.
    pub(crate) fn add(&mut self, film: &[Pixel], layers: &[LayerPixel], photons: u64) {
        for (sum, pixel) in self.layers.iter_mut().zip(layers) {
            let words: [f32; LAYER_WORDS] = bytemuck::cast(*pixel);
            sum.iter_mut().zip(words).for_each(|(sum, word)| *sum += f64::from(word));
        }
        for ((sum, squares), pixel) in self.sum.iter_mut().zip(&mut self.squares).zip(film) {
            for channel in 0..3 {
                let value = f64::from(pixel.rgb[channel]);
                sum[channel] += value;
                squares[channel] += value * value;
            }
        }
        let count = |of: fn(&Pixel) -> u32| film.iter().map(|pixel| u64::from(of(pixel))).sum::<u64>();
        self.passes += 1;
        self.photons += photons;
        self.rays += count(|pixel| pixel.rays);
        self.lost += count(|pixel| pixel.lost);
        self.not_finite += count(|pixel| pixel.not_finite);
    }

    /// The picture so far: the mean of the passes.
    #[must_use]
    pub fn image(&self) -> Image {
        let n = f64::from(self.passes.max(1));
        let rgb = self.sum.iter().map(|sum| sum.map(|value| (value / n) as f32)).collect();
        Image { width: self.size[0], height: self.size[1], rgb }
    }

    /// The layers so far: the mean of the passes.
    #[must_use]
    pub(crate) fn layer_pixels(&self) -> Vec<LayerPixel> {
        let n = f64::from(self.passes.max(1));
        self.layers.iter().map(|sum| bytemuck::cast(sum.map(|value| (value / n) as f32))).collect()
    }

    /// Variance of the picture: s²/n of each value, s² being the variance of the passes; nothing before the second pass. Progressive
    /// passes have shrinking radii, so that their scatter is a little more than noise.
    #[must_use]
    pub fn variance(&self) -> Option<Vec<[f64; 3]>> {
        if self.passes < 2 {
            return None;
        }
        let n = f64::from(self.passes);
        let variance = |sum: f64, squares: f64| ((squares - sum * sum / n) / (n - 1.0) / n).max(0.0);
        let pixels = self.sum.iter().zip(&self.squares);
        Some(pixels.map(|(sum, squares)| std::array::from_fn(|c| variance(sum[c], squares[c]))).collect())
    }

    /// [`variance`](Self::variance) as a layer; 0 before the second pass.
    pub(crate) fn variance_layer(&self) -> Vec<f32> {
        let variance = self.variance().unwrap_or_else(|| vec![[0.0; 3]; self.sum.len()]);
        variance.as_flattened().iter().map(|&value| value as f32).collect()
    }

    /// Estimate of how noisy the picture is: the relMSE that its variance alone would give against a perfect one, the mean of
    /// s²/n over value² + 0.01. What a radius blurs is not in it.
    #[must_use]
    pub fn noise(&self) -> Option<f64> {
        let variance = self.variance()?;
        let n = f64::from(self.passes);
        let values = variance.as_flattened().iter().zip(self.sum.as_flattened());
        let sum: f64 = values.map(|(variance, sum)| variance / ((sum / n).powi(2) + 0.01)).sum();
        Some(sum / variance.as_flattened().len() as f64)
    }
}

/// Seed of a pass. The first one has the render's own, so that a render of one pass is that pass.
pub(crate) fn pass_seed(seed: u32, pass: u32) -> u32 {
    if pass == 0 { seed } else { pcg4d([seed, pass, PASS_KEY, 0])[0] }
}

/// Radius of a pass, counted from 0: r²ᵢ₊₁ = r²ᵢ·(i + α)/(i + 1) for i = 1, 2, … (Knaus and Zwicker, "Progressive Photon Mapping: A
/// Probabilistic Approach", 2011, equation 15), no less than `least`. The variance of the mean then falls as N^−α and the squared bias
/// as N^−2(1−α): at α = 2/3 both as N^−2/3.
pub(crate) fn pass_radius(first: f32, pass: u32, alpha: f32, least: f32) -> f32 {
    let mut radius2 = f64::from(first).powi(2);
    for i in 1..=pass {
        radius2 *= (f64::from(i) + f64::from(alpha)) / (f64::from(i) + 1.0);
    }
    (radius2.sqrt() as f32).max(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(value: f32) -> Vec<Pixel> {
        vec![Pixel { rgb: [value, 2.0 * value, 0.0], rays: 3, ..Pixel::default() }; 2]
    }

    #[test]
    fn a_picture_is_the_mean_of_its_passes_and_its_variance_that_of_a_mean() {
        let mut state = ProgressState::new([2, 1], 0.1, false);
        assert_eq!(state.image().rgb, [[0.0; 3]; 2]);
        for value in [1.0, 2.0, 6.0] {
            state.add(&film(value), &[], 10);
        }
        assert_eq!(state.image().rgb, [[3.0, 6.0, 0.0]; 2]);
        // The passes scatter by s² = 7, over 3 passes.
        let variance = state.variance().unwrap();
        assert!((variance[0][0] - 7.0 / 3.0).abs() < 1e-12 && (variance[1][1] - 28.0 / 3.0).abs() < 1e-12);
        let noise = (7.0 / 3.0 / 9.01 + 28.0 / 3.0 / 36.01) / 3.0;
        assert!((state.noise().unwrap() - noise).abs() < 1e-12);
        assert_eq!((state.passes, state.photons, state.rays), (3, 30, 18));
    }

    #[test]
    fn one_pass_is_the_picture_and_has_no_variance() {
        let mut state = ProgressState::new([2, 1], 0.1, false);
        state.add(&film(0.123_456_7), &[], 1);
        assert_eq!(state.image().rgb[0], [0.123_456_7, 2.0 * 0.123_456_7, 0.0]);
        assert!(state.variance().is_none() && state.noise().is_none());
    }

    #[test]
    fn radii_shrink_as_published_and_seeds_differ() {
        assert_eq!(pass_radius(0.1, 0, 0.5, 0.0), 0.1);
        // r₂² = r₁²·(1 + α)/2, r₃² = r₂²·(2 + α)/3.
        let third = 0.1 * (1.5f64 / 2.0 * 2.5 / 3.0).sqrt();
        assert!((f64::from(pass_radius(0.1, 2, 0.5, 0.0)) - third).abs() < 1e-8);
        // In the end as the power (α − 1)/2 of the passes.
        let slope =
            (pass_radius(1.0, 40_000, 2.0 / 3.0, 0.0) / pass_radius(1.0, 10_000, 2.0 / 3.0, 0.0)).ln() / 4f32.ln();
        assert!((slope + 1.0 / 6.0).abs() < 1e-3, "{slope}");
        assert_eq!(pass_radius(0.1, 1000, 0.01, 0.05), 0.05);
        let mut seeds: Vec<u32> = (0..1000).map(|pass| pass_seed(7, pass)).collect();
        assert_eq!(seeds[0], 7);
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), 1000);
    }
}
