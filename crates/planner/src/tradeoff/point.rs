//! The settings that are tried.

use caustic_device::Precision;
use caustic_photon_map::{Filter, Gather, Hash, MAX_K, Nearest, Surface};
use caustic_renderer::scene::Scene;
use caustic_renderer::scene::limits::MAX_PHOTONS;
use caustic_renderer::{Feature, Integrator, Settings, Show, Stop, decide};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Pixels of the longer side of a picture, and of a quick one.
const SIDE: f64 = 192.0;
const QUICK_SIDE: f64 = 96.0;
/// How many fewer photons a quick sweep's base has than the scene asks for.
const QUICK: u32 = 8;

/// What results are kept by: the command that makes the point says all of its settings.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Case {
    /// What is swept.
    pub knob: String,
    /// The command line that renders it.
    pub command: String,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.knob, self.command)
    }
}

/// A point of the sweep.
#[derive(Clone, Debug)]
pub struct Point {
    /// What is swept.
    pub knob: &'static str,
    /// Its value there.
    pub value: String,
    /// The settings.
    pub settings: Settings,
    /// Whose arithmetic.
    pub precision: Precision,
}

impl Point {
    /// What its result is kept by. `scene` and `device` are as the user named them.
    #[must_use]
    pub fn case(&self, scene: &str, device: &str) -> Case {
        Case { knob: self.knob.to_string(), command: self.command(scene, device) }
    }

    /// The command line that renders the point.
    fn command(&self, scene: &str, device: &str) -> String {
        let settings = &self.settings;
        let [width, height] = settings.size;
        let name = |value: &dyn fmt::Debug| format!("{value:?}").to_lowercase();
        let mut words = format!("caustic render {scene} -o point.exr --device {device} --size {width}x{height}");
        let mut say = |flag: &str, value: String| words += &format!(" --{flag} {value}");
        say("spp", settings.spp.to_string());
        if settings.show != Show::Beauty {
            say("show", settings.show.name().to_string());
        }
        if settings.integrator != Integrator::Photon {
            say("integrator", name(&settings.integrator));
        }
        if settings.integrator != Integrator::Path {
            say("photons", settings.photons.to_string());
            say("caustic-photons", settings.caustic_photons.to_string());
            say("k", settings.k.to_string());
            say("radius", settings.radius.to_string());
        }
        let usual = [
            ("filter", name(&settings.filter), name(&Filter::Constant)),
            ("surface", name(&settings.surface), name(&Surface::Any)),
            ("gather", name(&settings.gather), name(&Gather::Auto)),
            ("hash", name(&settings.hash), name(&Hash::Auto)),
            ("nearest", name(&settings.nearest), name(&Nearest::Exact)),
            ("thin", settings.thin.to_string(), "1".to_string()),
            ("interpolate", settings.interpolate.to_string(), "0".to_string()),
            ("precision", name(&self.precision), name(&Precision::Exact)),
        ];
        for (flag, value, _) in usual.into_iter().filter(|(_, value, usual)| value != usual) {
            say(flag, value);
        }
        if let Some(table) = settings.table {
            say("table", table.to_string());
        }
        if settings.final_gather > 0 {
            say("final-gather", settings.final_gather.to_string());
        }
        if let Some(passes) = settings.stop.passes {
            say("passes", passes.to_string());
        }
        if settings.compact {
            words += " --compact";
        }
        words
    }
}

/// The settings that a sweep begins from: the scene's, of a small picture of a part of its light.
#[must_use]
pub fn base(scene: &Scene, quick: bool, show: Show) -> Settings {
    let settings = Settings::of(scene);
    let [width, height] = settings.size.map(f64::from);
    let scale = if quick { QUICK_SIDE } else { SIDE } / width.max(height);
    let fewer = if quick { QUICK } else { 1 };
    Settings {
        size: [width, height].map(|side| ((side * scale).round() as u32).max(1)),
        photons: (settings.photons / fewer).max(1),
        caustic_photons: settings.caustic_photons / fewer,
        // With as many photons in it.
        radius: (f64::from(settings.radius) * f64::from(fewer).sqrt()) as f32,
        spp: 4,
        show,
        ..settings
    }
}

/// All points, each knob's from less to more; the scene's own settings are the first.
#[must_use]
pub fn points(scene: &Scene, quick: bool, show: Show, gpu: bool) -> Vec<Point> {
    let base = base(scene, quick, show);
    let mut points = Vec::new();
    let mut add = |knob: &'static str, value: String, settings: Settings| {
        points.push(Point { knob, value, settings, precision: Precision::Exact });
    };
    add("scene's own", String::new(), base.clone());
    let times = |n: u32, factor: f64| ((f64::from(n) * factor).round() as u32).clamp(1, MAX_PHOTONS);
    let factors: &[f64] = if quick { &[0.125, 0.5, 2.0, 8.0] } else { &[1.0 / 32.0, 0.125, 0.5, 2.0, 8.0] };
    for &factor in factors {
        let photons = times(base.photons, factor);
        let caustic_photons = if base.caustic_photons == 0 { 0 } else { times(base.caustic_photons, factor) };
        add("photons", photons.to_string(), Settings { photons, caustic_photons, ..base.clone() });
    }
    // The largest radius does not hold back the larger discs.
    for k in [8, 24, 72, 216, 648] {
        let wider = (f64::from(k) / f64::from(base.k)).sqrt().max(1.0);
        let radius = (f64::from(base.radius) * wider) as f32;
        add("k", k.to_string(), Settings { k: k.min(MAX_K), radius, ..base.clone() });
    }
    // Many neighbours of many photons: what converges in one pass.
    for factor in if quick { &[0.25, 4.0][..] } else { &[0.0625, 0.25, 4.0, 16.0] } {
        let of = |n: u32| if n == 0 { 0 } else { times(n, *factor) };
        let k = ((f64::from(base.k) * factor.sqrt()) as u32).clamp(4, MAX_K);
        let radius = (f64::from(base.radius) / factor.sqrt().sqrt()) as f32;
        let (photons, caustic_photons) = (times(base.photons, *factor), of(base.caustic_photons));
        add(
            "photons and k",
            format!("{photons}, {k}"),
            Settings { photons, caustic_photons, k, radius, ..base.clone() },
        );
    }
    for factor in [0.25, 0.5, 2.0] {
        let radius = base.radius * factor;
        add("radius", format!("{radius} m"), Settings { radius, ..base.clone() });
    }
    for spp in [1, 2, 16] {
        add("samples", spp.to_string(), Settings { spp, ..base.clone() });
    }
    for filter in [Filter::Cone, Filter::Gaussian, Filter::Epanechnikov] {
        add("filter", format!("{filter:?}").to_lowercase(), Settings { filter, ..base.clone() });
    }
    for surface in [Surface::Facing, Surface::Own] {
        add("surface", format!("{surface:?}").to_lowercase(), Settings { surface, ..base.clone() });
    }
    for thin in [2, 8] {
        add("thinning", thin.to_string(), Settings { thin, ..base.clone() });
    }
    add("compact", "16 bytes".to_string(), Settings { compact: true, ..base.clone() });
    add("nearest", "approximate".to_string(), Settings { nearest: Nearest::Approximate, ..base.clone() });
    for interpolate in [1, 2, 4, 8] {
        add("interpolation", interpolate.to_string(), Settings { interpolate, ..base.clone() });
    }
    for gather in [Gather::Histogram, Gather::Heap, Gather::List] {
        add("gather", format!("{gather:?}").to_lowercase(), Settings { gather, ..base.clone() });
    }
    for hash in [Hash::Teschner, Hash::Morton] {
        add("hash", format!("{hash:?}").to_lowercase(), Settings { hash, ..base.clone() });
    }
    for table in [1 << 12, 1 << 16, 1 << 20] {
        let linear = Settings { hash: Hash::Linear, table: Some(table), ..base.clone() };
        add("table", table.to_string(), linear);
    }
    for passes in if quick { &[4][..] } else { &[2, 4, 16] } {
        // As many photons and samples in all.
        let fewer = |n: u32| if n == 0 { 0 } else { (n / passes).max(1) };
        let stop = Stop { passes: Some(*passes), ..Stop::default() };
        let (photons, caustic_photons) = (fewer(base.photons), fewer(base.caustic_photons));
        let spp = (base.spp / passes).max(1);
        let k = (base.k / passes).max(4);
        let split = Settings { photons, caustic_photons, spp, k, stop, ..base.clone() };
        add("passes", passes.to_string(), split.clone());
        let progressive = Settings { integrator: Integrator::Progressive, surface: Surface::Own, ..split };
        add("progressive", passes.to_string(), progressive);
    }
    for spp in if quick { &[16, 64][..] } else { &[16, 64, 256] } {
        let paths = Settings { integrator: Integrator::Path, spp: *spp, ..base.clone() };
        add("paths", spp.to_string(), paths);
    }
    add("final gather", "8".to_string(), Settings { final_gather: 8, ..base.clone() });
    let (final_gather, interpolate) = (64, 4);
    add("final gather", "64, every 4 pixels".to_string(), Settings { final_gather, interpolate, ..base.clone() });
    // Without photon maps, only what is not about them differs.
    let maps = [Feature::GlobalMap, Feature::CausticMap];
    if !decide(&scene.compile(), &base).iter().any(|one| one.modelled && maps.contains(&one.feature)) {
        points.retain(|point| ["scene's own", "samples", "paths"].contains(&point.knob));
    }
    // Paths know no parts of the light, and not every part has estimates at all.
    if show != Show::Beauty {
        points.retain(|point| point.settings.validate().is_ok());
    }
    // A final gather leaves out what it sees of the lights, which the whole map has; and neither it nor keys are for caustics.
    let idle: &[&str] = match show {
        Show::MapGlobal => &["final gather"],
        Show::Caustic | Show::MapCaustic => &["final gather", "interpolation"],
        _ => &[],
    };
    points.retain(|point| !idle.contains(&point.knob));
    if gpu {
        points.push(Point { knob: "precision", value: "fast".to_string(), settings: base, precision: Precision::Fast });
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustic_renderer::scene::BUILT_IN;
    use std::collections::HashSet;

    #[test]
    fn points_of_all_scenes_are_valid_and_have_commands_of_their_own() {
        for scene in BUILT_IN.iter().map(|scene| Scene::load(scene.name).unwrap()) {
            for quick in [false, true] {
                let points = points(&scene, quick, Show::Beauty, true);
                for point in &points {
                    point.settings.validate().unwrap_or_else(|error| panic!("{}: {point:?}: {error}", scene.name));
                }
                let commands: HashSet<_> = points.iter().map(|point| point.case(&scene.name, "cpu").command).collect();
                assert!(commands.len() + 1 >= points.len(), "{}: a table or k may be the scene's own", scene.name);
            }
        }
    }
}
