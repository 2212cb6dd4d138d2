//! Measuring all points of a sweep.

use super::Store;
use super::point::{Case, Point};
use super::recall::recall;
use caustic_device::{Device, Precision};
use caustic_experiments::store::Outcome;
use caustic_metrics::{Image, Metric, compare};
use caustic_renderer::scene::Scene;
use caustic_renderer::{Part, RenderError, render};
use std::collections::BTreeMap;

/// What happens.
pub enum Event<'a> {
    /// A point begins; so much of all is done.
    Begin(&'a Case, f64),
    /// A point is over.
    Done(&'a Case, &'a Outcome),
}

/// Measures the points, of all or of a part of them, that the store does not have yet. `devices` are the exact one and, for points that are fast, the fast one. Returns
/// whether all is there: false if `watch` returned false.
///
/// # Errors
/// If a device or the disk fails.
pub fn run(
    scene: &Scene,
    points: &[(Case, Point)],
    part: Option<Part>,
    reference: &Image,
    [exact, fast]: [Option<&Device>; 2],
    store: &mut Store,
    watch: &mut dyn FnMut(Event) -> bool,
) -> Result<bool, String> {
    let mine: Vec<_> = Part::share(part, points).collect();
    for (i, (case, point)) in mine.iter().enumerate() {
        if store.outcome(case).is_some() {
            continue;
        }
        if !watch(Event::Begin(case, i as f64 / mine.len() as f64)) {
            return Ok(false);
        }
        let device = if point.precision == Precision::Fast { fast } else { exact };
        let mut go_on = || watch(Event::Begin(case, i as f64 / mine.len() as f64));
        let outcome = match device.map(|device| measure(scene, point, reference, device, &mut go_on)) {
            None => Outcome::Skipped("there is no such device".to_string()),
            Some(Ok(values)) => Outcome::Values(values),
            Some(Err(RenderError::Interrupted)) => return Ok(false),
            // A point that the scene does not allow says so.
            Some(Err(error)) => Outcome::Skipped(error.to_string()),
        };
        store.add(case, outcome.clone(), None)?;
        if !watch(Event::Done(case, &outcome)) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Time, memory and errors of one point.
fn measure(
    scene: &Scene,
    point: &Point,
    reference: &Image,
    device: &Device,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<BTreeMap<String, f64>, RenderError> {
    let mut run = || {
        device.reset_stage_times();
        device.reset_peak_bytes();
        let rendered = render(scene, &point.settings, device, &mut |_| go_on())?;
        if rendered.report.complete { Ok(rendered) } else { Err(RenderError::Interrupted) }
    };
    let mut rendered = run()?;
    // What a device does quickly is done again, since the first time waits for memory and compilers, which may take many seconds.
    if rendered.report.stages.iter().map(|stage| stage.ms).sum::<f64>() < 1e3 {
        let again = run()?;
        if again.report.seconds < rendered.report.seconds {
            rendered = again;
        }
    }
    let report = &rendered.report;
    let mut values = BTreeMap::new();
    let mut add = |name: &str, value: f64| values.insert(name.to_string(), value);
    add("seconds", report.seconds);
    add("stages_s", report.stages.iter().map(|stage| stage.ms / 1e3).sum());
    add("memory_bytes", report.peak_bytes as f64);
    add("photons_emitted", report.photons_emitted as f64);
    let [width, height] = [rendered.image.width, rendered.image.height].map(|side| side as usize);
    let image = Image::from_linear(width, height, rendered.image.rgb);
    let image = image.map_err(|error| RenderError::AfterPass(error.to_string()))?;
    if let Some(recall) = recall(scene, &point.settings, device)? {
        add("recall", recall.recall);
        add("radius_error", recall.radius_error);
    }
    for metric in Metric::all() {
        // FLIP cannot compare pictures below its filters' size, and says so by an error.
        if let Ok(score) = compare(&image, reference, metric) {
            add(metric.name(), score.value);
        }
    }
    Ok(values)
}
