//! The radius of the first pass.

use crate::frame::Frame;
use crate::photons::{PassKind, sample};
use crate::report::Progress;
use crate::trace::trace;
use crate::{Integrator, RenderError, Settings, View};
use caustic_device::Plan;
use caustic_kernels::gather::{CUT_SHORT, Reach};
use caustic_kernels::layout::Query;
use caustic_photon_map::{MapOptions, Nearest, PhotonMap, RADII, plan_grid};

/// Most points of the picture that are looked at.
const POINTS: u32 = 4096;
/// Share of the points that a k-nearest estimate's largest radius suffices for.
const NEARLY_ALL: f64 = 0.95;
/// Share of the points that a progressive render's first radius suffices for.
const HALF: f64 = 0.5;

/// The radius of the first pass, m, and where it comes from if it was not given: how far the k nearest photons are from points that the
/// camera sees. A k-nearest estimate gets a largest radius that is enough for 95 % of them; progressive radii begin with the median, so
/// that the first pass is as blurred as an estimate of k photons.
pub(crate) fn find_radius(
    frame: &Frame<'_>,
    progress: &mut dyn FnMut(Progress) -> bool,
) -> Result<(f32, Option<String>), RenderError> {
    let Settings { radius, automatic_radius, k, seed, integrator, hash, .. } = *frame.settings;
    let first = PassKind::of(frame.settings, frame.compiled).into_iter().flatten().next();
    let Some(kind) = first.filter(|_| automatic_radius) else {
        return Ok((radius, None));
    };
    let device = frame.device;
    let none = |reason: &str| RenderError::NoRadius { reason: reason.to_string() };
    let (photons, report) = trace(device, frame.compiled, frame.buffers, seed, &kind, progress)?;
    let photons = photons.ok_or_else(|| none("the photon map is empty"))?;
    let stored = u64::from(report.photons_stored);

    // Points of a small picture of the same shape.
    let [width, height] = frame.settings.size.map(f64::from);
    let scale = (f64::from(POINTS) / (width * height)).sqrt().min(1.0);
    let size = [width, height].map(|side| ((side * scale) as u32).max(1));
    let view = View::new(device, frame.scene, size, 1, seed)?;
    let queries: Vec<Query> = device.read(&view.queries, u64::from(view.count()))?;
    let (low, high) = frame.compiled.diffuse_bounds;
    let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f32::max);
    let positions = sample(device, &photons, stored)?;
    // A search costs as much as its radius holds: it begins small.
    let mut most = (extent / 64.0).clamp(*RADII.start(), *RADII.end());
    loop {
        let options = MapOptions { radius: most, hash, table: None, cell: None };
        let grid = plan_grid(low, high, stored, &positions, &options)?;
        let mut plan = Plan::new();
        plan.scope("radius");
        let map = PhotonMap::plan(device, &mut plan, &photons, grid)?;
        let reaches = map.plan_reaches(device, &mut plan, &view.queries, view.count(), k, Nearest::Exact)?;
        device.run(&plan)?;
        let reaches: Vec<Reach> = device.read(&reaches, u64::from(view.count()))?;
        let searches = reaches.iter().filter(|reach| reach.photons == CUT_SHORT).count() as u64;
        if searches > 0 {
            return Err(RenderError::CutShort { device: device.name(), searches });
        }
        let seen = queries.iter().zip(&reaches).filter(|(query, _)| query.active != 0);
        let mut found: Vec<f32> =
            seen.map(|(_, reach)| if reach.photons == k { reach.radius2.sqrt() } else { f32::MAX }).collect();
        if found.is_empty() {
            return Err(none("the camera sees no diffuse surface"));
        }
        found.sort_unstable_by(f32::total_cmp);
        let at = |share: f64| found[(share * (found.len() - 1) as f64) as usize];
        let share = if integrator == Integrator::Progressive { HALF } else { NEARLY_ALL };
        let radius = at(share);
        if radius < f32::MAX && radius > 0.0 {
            let (percent, points) = (100.0 * share, found.len());
            let map = kind.map;
            let note = format!(
                "radius {radius:.4} m: within it, {percent:.0} % of {points} points that the camera sees have {k} photons of the {map} map"
            );
            return Ok((radius.clamp(*RADII.start(), *RADII.end()), Some(note)));
        }
        if most >= extent {
            return Err(none("too few photons lie where the camera looks; emit more"));
        }
        most *= 2.0;
    }
}
