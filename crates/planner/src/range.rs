//! Scenes and settings near the ends of what f32 holds.

use caustic_device::Device;
use caustic_kernels::layout::Arrival;
use caustic_kernels::trace::RAY_GLOBAL;
use caustic_renderer::Settings;
use caustic_renderer::scene::{CompiledScene, Scene};
use serde::Serialize;

/// Steps of f32 coordinates to a radius below which positions are too coarse for it: estimates are then wrong by a percent, by the stability
/// section of `caustic tradeoff` (RMS 2 % at 29 steps, 6 % at 3.6, 90 % at 0.45).
const COARSE: f64 = 64.0;
/// Steps to a radius below which estimates are wrong by tens of percent.
const BROKEN: f64 = 2.0;
/// The least power that a map keeps, as part of its largest: of three limbs of 22 bits, the last 24 bits are a photon's own.
const LEAST_POWER: f64 = 2e-13;

/// What may go wrong, with the remedy.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Whether a render would be wrong or impossible.
    pub broken: bool,
    /// A sentence.
    pub text: String,
}

/// What is near or beyond the ends of what numbers hold.
#[must_use]
pub fn findings(scene: &Scene, compiled: &CompiledScene, settings: &Settings, device: &Device) -> Vec<Finding> {
    [radius(scene, compiled, settings), powers(compiled, settings), buffers(settings, device)]
        .into_iter()
        .flatten()
        .collect()
}

fn radius(scene: &Scene, compiled: &CompiledScene, settings: &Settings) -> Option<Finding> {
    let (low, high) = compiled.diffuse_bounds;
    let reach = low.iter().chain(&high).map(|x| f64::from(x.abs())).fold(0.0, f64::max);
    let step = reach * f64::from(f32::EPSILON);
    let steps = f64::from(settings.radius) / step;
    if settings.automatic_radius || steps >= COARSE {
        return None;
    }
    let name = &scene.name;
    let least = COARSE * step;
    let text = format!(
        "the radius {} m is {steps:.1} steps of f32 at {reach:.3e} m, where `{name}` reaches: photons lie in too few places for it; use --radius {least:.1e} or more, or a smaller scene",
        settings.radius
    );
    Some(Finding { broken: steps < BROKEN, text })
}

/// Photons of the weakest light beside those of the strongest.
fn powers(compiled: &CompiledScene, settings: &Settings) -> Option<Finding> {
    let emitted = settings.photons.max(compiled.fewest_photons(RAY_GLOBAL));
    let lights = compiled.lights_for(emitted, RAY_GLOBAL);
    let power = lights.iter().filter(|light| light.photons > 0).map(|light| {
        let most = light.emission.iter().copied().fold(0.0, f32::max);
        f64::from(most) * f64::from(light.area.max(f32::MIN_POSITIVE)) / f64::from(light.photons)
    });
    // Areas of points and of surfaces mean different things, but not by factors that matter here.
    let (least, most) = power.filter(|&p| p > 0.0).fold((f64::MAX, 0.0f64), |(a, b), p| (a.min(p), b.max(p)));
    (most > 0.0 && least / most < LEAST_POWER).then(|| Finding {
        broken: false,
        text: format!(
            "photons of the weakest light have {:.0e} of the power of the strongest one's: a map keeps {LEAST_POWER:.0e}, so the weak ones' light is lost where both meet; make the lights less unequal",
            least / most
        ),
    })
}

/// Whether the largest buffer of a map can exist.
fn buffers(settings: &Settings, device: &Device) -> Option<Finding> {
    let photons = settings.photons.max(settings.caustic_photons);
    let at_once = settings.chunk.map_or(photons, |chunk| chunk.cut(photons).1);
    let needed = u64::from(at_once) * size_of::<Arrival>() as u64;
    let most = device.largest_buffer();
    (needed > most).then(|| Finding {
        broken: false,
        text: format!(
            "a map that stores a photon for each that is emitted needs a buffer of {needed} bytes, and {} allows {most}: use --chunk {}, or fewer --photons and more --passes",
            device.name(),
            most / size_of::<Arrival>() as u64
        ),
    })
}
