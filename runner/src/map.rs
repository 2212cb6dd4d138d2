//! `caustic map`: a photon map without a picture.

mod exact;
mod source;
mod streamed;

use crate::Failure;
use crate::args::{EstimateArgument, MapArguments};
use crate::progress::Monitor;
use crate::render::failure;
use caustic_bench::Digest;
use caustic_device::{Buffer, Device, Plan};
use caustic_kernels::layout::{Irradiance, Photon, Query};
use caustic_photon_map::{LargestPower, MapError, MapOptions, PhotonMap, bounds, plan_grid, sample};
use caustic_renderer::{Progress, RenderError};
use exact::{ExactDensity, ExactNearest};
use source::Source;
use std::time::Instant;

/// Queries whose neighbours are checked against brute force.
const CHECKED: usize = 64;

/// Builds, searches, checks and reports.
pub fn run(arguments: &MapArguments) -> Result<(), Failure> {
    let source = Source::parse(&arguments.photons, arguments.k, arguments.memory.is_some())?;
    if let Some(memory) = arguments.memory {
        return streamed::run(arguments, &source, memory);
    }
    let photons = source.photons(0..source.count()).map_err(Failure::input)?;
    let queries = source.queries(arguments.queries).map_err(Failure::input)?;
    let radius = arguments.radius.unwrap_or_else(|| source.radius(arguments.k));
    let options = MapOptions { radius, hash: arguments.hash.into(), table: None, cell: None };
    let (device, line) = Device::open_with(&arguments.device, arguments.precision.into()).map_err(Failure::input)?;
    eprintln!("{line}");

    let mut monitor = Monitor::new(arguments.json);
    let timed = time(&device, &photons, &queries, &options, arguments, &mut monitor);
    monitor.finish();
    let timed = timed.map_err(|error| failure(&error))?;
    let checked = check(&device, &photons, &queries, &options, arguments).map_err(Failure::input)?;
    let differ = checked.differ;
    let report = serde_json::json!({
        "device": device.name(),
        "photons": photons.len(),
        "queries": queries.len(),
        "estimate": arguments.estimate.name(),
        "k": arguments.k,
        "radius": radius,
        "build_ms": timed.build_ms,
        "query_ms": timed.query_ms,
        "map_bytes": timed.map_bytes,
        "peak_bytes": device.total_bytes().1,
        "checked_queries": CHECKED.min(queries.len()),
        "queries_that_differ_from_brute_force": differ,
        "irradiance_sha256": checked.sha256,
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
        println!(
            "query {:.3} ms, {} queries, {}",
            timed.query_ms,
            queries.len(),
            arguments.estimate.sentence(arguments.k)
        );
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
    let grid = plan_grid(low, high, photons.len() as u64, &sample(photons), options)?;
    let unsorted = device.upload("photons", photons)?;
    let query_buffer: Buffer = device.upload("queries", queries)?;
    let out = device.scratch::<Irradiance>("irradiance", queries.len() as u64)?;
    let mut build = Plan::new();
    build.scope("build");
    let map = PhotonMap::plan(device, &mut build, &unsorted, grid)?;
    let mut query = Plan::new();
    query.scope("query");
    let count = queries.len() as u32;
    match arguments.estimate {
        EstimateArgument::Nearest => {
            map.plan_irradiance(device, &mut query, &query_buffer, count, arguments.k, arguments.gather.into(), &out)?;
        }
        EstimateArgument::Density => map.plan_density(device, &mut query, &query_buffer, count, &out)?,
    }
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

/// What comparing with brute force says.
struct Checked {
    /// Of the first queries, those that have another result.
    differ: usize,
    /// The hash of the irradiance of all queries, where it is from all photons within the radius.
    sha256: Option<String>,
}

/// Compares the first queries with what looking at all photons finds: neighbours and distances, or irradiance, to the bit.
fn check(
    device: &Device,
    photons: &[Photon],
    queries: &[Query],
    options: &MapOptions,
    arguments: &MapArguments,
) -> Result<Checked, MapError> {
    let map = PhotonMap::build(device, photons, options)?;
    let first = &queries[..CHECKED.min(queries.len())];
    if arguments.estimate == EstimateArgument::Density {
        let mut largest = LargestPower::default();
        largest.see(photons);
        let mut exact = ExactDensity::new(first, largest, options.radius);
        exact.add(photons);
        let found = map.density(device, queries)?;
        let differ = exact.differ(&found, device.is_exact());
        return Ok(Checked { differ, sha256: Some(sha256(&found)) });
    }
    let mut exact = ExactNearest::new(first, arguments.k, options.radius);
    exact.add(photons, 0);
    let found = map.k_nearest(device, first, arguments.k, arguments.gather.into())?;
    let differ = exact.best.iter().zip(&found).filter(|(exact, found)| exact != found).count();
    Ok(Checked { differ, sha256: None })
}

/// The hash of estimates.
fn sha256(estimates: &[Irradiance]) -> String {
    let mut digest = Digest::default();
    digest.add(estimates);
    digest.hex()
}
