//! `caustic experiments`.

use crate::Failure;
use crate::args::{CasesArguments, ExperimentsArguments};
use crate::command;
use crate::progress::BenchMonitor;
use caustic_bench::record;
use caustic_bench::row::Machine;
use caustic_device::Device;
use caustic_experiments::figure::{self, Figure, Results};
use caustic_experiments::scope::Scope;
use caustic_experiments::store::{Outcome, Store};
use caustic_experiments::{Event, Options, merge, report, run as measure};
use std::path::Path;

/// Measures the thesis's experiments and writes a report.
pub fn run(arguments: &ExperimentsArguments) -> Result<(), Failure> {
    let figures = figure::named(&arguments.only).map_err(Failure::input)?;
    if arguments.list {
        for figure in &figures {
            println!("{:<10} {} (section {})", figure.id, figure.title, figure.section);
        }
        return Ok(());
    }
    let folder = &arguments.output;
    let CasesArguments { part, merge: parts, report_only } = &arguments.cases;
    if *report_only {
        return write(folder, &figures, &Store::existing("-o", folder).map_err(Failure::input)?);
    }
    if let Some(first) = parts.first() {
        let first = Store::existing("--merge", first).map_err(Failure::input)?.header;
        let scope = Scope { quick: first.quick, gpu: first.machine.is_gpu() };
        let options = Options { folder, figures: &figures, scope, part: None, patience_s: 0.0 };
        return write(folder, &figures, &merge(&options, parts).map_err(Failure::input)?);
    }
    let patience_s = arguments.patience.unwrap_or(if arguments.quick { 10.0 } else { 60.0 });
    if patience_s.is_nan() || patience_s <= 0.0 {
        return Err(Failure::input(format!("--patience is {patience_s} but must be above 0 seconds")));
    }
    let (device, line) = Device::open(&arguments.device).map_err(Failure::input)?;
    eprintln!("{line}");
    let (part, quick) = (*part, arguments.quick);
    let mut store =
        Store::open(folder, &Machine::of(&device), quick, part, &command::line()).map_err(Failure::input)?;
    let scope = Scope { quick, gpu: device.is_gpu() };
    let options = Options { folder, figures: &figures, scope, part, patience_s };
    let monitor = BenchMonitor::new();
    let complete = measure(&options, &device, &mut store, &mut |event| {
        match event {
            Event::Begin(case, done) => monitor.begin(&case.to_string(), done),
            Event::Done(case, Outcome::Skipped(reason)) => monitor.print(&format!("{case}: left out, {reason}")),
            Event::Done(..) => {}
        }
        monitor.goes_on()
    });
    monitor.finish();
    let complete = complete.map_err(Failure::machine)?;
    if let Some(part) = part {
        println!("part {part}: {} cases in {}", store.cases().count(), folder.display());
    } else {
        write(folder, &figures, &store)?;
    }
    if complete { Ok(()) } else { Err(Failure::interrupted_experiments(store.cases().count())) }
}

/// Writes the report, also of experiments that were interrupted.
fn write(folder: &Path, figures: &[&'static Figure], store: &Store) -> Result<(), Failure> {
    let gpu = store.header.machine.is_gpu();
    let results = Results { store, scope: Scope { quick: store.header.quick, gpu }, folder };
    let made = report::make(&results, figures).map_err(Failure::machine)?;
    let page = report::html(store, &made);
    let files = [
        ("report.html", page),
        ("results.csv", report::csv(store)),
        ("results.json", report::json(store, &made)),
        ("claims.md", report::claims(store, &made)),
    ];
    for (name, text) in files {
        record::write(&folder.join(name), &text).map_err(Failure::machine)?;
    }
    for made in &made {
        for (chart, svg) in made.page.charts.iter().zip(&made.svgs) {
            record::write(&folder.join(format!("{}.svg", chart.name)), svg).map_err(Failure::machine)?;
        }
    }
    println!("{}", report::verdicts(&made));
    println!("wrote {}", folder.join("report.html").display());
    Ok(())
}
