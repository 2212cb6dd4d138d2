//! With what chance each light is chosen.

use caustic_kernels::trace::Light;
use glam::DVec3;

/// A light without its chances.
pub(super) struct Source {
    /// The record, but for its chances.
    pub light: Light,
    /// Index of the surface that emits.
    pub surface: Option<usize>,
    /// Power, W, for each of red, green and blue.
    pub power_w: DVec3,
}

/// The chance of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Chance {
    pub probability: f32,
    pub cumulative: f32,
}

/// The smallest chance of a light times the number of lights: no light is so weak that it is never drawn.
const LEAST: f64 = 1.0 / 256.0;
/// The kernels' random numbers are multiples of 1 / STEPS.
const STEPS: f64 = 16_777_216.0;

/// Chances in proportion to the lights' power, the mean of its colours. They are multiples of 2⁻²⁴, as the kernels' random
/// numbers are, so that the chance on record is exactly the one with which a light is drawn.
pub(super) fn chances(sources: &[Source]) -> Vec<Chance> {
    let power = |source: &Source| source.power_w.element_sum() / 3.0;
    let total: f64 = sources.iter().map(power).sum();
    let least = LEAST / sources.len() as f64;
    let weights: Vec<f64> = sources.iter().map(|source| (power(source) / total).max(least)).collect();
    let total: f64 = weights.iter().sum();
    let mut sum = 0.0;
    let mut before = 0.0;
    let mut chances = Vec::with_capacity(weights.len());
    for (i, weight) in weights.iter().enumerate() {
        sum += weight;
        let cumulative = if i + 1 == weights.len() { 1.0 } else { (sum / total * STEPS).round() / STEPS };
        chances.push(Chance { probability: (cumulative - before) as f32, cumulative: cumulative as f32 });
        before = cumulative;
    }
    chances
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(power: f64) -> Source {
        Source { light: Light::default(), surface: None, power_w: DVec3::splat(power) }
    }

    #[test]
    fn chances_follow_power_and_end_at_one() {
        let chances = chances(&[source(1.0), source(3.0)]);
        assert_eq!(chances[0], Chance { probability: 0.25, cumulative: 0.25 });
        assert_eq!(chances[1], Chance { probability: 0.75, cumulative: 1.0 });
    }

    #[test]
    fn chances_are_differences_of_sums_and_never_nought() {
        let sources: Vec<Source> =
            (0..4096).map(|i| source(if i % 7 == 0 { 1e-30 } else { 1.0 / f64::from(i) })).collect();
        let chances = chances(&sources);
        let mut before = 0.0;
        for chance in &chances {
            assert!(chance.probability > 0.0);
            assert_eq!(before + f64::from(chance.probability), f64::from(chance.cumulative));
            before = f64::from(chance.cumulative);
        }
        assert_eq!(before, 1.0);
    }
}
