//! Why a render does what it does, a line each.

use caustic_device::Device;
use caustic_photon_map::{Gather, Hash, Surface};
use caustic_renderer::scene::{CompiledScene, Scene};
use caustic_renderer::{Feature, Integrator, Settings, decide};
use serde::Serialize;

/// A decision, and the reason for it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Line {
    /// What is decided.
    pub what: &'static str,
    /// The decision.
    pub choice: String,
    /// The reason.
    pub why: String,
}

impl Line {
    fn new(what: &'static str, choice: impl ToString, why: impl ToString) -> Self {
        Self { what, choice: choice.to_string(), why: why.to_string() }
    }
}

/// Explains a render of `scene`, which is `compiled` with [`Settings::forced`]. `chosen` says whether the settings were chosen for a budget.
#[must_use]
pub fn explain(
    scene: &Scene,
    compiled: &CompiledScene,
    settings: &Settings,
    device: &Device,
    chosen: bool,
) -> Vec<Line> {
    let mut lines = vec![integrator(settings)];
    let decisions = decide(compiled, settings);
    for one in &decisions {
        let choice = match (one.feature, one.modelled) {
            (Feature::Tree, false) => "list",
            (_, true) if one.forced => "yes, forced",
            (_, true) => "yes",
            (_, false) => "no",
        };
        lines.push(Line::new(one.feature.title(), choice, &one.why));
    }
    let maps: Vec<_> = decisions.iter().filter(|one| one.modelled).map(|one| one.feature).collect();
    let (global, caustic) = (maps.contains(&Feature::GlobalMap), maps.contains(&Feature::CausticMap));
    let defaults = &scene.defaults;
    let source = |is_default: bool, in_file: bool| match (chosen, is_default, in_file) {
        (true, false, _) => "chosen for the budget",
        (_, true, true) => "the scene's own",
        (_, true, false) => "the program's default, since the scene has none",
        (false, false, _) => "asked for",
    };
    let usual = Settings::of(scene);
    if global || caustic {
        lines.push(hash(settings));
        if let Some(table) = settings.table {
            let why = if chosen { "chosen for the budget, or asked for" } else { "asked for" };
            lines.push(Line::new("table", format!("{table} entries"), format!("{why}: the most of a linear hash")));
        }
        lines.push(gather(settings, device));
        let radius = if settings.automatic_radius { "auto".to_string() } else { format!("{} m", settings.radius) };
        let of_radius =
            source(settings.radius == usual.radius && !settings.automatic_radius, defaults.radius.is_some());
        let why = match settings.integrator {
            Integrator::Progressive => format!("{of_radius}; of the first pass, and those after it shrink"),
            _ => format!("{of_radius}; reached only where fewer than k photons are nearer"),
        };
        if settings.integrator != Integrator::Progressive {
            lines.push(Line::new("k", settings.k, source(settings.k == usual.k, defaults.k.is_some())));
        }
        lines.push(Line::new("radius", radius, why));
    }
    let amounts = [
        (global, "photons", settings.photons, usual.photons, defaults.photons),
        (caustic, "caustic photons", settings.caustic_photons, usual.caustic_photons, defaults.caustic_photons),
        (true, "samples a pixel", settings.spp, usual.spp, defaults.spp),
    ];
    for (_, what, value, usual, default) in amounts.into_iter().filter(|amount| amount.0) {
        lines.push(Line::new(what, value, source(value == usual, default.is_some())));
    }
    lines.extend(chunks(settings, global, caustic));
    lines.push(passes(settings, chosen));
    let (precision, why) = match (device.is_exact(), device.is_gpu()) {
        (true, true) => ("exact", "the same bits as on the CPU"),
        (true, false) => ("exact", "a CPU has no other"),
        (false, _) => ("fast", "asked for, or all that this device has"),
    };
    lines.push(Line::new("precision", precision, why));
    lines
}

fn integrator(settings: &Settings) -> Line {
    let why = match settings.integrator {
        Integrator::Photon => "k-nearest estimates are done in one pass, with some blur",
        Integrator::Progressive => "its radius shrinks from pass to pass, so that blur goes too",
        Integrator::Path => "unbiased, without photons",
        Integrator::Direct => "light straight from the lights alone",
    };
    Line::new("integrator", format!("{:?}", settings.integrator).to_lowercase(), why)
}

fn hash(settings: &Settings) -> Line {
    let why = match settings.hash {
        Hash::Auto => {
            "linear, unless its table of at most 16 entries a photon, and 2^24, has cells too wide for how the photons crowd; then teschner"
        }
        Hash::Linear => "asked for: no collisions, a table as large as the grid",
        Hash::Teschner => "asked for: a table by occupied cells, for any extent",
        Hash::Morton => "asked for: neighbouring cells lie near in memory",
    };
    Line::new("hash", format!("{:?}", settings.hash).to_lowercase(), why)
}

fn gather(settings: &Settings, device: &Device) -> Line {
    let weighted = settings.filter != caustic_photon_map::Filter::Constant || settings.surface != Surface::Any;
    let (choice, why) = match settings.gather {
        _ if settings.integrator == Integrator::Progressive => ("density", "all photons within the radius count"),
        _ if weighted => ("counting", "filters and surfaces take the distance of the k-th photon, then a second walk"),
        Gather::Auto if device.is_gpu() => ("counting", "what a GPU has for a lane does not hold a heap"),
        Gather::Auto => ("heap", "a CPU's cache holds it"),
        Gather::Histogram => ("counting", "asked for"),
        Gather::Heap => ("heap", "asked for"),
        Gather::List => ("list", "asked for"),
    };
    Line::new("gather", choice, why)
}

fn chunks(settings: &Settings, global: bool, caustic: bool) -> Option<Line> {
    let chunk = settings.chunk?;
    let of = |there: bool, photons: u32| if there { photons } else { 0 };
    let photons = of(global, settings.photons).max(of(caustic, settings.caustic_photons));
    let (chunks, photons) = chunk.cut(photons);
    let batches = match chunk.batches(settings) {
        1 => "all samples search at once".to_string(),
        batches => format!("for each of {batches} batches of samples they are traced again"),
    };
    let why = format!("maps of {photons} photons after one another, for want of memory; {batches}");
    Some(Line::new("chunks", chunks, why))
}

fn passes(settings: &Settings, chosen: bool) -> Line {
    let stop = &settings.stop;
    let until = [
        stop.passes.map(|passes| format!("{passes} passes")),
        stop.seconds.map(|seconds| format!("{seconds} s")),
        stop.photons.map(|photons| format!("{photons} photons")),
        stop.error.map(|error| format!("a noise of {error:.2e}")),
    ];
    let until: Vec<_> = until.into_iter().flatten().collect();
    if until.is_empty() {
        let (passes, why) = match settings.integrator {
            Integrator::Progressive => (caustic_renderer::DEFAULT_PASSES, "nothing else ends a progressive render"),
            _ => (1, "nothing asks for more"),
        };
        return Line::new("passes", passes, why);
    }
    Line::new(
        "passes",
        format!("until {}", until.join(" or ")),
        if chosen { "chosen for the budget" } else { "asked for" },
    )
}
