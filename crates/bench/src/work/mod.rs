//! A case at one size, prepared on a device.

mod frame;
mod map;
mod search;
mod sort;
mod trace;
mod traffic;
mod trouble;

pub use trouble::Trouble;

use crate::case::{Case, Kind};
use crate::machine::available_bytes;
use crate::measure::Policy;
use crate::row::{Clock, Peer, Sample};
use caustic_device::{Device, Plan};
use std::time::Instant;

/// What can be run again and again.
pub(crate) trait Work {
    /// Runs once, timed. Inputs that the last run overwrote are brought back before, outside the time.
    fn run(&mut self) -> Result<Sample, Trouble>;

    /// SHA-256 of the result of the last run.
    fn digest(&mut self) -> Result<String, Trouble>;

    /// How many results were checked by brute force, and how many of them differ.
    fn check(&mut self) -> Result<(usize, usize), Trouble>;

    /// What is counted a second.
    fn units(&self) -> Units;

    /// Least bytes that have to be moved.
    fn bytes(&self) -> Option<u64>;

    /// The clock that the headline time is from: stages on a GPU, where launches are the program's and not the algorithm's, and
    /// the wall on the CPU, as for the peers.
    fn clock(&self, device: &Device) -> Clock {
        if device.is_gpu() { Clock::Stages } else { Clock::Wall }
    }

    /// The peers on the same data.
    fn peers(&mut self, _policy: Policy, _goes_on: &mut dyn FnMut() -> bool) -> Result<Vec<Peer>, Trouble> {
        Ok(Vec::new())
    }
}

/// What is counted a second.
pub(crate) struct Units {
    /// How many a run.
    pub count: f64,
    /// What they are.
    pub name: &'static str,
    /// The parts whose time counts; all if empty.
    pub parts: &'static [&'static str],
}

/// Prepares a case at size `n`. A new kind is an arm here.
pub(crate) fn prepare<'a>(case: &Case, n: u32, device: &'a Device) -> Result<Box<dyn Work + 'a>, Trouble> {
    // What the last case left is of no use to this one.
    device.trim();
    let needed = host_bytes(&case.kind, n, device);
    if let Some(available) = available_bytes().filter(|&available| needed > available) {
        let mib = |bytes: u64| bytes >> 20;
        return Err(Trouble::Skip(format!(
            "inputs and results of N = {n} need about {} MiB of main memory and {} MiB are available",
            mib(needed),
            mib(available)
        )));
    }
    Ok(match &case.kind {
        Kind::Sort { bits, pairs } => Box::new(sort::Sort::new(device, n, *bits, *pairs)?),
        Kind::Build(map) => Box::new(map::Build::new(device, n, map)?),
        Kind::Gather { map, output, gather, .. } => {
            let queries = case.kind.queries(n).unwrap_or(n);
            Box::new(search::Search::new(device, n, map, queries, *output, *gather)?)
        }
        Kind::Trace { scene } => Box::new(trace::Trace::new(device, n, scene)?),
        Kind::Frame { scene, size, spp, k } => Box::new(frame::Frame::new(device, n, scene, *size, *spp, *k)?),
    })
}

/// Main memory that a case takes, roughly: inputs and results here, and on a CPU the buffers of the device, too.
fn host_bytes(kind: &Kind, n: u32, device: &Device) -> u64 {
    let n = u64::from(n);
    let [here, on_device] = match kind {
        Kind::Sort { pairs: true, .. } => [16 * n, 24 * n],
        Kind::Sort { pairs: false, .. } => [12 * n, 12 * n],
        Kind::Build(_) => [32 * n, 96 * n],
        Kind::Gather { map, queries, output, .. } => {
            let queries = u64::from(*queries).min(n);
            let result = if *output == crate::case::Output::Neighbours { 8 * u64::from(map.k) + 4 } else { 16 };
            [32 * n + queries * (16 + 2 * result), 96 * n + queries * (16 + result)]
        }
        // Two photons a path in all scenes that come with the program, with room to spare.
        Kind::Trace { .. } => [128 * n, 136 * n],
        Kind::Frame { .. } => [0, 300 * n],
    };
    if device.is_gpu() { here } else { here + on_device }
}

/// Runs a plan and takes its times.
fn timed(device: &Device, plan: &Plan) -> Result<Sample, Trouble> {
    device.reset_stage_times();
    let start = Instant::now();
    device.run(plan)?;
    Ok(Sample { wall_ms: start.elapsed().as_secs_f64() * 1e3, stages: device.stage_times() })
}
