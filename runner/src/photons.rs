//! `caustic photons`: photons saved, and told of.

use crate::Failure;
use crate::args::{DumpArgument, PhotonsArguments};
use crate::progress::Monitor;
use crate::render::failure;
use caustic_device::Device;
use caustic_photon_map::{Health, MapOptions, PhotonMap};
use caustic_renderer::output;
use caustic_renderer::scene::Scene;
use caustic_renderer::{MapHeader, PhotonFile, Settings};
use serde::Serialize;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Traces or reads photons, and saves them or tells of them.
pub fn run(arguments: &PhotonsArguments) -> Result<(), Failure> {
    let PhotonsArguments { dump, output, .. } = arguments;
    if let Some(output) = output {
        output::check_place(output).map_err(Failure::input)?;
    }
    match (dump, output) {
        (None, None) => {
            let message =
                "photons: --output is missing, the file to save the photons in; or give --dump stats, csv or ply";
            return Err(Failure::input(message));
        }
        (Some(DumpArgument::Ply), None) => {
            return Err(Failure::input("--dump ply is binary: give a file for it with --output"));
        }
        _ => {}
    }
    if arguments.json && *dump != Some(DumpArgument::Stats) {
        return Err(Failure::input("--json is for --dump stats"));
    }
    let path = Path::new(&arguments.input);
    let named_so = path.extension().is_some_and(|ending| ending == "caustic");
    let saved = named_so || PhotonFile::is_one(path);
    if saved && dump.is_none() {
        let message = format!("`{}` is a photon map already: say what to tell of it with --dump", arguments.input);
        return Err(Failure::input(message));
    }
    let file = if saved { read(arguments, path)? } else { trace(arguments)? };
    match dump {
        None => save(&file, output.as_deref(), arguments.quiet),
        Some(DumpArgument::Ply) => put(output.as_deref(), |to| file.write_ply(to)),
        Some(DumpArgument::Csv) => put(output.as_deref(), |to| file.write_csv(to)),
        Some(DumpArgument::Stats) => {
            let text = stats(&file, arguments)?;
            put(output.as_deref(), |to| to.write_all(text.as_bytes()))
        }
    }
}

/// Reads saved photons, which are what they are.
fn read(arguments: &PhotonsArguments, path: &Path) -> Result<PhotonFile, Failure> {
    for (flag, given) in [
        ("photons", arguments.photons.is_some()),
        ("caustic-photons", arguments.caustic_photons.is_some()),
        ("seed", arguments.seed.is_some()),
        ("show", arguments.show.is_some()),
    ] {
        if given {
            let input = &arguments.input;
            let message =
                format!("--{flag} is for photons that are to be traced: those of `{input}` are, so leave it out");
            return Err(Failure::input(message));
        }
    }
    PhotonFile::read(path).map_err(Failure::input)
}

fn trace(arguments: &PhotonsArguments) -> Result<PhotonFile, Failure> {
    let scene = Scene::load(&arguments.input).map_err(Failure::input)?;
    let defaults = Settings::of(&scene);
    let settings = Settings {
        photons: arguments.photons.unwrap_or(defaults.photons),
        caustic_photons: arguments.caustic_photons.unwrap_or(defaults.caustic_photons),
        seed: arguments.seed.unwrap_or_default(),
        show: arguments.show.unwrap_or_default().into(),
        ..defaults
    };
    settings.validate().map_err(|error| failure(&error))?;
    let device = open(arguments)?;
    let mut monitor = Monitor::new(arguments.quiet);
    let traced = PhotonFile::trace(&scene, &settings, &device, &mut |progress| monitor.show(progress));
    monitor.finish();
    traced.map_err(|error| failure(&error))
}

fn open(arguments: &PhotonsArguments) -> Result<Device, Failure> {
    let (device, line) = Device::open_with(&arguments.device, arguments.precision.into()).map_err(Failure::input)?;
    if !arguments.quiet && arguments.dump.is_none() {
        eprintln!("{line}");
    }
    Ok(device)
}

fn save(file: &PhotonFile, path: Option<&Path>, quiet: bool) -> Result<(), Failure> {
    let path = path.ok_or_else(|| Failure::input("--output is missing"))?;
    file.write(path).map_err(Failure::machine)?;
    if !quiet {
        for map in &file.header.maps {
            eprintln!("{} map: {} photons stored of {} emitted", map.map, map.stored, map.emitted);
        }
        eprintln!("wrote {}", path.display());
    }
    Ok(())
}

/// Writes to a file, which appears at once and whole, or to standard output.
fn put(path: Option<&Path>, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    match path {
        Some(path) => output::replace_with(path, write).map_err(Failure::machine),
        None => {
            let mut out = BufWriter::new(io::stdout().lock());
            match write(&mut out).and_then(|()| out.flush()) {
                // Whoever reads has seen enough.
                Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
                written => written.map_err(Failure::machine),
            }
        }
    }
}

/// What is told of a map.
#[derive(Serialize)]
struct Stats<'a> {
    #[serde(flatten)]
    header: &'a MapHeader,
    /// W, for each of red, green and blue.
    power: [f64; 3],
    /// Corners of the box around the photons in the scene's coordinates, m.
    low: [f64; 3],
    high: [f64; 3],
    /// Of a map of the photons. A render's own may have cells of another width, since it looks at other samples of them: `render --json` tells of that.
    hash: Option<Health>,
}

fn stats(file: &PhotonFile, arguments: &PhotonsArguments) -> Result<String, Failure> {
    let device = open(arguments)?;
    let radius = arguments.radius.unwrap_or(file.header.radius);
    let options = MapOptions { radius, hash: arguments.hash.into(), table: None, cell: None };
    let mut all = Vec::new();
    for (header, photons) in file.header.maps.iter().zip(&file.photons) {
        let mut stats = Stats { header, power: [0.0; 3], low: [f64::MAX; 3], high: [f64::MIN; 3], hash: None };
        for photon in photons {
            for axis in 0..3 {
                let x = f64::from(photon.position[axis]) + file.header.origin[axis];
                stats.low[axis] = stats.low[axis].min(x);
                stats.high[axis] = stats.high[axis].max(x);
                stats.power[axis] += f64::from(photon.power[axis]);
            }
        }
        if !photons.is_empty() {
            let map = PhotonMap::build(&device, photons, &options).map_err(Failure::input)?;
            stats.hash = Some(map.health(&device).map_err(Failure::machine)?);
        } else {
            (stats.low, stats.high) = ([0.0; 3], [0.0; 3]);
        }
        all.push(stats);
    }
    if arguments.json {
        let header = serde_json::json!({
            "scene": file.header.scene,
            "scene_sha256": file.header.scene_sha256,
            "version": file.header.version,
            "seed": file.header.seed,
            "exact": file.header.exact,
            "radius": radius,
            "maps": all,
        });
        return Ok(format!("{header:#}\n"));
    }
    Ok(text(file, radius, &all))
}

fn text(file: &PhotonFile, radius: f32, all: &[Stats]) -> String {
    let header = &file.header;
    let exact = if header.exact { "exact" } else { "fast" };
    let mut text = format!("scene {}, seed {}, {exact}, by caustic {}\n", header.scene, header.seed, header.version);
    let three = |values: [f64; 3]| values.map(|value| format!("{value:.5}")).join(" ");
    for stats in all {
        let MapHeader { map, stored, emitted, segments, paths_cut, .. } = stats.header;
        text += &format!("{map} map: {stored} photons stored of {emitted} emitted, {segments} rays");
        text += &if *paths_cut > 0 { format!(", {paths_cut} paths given up\n") } else { "\n".to_string() };
        text += &format!("  power    {} W (red, green, blue)\n", three(stats.power));
        text += &format!("  extent   {} to {} m\n", three(stats.low), three(stats.high));
        if let Some(hash) = &stats.hash {
            text += &format!(
                "  hash     {} entries, {:.1} % of them used, {} collisions\n",
                hash.entries,
                100.0 * hash.load,
                hash.collisions
            );
            text += &format!(
                "  cells    {} used, {:.2} photons each, {} in the fullest\n",
                hash.cells, hash.mean_cell, hash.longest_cell
            );
            text += &format!(
                "  queries  {:.1} candidates each, {} at the most, {:.1} of them within {radius} m ({} queries)\n",
                hash.candidates_per_query, hash.most_candidates, hash.found_per_query, hash.queries
            );
        }
    }
    text
}
