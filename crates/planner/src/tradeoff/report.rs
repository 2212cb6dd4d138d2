//! What a sweep shows: a page, a table for programs, and plots.

use super::front::{Front, front};
use super::point::{Case, Point};
use super::{Store, stability};
use caustic_experiments::figure::{Axis, Chart, Line, Table};
use caustic_experiments::report::{STYLE, escaped, table};
use caustic_experiments::store::Outcome;
use serde_json::{Value, json as value};
use std::fmt::Write;

/// Numbers of a point that tables have.
const NUMBERS: [&str; 9] =
    ["seconds", "memory_bytes", "relmse", "flip", "yee", "rmse", "photons_emitted", "recall", "radius_error"];

/// A measured point.
struct Row<'a> {
    case: &'a Case,
    point: &'a Point,
    numbers: [Option<f64>; NUMBERS.len()],
}

impl Row<'_> {
    fn number(&self, name: &str) -> f64 {
        let at = NUMBERS.iter().position(|known| *known == name);
        at.and_then(|at| self.numbers[at]).unwrap_or(f64::NAN)
    }
}

/// The points that have results.
fn rows<'a>(store: &Store, points: &'a [(Case, Point)]) -> Vec<Row<'a>> {
    let measured = points.iter().filter(|(case, _)| matches!(store.outcome(case), Some(Outcome::Values(_))));
    measured.map(|(case, point)| Row { case, point, numbers: NUMBERS.map(|name| store.value(case, name)) }).collect()
}

/// The front of relMSE over what a point costs.
fn front_over(rows: &[Row<'_>], cost: &str) -> Front {
    let points: Vec<_> = rows.iter().map(|row| (row.number(cost), row.number("relmse"))).collect();
    front(&points)
}

/// A line for each point.
#[must_use]
pub fn csv(store: &Store, points: &[(Case, Point)]) -> String {
    let rows = rows(store, points);
    let (time, memory) = (front_over(&rows, "seconds"), front_over(&rows, "memory_bytes"));
    let mut text = format!("knob,value,{},worth_its_time,worth_its_memory,command\n", NUMBERS.join(","));
    for (i, row) in rows.iter().enumerate() {
        let numbers: Vec<_> =
            row.numbers.iter().map(|number| number.map_or(String::new(), |number| format!("{number}"))).collect();
        let _ = writeln!(
            text,
            "{},\"{}\",{},{},{},\"{}\"",
            row.point.knob,
            row.point.value,
            numbers.join(","),
            time.worth.contains(&i),
            memory.worth.contains(&i),
            row.case.command
        );
    }
    text
}

/// The same for programs, with where it was measured.
#[must_use]
pub fn json(store: &Store, points: &[(Case, Point)]) -> String {
    let rows = rows(store, points);
    let (time, memory) = (front_over(&rows, "seconds"), front_over(&rows, "memory_bytes"));
    let of_rows: Vec<Value> = rows
        .iter()
        .enumerate()
        .map(|(i, row)| {
            let numbers: serde_json::Map<_, _> = NUMBERS
                .iter()
                .zip(row.numbers)
                .filter_map(|(name, number)| Some(((*name).to_string(), number?.into())))
                .collect();
            value!({
                "knob": row.point.knob,
                "value": row.point.value,
                "command": row.case.command,
                "numbers": numbers,
                "worth_its_time": time.worth.contains(&i),
                "worth_its_memory": memory.worth.contains(&i),
                "knee": time.knee == Some(i),
            })
        })
        .collect();
    format!("{:#}\n", value!({ "header": store.header, "points": of_rows }))
}

/// relMSE over time and over memory as SVG, with names of files.
///
/// # Errors
/// What the plotting library says.
pub fn svg(store: &Store, points: &[(Case, Point)], title: &str) -> Result<Vec<(String, String)>, String> {
    let rows = rows(store, points);
    let plots = [("time", "seconds", Axis::Time, 1e3), ("memory", "memory_bytes", Axis::Bytes, 1.0)];
    let one = |(name, cost, axis, unit): (&str, &str, Axis, f64)| {
        let at = |row: &Row<'_>| (row.number(cost) * unit, row.number("relmse"));
        // The front comes first, in a colour of its own.
        let front = front_over(&rows, cost);
        let worth = front.worth.iter().map(|&i| at(&rows[i])).collect();
        let mut lines = vec![Line { subject: 0, label: "worth having (Pareto)".to_string(), points: worth }];
        if let Some(knee) = front.knee {
            let label = format!("knee: {} {}", rows[knee].point.knob, rows[knee].point.value);
            lines.push(Line { subject: 1, label, points: vec![at(&rows[knee])] });
        }
        for row in &rows {
            let label = row.point.knob;
            match lines.iter_mut().find(|line| line.label == label) {
                Some(line) => line.points.push(at(row)),
                None => lines.push(Line { subject: lines.len() + 1, label: label.to_string(), points: vec![at(row)] }),
            }
        }
        lines.retain(|line| line.points.iter().any(|(x, y)| x.is_finite() && y.is_finite()));
        let title = format!("{title}: error over {name}");
        let chart = Chart { name: name.to_string(), title, axes: [axis, Axis::RelMse], thesis_to: None, lines };
        Ok((format!("{name}.svg"), caustic_experiments::report::svg(&chart)?))
    };
    plots.into_iter().map(one).collect()
}

/// The page.
#[must_use]
pub fn html(store: &Store, points: &[(Case, Point)], svgs: &[(String, String)], scene: &str) -> String {
    let rows = rows(store, points);
    let (time, memory) = (front_over(&rows, "seconds"), front_over(&rows, "memory_bytes"));
    let header = &store.header;
    let title = format!("{scene} on {}: what accuracy costs", header.machine.title());
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title><style>{STYLE}</style></head><body>\n<h1>{0}</h1>\n",
        escaped(&title)
    );
    let _ = writeln!(
        page,
        "<p>Each knob swept by itself around the scene's own settings, in pictures small enough for it; errors are those against the reference. \
         A point is worth having if no other is both cheaper and less wrong. recall@k is the share of the k nearest photons \
         that an estimate counts: all of them for every hash and gather, which differ in time and memory alone. caustic {}, commit {}, {}, begun {}.</p>",
        escaped(&header.machine.caustic),
        escaped(&header.machine.commit),
        escaped(&header.command),
        escaped(&header.date)
    );
    if let Some(knee) = time.knee {
        let row = &rows[knee];
        let _ = writeln!(
            page,
            "<p>The knee, after which less error costs much more time: <b>{} {}</b>, {:.2} s at relMSE {:.1e}: <code>{}</code></p>",
            escaped(row.point.knob),
            escaped(&row.point.value),
            row.number("seconds"),
            row.number("relmse"),
            escaped(&row.case.command)
        );
    }
    for (_, svg) in svgs {
        let _ = writeln!(page, "<figure>{svg}</figure>");
    }
    let or_nothing = |number: f64, digits| {
        if number.is_finite() { format!("{number:.digits$}") } else { String::new() }
    };
    let columns = [
        "knob",
        "value",
        "time, s",
        "memory, MiB",
        "relMSE",
        "FLIP",
        "Yee, pixels",
        "recall@k",
        "radius off, %",
        "worth",
        "beaten by",
        "command",
    ];
    let of_rows = rows.iter().enumerate().map(|(i, row)| {
        let worth = match (time.worth.contains(&i), memory.worth.contains(&i)) {
            (true, true) => "time, memory",
            (true, false) => "time",
            (false, true) => "memory",
            (false, false) => "",
        };
        let knee = if time.knee == Some(i) { ", knee" } else { "" };
        vec![
            row.point.knob.to_string(),
            row.point.value.clone(),
            format!("{:.3}", row.number("seconds")),
            format!("{:.1}", row.number("memory_bytes") / f64::from(1 << 20)),
            format!("{:.2e}", row.number("relmse")),
            format!("{:.4}", row.number("flip")),
            format!("{:.0}", row.number("yee")),
            or_nothing(row.number("recall"), 3),
            or_nothing(100.0 * row.number("radius_error"), 1),
            format!("{worth}{knee}"),
            beaten_by(&rows, i),
            row.case.command.clone(),
        ]
    });
    let title = "All points".to_string();
    table(&mut page, &Table { title, columns: columns.map(str::to_string).into(), rows: of_rows.collect() }, false);
    for of_number in stability::tables(store, header.quick) {
        table(&mut page, &of_number, true);
    }
    let skipped: String = store
        .cases()
        .filter_map(|(case, outcome)| match outcome {
            Outcome::Skipped(why) => Some(format!("<li>{}: {}</li>", escaped(&case.to_string()), escaped(why))),
            Outcome::Values(_) => None,
        })
        .collect();
    if !skipped.is_empty() {
        let _ = writeln!(page, "<h3>Not measured</h3><ul>{skipped}</ul>");
    }
    page + "</body></html>\n"
}

/// The cheapest point that is both faster and less wrong.
fn beaten_by(rows: &[Row<'_>], i: usize) -> String {
    let (time, error) = (rows[i].number("seconds"), rows[i].number("relmse"));
    let beats = |row: &&Row<'_>| row.number("seconds") < time && row.number("relmse") < error;
    let best = rows.iter().filter(beats).min_by(|a, b| a.number("relmse").total_cmp(&b.number("relmse")));
    best.map_or(String::new(), |row| format!("{} {}", row.point.knob, row.point.value))
}
