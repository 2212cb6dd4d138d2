//! `caustic map`: a photon map without a picture.

mod streamed;

use crate::Failure;
use crate::args::MapArguments;
use crate::progress::Monitor;
use crate::render::failure;
use caustic_bench::points::{Distribution, Points};
use caustic_device::{Buffer, Device, Plan};
use caustic_kernels::gather::distance2;
use caustic_kernels::layout::{Irradiance, Neighbour, Photon, Query};
use caustic_photon_map::{MapError, MapOptions, PhotonMap, bounds, plan_grid};
use caustic_renderer::scene::suggestion;
use caustic_renderer::{Progress, RenderError};
use std::time::Instant;

/// Queries whose neighbours are checked against brute force.
const CHECKED: usize = 64;

/// Builds, searches, checks and reports.
pub fn run(arguments: &MapArguments) -> Result<(), Failure> {
    let source = Source::parse(&arguments.photons, arguments.memory.is_some())?;
    if let Some(memory) = arguments.memory {
        return streamed::run(arguments, &source, memory);
    }
    let (photons, queries) = source.draw(arguments.k, arguments.queries)?;
    let radius = arguments.radius.unwrap_or_else(|| source.radius(photons.len(), arguments.k));
    let options = MapOptions { radius, hash: arguments.hash.into(), table: None, cell: None };
    let (device, line) = Device::open_with(&arguments.device, arguments.precision.into()).map_err(Failure::input)?;
    eprintln!("{line}");

    let mut monitor = Monitor::new(arguments.json);
    let timed = time(&device, &photons, &queries, &options, arguments, &mut monitor);
    monitor.finish();
    let timed = timed.map_err(|error| failure(&error))?;
    let differ = check(&device, &photons, &queries, &options, arguments).map_err(Failure::input)?;
    let report = serde_json::json!({
        "device": device.name(),
        "photons": photons.len(),
        "queries": queries.len(),
        "k": arguments.k,
        "radius": radius,
        "build_ms": timed.build_ms,
        "query_ms": timed.query_ms,
        "map_bytes": timed.map_bytes,
        "peak_bytes": device.total_bytes().1,
        "checked_queries": CHECKED.min(queries.len()),
        "queries_that_differ_from_brute_force": differ,
        "stages": timed.stages,
    });
    if arguments.json {
        println!("{report:#}");
    } else {
        println!(
            "build {:.3} ms, {} photons, radius {radius} m, {} bytes",
            timed.build_ms,
            photons.len(),
            timed.map_bytes
        );
        println!("query {:.3} ms, {} queries, k = {}", timed.query_ms, queries.len(), arguments.k);
        println!("times are medians of {}; positions and results stay on the device", arguments.repeat);
        println!("{differ} of {} checked queries differ from brute force", CHECKED.min(queries.len()));
    }
    if differ > 0 {
        return Err(Failure::machine(format!("{differ} queries differ from brute force: the device computes wrongly")));
    }
    Ok(())
}

struct Timed {
    build_ms: f64,
    query_ms: f64,
    map_bytes: u64,
    stages: Vec<caustic_device::StageTime>,
}

/// Median times of the build and of the irradiance query, from stage times: the work on the device alone.
fn time(
    device: &Device,
    photons: &[Photon],
    queries: &[Query],
    options: &MapOptions,
    arguments: &MapArguments,
    monitor: &mut Monitor,
) -> Result<Timed, RenderError> {
    let (low, high) = bounds("photons", photons.iter().map(|photon| photon.position))?;
    let sample: Vec<[f32; 3]> =
        photons.iter().step_by(photons.len().div_ceil(4096)).map(|photon| photon.position).collect();
    let grid = plan_grid(low, high, photons.len() as u64, &sample, options)?;
    let unsorted = device.upload("photons", photons)?;
    let query_buffer: Buffer = device.upload("queries", queries)?;
    let out = device.scratch::<Irradiance>("irradiance", queries.len() as u64)?;
    let mut build = Plan::new();
    build.scope("build");
    let map = PhotonMap::plan(device, &mut build, &unsorted, grid)?;
    let mut query = Plan::new();
    query.scope("query");
    let count = queries.len() as u32;
    map.plan_irradiance(device, &mut query, &query_buffer, count, arguments.k, arguments.gather.into(), &out)?;
    // A warm-up of each comes first.
    let mut steps = 0;
    let mut run = |plan: &Plan| -> Result<f64, RenderError> {
        let mut times = Vec::new();
        for repetition in 0..=arguments.repeat {
            if !monitor.show(Progress { phase: "map", done: steps, total: 2 * u64::from(arguments.repeat + 1) }) {
                return Err(RenderError::Interrupted);
            }
            steps += 1;
            device.reset_stage_times();
            let start = Instant::now();
            device.run(plan)?;
            let stages: f64 = device.stage_times().iter().map(|stage| stage.ms).sum();
            // An adapter without time stamps leaves the wall clock.
            let ms = if stages > 0.0 { stages } else { start.elapsed().as_secs_f64() * 1e3 };
            if repetition > 0 {
                times.push(ms);
            }
        }
        times.sort_by(f64::total_cmp);
        Ok(times[times.len() / 2])
    };
    let build_ms = run(&build)?;
    let mut stages = device.stage_times();
    let query_ms = run(&query)?;
    stages.extend(device.stage_times());
    for stage in &mut stages {
        // Only the last repetition is kept.
        stage.ms = (stage.ms * 1e6).round() / 1e6;
    }
    Ok(Timed { build_ms, query_ms, map_bytes: map.bytes(), stages })
}

/// How many of the first queries have other neighbours, or other distances, than brute force finds.
fn check(
    device: &Device,
    photons: &[Photon],
    queries: &[Query],
    options: &MapOptions,
    arguments: &MapArguments,
) -> Result<usize, MapError> {
    let map = PhotonMap::build(device, photons, options)?;
    let queries = &queries[..CHECKED.min(queries.len())];
    let found = map.k_nearest(device, queries, arguments.k, arguments.gather.into())?;
    let differ = queries.iter().zip(&found).filter(|(query, found)| {
        let mut all: Vec<Neighbour> = photons
            .iter()
            .enumerate()
            .map(|(i, photon)| Neighbour { distance2: distance2(query.position, photon.position), photon: i as u32 })
            .filter(|neighbour| neighbour.distance2 <= map.grid().radius2)
            .collect();
        all.sort_by(|a, b| a.distance2.total_cmp(&b.distance2).then(a.photon.cmp(&b.photon)));
        all.truncate(arguments.k as usize);
        all != **found
    });
    Ok(differ.count())
}

/// Where photons come from.
enum Source {
    /// So many of a distribution.
    Drawn(Distribution, u32),
    /// A text file.
    File(std::path::PathBuf),
}

impl Source {
    fn parse(text: &str, streamed: bool) -> Result<Self, Failure> {
        let most = if streamed { u32::MAX } else { 1 << 28 };
        let number = |n: &str| {
            let number = n.parse::<u32>().ok().filter(|n| (1..=most).contains(n));
            number.ok_or_else(|| {
                let more = if streamed { "" } else { "; --memory allows more" };
                Failure::input(format!("--photons {text}: the number must be 1 to {most}{more}"))
            })
        };
        match text.split_once(':') {
            Some(("uniform", n)) => Ok(Self::Drawn(Distribution::Uniform, number(n)?)),
            Some(("surface", n)) => Ok(Self::Drawn(Distribution::Surface, number(n)?)),
            Some(("clustered", n)) => Ok(Self::Drawn(Distribution::Caustic, number(n)?)),
            Some(("cell", n)) => Ok(Self::Drawn(Distribution::Cell, number(n)?)),
            // A file may be called so; a kind that is misspelt is none.
            Some((kind, n)) if n.parse::<u64>().is_ok() && !std::path::Path::new(text).exists() => {
                let meant = suggestion(kind, ["uniform", "surface", "clustered", "cell"]);
                Err(Failure::input(format!(
                    "--photons {text}: there is no kind `{kind}`{meant}; give uniform:N, surface:N, clustered:N, cell:N or a text file"
                )))
            }
            _ => Ok(Self::File(text.into())),
        }
    }

    /// Photons, and queries drawn like them.
    fn draw(&self, k: u32, queries: u32) -> Result<(Vec<Photon>, Vec<Query>), Failure> {
        match self {
            Self::Drawn(distribution, n) => {
                let points = Points::new(*distribution, *n, k);
                Ok((points.photons(*n), points.queries(queries)))
            }
            Self::File(path) => {
                let positions = read(path)?;
                let query = |i: u32| Query { position: positions[i as usize % positions.len()], active: 1 };
                let queries = (0..queries).map(query).collect();
                let photon = |position| Photon { position, power: [1.0; 3], ..Photon::default() };
                Ok((positions.into_iter().map(photon).collect(), queries))
            }
        }
    }

    /// A radius within which 2·k photons are expected around an average query.
    fn radius(&self, photons: usize, k: u32) -> f32 {
        let distribution = match self {
            Self::Drawn(distribution, _) => *distribution,
            Self::File(_) => Distribution::Uniform,
        };
        distribution.radius(photons as u32, k)
    }
}

/// Reads `x y z` lines. Lines that begin with # are comments.
fn read(path: &std::path::Path) -> Result<Vec<[f32; 3]>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| {
        Failure::input(format!("{}: {error}; give a text file with `x y z` a line, or uniform:N", path.display()))
    })?;
    positions(&path.display().to_string(), &text)
}

/// The positions in the text of `file`.
fn positions(file: &str, text: &str) -> Result<Vec<[f32; 3]>, Failure> {
    let mut positions = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#')) {
        let numbers: Vec<f32> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
        match numbers[..] {
            [x, y, z, ..] => positions.push([x, y, z]),
            _ => return Err(Failure::input(format!("{file}, line {}: three numbers `x y z` must stand here", i + 1))),
        }
    }
    if positions.is_empty() {
        return Err(Failure::input(format!("{file} holds no photons; it needs a line `x y z` for each")));
    }
    Ok(positions)
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustic_photon_map::bounds;

    /// Any text gives positions, which the map then checks, or one sentence. `CAUSTIC_FUZZ` sets how many are tried.
    #[test]
    fn any_text_is_positions_or_a_sentence() {
        let pieces = [
            "1", "-2.5", "1e-40", "3e38", "1e39", "nan", "inf", "-0", " ", "\t", "\n", "\r\n", "#", "x", "ü", ",",
            "\u{0}",
        ];
        let count = std::env::var("CAUSTIC_FUZZ").ok().map_or(20_000, |count| count.parse().expect("a number"));
        let (mut good, mut bad) = (0, 0);
        for seed in 0..count {
            let random = |step: u32| caustic_kernels::num::pcg4d([seed, step, 0xf11e, 0])[0] as usize;
            let word = |step| pieces[random(step) % if random(0) % 2 == 0 { 10 } else { pieces.len() }];
            let text: String = (1..2 + random(99) as u32 % 30).map(|step| format!("{} ", word(step))).collect();
            match positions("photons.txt", &text) {
                Ok(positions) => {
                    assert!(!positions.is_empty());
                    let finite = positions.as_flattened().iter().all(|x| x.is_finite());
                    assert_eq!(bounds("photons", positions.iter().copied()).is_ok(), finite);
                    good += 1;
                }
                Err(failure) => {
                    assert!(failure.message().starts_with("photons.txt") && !failure.message().contains('\n'));
                    bad += 1;
                }
            }
        }
        assert!(good > count / 50 && bad > count / 50, "{good} good, {bad} bad");
    }
}
