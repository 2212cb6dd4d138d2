//! What an eye can tell apart, by published measurements.

/// 10^−3.94 cd/m²: in less light the threshold is constant (the first branch of [`threshold_versus_intensity`]), so other formulas are
/// not taken below.
pub const DARKNESS: f64 = 1.148_153_621_496_883e-4;

/// The least difference of luminance that is seen on a field of luminance `adapted`, both in cd/m².
///
/// Ward Larson, Rushmeier and Piatko, "A visibility matching tone reproduction operator for high dynamic range scenes" (IEEE
/// Transactions on Visualization and Computer Graphics 3(4), 1997), table 1, after Ferwerda, Pattanaik, Shirley and
/// Greenberg (SIGGRAPH 1996). With l = log₁₀ `adapted`, log₁₀ of the threshold is
///
/// | −2.86 | l < −3.94 |
/// | --- | --- |
/// | (0.405 l + 1.6)^2.18 − 2.86 | l < −1.44 |
/// | l − 0.395 | l < −0.0184 |
/// | (0.249 l + 0.65)^2.7 − 0.72 | l < 1.9 |
/// | l − 1.255 | else |
#[must_use]
pub fn threshold_versus_intensity(adapted: f64) -> f64 {
    let l = adapted.log10();
    let threshold = if l < -3.94 {
        -2.86
    } else if l < -1.44 {
        (0.405 * l + 1.6).powf(2.18) - 2.86
    } else if l < -0.0184 {
        l - 0.395
    } else if l < 1.9 {
        (0.249 * l + 0.65).powf(2.7) - 0.72
    } else {
        l - 1.255
    };
    10f64.powf(threshold)
}

/// One over the least contrast that is seen of a grating of `frequency` cycles a degree at `adapted` cd/m².
///
/// Barten, "The square root integral (SQRI): a new metric to describe the effect of various display parameters on perceived image
/// quality" (SPIE 1077, 1989), as Ramasubramanian et al. 1999 take it: a ρ e^(−bρ) √(1 + c e^(bρ)) with
/// a = 440 (1 + 0.7/L)^−0.2, b = 0.3 (1 + 100/L)^0.15 and c = 0.06.
#[must_use]
pub fn contrast_sensitivity(frequency: f64, adapted: f64) -> f64 {
    amplitude(adapted) / decay(adapted) * shape(decay(adapted) * frequency)
}

/// The largest [`contrast_sensitivity`] at `adapted` cd/m².
#[must_use]
pub fn highest_contrast_sensitivity(adapted: f64) -> f64 {
    amplitude(adapted) / decay(adapted) * shape(BEST)
}

/// How many times the contrast must be what it must be at the frequency that is seen best: the highest contrast sensitivity over that
/// at `frequency` cycles a degree (Ramasubramanian et al. 1999, spatially dependent processing). At most 10⁶.
#[must_use]
pub fn frequency_factor(frequency: f64, adapted: f64) -> f64 {
    (shape(BEST) / shape(decay(adapted) * frequency)).min(1e6)
}

/// How far a pattern raises the threshold of what lies over it, 1 or more. `seen` is the pattern's contrast times the
/// [`contrast_sensitivity`]: 1 is just visible.
///
/// Daly, "The visible differences predictor: an algorithm for the assessment of image fidelity" (in Watson, Digital Images and Human
/// Vision, 1993), threshold elevation: (1 + (k₁ (k₂ m)^s)^b)^(1/b), with k₁ = W^(1 − 1/(1 − Q)) = 0.0153, k₂ = W^(1/(1 − Q)) = 392.5 for
/// W = 6 and Q = 0.7, a slope s of 0.7 and b = 4.
#[must_use]
pub fn masking(seen: f64) -> f64 {
    const K1: f64 = 0.015_286_7;
    const K2: f64 = 392.498;
    (1.0 + (K1 * (K2 * seen).powf(0.7)).powi(4)).powf(0.25)
}

/// How much of colour is seen at `adapted` cd/m², 0 to 1: nothing below 0.01, where only rods see, all above 10, where only cones do
/// (the ranges of Ferwerda et al. 1996), and in between in proportion to the logarithm. Yee and Newman 2004 turn the test of colour
/// down in mesopic light and off in scotopic light; the ramp is ours.
#[must_use]
pub fn colour_vision(adapted: f64) -> f64 {
    ((adapted.log10() + 2.0) / 3.0).clamp(0.0, 1.0)
}

fn amplitude(adapted: f64) -> f64 {
    440.0 * (1.0 + 0.7 / adapted).powf(-0.2)
}

fn decay(adapted: f64) -> f64 {
    0.3 * (1.0 + 100.0 / adapted).powf(0.15)
}

/// Barten's function of u = bρ: a ρ e^(−bρ) √(1 + c e^(bρ)) is (a/b) times it, at any luminance.
fn shape(u: f64) -> f64 {
    u * ((-2.0 * u).exp() + 0.06 * (-u).exp()).sqrt()
}

/// Where [`shape`] is largest: the root of 1/u − 1 + 0.03 eᵘ / (1 + 0.06 eᵘ).
const BEST: f64 = 1.081_264_145_306_999;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_those_of_the_table() {
        // By hand, one of each branch, and no step between two.
        for (adapted, threshold) in [
            (1e-5, 1.380e-3),
            (0.01, 5.472e-3),
            (0.1, 4.027e-2),
            (1.0, 0.391_3),
            (10.0, 1.072),
            (100.0, 5.559),
            (1e4, 555.9),
        ] {
            let found = threshold_versus_intensity(adapted);
            assert!((found / threshold - 1.0).abs() < 2e-3, "{adapted}: {found} instead of {threshold}");
        }
        for l in [-3.94, -1.44, -0.0184, 1.9f64] {
            let [below, above] = [l - 1e-9, l + 1e-9].map(|l| threshold_versus_intensity(10f64.powf(l)).log10());
            assert!((below - above).abs() < 0.02, "10^{l}: {below} {above}");
        }
        assert_eq!(threshold_versus_intensity(0.0), threshold_versus_intensity(1e-6));
    }

    #[test]
    fn contrast_sensitivity_is_bartens_and_its_peak_is_the_peak() {
        // By hand: a = 439.4, b = 0.3329 at 100 cd/m².
        assert!((contrast_sensitivity(4.0, 100.0) / 514.2 - 1.0).abs() < 2e-3, "{}", contrast_sensitivity(4.0, 100.0));
        for adapted in [DARKNESS, 0.01, 1.0, 100.0, 1e4] {
            let highest = highest_contrast_sensitivity(adapted);
            let found = (1..6000).map(|i| contrast_sensitivity(f64::from(i) / 100.0, adapted)).fold(0.0, f64::max);
            assert!(found <= highest * (1.0 + 1e-12) && found > highest * 0.9999, "{adapted}: {found} of {highest}");
        }
        // Fine gratings and coarse ones are seen worse, and in the dark all are.
        assert!(frequency_factor(30.0, 100.0) > 10.0 && frequency_factor(0.5, 100.0) > 2.0);
        assert!(highest_contrast_sensitivity(0.1) < 0.3 * highest_contrast_sensitivity(100.0));
        assert_eq!(frequency_factor(1e9, 100.0), 1e6);
    }

    #[test]
    fn masking_begins_where_the_mask_is_seen() {
        assert_eq!(masking(0.0), 1.0);
        assert!(masking(0.1) < 1.001);
        // k₂ is k₁^(−1/s), so that a mask that is just visible raises by 2^(1/4).
        assert!((masking(1.0) - 2f64.powf(0.25)).abs() < 1e-3, "{}", masking(1.0));
        // Far above, by its contrast to the power of 0.7.
        assert!((masking(1000.0) / masking(100.0) - 10f64.powf(0.7)).abs() < 1e-3);
    }

    #[test]
    fn colour_goes_with_the_light() {
        assert_eq!([0.0, 1e-3, 0.01, 10.0, 100.0].map(colour_vision), [0.0, 0.0, 0.0, 1.0, 1.0]);
        assert!((colour_vision(1.0) - 2.0 / 3.0).abs() < 1e-12);
    }
}
