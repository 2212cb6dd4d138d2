//! `caustic map --memory`: more photons than memory holds, a map of each chunk after another.

use super::exact::{ExactDensity, ExactNearest};
use super::source::Source;
use super::{Checked, sha256};
use crate::Failure;
use crate::args::{EstimateArgument, MapArguments};
use crate::progress::Monitor;
use crate::render::failure;
use caustic_device::Device;
use caustic_kernels::layout::{Arrival, Neighbour, Photon, Query};
use caustic_photon_map::{DensityStreamed, MapError, MapOptions, NearestStreamed};
use caustic_renderer::{Progress, RenderError};
use std::time::Instant;

/// Queries whose neighbours are checked against brute force.
const CHECKED: usize = 8;
/// Bytes of a photon of a chunk: 32 as it is drawn or read, 32 on the device, 64 in the map, 20 for the sort, and what of the chunk before is not yet
/// reused.
const PHOTON_BYTES: u64 = 160;
/// Bytes besides: the program, the table of cells (64 MiB), the neighbours of a part of the queries, and a file's window (16 MiB).
const OTHER_BYTES: u64 = 400 << 20;
/// Most bytes of a photon in one buffer.
const BUFFER_BYTES: u64 = size_of::<Arrival>() as u64;

/// Reads or draws photons, maps them and searches among them chunk by chunk, checks and reports.
pub fn run(arguments: &MapArguments, source: &Source, memory: u64) -> Result<(), Failure> {
    let count = source.count();
    let queries = source.queries(arguments.queries).map_err(Failure::input)?;
    let radius = arguments.radius.unwrap_or_else(|| source.radius(arguments.k));
    let options = MapOptions { radius, hash: arguments.hash.into(), table: None, cell: None };
    let (device, line) = Device::open_with(&arguments.device, arguments.precision.into()).map_err(Failure::input)?;
    eprintln!("{line}");
    let mut monitor = Monitor::new(arguments.json);
    let begun = Instant::now();
    let search = Search::new(&device, arguments, source, &queries, &options, &mut monitor);
    let mut search = search.inspect_err(|_| monitor.finish()).map_err(|error| failure(&error))?;
    let taken = OTHER_BYTES + search.bytes() + size_of_val(&queries[..]) as u64;
    let fits = memory.saturating_sub(taken) / PHOTON_BYTES;
    if fits < 1000 {
        monitor.finish();
        let least = (taken + 1000 * PHOTON_BYTES).div_ceil(1 << 20);
        return Err(Failure::input(format!(
            "--memory {} MiB is too little: give at least {least}MiB, or fewer --queries",
            memory >> 20
        )));
    }
    let fits = fits.min(device.largest_buffer() / BUFFER_BYTES);
    // Chunks of one size, so that the memory of one serves the next.
    let chunks = u64::from(count).div_ceil(fits);
    let chunk = u64::from(count).div_ceil(chunks) as u32;
    let mut added = Ok(());
    let read = source.each(chunk, |first, photons| {
        added = if monitor.show(Progress { phase: "chunks", done: first.into(), total: count.into() }) {
            search.add(photons, first).map_err(RenderError::from)
        } else {
            Err(RenderError::Interrupted)
        };
        added.is_ok()
    });
    monitor.finish();
    read.map_err(Failure::input)?;
    added.map_err(|error| failure(&error))?;
    let Checked { differ, sha256 } = search.check().map_err(|error| failure(&error.into()))?;
    let seconds = begun.elapsed().as_secs_f64();
    let checked = CHECKED.min(queries.len());
    let predicted = taken + PHOTON_BYTES * u64::from(chunk);
    let peak = peak_bytes();
    if arguments.json {
        let report = serde_json::json!({
            "device": device.name(),
            "photons": count,
            "chunks": chunks,
            "chunk_photons": chunk,
            "queries": queries.len(),
            "estimate": arguments.estimate.name(),
            "k": arguments.k,
            "radius": radius,
            "seconds": seconds,
            "memory_bytes": memory,
            "predicted_bytes": predicted,
            "peak_bytes": peak,
            "device_peak_bytes": device.total_bytes().1,
            "checked_queries": checked,
            "queries_that_differ_from_brute_force": differ,
            "irradiance_sha256": sha256,
            "stages": device.stage_times(),
        });
        println!("{report:#}");
    } else {
        let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
        println!(
            "{count} photons in {chunks} chunks of {chunk}, {} queries, {}: {seconds:.1} s",
            queries.len(),
            arguments.estimate.sentence(arguments.k)
        );
        let peak = peak.map_or("unknown".to_string(), |peak| format!("{:.2} GiB", gib(peak)));
        println!(
            "memory: {:.2} GiB allowed, {:.2} GiB predicted, peak of the process {peak}, of the device {:.2} GiB",
            gib(memory),
            gib(predicted),
            gib(device.total_bytes().1)
        );
        println!("{differ} of {checked} checked queries differ from brute force");
    }
    if differ > 0 {
        return Err(Failure::machine(format!("{differ} queries differ from brute force: the device computes wrongly")));
    }
    Ok(())
}

/// What is asked of the photons, with what the first queries should have.
enum Search<'a> {
    Nearest(NearestStreamed<'a>, ExactNearest),
    Density(DensityStreamed<'a>, ExactDensity, bool),
}

impl<'a> Search<'a> {
    fn new(
        device: &'a Device,
        arguments: &MapArguments,
        source: &Source,
        queries: &'a [Query],
        options: &MapOptions,
        monitor: &mut Monitor,
    ) -> Result<Self, RenderError> {
        let first = &queries[..CHECKED.min(queries.len())];
        match arguments.estimate {
            EstimateArgument::Nearest => {
                let exact = ExactNearest::new(first, arguments.k, options.radius);
                let gather = arguments.gather.into();
                Ok(Self::Nearest(NearestStreamed::new(device, queries, arguments.k, gather, options)?, exact))
            }
            EstimateArgument::Density => {
                let mut go_on = true;
                let total = source.count().into();
                let largest = source.largest_power(|done| {
                    go_on = monitor.show(Progress { phase: "largest power", done: done.into(), total });
                    go_on
                })?;
                if !go_on {
                    return Err(RenderError::Interrupted);
                }
                let exact = ExactDensity::new(first, largest, options.radius);
                Ok(Self::Density(DensityStreamed::new(device, queries, largest, options)?, exact, device.is_exact()))
            }
        }
    }

    /// Bytes that it takes beside photons and queries.
    fn bytes(&self) -> u64 {
        match self {
            Self::Nearest(nearest, _) => nearest.bytes(),
            Self::Density(density, ..) => density.bytes(),
        }
    }

    /// Adds the photons from index `first` on.
    fn add(&mut self, photons: &[Photon], first: u32) -> Result<(), MapError> {
        match self {
            Self::Nearest(nearest, exact) => {
                exact.add(photons, first);
                nearest.add(photons)
            }
            Self::Density(density, exact, _) => {
                exact.add(photons);
                density.add(photons)
            }
        }
    }

    /// How many of the first queries differ, and the hash of all.
    fn check(&self) -> Result<Checked, MapError> {
        match self {
            Self::Nearest(nearest, exact) => {
                let differs = |(q, best): &(usize, &Vec<Neighbour>)| best[..] != *nearest.neighbours(*q);
                Ok(Checked { differ: exact.best.iter().enumerate().filter(differs).count(), sha256: None })
            }
            Self::Density(density, exact, is_exact) => {
                let found = density.irradiance()?;
                Ok(Checked { differ: exact.differ(&found, *is_exact), sha256: Some(sha256(&found)) })
            }
        }
    }
}

/// Most memory that this process has had, bytes, where the system tells (Linux).
fn peak_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kib| kib * 1024)
}
