//! What limited a picture, and what to do about it.

use crate::predict::Prediction;
use crate::survey::{Survey, within};
use caustic_device::Device;
use caustic_renderer::scene::CompiledScene;
use caustic_renderer::scene::limits::{MAX_K, MAX_PHOTONS, MAX_SPP};
use caustic_renderer::{RenderReport, Settings};

/// Photons of a map for each in an estimate below which the estimates are of much of the scene.
const STARVED: u32 = 20;

/// A paragraph about a finished render: what limited it, and which flag buys the most for the next second.
#[must_use]
pub fn advice(
    survey: &Survey,
    scene: &CompiledScene,
    settings: &Settings,
    report: &RenderReport,
    device: &Device,
) -> String {
    let passes = report.passes.max(1);
    let now = survey.predict(scene, settings, passes, device);
    let starved = report.maps.iter().find(|map| map.photons_stored < STARVED.saturating_mul(settings.k));
    let [samples, photons] = [now.sample_noise, now.noise - now.sample_noise];
    let parts = [(samples, "noise of the camera's samples"), (photons, "noise of photons"), (now.bias, "blur")];
    let (most, what) = parts.into_iter().fold((-1.0, ""), |most, part| if part.0 > most.0 { part } else { most });
    let mut text = format!(
        "quality: an expected relMSE of {:.1e}, most of it ({:.0} %) {what}",
        now.error(),
        100.0 * most / now.error().max(f64::MIN_POSITIVE)
    );
    if let Some(map) = starved {
        text += &format!(
            "; the {} map has only {} photons for estimates of {}, so that much of it is one blot",
            map.map, map.photons_stored, settings.k
        );
    }
    if let Some((flag, then)) = best_step(survey, scene, settings, passes, &now, device) {
        text += &format!(
            ". What buys the most is {flag}: {:.1e} for {:.2} s more",
            then.error(),
            (then.seconds - now.seconds).max(0.0)
        );
    }
    text + "."
}

/// Of all flags, each doubled or halved, the one that takes away the most error for a second.
fn best_step(
    survey: &Survey,
    scene: &CompiledScene,
    settings: &Settings,
    passes: u32,
    now: &Prediction,
    device: &Device,
) -> Option<(String, Prediction)> {
    let of = |settings: Settings, passes: u32| survey.predict(scene, &settings, passes, device);
    let twice = |value: u32, most: u32| value.saturating_mul(2).min(most);
    let [photons, caustic] = [settings.photons, settings.caustic_photons].map(|photons| twice(photons, MAX_PHOTONS));
    let spp = twice(settings.spp, MAX_SPP);
    let with_k = |k: u32, photons: u32| within(survey.radius_for(k, photons));
    let k_less = (settings.k / 2).max(1);
    let k_more = twice(settings.k, MAX_K);
    let steps = [
        (format!("--spp {spp}"), of(Settings { spp, ..settings.clone() }, passes)),
        (format!("--passes {}", 2 * passes), of(settings.clone(), 2 * passes)),
        (
            format!("--photons {photons} --caustic-photons {caustic}"),
            of(Settings { photons, caustic_photons: caustic, ..settings.clone() }, passes),
        ),
        (format!("--k {k_less}"), of(Settings { k: k_less, ..settings.clone() }, passes)),
        (
            format!("--k {k_more} --radius {}", with_k(k_more, settings.photons)),
            of(Settings { k: k_more, ..settings.clone() }, passes),
        ),
    ];
    let gain = |then: &Prediction| {
        let less = (now.error() / then.error().max(f64::MIN_POSITIVE)).ln();
        // What costs nothing is worth as much as if it took a hundredth of the render.
        less / (then.seconds - now.seconds).max(0.01 * now.seconds)
    };
    let best = steps.into_iter().max_by(|a, b| gain(&a.1).total_cmp(&gain(&b.1)))?;
    (gain(&best.1) > 0.0).then_some(best)
}
