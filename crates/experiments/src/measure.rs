//! Measuring a case.

use crate::case::{Case, What};
use crate::picture;
use crate::stage::Stage;
use crate::store::Outcome;
use crate::subject::Subject;
use caustic_bench::measure::{Policy, Spread, repeat};
use caustic_bench::{Digest, Trouble};
use caustic_device::{Buffer, Device};
use caustic_kernels::gather::GATHER_LANES;
use caustic_kernels::layout::{Neighbour, Query};
use caustic_photon_map::{Neighbours, whole};
use caustic_recorder::Recorder;
use caustic_rivals::{KdSearch, KdTree, PhotonIndex, Photons, radius_error};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// Bytes of neighbours that a search returns at once: more queries are searched in parts.
const MOST_FOUND: u64 = 1 << 29;

/// Lanes of a warp.
const WARP: u32 = 32;

/// What came of a case, with the SHA-256 of what was found.
pub(crate) type Measured = (Outcome, Option<String>);

/// Measures a case. `folder` is where pictures go.
pub(crate) fn measure(
    stage: &mut Stage,
    subject: &Subject,
    case: &Case,
    folder: &Path,
    quick: bool,
) -> Result<Measured, Trouble> {
    let start = Instant::now();
    let measured = match case.what {
        What::Speed => speed(stage, subject, case, quick),
        What::Access => access(stage, subject, case),
        What::Picture => picture::measure(stage, subject, case, folder),
        What::Radius => radius(stage, case),
    };
    match measured {
        // What is no time itself takes time, too: so much of it that larger cases are to be foreseen.
        Ok((Outcome::Values(mut values), found)) if case.what != What::Speed => {
            values.insert("case_ms".to_string(), milliseconds(start));
            Ok((Outcome::Values(values), found))
        }
        Err(Trouble::Skip(reason)) => Ok((Outcome::Skipped(reason), None)),
        other => other,
    }
}

/// Times and bytes. Construction is by the wall clock, from photons on the device to an index that can be searched; of both there is also
/// what the stages took, which is what a GPU worked.
fn speed(stage: &mut Stage, subject: &Subject, case: &Case, quick: bool) -> Result<Measured, Trouble> {
    let budget = Duration::from_secs_f64(if quick { 0.05 } else { 0.7 });
    // A GPU that waited for the host has a low clock.
    let warm_for = Duration::from_millis(if stage.device_of(subject.on_cpu).is_gpu() && !quick { 50 } else { 0 });
    let policy = Policy { repeat: if quick { 3 } else { 7 }, warm_up: 0, warm_for, budget, least: 1 };
    let queries = stage.look(case.size)?.to_vec();
    stage.photons(case.map, case.photons, subject.on_cpu)?;
    let device = stage.device_of(subject.on_cpu);
    let photons = stage.uploaded();
    let (before, _) = device.total_bytes();
    let mut index: Option<Box<dyn PhotonIndex>> = None;
    let mut values = BTreeMap::new();
    let builds = repeat(Policy { warm_up: 1, ..policy }, &mut || true, || {
        index = None;
        device.reset_stage_times();
        device.reset_peak_bytes();
        let start = Instant::now();
        index = Some(subject.technique.build(device, photons, case.radius())?);
        let wall = milliseconds(start);
        let (now, peak) = device.total_bytes();
        values.insert("memory_bytes".to_string(), (now - before) as f64);
        values.insert("peak_bytes".to_string(), (peak - before) as f64);
        Ok::<_, Trouble>((wall, stages(device)))
    })?;
    times(&mut values, "build", &builds);
    let Some(index) = index else { return Err(Trouble::Interrupted) };

    let parts = parts(device, &queries, case.k)?;
    let mut run = |each: &mut dyn FnMut(&Neighbours, u32) -> Result<(), Trouble>| {
        device.reset_stage_times();
        device.reset_peak_bytes();
        let start = Instant::now();
        let mut apart = Duration::ZERO;
        for (queries, count) in &parts {
            let found = index.search(device, queries, *count, case.k)?;
            let found_at = Instant::now();
            each(&found, *count)?;
            apart += found_at.elapsed();
        }
        let wall = (start.elapsed() - apart).as_secs_f64() * 1e3;
        values.insert("search_peak_bytes".to_string(), (device.total_bytes().1 - before) as f64);
        Ok::<_, Trouble>((wall, stages(device)))
    };
    // Read back first: that warms everything up.
    let mut digest = Digest::default();
    let first = run(&mut |found, count| add(&mut digest, device, found, count, case.k))?;
    let searches = if !device.is_gpu() && Duration::from_secs_f64(first.0 * 1e-3) > budget {
        // A CPU has nothing to compile, and is warm after so long a search.
        vec![first]
    } else {
        repeat(policy, &mut || true, || run(&mut |_, _| Ok(())))?
    };
    times(&mut values, "search", &searches);
    for stage in device.stage_times() {
        values.insert(format!("search/{}_ms", stage.stage), stage.ms);
    }
    Ok((Outcome::Values(values), Some(digest.hex())))
}

/// Workgroups of a search that are recorded: enough for counts to settle.
const RECORDED: u32 = 100;

/// Memory accesses, by a recorder, whatever the device. Of many workgroups some are recorded, and counts are scaled to all.
fn access(stage: &mut Stage, subject: &Subject, case: &Case) -> Result<Measured, Trouble> {
    let queries = stage.look(case.size)?.to_vec();
    let photons = stage.first(case.map, case.photons)?;
    let recorder = Recorder::every(WARP, prime_from(case.queries() / GATHER_LANES / RECORDED));
    let device = recorder.device();
    let photons = Photons::upload(&device, &photons)?;
    let index = subject.technique.build(&device, &photons, case.radius())?;
    let mut values = BTreeMap::new();
    counts(&mut values, "build", &recorder);
    let parts = parts(&device, &queries, case.k)?;
    search(&device, index.as_ref(), &parts, case.k)?;
    counts(&mut values, "search", &recorder);
    Ok((Outcome::Values(values), None))
}

/// The first prime from a number on, or 1: workgroups so far apart do not all lie in the same column of a picture.
fn prime_from(n: u32) -> u32 {
    if n < 2 {
        return 1;
    }
    let is_prime = |n: &u32| (2..).take_while(|d| d * d <= *n).all(|d| !n.is_multiple_of(d));
    (n..).find(is_prime).unwrap_or(n)
}

/// What was recorded since the last time, scaled to all workgroups.
fn counts(values: &mut BTreeMap<String, f64>, of: &str, recorder: &Recorder) {
    let mut add = |name: String, count: f64| *values.entry(name).or_insert(0.0) += count.round();
    for stage in recorder.report() {
        let all = f64::from(stage.groups as u32) / f64::from(stage.recorded_groups.max(1) as u32);
        add(format!("{of}_excess_sectors"), stage.total.excess as f64 * all);
        add(format!("{of}_sectors"), stage.total.sectors as f64 * all);
        let local = stage.local_loads + stage.local_stores;
        add(format!("{of}_local_accesses"), local as f64 * all);
        if local > 0 {
            add(format!("{of}_local/{}", stage.kernel), local as f64 * all);
        }
    }
    recorder.reset();
}

/// How far the radius of the kd-tree's search is from that of the k-th neighbour, after one to four histograms.
fn radius(stage: &mut Stage, case: &Case) -> Result<Measured, Trouble> {
    stage.look(case.size)?;
    stage.photons(case.map, case.photons, false)?;
    let (device, photons, (_, queries)) = (stage.device_of(false), stage.uploaded(), stage.view());
    let tree = KdTree::build(device, photons, case.radius(), KdSearch::Range)?;
    let mut values = BTreeMap::new();
    for rounds in 1..=4 {
        let error = radius_error(device, &tree, queries, case.k, rounds)?;
        values.insert(format!("mean_error_{rounds}"), error.mean);
        values.insert(format!("most_error_{rounds}"), error.max);
        values.insert("queries".to_string(), error.queries as f64);
    }
    Ok((Outcome::Values(values), None))
}

fn times(values: &mut BTreeMap<String, f64>, of: &str, runs: &[(f64, f64)]) {
    let median = |part: fn(&(f64, f64)) -> f64| Spread::of(&runs.iter().map(part).collect::<Vec<_>>()).median;
    values.insert(format!("{of}_ms"), median(|run| run.0));
    values.insert(format!("{of}_stages_ms"), median(|run| run.1));
    values.insert(format!("{of}_runs"), runs.len() as f64);
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

/// What all stages took since they were reset.
fn stages(device: &Device) -> f64 {
    device.stage_times().iter().map(|stage| stage.ms).sum()
}

/// Queries in parts whose neighbours fit a buffer.
fn parts(device: &Device, queries: &[Query], k: u32) -> Result<Vec<(Buffer, u32)>, Trouble> {
    let most = (MOST_FOUND / (u64::from(k) * size_of::<Neighbour>() as u64)) as usize;
    let part = |part: &[Query]| Ok((device.upload("queries", part)?, part.len() as u32));
    queries.chunks(most.max(1)).map(part).collect()
}

fn search(device: &Device, index: &dyn PhotonIndex, parts: &[(Buffer, u32)], k: u32) -> Result<(), Trouble> {
    for (queries, count) in parts {
        index.search(device, queries, *count, k)?;
    }
    Ok(())
}

/// Adds neighbours to a hash: the same for every technique.
fn add(digest: &mut Digest, device: &Device, found: &Neighbours, count: u32, k: u32) -> Result<(), Trouble> {
    let counts: Vec<u32> = device.read(&found.counts, u64::from(count))?;
    whole(device, counts.iter().copied())?;
    let neighbours: Vec<Neighbour> = device.read(&found.neighbours, u64::from(count) * u64::from(k))?;
    digest.add(&counts);
    for (row, count) in neighbours.chunks(k as usize).zip(counts) {
        digest.add(&row[..count as usize]);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::prime_from;

    #[test]
    fn primes_come_from_where_they_should() {
        assert_eq!([0, 1, 2, 3, 4, 24, 48, 75].map(prime_from), [1, 1, 2, 3, 5, 29, 53, 79]);
    }
}
