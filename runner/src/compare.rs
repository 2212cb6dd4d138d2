//! `caustic compare`.

use crate::Failure;
use crate::args::{CompareArguments, MetricArgument, Threshold};
use caustic_metrics::{FlipOptions, Image, Metric, Range, Score, YeeOptions, compare, heat};
use caustic_renderer::output::{self, Format, Metadata};
use clap::ValueEnum;
use serde_json::{Value, json};
use std::fs::canonicalize;
use std::path::Path;

/// A metric's score with the most that it may be.
struct Row {
    score: Score,
    most: Option<f64>,
}

impl Row {
    fn within(&self) -> Option<bool> {
        self.most.map(|most| self.score.value <= most)
    }
}

/// Compares a picture with a reference and prints what each metric says.
pub fn run(arguments: &CompareArguments) -> Result<(), Failure> {
    let metrics = metrics(arguments);
    let thresholds = thresholds(&arguments.threshold, &metrics)?;
    if let Some(diff) = &arguments.diff {
        check_diff(diff, [&arguments.picture, &arguments.reference])?;
    }
    let read = |path: &Path| Image::read(path).map_err(Failure::input);
    let (picture, reference) = (read(&arguments.picture)?, read(&arguments.reference)?);
    let mut rows = Vec::new();
    for (metric, most) in metrics.into_iter().zip(thresholds) {
        rows.push(Row { score: compare(&picture, &reference, metric).map_err(Failure::input)?, most });
    }
    if let Some(diff) = &arguments.diff {
        write_diff(diff, &reference, &rows[0].score)?;
    }
    if arguments.json {
        println!("{:#}", as_json(arguments, [&picture, &reference], &rows));
    } else {
        tell(arguments, [&picture, &reference], &rows);
    }
    outcome(&rows)
}

/// The metrics asked for, once each, with their parameters.
fn metrics(arguments: &CompareArguments) -> Vec<Metric> {
    let mut flip = FlipOptions::default();
    if let Some(pixels) = arguments.pixels_per_degree {
        flip.pixels_per_degree = pixels as f32;
    }
    let yee = YeeOptions { field_of_view: arguments.field_of_view, white: arguments.white };
    let all = [Metric::Flip(flip), Metric::Yee(yee), Metric::RelMse, Metric::Rmse];
    let mut metrics: Vec<Metric> = Vec::new();
    for asked in &arguments.metric {
        for metric in all.iter().filter(|metric| *asked == MetricArgument::All || name(*asked) == metric.name()) {
            if !metrics.contains(metric) {
                metrics.push(*metric);
            }
        }
    }
    metrics
}

fn name(metric: MetricArgument) -> String {
    metric.to_possible_value().map_or(String::new(), |value| value.get_name().to_string())
}

/// The threshold of each metric.
fn thresholds(given: &[Threshold], metrics: &[Metric]) -> Result<Vec<Option<f64>>, Failure> {
    let names: Vec<_> = metrics.iter().map(Metric::name).collect();
    let mut thresholds = vec![None; metrics.len()];
    for Threshold { metric, most } in given {
        let at = match metric {
            Some(metric) => names.iter().position(|known| *known == name(*metric)).ok_or_else(|| {
                let name = name(*metric);
                Failure::input(format!("--threshold {name}={most}: --metric leaves {name} out; add it there"))
            })?,
            None if metrics.len() == 1 => 0,
            None => {
                return Err(Failure::input(format!(
                    "--threshold {most}: of which metric? Write --threshold {}={most}, or choose one with --metric",
                    names[0]
                )));
            }
        };
        if thresholds[at].replace(*most).is_some() {
            return Err(Failure::input(format!("--threshold is given twice for {}; leave one out", names[at])));
        }
    }
    Ok(thresholds)
}

/// Checks, before anything is compared, that the heat map can be written and takes the place of neither picture.
fn check_diff(diff: &Path, pictures: [&Path; 2]) -> Result<(), Failure> {
    if Format::of(diff).ok() != Some(Format::Png) {
        return Err(Failure::input(format!(
            "--diff `{}` does not end in .png, the format of heat maps",
            diff.display()
        )));
    }
    output::check_path(diff).map_err(Failure::input)?;
    let same = |picture: &&Path| matches!((canonicalize(diff), canonicalize(picture)), (Ok(a), Ok(b)) if a == b);
    if pictures.iter().any(same) {
        return Err(Failure::input(format!(
            "--diff `{}` would replace a picture compared; write it elsewhere",
            diff.display()
        )));
    }
    Ok(())
}

fn write_diff(diff: &Path, size: &Image, score: &Score) -> Result<(), Failure> {
    let side = |pixels: usize| u32::try_from(pixels).unwrap_or(u32::MAX);
    let rgb = heat(&score.map, score.full_scale());
    let picture = output::Image { width: side(size.width()), height: side(size.height()), rgb };
    output::write(diff, &picture, &Metadata::default()).map_err(Failure::machine)
}

/// The range that both pictures have, or that the one with more was cut to.
fn range(pictures: [&Image; 2]) -> Range {
    if pictures.iter().all(|image| image.range() == Range::Scene) { Range::Scene } else { Range::Display }
}

fn tell(arguments: &CompareArguments, pictures: [&Image; 2], rows: &[Row]) {
    let [picture, reference] = pictures;
    println!("{} against {}, {} × {} pixels", picture.name(), reference.name(), reference.width(), reference.height());
    if let Some(scene) = pictures.iter().find(|image| image.range() != range(pictures)) {
        println!(
            "note: {} is compared as a display shows it, cut off at black and white: the other has no more",
            scene.name()
        );
    }
    for row in rows {
        let Score { metric, value, .. } = &row.score;
        let judged = match (row.within(), row.most) {
            (Some(true), Some(most)) => format!(", within {most}"),
            (Some(false), Some(most)) => format!(", MORE THAN {most}"),
            _ => String::new(),
        };
        println!("{:<7} {:<12} {}{judged}", metric.name(), number(*value), describe(&row.score, range(pictures)));
    }
    if let Some(diff) = &arguments.diff {
        let first = &rows[0].score;
        println!(
            "wrote {}: {}, brightest at {}",
            diff.display(),
            first.metric.name(),
            number(f64::from(first.full_scale()))
        );
    }
}

/// What a score's number is.
fn describe(score: &Score, range: Range) -> String {
    match score.metric {
        Metric::Flip(options) => {
            let kind = if range == Range::Scene { "HDR-FLIP" } else { "LDR-FLIP" };
            format!("mean of {kind}, 0 to 1, at {:.2} pixels a degree", options.pixels_per_degree)
        }
        Metric::Yee(options) => {
            let percent = 100.0 * score.value / score.map.len() as f64;
            let YeeOptions { field_of_view, white } = options;
            format!("pixels ({percent:.3} %) differ visibly, {field_of_view}° wide, white of {white} cd/m²")
        }
        Metric::RelMse => "mean square error relative to the reference".to_string(),
        Metric::Rmse => "root of the mean square error, in linear light".to_string(),
        _ => String::new(),
    }
}

/// Four digits of a number, none more of a whole one.
fn number(value: f64) -> String {
    if value.fract() == 0.0 && value < 1e15 {
        format!("{value}")
    } else if (1e-3..1e6).contains(&value) {
        format!("{value:.5}")
    } else {
        format!("{value:.3e}")
    }
}

fn as_json(arguments: &CompareArguments, pictures: [&Image; 2], rows: &[Row]) -> Value {
    let range = range(pictures);
    let mut metrics = serde_json::Map::new();
    for row in rows {
        let Score { metric, value, map } = &row.score;
        let mut entry = json!({ "value": value, "threshold": row.most, "within": row.within() });
        match metric {
            Metric::Flip(options) => {
                entry["kind"] = if range == Range::Scene { "hdr" } else { "ldr" }.into();
                entry["pixels_per_degree"] = options.pixels_per_degree.into();
            }
            Metric::Yee(options) => {
                entry["fraction"] = (value / map.len() as f64).into();
                entry["field_of_view_degrees"] = options.field_of_view.into();
                entry["white_cd_m2"] = options.white.into();
            }
            Metric::RelMse => entry["epsilon"] = caustic_metrics::EPSILON.into(),
            _ => {}
        }
        metrics.insert(metric.name().to_string(), entry);
    }
    let judged: Vec<_> = rows.iter().filter_map(Row::within).collect();
    let first = &rows[0].score;
    json!({
        "picture": arguments.picture.display().to_string(),
        "reference": arguments.reference.display().to_string(),
        "width": pictures[1].width(),
        "height": pictures[1].height(),
        "range": if range == Range::Scene { "scene" } else { "display" },
        "metrics": metrics,
        "within": (!judged.is_empty()).then(|| judged.iter().all(|within| *within)),
        "diff": arguments.diff.as_ref().map(|diff| json!({
            "file": diff.display().to_string(),
            "metric": first.metric.name(),
            "brightest_at": first.full_scale(),
        })),
    })
}

/// An error if a threshold is exceeded, that names each.
fn outcome(rows: &[Row]) -> Result<(), Failure> {
    let exceeded = rows.iter().filter_map(|row| {
        let most = row.most.filter(|_| row.within() == Some(false))?;
        Some(format!("{} is {}, more than the threshold of {most}", row.score.metric.name(), number(row.score.value)))
    });
    let exceeded: Vec<_> = exceeded.collect();
    if exceeded.is_empty() {
        Ok(())
    } else {
        Err(Failure::differs(format!("the pictures differ: {}", exceeded.join("; "))))
    }
}
