//! `caustic tradeoff`.

use crate::Failure;
use crate::args::{CasesArguments, TradeoffArguments};
use crate::command;
use crate::progress::BenchMonitor;
use caustic_bench::record;
use caustic_bench::row::Machine;
use caustic_device::{Device, DeviceChoice, Precision};
use caustic_experiments::store::Outcome;
use caustic_planner::tradeoff::{
    Case, Event, Point, Store, csv, html, json, points, reference, run as measure, stability, stability_cases, svg,
};
use caustic_renderer::Show;
use caustic_renderer::scene::Scene;
use std::path::Path;

/// Share of the bar that the reference has.
const OF_REFERENCE: f64 = 0.4;

/// Sweeps the settings of a scene and writes a report.
pub fn run(arguments: &TradeoffArguments) -> Result<(), Failure> {
    let scene = Scene::load(&arguments.scene).map_err(Failure::input)?;
    let given = (arguments.reference != "auto").then(|| Path::new(&arguments.reference));
    let folder = &arguments.output;
    let show = Show::from(arguments.show);
    let title = if show == Show::Beauty { scene.name.clone() } else { format!("{}, {}", scene.name, show.name()) };
    let all = |gpu: bool, quick: bool| -> Vec<(Case, Point)> {
        let device = named(&arguments.device, gpu);
        let of_point = |point: Point| (point.case(&arguments.scene, &device), point);
        points(&scene, quick, show, gpu).into_iter().map(of_point).collect()
    };
    let CasesArguments { part, merge: parts, report_only } = &arguments.cases;
    if *report_only {
        let store = Store::existing("-o", folder).map_err(Failure::input)?;
        return write(folder, &title, &all(store.header.machine.is_gpu(), store.header.quick), &store);
    }
    if let Some(first) = parts.first() {
        let of_first = Store::existing("--merge", first).map_err(Failure::input)?.header;
        let (gpu, quick) = (of_first.machine.is_gpu(), of_first.quick);
        let all = all(gpu, quick);
        let mut cases: Vec<Case> = all.iter().map(|(case, _)| case.clone()).collect();
        cases.extend(stability_cases(quick, gpu));
        let store = Store::merge(folder, parts, &cases).map_err(Failure::input)?;
        return write(folder, &title, &all, &store);
    }
    let (device, line) = Device::open(&arguments.device).map_err(Failure::input)?;
    eprintln!("{line}");
    if let Some(path) = given {
        caustic_metrics::Image::read(path).map_err(|error| Failure::input(format!("--reference: {error}")))?;
    }
    let machine = Machine::of(&device);
    let (part, quick) = (*part, arguments.quick);
    let all = all(device.is_gpu(), quick);
    let mut store = Store::open(folder, &machine, quick, part, &command::line()).map_err(Failure::input)?;
    let monitor = BenchMonitor::new();
    let truth = reference(&scene, &device, quick, show, given, folder, &mut |progress| {
        monitor.begin("reference", OF_REFERENCE * progress.done as f64 / progress.total.max(1) as f64);
        monitor.goes_on()
    });
    let truth = match truth {
        Ok(truth) => truth,
        Err(None) => {
            monitor.finish();
            return Err(Failure::interrupted_sweep(store.cases().count()));
        }
        Err(Some(error)) => return Err(Failure::input(error)),
    };
    let fast = device.is_gpu().then(|| Device::open_with(&arguments.device, Precision::Fast).ok()).flatten();
    let fast = fast.as_ref().map(|(device, _)| device);
    let devices = [Some(&device), fast];
    let mut watch = |event: Event| {
        match event {
            Event::Begin(case, done) => monitor.begin(&case.knob, OF_REFERENCE + (1.0 - OF_REFERENCE) * done),
            Event::Done(case, Outcome::Skipped(reason)) => monitor.print(&format!("{case}: left out, {reason}")),
            Event::Done(..) => {}
        }
        monitor.goes_on()
    };
    let complete = measure(&scene, &all, part, &truth, devices, &mut store, &mut watch)
        .and_then(|complete| Ok(complete && stability(quick, part, devices, &mut store, &mut watch)?));
    monitor.finish();
    let complete = complete.map_err(Failure::machine)?;
    if let Some(part) = part {
        println!("part {part}: {} cases in {}", store.cases().count(), folder.display());
    } else {
        write(folder, &title, &all, &store)?;
    }
    if complete { Ok(()) } else { Err(Failure::interrupted_sweep(store.cases().count())) }
}

/// The device as commands name it: what `auto` found.
fn named(asked: &DeviceChoice, gpu: bool) -> String {
    match asked {
        DeviceChoice::Gpu(Some(which)) => format!("gpu:{which}"),
        _ => if gpu { "gpu" } else { "cpu" }.to_string(),
    }
}

/// Writes the report, also of a sweep that was interrupted.
fn write(folder: &Path, title: &str, points: &[(Case, Point)], store: &Store) -> Result<(), Failure> {
    let svgs = svg(store, points, title).map_err(Failure::machine)?;
    let page = html(store, points, &svgs, title);
    let mut files = vec![
        ("report.html".to_string(), page),
        ("points.csv".to_string(), csv(store, points)),
        ("points.json".to_string(), json(store, points)),
    ];
    files.extend(svgs);
    for (name, text) in files {
        record::write(&folder.join(name), &text).map_err(Failure::machine)?;
    }
    println!("wrote {}", folder.join("report.html").display());
    Ok(())
}
