//! `caustic map --memory`: more photons than memory holds, a map of each chunk after another.

use super::Source;
use crate::Failure;
use crate::args::MapArguments;
use crate::progress::Monitor;
use crate::render::failure;
use caustic_bench::points::Points;
use caustic_device::Device;
use caustic_kernels::gather::distance2;
use caustic_kernels::layout::{Arrival, Neighbour, Photon, Query};
use caustic_photon_map::{MapOptions, NearestStreamed};
use caustic_renderer::{Progress, RenderError};
use std::time::Instant;

/// Queries whose neighbours are checked against brute force.
const CHECKED: usize = 8;
/// Bytes of a photon of a chunk: 32 as it is drawn, 32 on the device, 64 in the map, 20 for the sort, and what of the chunk before is not yet
/// reused.
const PHOTON_BYTES: u64 = 160;
/// Bytes besides: the program, the table of cells (64 MiB), and the neighbours of a part of the queries.
const OTHER_BYTES: u64 = 400 << 20;
/// Most bytes of a photon in one buffer.
const BUFFER_BYTES: u64 = size_of::<Arrival>() as u64;

/// Draws, builds, searches and checks chunk by chunk, and reports.
pub fn run(arguments: &MapArguments, source: &Source, memory: u64) -> Result<(), Failure> {
    let Source::Drawn(distribution, count) = *source else {
        return Err(Failure::input(
            "--memory is for synthetic photons, such as uniform:100000000; a text file is read whole",
        ));
    };
    let points = Points::new(distribution, count, arguments.k);
    let queries = points.queries(arguments.queries);
    let radius = arguments.radius.unwrap_or_else(|| distribution.radius(count, arguments.k));
    let options = MapOptions { radius, hash: arguments.hash.into(), table: None, cell: None };
    let (device, line) = Device::open_with(&arguments.device, arguments.precision.into()).map_err(Failure::input)?;
    eprintln!("{line}");
    let gather = arguments.gather.into();
    let mut nearest = NearestStreamed::new(&device, &queries, arguments.k, gather, &options)
        .map_err(|error| failure(&error.into()))?;
    let taken = OTHER_BYTES + nearest.bytes() + size_of_val(&queries[..]) as u64;
    let fits = memory.saturating_sub(taken) / PHOTON_BYTES;
    if fits < 1000 {
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
    let mut monitor = Monitor::new(arguments.json);
    let begun = Instant::now();
    let mut exact =
        BruteForce { queries: &queries[..CHECKED.min(queries.len())], best: Vec::new(), radius2: radius * radius };
    let mut first = 0;
    let mut work = || -> Result<(), RenderError> {
        while first < count {
            if !monitor.show(Progress { phase: "chunks", done: first.into(), total: count.into() }) {
                return Err(RenderError::Interrupted);
            }
            let photons = points.photons_of(first..first.saturating_add(chunk).min(count));
            exact.add(&photons, first, arguments.k as usize);
            nearest.add(&photons)?;
            first += photons.len() as u32;
        }
        Ok(())
    };
    let worked = work();
    monitor.finish();
    worked.map_err(|error| failure(&error))?;
    let seconds = begun.elapsed().as_secs_f64();
    let differ = exact.best.iter().enumerate().filter(|(q, best)| best[..] != *nearest.neighbours(*q)).count();
    let stages = device.stage_times();
    let predicted = taken + PHOTON_BYTES * u64::from(chunk);
    let peak = peak_bytes();
    if arguments.json {
        let report = serde_json::json!({
            "device": device.name(),
            "photons": count,
            "chunks": chunks,
            "chunk_photons": chunk,
            "queries": queries.len(),
            "k": arguments.k,
            "radius": radius,
            "seconds": seconds,
            "memory_bytes": memory,
            "predicted_bytes": predicted,
            "peak_bytes": peak,
            "device_peak_bytes": device.total_bytes().1,
            "checked_queries": exact.best.len(),
            "queries_that_differ_from_brute_force": differ,
            "stages": stages,
        });
        println!("{report:#}");
    } else {
        let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
        println!(
            "{count} photons in {chunks} chunks of {chunk}, {} queries, k = {}: {seconds:.1} s",
            queries.len(),
            arguments.k
        );
        let peak = peak.map_or("unknown".to_string(), |peak| format!("{:.2} GiB", gib(peak)));
        println!(
            "memory: {:.2} GiB allowed, {:.2} GiB predicted, peak of the process {peak}, of the device {:.2} GiB",
            gib(memory),
            gib(predicted),
            gib(device.total_bytes().1)
        );
        println!("{differ} of {} checked queries differ from brute force", exact.best.len());
    }
    if differ > 0 {
        return Err(Failure::machine(format!("{differ} queries differ from brute force: the device computes wrongly")));
    }
    Ok(())
}

/// Most memory that this process has had, bytes, where the system tells (Linux).
fn peak_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kib| kib * 1024)
}

/// The nearest photons of a few queries, found by looking at all.
struct BruteForce<'a> {
    queries: &'a [Query],
    best: Vec<Vec<Neighbour>>,
    radius2: f32,
}

impl BruteForce<'_> {
    /// Looks at the photons from index `first` on.
    fn add(&mut self, photons: &[Photon], first: u32, k: usize) {
        self.best.resize(self.queries.len(), Vec::new());
        for (query, best) in self.queries.iter().zip(&mut self.best) {
            let bound = if best.len() < k { self.radius2 } else { best[k - 1].distance2 };
            let near = (first..).zip(photons).filter_map(|(photon, &Photon { position, .. })| {
                let distance2 = distance2(query.position, position);
                (distance2 <= bound).then_some(Neighbour { distance2, photon })
            });
            best.extend(near);
            best.sort_by(|a, b| a.distance2.total_cmp(&b.distance2).then(a.photon.cmp(&b.photon)));
            best.truncate(k);
        }
    }
}
