//! `caustic bench`.

use crate::Failure;
use crate::args::BenchArguments;
use crate::command;
use crate::progress::BenchMonitor;
use caustic_bench::case::{self, Case};
use caustic_bench::record::{self, Record};
use caustic_bench::report;
use caustic_bench::row::Row;
use caustic_bench::suite::{self, Event, Options, Suite};
use caustic_device::Device;
use std::collections::BTreeMap;
use std::path::Path;

/// Measures cases and writes what came out, or makes a table of records.
pub fn run(arguments: &BenchArguments) -> Result<(), Failure> {
    if !arguments.table.is_empty() {
        return table(arguments);
    }
    let cases = cases(arguments)?;
    if arguments.list {
        for case in &cases {
            let sizes: Vec<_> = case.sizes.iter().map(ToString::to_string).collect();
            println!("{:<24} {}; {}: {}", case.name, case.description, case.kind.counts(), sizes.join(" "));
        }
        return Ok(());
    }
    check_places(arguments, &cases)?;
    let (device, line) = Device::open(&arguments.device).map_err(Failure::input)?;
    eprintln!("{line}");
    let options = Options {
        max_n: arguments.max_n,
        repeat: arguments.repeat,
        budget_s: arguments.budget.unwrap_or(if arguments.quick { 1.0 } else { 10.0 }),
        quick: arguments.quick,
        peers: !arguments.no_peers,
    };
    let monitor = BenchMonitor::new();
    monitor.print(&report::header());
    let suite = suite::run(&cases, &device, &options, &mut |event| {
        match event {
            Event::Begin(case, n, done) => monitor.begin(&format!("{} {n}", case.name), done),
            Event::Row(row) => monitor.print(&report::line(row)),
            Event::Tick => {}
        }
        monitor.goes_on()
    });
    monitor.finish();
    println!("{}", report::footer(&suite));
    write(arguments, &suite)?;
    if arguments.bless {
        bless(&cases, &suite)?;
    }
    outcome(arguments, &suite)
}

/// The cases that were asked for.
fn cases(arguments: &BenchArguments) -> Result<Vec<Case>, Failure> {
    let named = |name: &String| {
        let is_file = name.ends_with(".toml") || name.contains(['/', '\\']);
        if is_file { case::load(Path::new(name)).map(|case| vec![case]) } else { case::built_in(Some(name)) }
    };
    let mut cases = match &arguments.cases {
        Some(folder) => case::load_folder(folder).map_err(Failure::input)?,
        None if arguments.case.is_empty() => case::built_in(None).map_err(Failure::input)?,
        None => {
            let named: Result<Vec<_>, _> = arguments.case.iter().map(named).collect();
            named.map_err(Failure::input)?.concat()
        }
    };
    if let Some(text) = &arguments.filter {
        let names: Vec<_> = cases.iter().map(|case| case.name.clone()).collect();
        cases.retain(|case| case.name.contains(text.as_str()));
        if cases.is_empty() {
            let names = names.join(", ");
            return Err(Failure::input(format!("--filter {text}: no case has that in its name; there are {names}")));
        }
    }
    Ok(cases)
}

/// Refuses what could not be written, before an hour of measurements.
fn check_places(arguments: &BenchArguments, cases: &[Case]) -> Result<(), Failure> {
    let BenchArguments { json, csv, markdown, svg, record, bless, .. } = arguments;
    for (flag, path) in [("--json", json), ("--csv", csv), ("--markdown", markdown)] {
        let Some(path) = path else { continue };
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.is_dir() || path.is_dir() {
            let path = path.display();
            return Err(Failure::input(format!("{flag} {path}: this must be a file in a folder that there is")));
        }
    }
    for (flag, folder) in [("--svg", svg), ("--record", record)] {
        let Some(folder) = folder else { continue };
        std::fs::create_dir_all(folder)
            .map_err(|error| Failure::input(format!("{flag} {}: it cannot be a folder: {error}", folder.display())))?;
    }
    if let Some(case) = cases.iter().find(|case| *bless && case.path.is_none()) {
        let name = &case.name;
        return Err(Failure::input(format!(
            "--bless: {name} is built in; give files with --cases or --case FILE.toml"
        )));
    }
    Ok(())
}

/// Writes every output that was asked for, also of a suite that was interrupted.
fn write(arguments: &BenchArguments, suite: &Suite) -> Result<(), Failure> {
    let made = Record::new(suite, &command::line());
    let texts = [
        (&arguments.json, made.json()),
        (&arguments.csv, report::csv(&suite.rows)),
        (&arguments.markdown, report::markdown(&suite.rows)),
    ];
    for (path, text) in texts {
        if let Some(path) = path {
            record::write(path, &text).map_err(Failure::machine)?;
        }
    }
    if let Some(folder) = &arguments.svg {
        for (case, svg) in report::plots(&suite.rows, &suite.machine.title()).map_err(Failure::machine)? {
            record::write(&folder.join(format!("{case}.svg")), &svg).map_err(Failure::machine)?;
        }
    }
    if let Some(folder) = &arguments.record {
        let path = made.write(folder).map_err(Failure::machine)?;
        eprintln!("wrote {}", path.display());
    }
    Ok(())
}

/// Writes hashes into case files; not those of results that brute force contradicts.
fn bless(cases: &[Case], suite: &Suite) -> Result<(), Failure> {
    for case in cases {
        let of_case = suite.rows.iter().filter(|row| row.case == case.name);
        let right = |row: &Row| {
            let measured = row.measured().filter(|measured| measured.differ == 0)?;
            Some((row.n, measured.sha256.clone()))
        };
        let hashes: BTreeMap<_, _> = of_case.filter_map(right).collect();
        if !hashes.is_empty() {
            case::bless(case, &hashes).map_err(Failure::machine)?;
            eprintln!("{}: {} hashes written", case.name, hashes.len());
        }
    }
    Ok(())
}

/// Whether anything is wrong. A hash that was just blessed is not.
fn outcome(arguments: &BenchArguments, suite: &Suite) -> Result<(), Failure> {
    let wrong: Vec<_> = suite.wrong.iter().filter(|what| !arguments.bless || !what.contains("SHA-256")).collect();
    if let Some(first) = wrong.first() {
        let more = if wrong.len() > 1 { format!(" (and {} more)", wrong.len() - 1) } else { String::new() };
        return Err(Failure::machine(format!("{first}{more}")));
    }
    if suite.interrupted {
        return Err(Failure::interrupted_bench(suite.rows.len()));
    }
    Ok(())
}

/// Makes the table of records.
fn table(arguments: &BenchArguments) -> Result<(), Failure> {
    let records: Result<Vec<_>, _> = arguments.table.iter().map(|path| Record::read(path)).collect();
    let table = record::table(&records.map_err(Failure::input)?);
    match &arguments.into {
        Some(path) => record::replace_in(path, &table).map_err(Failure::input),
        None => {
            print!("{table}");
            Ok(())
        }
    }
}
