//! The first passes of a render as it was chosen, before it is asked for: what they take and how noisy they are say how far a survey is off there.

use crate::scout::{Scout, of_maps};
use crate::survey::{Correction, SEEDS, Survey, median, noise_of_maps, seeds};
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

/// What came of the first passes of some settings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rehearsal {
    /// A render of one pass, on a device that holds no memory yet, s.
    pub first_s: f64,
    /// A pass after others, s.
    pub pass_s: f64,
    /// relMSE from photons; 0 if there are no maps.
    pub photon_noise: f64,
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
        let photon_noise = if of_maps(settings) { noise_of_maps(&seeds(scout, settings)?) } else { 0.0 };
        Ok(Self { first_s: median(first), pass_s: median(later), photon_noise })
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
        };
        Self { correction, ..plain }
    }
}
