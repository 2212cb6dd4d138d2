//! Measuring cases, one size after the other.

use crate::case::{Case, Target};
use crate::machine::{Machine, is_device};
use crate::measure::{Policy, Spread, repeat};
use crate::roofline::copy_roofline;
use crate::row::{Measured, Outcome, Part, Reached, Row, Sample, Stage};
use crate::work::{Trouble, Work, prepare};
use caustic_device::Device;
use std::time::Duration;

/// The largest N on a CPU that is not told otherwise: ten times as many take minutes a case.
pub const CPU_MAX_N: u32 = 10_000_000;
/// The largest N of a quick run.
pub const QUICK_N: u32 = 1 << 16;

/// How long a GPU's clock may take to rise: an H100 ran whole rows at down to a fourth of its speed, 21 runs of a millisecond after the host
/// had checked large results.
const WARM_FOR: Duration = Duration::from_millis(300);

/// What to measure, and how often.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// The largest N; if not given, [`CPU_MAX_N`] on a CPU and no bound on a GPU.
    pub max_n: Option<u32>,
    /// Runs of each row, if they are fast enough.
    pub repeat: u32,
    /// Seconds after which five runs are enough.
    pub budget_s: f64,
    /// Small sizes only, few runs.
    pub quick: bool,
    /// Whether the peers run, where they are compiled in.
    pub peers: bool,
}

/// Rows, and where they are from.
#[derive(Clone, Debug)]
pub struct Suite {
    /// The machine.
    pub machine: Machine,
    /// Bytes a second of a copy, read and written ones together.
    pub copy_bytes_per_second: Option<f64>,
    /// What was measured, in order.
    pub rows: Vec<Row>,
    /// Whether the user stopped it before the end.
    pub interrupted: bool,
    /// What is wrong: results that are not what they have to be, devices that failed.
    pub wrong: Vec<String>,
}

/// How far the suite is.
pub enum Event<'a> {
    /// It begins this case at this size; so much of all is done.
    Begin(&'a Case, u32, f64),
    /// It finished a row.
    Row(&'a Row),
    /// Nothing new: does it go on?
    Tick,
}

/// Measures `cases` on `device`. `tell` is called now and then, and the suite ends when it returns false.
pub fn run(cases: &[Case], device: &Device, options: &Options, tell: &mut dyn FnMut(Event<'_>) -> bool) -> Suite {
    let copy = copy_roofline(device);
    let mut suite = Suite {
        machine: Machine::of(device),
        copy_bytes_per_second: copy,
        rows: Vec::new(),
        interrupted: false,
        wrong: Vec::new(),
    };
    let largest = options.max_n.or((!device.is_gpu()).then_some(CPU_MAX_N)).unwrap_or(u32::MAX);
    let runs = |case: &Case, n: u32| n <= largest && (!options.quick || n <= QUICK_N.max(case.sizes[0]));
    let effort =
        |case: &Case| -> f64 { case.sizes.iter().filter(|&&n| runs(case, n)).map(|&n| case.kind.effort(n)).sum() };
    let all: f64 = cases.iter().map(effort).sum();
    let mut done = 0.0;
    'cases: for case in cases {
        for &n in &case.sizes {
            // Quick is a choice of sizes; what it leaves out is none of them. A bound is reported.
            if options.quick && !runs(case, n) {
                continue;
            }
            let mut outcome = Err(Trouble::Skip(above(largest, options)));
            if runs(case, n) {
                if !tell(Event::Begin(case, n, done / all)) {
                    suite.interrupted = true;
                    break 'cases;
                }
                outcome = measure(case, n, device, options, copy, &mut || tell(Event::Tick));
                done += case.kind.effort(n);
            }
            let outcome = match outcome {
                Ok(measured) => {
                    suite.wrong.extend(wrongs(case, n, &measured, device));
                    Outcome::Measured(Box::new(measured))
                }
                Err(Trouble::Skip(reason)) => Outcome::Skipped(reason),
                Err(Trouble::Interrupted) => {
                    suite.interrupted = true;
                    break 'cases;
                }
                Err(Trouble::Fail(reason)) => {
                    suite.wrong.push(format!("{} at N = {n}: {reason}", case.name));
                    break 'cases;
                }
            };
            let row = Row {
                case: case.name.clone(),
                kind: case.kind.name().to_string(),
                n,
                counts: case.kind.counts().to_string(),
                queries: case.kind.queries(n),
                outcome,
            };
            let goes_on = tell(Event::Row(&row));
            suite.rows.push(row);
            if !goes_on {
                // This row may have fewer runs than were asked for, which it says.
                suite.interrupted = true;
                break 'cases;
            }
        }
    }
    suite
}

fn above(largest: u32, options: &Options) -> String {
    match options.max_n {
        Some(n) => format!("N is above --max-n {n}"),
        None => format!("N is above {largest}, the bound of a CPU; --max-n raises it"),
    }
}

/// What is wrong with a row's results.
fn wrongs(case: &Case, n: u32, measured: &Measured, device: &Device) -> Vec<String> {
    let mut wrong = Vec::new();
    // What is not meant to be exact has other bits, and that is no error.
    if measured.as_expected == Some(false) && device.is_exact() {
        let expected = case.expected.get(&n).map_or("", String::as_str);
        let found = &measured.sha256;
        wrong.push(format!("{} at N = {n}: the result's SHA-256 is {found} but must be {expected}", case.name));
    }
    if measured.differ > 0 {
        let (differ, checked) = (measured.differ, measured.checked);
        wrong.push(format!("{} at N = {n}: {differ} of {checked} checked results differ from brute force", case.name));
    }
    wrong
}

fn measure(
    case: &Case,
    n: u32,
    device: &Device,
    options: &Options,
    copy: Option<f64>,
    goes_on: &mut dyn FnMut() -> bool,
) -> Result<Measured, Trouble> {
    let mut work = prepare(case, n, device)?;
    let policy = Policy {
        repeat: options.repeat as usize,
        warm_up: if device.is_gpu() { 3 } else { 1 },
        warm_for: if device.is_gpu() && !device.is_software_gpu() { WARM_FOR } else { Duration::ZERO },
        budget: Duration::from_secs_f64(options.budget_s),
        least: if options.quick { 3 } else { 5 },
    };
    let samples = repeat(policy, goes_on, || work.run())?;
    if samples.is_empty() {
        return Err(Trouble::Interrupted);
    }
    let sha256 = work.digest()?;
    let (checked, differ) = work.check()?;
    let mut measured = summary(work.as_ref(), &samples, device);
    measured.as_expected = case.expected.get(&n).map(|expected| *expected == sha256);
    measured.sha256 = sha256;
    (measured.checked, measured.differ) = (checked, differ);
    let seconds = measured.time().median * 1e-3;
    measured.of_copy = measured.bytes.zip(copy).map(|(bytes, copy)| bytes as f64 / seconds / copy);
    if options.peers && goes_on() {
        measured.peers = work.peers(policy, goes_on)?;
        for peer in &mut measured.peers {
            // By the same clock where both have it.
            let ours_by_stages = measured.stages_ms.zip(peer.stages_ms);
            let pair = ours_by_stages.or(peer.wall_ms.map(|theirs| (measured.wall_ms, theirs)));
            peer.over_ours = pair.map(|(ours, theirs)| theirs.median / ours.median);
        }
    }
    let about = case.targets.iter().filter(|target| target.n == n && is_device(&target.device, device));
    measured.targets = about.flat_map(|target| reached(target, &measured)).collect();
    Ok(measured)
}

/// Times of samples.
fn summary(work: &dyn Work, samples: &[Sample], device: &Device) -> Measured {
    let sum = |sample: &Sample, wanted: &dyn Fn(&str) -> bool| -> f64 {
        sample.stages.iter().filter(|stage| wanted(&stage.stage)).map(|stage| stage.ms).sum()
    };
    let of = |wanted: &dyn Fn(&str) -> bool| {
        let times: Vec<f64> = samples.iter().map(|sample| sum(sample, wanted)).collect();
        Spread::of(&times)
    };
    let in_part = |part: &str, stage: &str| stage.split_once('/').is_some_and(|(scope, _)| scope == part);
    let mut parts: Vec<Part> = Vec::new();
    let mut stages = Vec::new();
    for stage in &samples[0].stages {
        if let Some((part, _)) = stage.stage.split_once('/')
            && parts.iter().all(|known| known.part != part)
        {
            parts.push(Part { part: part.to_string(), ms: of(&|stage| in_part(part, stage)).median });
        }
        let ms = of(&|other| other == stage.stage).median;
        stages.push(Stage { stage: stage.stage.clone(), runs: stage.runs, ms });
    }
    let stages_ms = Some(of(&|_| true)).filter(|spread| spread.median > 0.0);
    let wall: Vec<f64> = samples.iter().map(|sample| sample.wall_ms).collect();
    let clock = if stages_ms.is_some() { work.clock(device) } else { crate::row::Clock::Wall };
    let mut measured = Measured {
        runs: samples.len(),
        clock,
        stages_ms,
        wall_ms: Spread::of(&wall),
        parts,
        stages,
        per_second: 0.0,
        unit: String::new(),
        bytes: work.bytes(),
        of_copy: None,
        sha256: String::new(),
        as_expected: None,
        checked: 0,
        differ: 0,
        targets: Vec::new(),
        peers: Vec::new(),
    };
    let units = work.units();
    let counted: f64 = units.parts.iter().filter_map(|part| measured.part(part)).sum();
    let ms = if counted > 0.0 { counted } else { measured.time().median };
    measured.per_second = units.count / (ms * 1e-3);
    measured.unit = units.name.to_string();
    measured
}

/// Whether a target's figures are met.
fn reached(target: &Target, measured: &Measured) -> Vec<Reached> {
    let mut all = Vec::new();
    let of = if target.counts == "all" { String::new() } else { format!("{} ", target.counts) };
    if let Some(most) = target.ms {
        let met = measured.part(&target.counts).map(|ms| ms <= most);
        all.push(Reached { target: format!("{of}≤ {most} ms"), met });
    }
    if let Some(least) = target.per_second {
        let met = Some(measured.per_second >= least);
        all.push(Reached { target: format!("≥ {} M {}/s", least / 1e6, measured.unit), met });
    }
    for name in &target.faster_than {
        let peer = measured.peers.iter().find(|peer| peer.name == *name);
        let met = peer.and_then(|peer| peer.over_ours).map(|over| over > 1.0);
        all.push(Reached { target: format!("faster than {name}"), met });
    }
    all
}
