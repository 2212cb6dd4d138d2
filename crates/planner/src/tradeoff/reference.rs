//! The picture that errors are measured against.

use super::point::base;
use caustic_bench::record;
use caustic_device::Device;
use caustic_metrics::Image;
use caustic_photon_map::Surface;
use caustic_renderer::output::{self, Metadata};
use caustic_renderer::scene::Scene;
use caustic_renderer::{Given, Integrator, Progress, RenderError, Settings, Show, Stop, render_on};
use std::path::Path;

/// Seed of the reference: of no point.
const SEED: u32 = 0x7efe_7e4c;
/// Passes, and those of a quick one.
const PASSES: u32 = 512;
const QUICK_PASSES: u32 = 96;

/// The reference of a scene: what is at `given`, or a progressive render of photons of the same surface only, which converges to the truth but for
/// what the last radius blurs. It is kept in `folder` with all its settings, and taken from there if these are the same.
///
/// # Errors
/// A sentence; `None` if `progress` returned false.
pub fn reference(
    scene: &Scene,
    device: &Device,
    quick: bool,
    show: Show,
    given: Option<&Path>,
    folder: &Path,
    progress: &mut dyn FnMut(Progress) -> bool,
) -> Result<Image, Option<String>> {
    let size = base(scene, quick, show).size;
    let sized = |image: Image, from: &str| {
        if [image.width(), image.height()] == size.map(|side| side as usize) {
            return Ok(image);
        }
        let [width, height] = size;
        Err(Some(format!(
            "--reference: {from} has {} × {} pixels, and the pictures have {width} × {height}; render it with --size {width}x{height}",
            image.width(),
            image.height()
        )))
    };
    if let Some(path) = given {
        let image = Image::read(path).map_err(|error| Some(format!("--reference: {error}")))?;
        return sized(image, &format!("`{}`", path.display()));
    }
    let settings = settings(scene, quick, show);
    let identity = format!("caustic {} {} {settings:?}\n", env!("CARGO_PKG_VERSION"), scene.compile().sha256());
    let (picture, beside) = (folder.join("reference.exr"), folder.join("reference.txt"));
    if std::fs::read_to_string(&beside).is_ok_and(|text| text == identity)
        && let Ok(image) = Image::read(&picture)
    {
        return sized(image, "the kept one");
    }
    let rendered = render_on(scene, &settings, device, Given::default(), progress, &mut |_| Ok(()));
    let rendered = rendered.map_err(|error| match error {
        RenderError::Interrupted => None,
        error => Some(error.to_string()),
    })?;
    if !rendered.report.complete {
        return Err(None);
    }
    let metadata = Metadata {
        version: env!("CARGO_PKG_VERSION").to_string(),
        scene: scene.name.clone(),
        seed: SEED,
        settings: vec![("reference".to_string(), identity.trim().to_string())],
    };
    output::write(&picture, &rendered.image, &metadata).map_err(|error| Some(error.to_string()))?;
    record::write(&beside, &identity).map_err(Some)?;
    let [width, height] = size.map(|side| side as usize);
    Image::from_linear(width, height, rendered.image.rgb).map_err(|error| Some(error.to_string()))
}

/// How the reference is rendered.
fn settings(scene: &Scene, quick: bool, show: Show) -> Settings {
    let base = base(scene, quick, show);
    let passes = Some(if quick { QUICK_PASSES } else { PASSES });
    let most = if quick { 50_000 } else { 500_000 };
    Settings {
        integrator: Integrator::Progressive,
        surface: Surface::Own,
        photons: base.photons.min(most),
        caustic_photons: base.caustic_photons.min(most / 2),
        seed: SEED,
        stop: Stop { passes, ..Stop::default() },
        ..base
    }
}
