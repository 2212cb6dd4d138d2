//! The render: units of passes until there are enough, added up.

use crate::accumulate::ProgressState;
use crate::buffers::SceneBuffers;
use crate::crew::{self, Remote, Shared};
use crate::frame::Frame;
use crate::gather::{After, Gathering};
use crate::output::{Image, Layer};
use crate::photon_file::PhotonFile;
use crate::queue::Queue;
use crate::radius::find_radius;
use crate::report::{Progress, RenderReport};
use crate::scene::Scene;
use crate::sums::Counts;
use crate::work::{Part, Split};
use crate::worker::{Worker, radius_of};
use crate::{RenderError, Settings};
use caustic_device::{BufferBytes, Device, StageTime};
use std::time::Instant;

/// A finished render.
pub struct Rendered {
    /// The image: radiance, W·sr⁻¹·m⁻².
    pub image: Image,
    /// The layers that the settings ask for, in their order.
    pub layers: Vec<Layer>,
    /// What the render did.
    pub report: RenderReport,
    /// What its units came to: what a part is made of.
    pub state: ProgressState,
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
    /// The part of the render to compute; all of it if not given.
    pub part: Option<Part>,
    /// Workers elsewhere who help.
    pub remote: Option<&'a mut dyn Remote>,
}

/// [`render`] from what is given, that hands what there is after each unit to `after`.
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
    render_across(scene, settings, &[device], given, progress, after)
}

/// [`render_on`] on several devices at once, with the bits of one. A device that is lost leaves its units to the others.
///
/// # Errors
/// All of [`RenderError`], and those of `after`.
///
/// # Panics
/// If there is no device, or the passes that are given have another size than the picture, or others layers.
pub fn render_across(
    scene: &Scene,
    settings: &Settings,
    devices: &[&Device],
    given: Given<'_>,
    progress: &mut dyn FnMut(Progress) -> bool,
    after: After<'_>,
) -> Result<Rendered, RenderError> {
    settings.validate()?;
    let Given { passes, photons, part, remote } = given;
    if let Some(file) = photons {
        file.check_scene(scene)?;
        if settings.chunk.is_some() {
            let range = "left out with photons in chunks, which are traced anew for each".to_string();
            return Err(RenderError::Setting { name: "load-map", value: file.source.clone(), range });
        }
        if settings.passes() != Some(1) {
            let range = "1 with photons from a file, which are those of one pass".to_string();
            let value = settings.passes().map_or("open".to_string(), |passes| passes.to_string());
            return Err(RenderError::Setting { name: "passes", value, range });
        }
    }
    let clock = Instant::now();
    let workers = devices.len() + remote.as_ref().map_or(0, |remote| remote.workers());
    let split = Split::new(settings, part.map_or(1, |part| part.of), workers as u32);
    let (first, end) = split.numbers(settings, part)?;
    let compiled = scene.compile_with(&settings.forced);
    let mut notes = scene.notes.clone();
    let buffers = SceneBuffers::new(devices[0], &compiled)?;
    let frame = Frame::new(devices[0], scene, &compiled, &buffers, settings, photons)?;
    let state = match passes {
        Some(mut state) => {
            assert_eq!(state.size, settings.size, "the size of the passes");
            assert_eq!(state.has_layers, settings.needs_layers(), "layers of the passes");
            state.keep_units(&split);
            state
        }
        None => {
            let (radius, note) = find_radius(&frame, progress)?;
            notes.extend(note);
            ProgressState::new(settings.size, radius, settings.needs_layers())
        }
    };
    let (done, first_radius) = (state.done(), state.first_radius);
    let units = end.map(|end| (first..end).filter(|&unit| !done.has(&split.unit(unit))).count() as u64);
    let queue = Queue::new(split, (first, end), done, workers);
    let mut gathering = Gathering::new(settings, split, units, state, after, clock);
    let worker = Worker::new(frame, first_radius);
    if workers == 1 {
        alone(worker, &queue, units == Some(1), &mut gathering, progress)?;
    } else {
        let shared = Shared { scene, compiled: &compiled, settings, photons, first_radius, queue: &queue };
        crew::work(&shared, worker, devices, remote, &mut gathering, progress)?;
    }
    if gathering.stopped_by == Some("interrupted") && gathering.state.is_empty() {
        return Err(RenderError::Interrupted);
    }
    Ok(rendered(settings, devices, gathering, notes, &clock))
}

/// One device computes all units of the queue.
fn alone(
    mut worker: Worker<'_>,
    queue: &Queue,
    single: bool,
    gathering: &mut Gathering<'_>,
    progress: &mut dyn FnMut(Progress) -> bool,
) -> Result<(), RenderError> {
    while gathering.stopped_by.is_none() {
        let Some(unit) = queue.take(0) else { break };
        let outcome = worker.run(unit, &mut |now| {
            // Who waits for one unit wants to see what it is at.
            let image = if now.phase == "image" { now.done as f64 / now.total.max(1) as f64 } else { 0.0 };
            progress(if single { now } else { gathering.progress(image) })
        });
        queue.finish(0, &unit);
        match outcome {
            Ok(outcome) => gathering.accept(outcome)?,
            Err(RenderError::Interrupted) => gathering.interrupt(),
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// What a render that ended came to.
fn rendered(
    settings: &Settings,
    devices: &[&Device],
    gathering: Gathering<'_>,
    mut said: Vec<String>,
    clock: &Instant,
) -> Rendered {
    let Gathering { state, maps, last_pass, notes: more, mut problems, stopped_by, .. } = gathering;
    said.extend(more);
    let counts = state.all_counts();
    said.extend(notes(&counts));
    // Each is a note as well, for those who do not ask for problems.
    said.extend(problems.iter().cloned());
    let samples = [(counts.lost, "given up"), (counts.not_finite, "not finite")].into_iter();
    problems.extend(samples.filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} camera samples were {what}")));
    let image = state.image();
    let layers = state.layers(&settings.layers);
    let passes = state.passes();
    let last_pass = last_pass.unwrap_or(passes.saturating_sub(1));
    let on_host = maps.iter().map(|map| map.host_bytes).max().unwrap_or(0);
    let report = RenderReport {
        device: devices.iter().map(|device| device.name()).collect::<Vec<_>>().join(" + "),
        complete: stopped_by != Some("interrupted"),
        passes,
        // A part ends where its units do.
        stopped_by: stopped_by.unwrap_or("passes"),
        radius_m: radius_of(settings, state.first_radius, last_pass),
        noise: state.noise(),
        photons_emitted: state.photons(),
        seconds: clock.elapsed().as_secs_f64(),
        maps,
        camera_rays: counts.rays,
        notes: said,
        problems,
        stages: stage_times(devices),
        buffers: buffer_bytes(devices),
        peak_bytes: devices.iter().map(|device| device.total_bytes().1 + on_host).sum(),
        mean_radiance: mean(&image),
    };
    Rendered { image, layers, report, state }
}

/// What counts of camera samples are worth a look.
pub(crate) fn notes(counts: &Counts) -> Vec<String> {
    let Counts { lost, not_finite, .. } = *counts;
    let lost =
        (lost > 0).then(|| format!("{lost} camera paths were given up among mirrors and glass; they count as black"));
    let not_finite = (not_finite > 0).then(|| {
        format!("{not_finite} camera samples were not finite and count as black: a radius or power is extreme")
    });
    lost.into_iter().chain(not_finite).collect()
}

/// Times of all devices together.
fn stage_times(devices: &[&Device]) -> Vec<StageTime> {
    let mut all: Vec<StageTime> = Vec::new();
    for time in devices.iter().flat_map(|device| device.stage_times()) {
        match all.iter_mut().find(|other| other.stage == time.stage) {
            Some(other) => {
                other.runs += time.runs;
                other.ms += time.ms;
            }
            None => all.push(time),
        }
    }
    all
}

/// Bytes of all devices together.
fn buffer_bytes(devices: &[&Device]) -> Vec<BufferBytes> {
    let mut all: Vec<BufferBytes> = Vec::new();
    for bytes in devices.iter().flat_map(|device| device.buffer_bytes()) {
        match all.iter_mut().find(|other| other.buffer == bytes.buffer) {
            Some(other) => {
                other.bytes += bytes.bytes;
                other.peak_bytes += bytes.peak_bytes;
            }
            None => all.push(bytes),
        }
    }
    all
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
