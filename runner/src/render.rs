//! `caustic render`.

use crate::Failure;
use crate::args::RenderArguments;
use crate::progress::Monitor;
use caustic_device::{Device, Error as DeviceError, Precision};
use caustic_photon_map::MapError;
use caustic_renderer::output::{self, Metadata};
use caustic_renderer::scene::Scene;
use caustic_renderer::{RenderError, RenderReport, Settings, render};
use std::path::Path;

/// Renders a scene and writes the image.
pub fn run(arguments: &RenderArguments) -> Result<(), Failure> {
    output::check_path(&arguments.output).map_err(Failure::input)?;
    let scene = Scene::load(&arguments.scene).map_err(Failure::input)?;
    let settings = settings(arguments, &scene);
    settings.validate().map_err(|error| failure(&error))?;
    let (device, line) = Device::open_with(&arguments.device, arguments.precision.into()).map_err(Failure::input)?;
    if !arguments.quiet {
        eprintln!("{line}");
    }
    let mut monitor = Monitor::new(arguments.quiet);
    let rendered = render(&scene, &settings, &device, &mut |progress| monitor.show(progress));
    monitor.finish();
    let rendered = rendered.map_err(|error| failure(&error))?;
    let described = describe(&settings, if device.is_exact() { Precision::Exact } else { Precision::Fast });
    let metadata = Metadata {
        version: env!("CARGO_PKG_VERSION").to_string(),
        scene: scene.name.clone(),
        seed: settings.seed,
        settings: described.clone(),
    };
    output::write(&arguments.output, &rendered.image, &metadata).map_err(Failure::machine)?;
    if !arguments.quiet {
        tell(&rendered.report, &arguments.output);
    }
    if arguments.json {
        let mut value = serde_json::to_value(&rendered.report).map_err(Failure::machine)?;
        value["output"] = arguments.output.display().to_string().into();
        value["scene"] = scene.name.into();
        value["seed"] = settings.seed.into();
        value["settings"] = described.into_iter().collect();
        println!("{value:#}");
    }
    if !rendered.report.complete {
        return Err(Failure::interrupted(&arguments.output));
    }
    match rendered.report.problems.first() {
        Some(problem) if arguments.strict => Err(Failure::machine(format!(
            "{} is written, but --strict was asked for and the render has {} problems, the first: {problem}",
            arguments.output.display(),
            rendered.report.problems.len()
        ))),
        _ => Ok(()),
    }
}

/// The settings of the scene, with those of the command line in their place where given.
fn settings(arguments: &RenderArguments, scene: &Scene) -> Settings {
    let defaults = Settings::of(scene);
    Settings {
        size: arguments.size.unwrap_or(defaults.size),
        photons: arguments.photons.unwrap_or(defaults.photons),
        caustic_photons: arguments.caustic_photons.unwrap_or(defaults.caustic_photons),
        k: arguments.k.unwrap_or(defaults.k),
        radius: arguments.radius.unwrap_or(defaults.radius),
        hash: arguments.hash.into(),
        gather: arguments.gather.into(),
        spp: arguments.spp.unwrap_or(defaults.spp),
        seed: arguments.seed,
        show: arguments.show.into(),
    }
}

/// What the image depends on. Device, hash and gather are left out: an exact image does not depend on them.
fn describe(settings: &Settings, precision: Precision) -> Vec<(String, String)> {
    [
        ("show", format!("{:?}", settings.show)),
        ("photons", settings.photons.to_string()),
        ("caustic_photons", settings.caustic_photons.to_string()),
        ("k", settings.k.to_string()),
        ("radius", settings.radius.to_string()),
        ("spp", settings.spp.to_string()),
        ("precision", format!("{precision:?}").to_lowercase()),
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
    for map in &report.maps {
        photons += u64::from(map.photons_emitted);
        for walk in ["count_photons", "store_photons"] {
            // A scene that is more than basic has kernels of its own.
            if let Some(ms) = ["", "_full"].iter().find_map(|kind| stage(&format!("{}/{walk}{kind}", map.map))) {
                rays += map.segments;
                photon_ms += ms;
            }
        }
    }
    let camera_ms: f64 = ["trace_camera", "trace_camera_full", "shade_direct", "shade_direct_full"]
        .into_iter()
        .filter_map(|s| stage(&format!("image/{s}")))
        .sum();
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
        RenderError::CutShort { .. } | RenderError::Map(MapError::CutShort { .. }) => Failure::machine(error),
        RenderError::Map(MapError::Device(DeviceError::DeviceLost { .. } | DeviceError::Stage { .. })) => {
            Failure::machine(error)
        }
        RenderError::Setting { name, value, range } => {
            Failure::input(format!("--{name} is {value} but must be {range}"))
        }
        _ => Failure::input(error),
    }
}
