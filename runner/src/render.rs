//! `caustic render`.

use crate::Failure;
use crate::args::{RadiusArgument, RenderArguments, layers};
use crate::plan::{Planned, differs_between_machines};
use crate::progress::{Monitor, say_when_stopped};
use crate::ranks::Ranks;
use caustic_device::{Device, Error as DeviceError, Precision};
use caustic_photon_map::MapError;
use caustic_renderer::output::{self, DENOISER_LAYERS, Extras, Format, LayerKind, Metadata, OutputError, can_denoise};
use caustic_renderer::scene::Scene;
use caustic_renderer::{
    About, Checkpoint, CheckpointError, Chunk, Given, Integrator, PhotonFile, Remote, RenderError, RenderReport,
    Settings, digest, render_across, write_part,
};
use std::path::Path;
use std::time::{Duration, Instant};

/// A render that takes less shows no picture on its way.
const SOON: Duration = Duration::from_secs(1);

/// Renders a scene and writes the image.
pub fn run(arguments: &RenderArguments) -> Result<(), Failure> {
    let Some(mut ranks) = Ranks::join()? else {
        return prepare(arguments, false).and_then(|job| render(arguments, &job, None));
    };
    let mut job = prepare(arguments, true);
    let ready = job.as_ref().ok().map(|job| digest(&job.scene, job.settings(), job.devices[0].is_exact()));
    let agreed = ranks.agree(ready);
    let root = ranks.is_root();
    if let (Err(failure), true) = (&agreed, job.is_ok()) {
        return Err(if root { failure.clone() } else { failure.silent() });
    }
    let job = job.as_mut().map_err(|failure| failure.clone())?;
    // Each process of a host takes one of its devices.
    let own = ranks.device(job.devices.len());
    job.devices = vec![job.devices.swap_remove(own)];
    if !root {
        return ranks.help(&job.scene, job.settings(), &job.devices[0], job.file.as_ref()).map_err(|e| failure(&e));
    }
    say_when_stopped(when_a_rank_is_lost(arguments));
    let result = render(arguments, job, Some(&mut ranks));
    if let Err(failure) = result {
        failure.tell();
        ranks.abort(failure.code());
    }
    Ok(())
}

/// What the root says when MPI ends it, as it ends all when one is lost.
fn when_a_rank_is_lost(arguments: &RenderArguments) -> String {
    let kept = match &arguments.how.checkpoint {
        Some(path) => format!(
            "the checkpoint {} holds the passes that were finished, and the same command{} goes on from there, with any number of ranks",
            path.display(),
            if arguments.how.resume { "" } else { " with --resume" }
        ),
        None => "without --checkpoint FILE the next render begins anew".to_string(),
    };
    format!("rank 0 was told to stop, as all ranks are when one is lost; {kept}")
}

/// What a render needs, checked.
struct Job<'a> {
    output: &'a Path,
    scene: Scene,
    file: Option<PhotonFile>,
    planned: Planned,
    devices: Vec<Device>,
    /// What they are, a line each.
    lines: Vec<String>,
}

impl Job<'_> {
    fn settings(&self) -> &Settings {
        &self.planned.settings
    }
}

/// Checks everything and plans. `shared`: other processes, which must plan the same, render with this one.
fn prepare(arguments: &RenderArguments, shared: bool) -> Result<Job<'_>, Failure> {
    let output =
        arguments.output.as_deref().ok_or_else(|| Failure::input("-o FILE is missing: where to write the image"))?;
    check_output(arguments, output)?;
    if (shared || arguments.how.part.is_some()) && differs_between_machines(arguments) {
        return Err(Failure::input(
            "--part and MPI need the same settings everywhere, and those chosen for a budget differ between machines and moments; give --passes instead, or add --costs built-in",
        ));
    }
    if arguments.denoise && !can_denoise() {
        return Err(Failure::input(OutputError::NoDenoiser));
    }
    let scene = Scene::load(&arguments.scene).map_err(Failure::input)?;
    let file = arguments.load_map.as_deref().map(PhotonFile::read).transpose().map_err(Failure::input)?;
    let settings = settings(arguments, &scene, file.as_ref());
    if let Some(file) = &file {
        file.check_scene(&scene).map_err(Failure::input)?;
    }
    settings.validate().map_err(|error| failure(&error))?;
    let opened = Device::open_several(&arguments.device, arguments.precision.into()).map_err(Failure::input)?;
    let (devices, lines): (Vec<Device>, _) = opened.into_iter().unzip();
    let mut monitor = Monitor::new(arguments.quiet);
    let planned = Planned::new(arguments, &scene, settings, &devices[0], &mut monitor)?;
    Ok(Job { output, scene, file, planned, devices, lines })
}

fn render(arguments: &RenderArguments, job: &Job, ranks: Option<&mut Ranks>) -> Result<(), Failure> {
    let Job { output, scene, file, planned, devices, lines } = job;
    let settings = job.settings();
    let how = &arguments.how;
    let display = arguments.display.of(output).map_err(Failure::input)?;
    let asked = layers(&arguments.aov);
    if !arguments.quiet {
        lines.iter().for_each(|line| eprintln!("{line}"));
    }
    let devices: Vec<&Device> = devices.iter().collect();
    let mut monitor = Monitor::new(arguments.quiet);
    let exact = devices[0].is_exact();
    let precision = if exact { Precision::Exact } else { Precision::Fast };
    if !arguments.quiet {
        planned.tell(arguments.plan.explain);
    }
    let metadata = |passes: u32| Metadata {
        version: env!("CARGO_PKG_VERSION").to_string(),
        scene: scene.name.clone(),
        seed: settings.seed,
        settings: describe(settings, precision, passes),
    };
    let checkpoint = how.checkpoint.as_ref().map(|path| Checkpoint::new(path, scene, settings, exact));
    let alone = ranks.is_none() && how.part.is_none();
    let remote = ranks.map(|ranks| ranks as &mut dyn Remote);
    let mut given = Given { photons: file.as_ref(), part: how.part, remote, passes: None };
    if let Some(checkpoint) = &checkpoint {
        let begun = if how.resume { checkpoint.load().map(Some) } else { checkpoint.begin().map(|()| None) };
        given.passes = begun.map_err(|error| checkpoint_failure(&error))?;
    }
    let plain = Extras { display, ..Extras::default() };
    let progress = &mut |progress| monitor.show(progress);
    let (begun, mut shown) = (Instant::now(), 0);
    let rendered = render_across(scene, settings, &devices, given, progress, &mut |state| {
        let kept = |error: &dyn std::fmt::Display| RenderError::AfterPass(error.to_string());
        if let Some(checkpoint) = &checkpoint {
            checkpoint.save(state).map_err(|error| kept(&error))?;
        }
        // A picture to look at while it gets better; the last pass is written at the end in any case.
        let passes = state.passes();
        let wanted = passes.is_power_of_two() && passes > shown && how.part.is_none() && begun.elapsed() > SOON;
        if wanted && settings.stop.passes != Some(passes) && !single(settings) {
            shown = passes;
            let written = output::write_with(output, &state.image(), &metadata(passes), &plain);
            written.map_err(|error| kept(&error))?;
        }
        Ok(())
    });
    monitor.finish();
    let mut rendered = rendered.map_err(|error| failure(&error))?;
    let report = &rendered.report;
    let mut metadata = metadata(if how.part.is_some() { settings.passes().unwrap_or_default() } else { report.passes });
    if let Some(part) = how.part {
        if !report.complete {
            return Err(Failure::interrupted_before_image());
        }
        let passes = settings.passes().unwrap_or_default();
        let about = About { part, merged: Vec::new(), passes, layers: asked, metadata: metadata.clone() };
        write_part(output, scene, settings, exact, &about, &rendered.state).map_err(Failure::machine)?;
    } else {
        if arguments.denoise {
            rendered.image = output::denoise(&rendered.image, &rendered.layers).map_err(Failure::machine)?;
            metadata.settings.push(("denoiser".to_string(), "OpenImageDenoise".to_string()));
        }
        rendered.layers.retain(|layer| asked.contains(&layer.kind));
        let extras = Extras { layers: &rendered.layers, ..plain };
        output::write_with(output, &rendered.image, &metadata, &extras).map_err(Failure::machine)?;
    }
    if !arguments.quiet {
        tell(&rendered.report, output);
        // What is foreseen is the work of one device.
        if let ([device], true) = (&devices[..], alone) {
            planned.compare(&rendered.report, device);
        }
    }
    if arguments.json {
        let mut value = serde_json::to_value(&rendered.report).map_err(Failure::machine)?;
        value["output"] = output.display().to_string().into();
        value["scene"] = scene.name.clone().into();
        value["seed"] = settings.seed.into();
        value["plan"] = planned.json();
        value["settings"] = metadata.settings.into_iter().collect();
        println!("{value:#}");
    }
    if !rendered.report.complete {
        return Err(Failure::interrupted(output, rendered.report.passes));
    }
    match rendered.report.problems.first() {
        Some(problem) if arguments.strict => Err(Failure::machine(format!(
            "{} is written, but --strict was asked for and the render has {} problems, the first: {problem}",
            output.display(),
            rendered.report.problems.len()
        ))),
        _ => Ok(()),
    }
}

/// Checks that the output can be what it is asked to be, where it is asked to be.
fn check_output(arguments: &RenderArguments, path: &Path) -> Result<(), Failure> {
    if arguments.how.part.is_some() {
        if path.extension().is_none_or(|ending| ending != "caustic") {
            return Err(Failure::input(format!(
                "--part: `{}` does not end in .caustic; a part of an image is no image yet, and `caustic merge` makes one of all parts",
                path.display()
            )));
        }
        return output::check_place(path).map_err(Failure::input);
    }
    output::check_path(path).map_err(Failure::input)?;
    arguments.display.of(path).map_err(Failure::input)?;
    match layers(&arguments.aov).first().filter(|_| Format::of(path) != Ok(Format::Exr)) {
        Some(layer) => Err(Failure::input(OutputError::NoLayers { path: path.to_path_buf(), layer: layer.name() })),
        None => Ok(()),
    }
}

/// The settings of the scene, with those of the command line in their place where given.
pub fn settings(arguments: &RenderArguments, scene: &Scene, file: Option<&PhotonFile>) -> Settings {
    let defaults = Settings::of(scene);
    let settings = Settings {
        size: arguments.size.unwrap_or(defaults.size),
        photons: file.map(|file| file.header.photons).or(arguments.photons).unwrap_or(defaults.photons),
        caustic_photons: file
            .map(|file| file.header.caustic_photons)
            .or(arguments.caustic_photons)
            .unwrap_or(defaults.caustic_photons),
        k: arguments.k.unwrap_or(defaults.k),
        radius: match arguments.radius {
            Some(RadiusArgument::Metres(radius)) => radius,
            _ => defaults.radius,
        },
        automatic_radius: matches!(arguments.radius, Some(RadiusArgument::Auto)),
        hash: arguments.hash.into(),
        table: arguments.table,
        gather: arguments.gather.into(),
        spp: arguments.spp.unwrap_or(defaults.spp),
        seed: arguments.seed.or(file.map(|file| file.header.seed)).unwrap_or_default(),
        show: arguments.show.into(),
        integrator: arguments.how.integrator.into(),
        filter: arguments.how.filter.into(),
        surface: arguments.how.surface.into(),
        alpha: arguments.how.alpha,
        final_gather: arguments.how.final_gather,
        keep: arguments.how.keep.into(),
        thin: arguments.how.thin,
        compact: arguments.how.compact,
        nearest: arguments.how.nearest.into(),
        interpolate: arguments.how.interpolate,
        stop: arguments.how.stop(),
        layers: wanted_layers(arguments),
        forced: arguments.plan.force.iter().map(|&feature| feature.into()).collect(),
        health: arguments.json,
        chunk: None,
    };
    Settings { chunk: arguments.how.chunk.map(|photons| Chunk::of(photons, &settings)), ..settings }
}

/// Whether there is one pass, come what may.
fn single(settings: &Settings) -> bool {
    settings.integrator != Integrator::Progressive && settings.stop == caustic_renderer::Stop::default()
}

/// Whether a checkpoint that cannot be used is the input's or the machine's fault.
fn checkpoint_failure(error: &CheckpointError) -> Failure {
    match error {
        CheckpointError::Read { .. } => Failure::machine(error),
        _ => Failure::input(error),
    }
}

/// The layers that the file or the denoiser needs.
fn wanted_layers(arguments: &RenderArguments) -> Vec<LayerKind> {
    let mut wanted = layers(&arguments.aov);
    if arguments.denoise {
        wanted.extend(DENOISER_LAYERS.iter().filter(|layer| !layers(&arguments.aov).contains(layer)));
    }
    wanted
}

/// What the image depends on. Device, hash and gather are left out: an exact image does not depend on them.
fn describe(settings: &Settings, precision: Precision, passes: u32) -> Vec<(String, String)> {
    let name = |value: &dyn std::fmt::Debug| format!("{value:?}").to_lowercase();
    let radius = if settings.automatic_radius { "auto".to_string() } else { settings.radius.to_string() };
    [
        ("show", format!("{:?}", settings.show)),
        ("photons", settings.photons.to_string()),
        ("caustic_photons", settings.caustic_photons.to_string()),
        ("k", settings.k.to_string()),
        ("radius", radius),
        ("spp", settings.spp.to_string()),
        ("integrator", name(&settings.integrator)),
        ("filter", name(&settings.filter)),
        ("surface", name(&settings.surface)),
        ("alpha", settings.alpha.to_string()),
        ("final_gather", settings.final_gather.to_string()),
        ("compact", settings.compact.to_string()),
        ("thin", settings.thin.to_string()),
        ("nearest", name(&settings.nearest)),
        ("interpolate", settings.interpolate.to_string()),
        ("passes", passes.to_string()),
        ("precision", name(&precision)),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .to_vec()
}

fn tell(report: &RenderReport, output: &Path) {
    for map in &report.maps {
        eprintln!(
            "{} map: {} photons stored of {} emitted, {:.1} MiB",
            map.map,
            map.photons_stored,
            map.photons_emitted,
            map.bytes as f64 / f64::from(1 << 20)
        );
    }
    if let Some(line) = speed(report) {
        eprintln!("{line}");
    }
    for note in &report.notes {
        eprintln!("note: {note}");
    }
    if report.passes > 1 {
        let noise =
            report.noise.map_or(String::new(), |noise| format!("; the relMSE of the noise is about {noise:.2e}"));
        let photons =
            if report.photons_emitted > 0 { format!(", {} photons", report.photons_emitted) } else { String::new() };
        eprintln!("passes: {} until {}{photons}{noise}", report.passes, report.stopped_by);
    }
    let stages: f64 = report.stages.iter().map(|stage| stage.ms).sum();
    let mut slowest = report.stages.clone();
    slowest.sort_by(|a, b| b.ms.total_cmp(&a.ms));
    let slowest: Vec<_> =
        slowest.iter().take(4).map(|s| format!("{} {:.0} %", s.stage, 100.0 * s.ms / stages)).collect();
    eprintln!("time: {:.2} s, of which the stages {:.2} s ({})", report.seconds, stages / 1e3, slowest.join(", "));
    eprintln!("memory: {:.1} MiB at the most", report.peak_bytes as f64 / f64::from(1 << 20));
    if report.complete {
        eprintln!("wrote {}", output.display());
    }
}

/// How fast photons and rays were, by the times of the stages that trace. A photon path is walked twice, to count and to store,
/// and both walks are in its time; so are they in the rays.
fn speed(report: &RenderReport) -> Option<String> {
    let stage = |name: &str| report.stages.iter().find(|stage| stage.stage == name).map(|stage| stage.ms);
    let (mut photons, mut rays, mut photon_ms) = (0, 0, 0.0);
    // Stages have the times of all passes, and the maps are those of one.
    let passes = u64::from(report.passes.max(1));
    for map in &report.maps {
        photons += passes * u64::from(map.photons_emitted);
        for walk in ["count_photons", "store_photons"] {
            if let Some(ms) = stage(&format!("{}/{walk}", map.map)) {
                rays += passes * map.segments;
                photon_ms += ms;
            }
        }
    }
    let camera_ms: f64 =
        ["trace_camera", "shade_direct"].into_iter().filter_map(|s| stage(&format!("image/{s}"))).sum();
    let millions = |count: u64, ms: f64| format!("{:.1} million", count as f64 / ms / 1e3);
    let image = format!("{} rays/s of the image", millions(report.camera_rays, camera_ms));
    (camera_ms > 0.0).then(|| {
        if photon_ms > 0.0 {
            let (photons, rays) = (millions(photons, photon_ms), millions(rays, photon_ms));
            format!("speed: {photons} photons/s emitted, {rays} rays/s of photon paths, {image}")
        } else {
            format!("speed: {image}")
        }
    })
}

/// Whether an error is the input's or the machine's fault.
pub fn failure(error: &RenderError) -> Failure {
    match error {
        RenderError::Interrupted => Failure::interrupted_before_image(),
        RenderError::AfterPass(_)
        | RenderError::CutShort { .. }
        | RenderError::Elsewhere { .. }
        | RenderError::Map(
            MapError::CutShort { .. } | MapError::Device(DeviceError::DeviceLost { .. } | DeviceError::Stage { .. }),
        ) => Failure::machine(error),
        RenderError::Setting { name, value, range } => {
            Failure::input(format!("--{name} is {value} but must be {range}"))
        }
        _ => Failure::input(error),
    }
}
