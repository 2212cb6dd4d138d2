//! The render: passes until there are enough, added up.

use crate::accumulate::{ProgressState, pass_radius, pass_seed};
use crate::buffers::SceneBuffers;
use crate::frame::Frame;
use crate::output::{Image, Layer, LayerKind};
use crate::photon_file::PhotonFile;
use crate::radius::find_radius;
use crate::report::{Progress, RenderReport};
use crate::scene::Scene;
use crate::{Integrator, RenderError, Settings};
use caustic_device::Device;
use caustic_kernels::trace::Pixel;
use caustic_photon_map::RADII;
use std::time::Instant;

/// A finished render.
pub struct Rendered {
    /// The image: radiance, W·sr⁻¹·m⁻².
    pub image: Image,
    /// The layers that the settings ask for, in their order.
    pub layers: Vec<Layer>,
    /// What the render did.
    pub report: RenderReport,
}

/// Renders a scene. `progress` is called now and then, and the render stops when it returns false: with
/// [`RenderError::Interrupted`] while there is no image yet, afterwards with the passes that are finished, or with the rows of the first one.
///
/// # Errors
/// All of [`RenderError`].
pub fn render(
    scene: &Scene,
    settings: &Settings,
    device: &Device,
    progress: &mut dyn FnMut(Progress) -> bool,
) -> Result<Rendered, RenderError> {
    render_on(scene, settings, device, Given::default(), progress, &mut |_| Ok(()))
}

/// What a render need not do itself.
#[derive(Default)]
pub struct Given<'a> {
    /// Passes to go on from. A render that goes on gives the bits of one that was never stopped, if scene and settings but for
    /// [`Settings::stop`] are the same.
    pub passes: Option<ProgressState>,
    /// Photons to use instead of traced ones: those of one pass.
    pub photons: Option<&'a PhotonFile>,
}

/// [`render`] from what is given, that hands what there is after each pass to `after`.
///
/// # Errors
/// All of [`RenderError`], and those of `after`.
///
/// # Panics
/// If the passes that are given have another size than the picture, or others layers.
pub fn render_on(
    scene: &Scene,
    settings: &Settings,
    device: &Device,
    given: Given<'_>,
    progress: &mut dyn FnMut(Progress) -> bool,
    after: &mut dyn FnMut(&ProgressState) -> Result<(), RenderError>,
) -> Result<Rendered, RenderError> {
    settings.validate()?;
    if let Some(file) = given.photons {
        file.check_scene(scene)?;
        if settings.passes() != Some(1) {
            let range = "1 with photons from a file, which are those of one pass".to_string();
            let value = settings.passes().map_or("open".to_string(), |passes| passes.to_string());
            return Err(RenderError::Setting { name: "passes", value, range });
        }
    }
    let clock = Instant::now();
    let compiled = scene.compile_with(&settings.forced);
    let buffers = SceneBuffers::new(device, &compiled)?;
    let frame = Frame::new(device, scene, &compiled, &buffers, settings, given.photons)?;
    let mut notes = scene.notes.clone();
    let mut state = match given.passes {
        Some(state) => {
            assert_eq!(state.size, settings.size, "the size of the passes");
            assert_eq!(!state.layers.is_empty(), settings.needs_layers(), "layers of the passes");
            state
        }
        None => {
            let (radius, note) = find_radius(&frame, progress)?;
            notes.extend(note);
            ProgressState::new(settings.size, radius, settings.needs_layers())
        }
    };
    let radius_of = |state: &ProgressState| match settings.integrator {
        Integrator::Progressive => pass_radius(state.first_radius, state.passes, settings.alpha, *RADII.start()),
        _ => state.first_radius,
    };
    let mut radius = radius_of(&state);
    let mut maps = Vec::new();
    let mut problems = Vec::new();
    let mut partial = None;
    // Only who asks for an error waits for an estimate of it after each pass.
    let noise_of = |state: &ProgressState| settings.stop.error.and_then(|_| state.noise());
    let mut noise = noise_of(&state);
    let mut stopped_by = reached(settings, &state, noise, &clock);
    while stopped_by.is_none() {
        radius = radius_of(&state);
        let alone = settings.passes() == Some(1);
        let mut within = |now: Progress| {
            if alone { progress(now) } else { progress(overall(settings, &state, noise, &clock, now)) }
        };
        match frame.pass(pass_seed(settings.seed, state.passes), radius, &mut within) {
            Ok(pass) if pass.complete => {
                check(device, &pass.film)?;
                let emitted = pass.maps.iter().map(|map| u64::from(map.photons_emitted)).sum();
                state.add(&pass.film, &pass.layers, emitted);
                maps = pass.maps;
                problems.extend(pass.problems);
                if state.passes == 1 {
                    notes.extend(pass.notes);
                }
                after(&state)?;
                noise = noise_of(&state);
                stopped_by = reached(settings, &state, noise, &clock);
            }
            // Of the first pass there are rows to show.
            Ok(mut pass) if state.passes == 0 => {
                check(device, &pass.film)?;
                problems.append(&mut pass.problems);
                notes.append(&mut pass.notes);
                maps = std::mem::take(&mut pass.maps);
                partial = Some(pass);
                stopped_by = Some("interrupted");
            }
            Err(RenderError::Interrupted) if state.passes == 0 => return Err(RenderError::Interrupted),
            Ok(_) | Err(RenderError::Interrupted) => stopped_by = Some("interrupted"),
            Err(error) => return Err(error),
        }
    }
    let (passes, noise, photons_emitted) = (state.passes, state.noise(), state.photons);
    if let Some(pass) = &partial {
        state.add(&pass.film, &pass.layers, 0);
    }
    if state.lost > 0 {
        notes.push(format!("{} camera paths were given up among mirrors and glass; they count as black", state.lost));
    }
    if state.not_finite > 0 {
        let count = state.not_finite;
        notes.push(format!("{count} camera samples were not finite and count as black: a radius or power is extreme"));
    }
    // Each is a note as well, for those who do not ask for problems.
    notes.extend(problems.iter().cloned());
    let samples = [(state.lost, "given up"), (state.not_finite, "not finite")].into_iter();
    problems.extend(samples.filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} camera samples were {what}")));
    let image = state.image();
    let layers = layers(settings, &state);
    let report = RenderReport {
        device: device.name(),
        complete: stopped_by != Some("interrupted"),
        passes,
        stopped_by: stopped_by.unwrap_or_default(),
        radius_m: radius,
        noise,
        photons_emitted,
        seconds: clock.elapsed().as_secs_f64(),
        maps,
        camera_rays: state.rays,
        notes,
        problems,
        stages: device.stage_times(),
        buffers: device.buffer_bytes(),
        peak_bytes: device.total_bytes().1,
        mean_radiance: mean(&image),
    };
    Ok(Rendered { image, layers, report })
}

/// The layers that the settings ask for.
fn layers(settings: &Settings, state: &ProgressState) -> Vec<Layer> {
    let pixels = state.layer_pixels();
    let layer = |&kind: &LayerKind| match kind {
        LayerKind::Variance => Layer { kind, values: state.variance_layer() },
        _ => Layer::of(kind, &pixels),
    };
    settings.layers.iter().map(layer).collect()
}

/// Refuses a film that a device did not finish.
fn check(device: &Device, film: &[Pixel]) -> Result<(), RenderError> {
    match film.iter().map(|pixel| u64::from(pixel.cut_short)).sum() {
        0 => Ok(()),
        searches => Err(RenderError::CutShort { device: device.name(), searches }),
    }
}

/// What says that there are enough passes.
fn reached(settings: &Settings, state: &ProgressState, noise: Option<f64>, clock: &Instant) -> Option<&'static str> {
    let stop = &settings.stop;
    if state.passes == 0 {
        return None;
    }
    if settings.passes().is_some_and(|passes| state.passes >= passes) {
        Some("passes")
    } else if stop.photons.is_some_and(|photons| state.photons >= photons) {
        Some("photons")
    } else if stop.seconds.is_some_and(|seconds| clock.elapsed().as_secs_f64() >= seconds) {
        Some("time")
    } else if stop.error.is_some_and(|error| noise.is_some_and(|noise| noise <= error)) {
        Some("error")
    } else {
        None
    }
}

/// Progress of all passes: that of whatever is going to end them first.
fn overall(settings: &Settings, state: &ProgressState, noise: Option<f64>, clock: &Instant, now: Progress) -> Progress {
    const TOTAL: u64 = 1 << 20;
    let within = if now.phase == "image" { now.done as f64 / now.total.max(1) as f64 } else { 0.0 };
    let done = f64::from(state.passes) + within;
    let stop = &settings.stop;
    let parts = [
        settings.passes().map(|passes| done / f64::from(passes)),
        stop.seconds.map(|seconds| clock.elapsed().as_secs_f64() / seconds),
        stop.photons.map(|photons| state.photons as f64 / photons as f64),
        // Noise falls with the number of passes.
        stop.error.and_then(|error| Some(error / noise? * done / f64::from(state.passes))),
    ];
    let part = parts.into_iter().flatten().fold(0.0, f64::max).min(1.0);
    Progress { phase: "passes", done: (part * TOTAL as f64) as u64, total: TOTAL }
}

/// Mean radiance of an image, W·sr⁻¹·m⁻².
fn mean(image: &Image) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for pixel in &image.rgb {
        for (sum, &value) in sum.iter_mut().zip(pixel) {
            *sum += f64::from(value);
        }
    }
    sum.map(|sum| sum / image.rgb.len() as f64)
}
