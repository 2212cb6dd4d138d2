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

/// The smallest chance of a light times the number of lights: none is so weak that it is hardly drawn, or starves for photons. The
/// strong ones pay for it with an eighth of theirs at the most.
const LEAST: f64 = 1.0 / 8.0;
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

/// Hands out a pass's photons to its lights, in proportion to their chances and at least one to each that takes part; the others get none. There
/// have to be as many photons as such lights.
pub(super) fn share_photons(lights: &mut [Light], photons: u32, takes_part: impl Fn(&Light) -> bool) {
    let weight = |light: &Light| if takes_part(light) { f64::from(light.probability) } else { 0.0 };
    let total: f64 = lights.iter().map(weight).sum();
    let taking_part = lights.iter().filter(|light| takes_part(light)).count() as u32;
    // What is left when each has one is cut at the sums of the chances, so that all is handed out.
    let rest = f64::from(photons.saturating_sub(taking_part));
    let (mut sum, mut ones, mut first) = (0.0, 0, 0);
    for light in lights {
        sum += weight(light);
        ones += u32::from(takes_part(light));
        let end = if ones == taking_part { photons } else { ones + (rest * sum / total) as u32 };
        light.first_photon = first;
        light.photons = end - first;
        first = end;
    }
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

    #[test]
    fn photons_are_handed_out_to_the_last_and_nobody_starves() {
        let mut sources: Vec<Source> = (0..256).map(|i| source(if i == 9 { 1e6 } else { 1e-6 })).collect();
        sources[3].power_w = DVec3::splat(5.0);
        let mut lights: Vec<Light> = chances(&sources)
            .into_iter()
            .map(|chance| Light { probability: chance.probability, cumulative: chance.cumulative, ..Light::default() })
            .collect();
        for (photons, out) in [(256, 300), (1_000_000, 300), (1_000_000, 9), (255, 0)] {
            share_photons(&mut lights, photons, |light| light.cumulative != 0.0 || out == 300);
            let all: u32 = lights.iter().map(|light| light.photons).sum();
            assert_eq!(all, photons);
            let mut first = 0;
            for light in &lights {
                assert_eq!(light.first_photon, first);
                first += light.photons;
            }
        }
        share_photons(&mut lights, 1_000_000, |_| true);
        // An eighth of an equal share, 3906, less what that took from the whole.
        assert!(lights.iter().all(|light| light.photons >= 430), "{:?}", lights.iter().map(|l| l.photons).min());
        assert!(lights[9].photons > 880_000);
        let left_out = lights[9].probability;
        share_photons(&mut lights, 1000, |light| light.probability != left_out);
        assert_eq!((lights[9].photons, lights.iter().map(|light| light.photons).sum::<u32>()), (0, 1000));
    }
}
