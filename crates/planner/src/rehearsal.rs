//! The first passes of a render as it was chosen, before it is asked for: what they take and how noisy and blurred they are say how far a survey is off there.

use crate::scout::{Scout, of_maps};
use crate::survey::{Correction, SEEDS, STEP, Survey, median, noise_and_blur, seeds, within};
use caustic_device::Device;
use caustic_renderer::scene::CompiledScene;
use caustic_renderer::{RenderError, Settings};
use serde::{Deserialize, Serialize};

/// Most time of a pass that is rehearsed, s; or this part of the whole render.
const LONGEST: f64 = 1.0;
const PART: f64 = 0.025;
/// Passes shorter than this are timed three times, s: other programs disturb them more.
const SHORT: f64 = 0.3;

/// Passes after the first that are timed.
const MORE: u32 = 2;
/// Most times as much blur as was foreseen that a rehearsal is believed to see: more is a bright speck.
const MOST_BLUR: f64 = 3.0;
/// Fewest photons in a disc that another one is compared with.
const LEAST: u32 = 2;

/// What came of the first passes of some settings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rehearsal {
    /// A render of one pass, on a device that holds no memory yet, s.
    pub first_s: f64,
    /// A pass after others, s.
    pub pass_s: f64,
    /// relMSE from photons; 0 if there are no maps.
    pub photon_noise: f64,
    /// Mean square of how much the picture differs from one with discs of fewer photons but for noise, as relMSE.
    pub blur: f64,
    /// How many times fewer these are.
    pub step: f64,
}

impl Rehearsal {
    /// Whether a render that takes so long as a whole, with passes of so many seconds, is worth one.
    pub(crate) fn is_worth_it(seconds: f64, pass_seconds: f64) -> bool {
        pass_seconds <= LONGEST.max(PART * seconds)
    }

    /// Renders a few passes of `settings`, with other seeds.
    ///
    /// # Errors
    /// Those of renders; [`RenderError::Interrupted`] if the scout is not to go on.
    pub fn take(scout: &mut Scout<'_>, settings: &Settings) -> Result<Self, RenderError> {
        let (mut first, mut later) = (Vec::new(), Vec::new());
        for seed in SEEDS {
            let settings = Settings { seed, ..settings.clone() };
            let mut timed = |passes| -> Result<f64, RenderError> {
                scout.device.trim();
                Ok(scout.plain(&settings, passes)?.seconds())
            };
            let (one, all) = (timed(1)?, timed(1 + MORE)?);
            first.push(one);
            later.push((all - one).max(0.0) / f64::from(MORE));
            if one > SHORT {
                break;
            }
        }
        let k = (settings.k / STEP).max(LEAST).min(settings.k);
        let step = f64::from(settings.k) / f64::from(k);
        let [photon_noise, blur] = if of_maps(settings) {
            let radius = within(f64::from(settings.radius) / step.sqrt());
            let less = seeds(scout, &Settings { k, radius, ..settings.clone() })?;
            noise_and_blur([&less, &seeds(scout, settings)?])
        } else {
            [0.0; 2]
        };
        Ok(Self { first_s: median(first), pass_s: median(later), photon_noise, blur, step })
    }
}

impl Survey {
    /// This survey as a rehearsal of `settings` corrects it, there and near.
    #[must_use]
    pub fn corrected(
        &self,
        scene: &CompiledScene,
        settings: &Settings,
        rehearsal: &Rehearsal,
        device: &Device,
    ) -> Self {
        let plain = Self { correction: Correction::default(), ..self.clone() };
        let foreseen = plain.predict(scene, settings, 1, device);
        let ratio = |came: f64, foreseen: f64| if came > 0.0 && foreseen > 0.0 { came / foreseen } else { 1.0 };
        let correction = Correction {
            setup_s: rehearsal.first_s - rehearsal.pass_s - plain.setup_s,
            pass: ratio(rehearsal.pass_s, foreseen.pass_seconds),
            photon_noise: ratio(rehearsal.photon_noise, foreseen.noise - foreseen.sample_noise),
            // Smaller discs have some of the blur as well. The survey's own estimate is as good as this one: neither is precise, and their mean is
            // better than either.
            blur: if rehearsal.step > 1.0 && foreseen.bias > 0.0 {
                let share = 1.0 - rehearsal.step.powf(-self.blur_power());
                let seen = rehearsal.blur.max(0.0) / share.powi(2);
                0.5 + 0.5 * (seen / foreseen.bias).min(MOST_BLUR)
            } else {
                1.0
            },
        };
        Self { correction, ..plain }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::Surveyor;
    use crate::scout::Costs;
    use caustic_renderer::scene::Scene;

    /// What is foreseen of settings that were rehearsed is what came of them.
    #[test]
    fn a_corrected_survey_foresees_what_was_rehearsed() {
        let (scene, device) = (Scene::load("cornell").unwrap(), Device::cpu());
        let compiled = scene.compile();
        let settings =
            Settings { size: [24, 16], photons: 5000, caustic_photons: 2000, k: 20, spp: 2, ..Settings::of(&scene) };
        let mut go_on = || true;
        let scout = Scout::new(&scene, &device, Costs::BuiltIn, &mut go_on);
        let survey = Surveyor::new(scout, None).survey(&settings).unwrap();
        let plain = survey.predict(&compiled, &settings, 1, &device);
        let share = 1.0 - 4f64.powf(-survey.blur_power());
        let rehearsal = Rehearsal {
            first_s: 3.0,
            pass_s: 2.0,
            photon_noise: 0.25,
            blur: 2.0 * plain.bias * share * share,
            step: 4.0,
        };
        let corrected = survey.corrected(&compiled, &settings, &rehearsal, &device);
        let [one, four] = [1, 4].map(|passes| corrected.predict(&compiled, &settings, passes, &device));
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
        assert!(near(one.seconds, 3.0) && near(four.seconds, 9.0) && near(four.pass_seconds, 2.0), "{one:?} {four:?}");
        assert!(near(one.noise - one.sample_noise, 0.25) && near(one.sample_noise, plain.sample_noise), "{one:?}");
        assert!(near(one.bias, 1.5 * plain.bias), "{one:?} {plain:?}");
        // A second correction replaces the first.
        assert_eq!(corrected.corrected(&compiled, &settings, &rehearsal, &device), corrected);
    }

    #[test]
    fn what_takes_long_is_not_rehearsed() {
        assert!(Rehearsal::is_worth_it(0.2, 0.2) && Rehearsal::is_worth_it(200.0, 5.0));
        assert!(!Rehearsal::is_worth_it(20.0, 5.0));
    }
}
