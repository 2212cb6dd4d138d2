//! Renders with a clock, most of them small: what surveys are made of.

use caustic_device::Device;
use caustic_renderer::output::{Image, Layer, LayerKind};
use caustic_renderer::scene::Scene;
use caustic_renderer::{Integrator, PhotonFile, Progress, RenderError, RenderReport, Settings, Show, Stop, render};
use std::time::Instant;

/// Built-in costs, s: about those of two cores of a server of 2024. With them a survey depends on the scene alone.
mod built_in {
    /// A segment of a photon path, walked twice.
    pub const SEGMENT: f64 = 4e-7;
    /// A stored photon, sorted into its map.
    pub const STORED: f64 = 1.5e-7;
    /// An entry of a table.
    pub const ENTRY: f64 = 5e-9;
    /// A ray of the camera or towards a light.
    pub const RAY: f64 = 3e-7;
    /// A query, and each photon that it asks for.
    pub const QUERY: f64 = 1e-6;
    pub const NEIGHBOUR: f64 = 4e-8;
}

/// Whose costs are predicted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Costs {
    /// Those of this device, by the clock.
    #[default]
    Measured,
    /// Constants times what the small renders counted: the same on every machine, so that the same settings are chosen everywhere.
    BuiltIn,
}

/// A render, of one pass if its times are to mean something each.
pub(crate) struct Pilot {
    pub(crate) image: Image,
    /// What photon maps add to it; black for an integrator without.
    pub(crate) indirect: Vec<[f32; 3]>,
    pub(crate) report: RenderReport,
    /// Until the first photon, s.
    pub(crate) setup_s: f64,
    /// Tracing the global and the caustic map, and building all of them but for their tables, s.
    pub(crate) map_s: [f64; 2],
    /// The tables, s.
    pub(crate) tables_s: f64,
    /// Everything after the maps, s.
    pub(crate) image_s: f64,
}

impl Pilot {
    /// All of it, s.
    pub(crate) fn seconds(&self) -> f64 {
        self.setup_s + self.map_s.iter().sum::<f64>() + self.tables_s + self.image_s
    }
}

/// Who renders pilots.
pub struct Scout<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) device: &'a Device,
    pub(crate) costs: Costs,
    go_on: &'a mut dyn FnMut() -> bool,
}

impl<'a> Scout<'a> {
    /// Of a scene on a device; [`RenderError::Interrupted`] ends what it does if `go_on` returns false.
    pub fn new(scene: &'a Scene, device: &'a Device, costs: Costs, go_on: &'a mut dyn FnMut() -> bool) -> Self {
        Self { scene, device, costs, go_on }
    }

    /// Renders one pass of `settings`, and what photon maps add to it.
    pub(crate) fn pilot(&mut self, settings: &Settings) -> Result<Pilot, RenderError> {
        let layers = match settings.show {
            _ if !of_maps(settings) => Vec::new(),
            Show::Beauty => vec![LayerKind::Global, LayerKind::Caustic],
            Show::Global | Show::MapGlobal => vec![LayerKind::Global],
            Show::Caustic | Show::MapCaustic => vec![LayerKind::Caustic],
            Show::Direct => Vec::new(),
        };
        self.plain(&Settings { layers, ..settings.clone() }, 1)
    }

    /// Renders passes of `settings` as they are: their light of photon maps is not known by itself, and takes no time.
    pub(crate) fn plain(&mut self, settings: &Settings, passes: u32) -> Result<Pilot, RenderError> {
        let stop = Stop { passes: Some(passes), ..Stop::default() };
        run(self, &Settings { stop, ..settings.clone() })
    }

    /// Where the first photons of each map lie, m.
    pub(crate) fn positions(&mut self, settings: &Settings, most: usize) -> Result<[Vec<[f32; 3]>; 2], RenderError> {
        let mut positions = [Vec::new(), Vec::new()];
        if of_maps(settings) {
            let traced = PhotonFile::trace(self.scene, settings, self.device, &mut |_| (self.go_on)())?;
            for (map, photons) in traced.header.maps.iter().zip(&traced.photons) {
                let of = usize::from(map.map == "caustic");
                positions[of] = photons.iter().take(most).map(|photon| photon.position).collect();
            }
        }
        Ok(positions)
    }
}

/// Whether a render has photon maps.
pub(crate) fn of_maps(settings: &Settings) -> bool {
    matches!(settings.integrator, Integrator::Photon | Integrator::Progressive)
}

fn run(scout: &mut Scout<'_>, settings: &Settings) -> Result<Pilot, RenderError> {
    let Scout { scene, device, costs, ref mut go_on } = *scout;
    device.reset_stage_times();
    let clock = Instant::now();
    // When each phase began: of the global map, of the caustic one, and of the image.
    let mut begun = [None; 3];
    let rendered = render(scene, settings, device, &mut |Progress { phase, .. }| {
        let phase = ["global photons", "caustic photons", "image"].iter().position(|name| *name == phase);
        if let Some(begun) = phase.and_then(|phase| begun.get_mut(phase)) {
            begun.get_or_insert(clock.elapsed().as_secs_f64());
        }
        go_on()
    })?;
    let end = clock.elapsed().as_secs_f64();
    let image_at = begun[2].unwrap_or(end);
    let caustic_at = begun[1].unwrap_or(image_at);
    let global_at = begun[0].unwrap_or(caustic_at);
    let stages = &rendered.report.stages;
    let table_of = |map: &str| {
        let name = format!("{map}/cell_begins");
        stages.iter().filter(|stage| stage.stage == name).map(|stage| stage.ms / 1e3).sum::<f64>()
    };
    let tables = [table_of("global"), table_of("caustic")];
    let mut pilot = Pilot {
        indirect: indirect(&rendered.layers, rendered.image.rgb.len()),
        setup_s: global_at,
        map_s: [caustic_at - global_at - tables[0], image_at - caustic_at - tables[1]].map(|s| s.max(0.0)),
        tables_s: tables.iter().sum(),
        image_s: end - image_at,
        image: rendered.image,
        report: rendered.report,
    };
    if costs == Costs::BuiltIn {
        count(&mut pilot, settings);
    }
    Ok(pilot)
}

/// Replaces measured times by counts times constants.
fn count(pilot: &mut Pilot, settings: &Settings) {
    use built_in::{ENTRY, NEIGHBOUR, QUERY, RAY, SEGMENT, STORED};
    pilot.setup_s = 0.01;
    pilot.map_s = [0.0; 2];
    pilot.tables_s = 0.0;
    let samples = f64::from(settings.size[0]) * f64::from(settings.size[1]) * f64::from(settings.spp);
    pilot.image_s = pilot.report.camera_rays as f64 * RAY;
    for map in &pilot.report.maps {
        let of = usize::from(map.map == "caustic");
        pilot.map_s[of] = map.segments as f64 * SEGMENT + f64::from(map.photons_stored) * STORED;
        pilot.tables_s += f64::from(map.table_entries) * ENTRY;
        let gathered = if of == 0 { settings.final_gather.max(1) } else { 1 };
        pilot.image_s += samples * f64::from(gathered) * (QUERY + f64::from(settings.k) * NEIGHBOUR);
    }
}

/// The sum of the layers of light from photon maps.
fn indirect(layers: &[Layer], pixels: usize) -> Vec<[f32; 3]> {
    let mut sum = vec![[0.0; 3]; pixels];
    for layer in layers {
        for (sum, value) in sum.as_flattened_mut().iter_mut().zip(&layer.values) {
            *sum += value;
        }
    }
    sum
}
