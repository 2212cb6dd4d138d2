//! What the passes of a picture share, and the photon maps of a pass.

use crate::buffers::SceneBuffers;
use crate::ledger;
use crate::pace::Pace;
use crate::photon_file::PhotonFile;
use crate::photons::{PassKind, photon_map};
use crate::report::{MapReport, Progress};
use crate::scene::{CompiledScene, Scene};
use crate::trace::trace;
use crate::{Feature, Keep, RenderError, Settings, decide};
use caustic_device::{Buffer, Device, Plan};
use caustic_kernels::layout::Query;
use caustic_kernels::trace::{Camera, CameraTile, MAX_BOUNCES, PART_CAUSTIC, PART_GLOBAL, Vertex};
use caustic_photon_map::{LargestPower, PhotonMap, SeenCells};

/// Camera samples of one tile: the unit of progress. A GPU needs more of them to be busy; it begins with a part of that.
pub(crate) const CPU_SAMPLES: u32 = 1 << 17;
pub(crate) const GPU_FIRST_SAMPLES: u32 = 1 << 19;
pub(crate) const GPU_SAMPLES: u32 = 1 << 21;

/// Photons that look for light where there is no global map.
const FEW_PHOTONS: u32 = 4096;

/// What passes of a picture share.
pub(crate) struct Frame<'a> {
    pub(crate) device: &'a Device,
    pub(crate) scene: &'a Scene,
    pub(crate) compiled: &'a CompiledScene,
    pub(crate) buffers: &'a SceneBuffers,
    pub(crate) settings: &'a Settings,
    /// Photons that need not be traced.
    pub(crate) photons: Option<&'a PhotonFile>,
    pub(crate) camera: Buffer,
}

/// The photon maps of a pass: global and caustic.
pub(crate) struct Maps {
    pub(crate) seed: u32,
    pub(crate) radius: f32,
    /// None where they come in chunks.
    pub(crate) whole: [Option<PhotonMap>; 2],
    /// What is known of those that come in chunks.
    pub(crate) chunked: [Chunked; 2],
    pub(crate) said: Said,
}

/// What is known of a map whose chunks have come before.
#[derive(Clone, Copy, Default)]
pub(crate) struct Chunked {
    /// Photons stored, if all have come.
    pub(crate) stored: Option<u32>,
    pub(crate) largest: LargestPower,
}

/// What there is to say of the maps of a pass.
#[derive(Clone, Default)]
pub(crate) struct Said {
    /// What became of them.
    pub(crate) reports: Vec<MapReport>,
    pub(crate) notes: Vec<String>,
    /// What makes the picture doubtful.
    pub(crate) problems: Vec<String>,
}

impl Said {
    /// Says what became of a map.
    pub(crate) fn enter(&mut self, kind: &PassKind, report: MapReport) {
        let (map, stored) = (kind.map, report.photons_stored);
        if stored == 0 {
            self.notes.push(format!("the {map} map is empty: no such light was found"));
        }
        if report.paths_cut > 0 {
            let cut = report.paths_cut;
            self.problems.push(format!("{cut} paths of the {map} map were given up after {MAX_BOUNCES} bounces"));
        }
        self.problems.extend(ledger::problems(map, &report.ledger));
        self.reports.push(report);
    }
}

impl<'a> Frame<'a> {
    pub(crate) fn new(
        device: &'a Device,
        scene: &'a Scene,
        compiled: &'a CompiledScene,
        buffers: &'a SceneBuffers,
        settings: &'a Settings,
        photons: Option<&'a PhotonFile>,
    ) -> Result<Self, RenderError> {
        let [width, height] = settings.size;
        let camera = device.upload::<Camera>("camera", &[scene.camera(width, height)])?;
        Ok(Self { device, scene, compiled, buffers, settings, photons, camera })
    }

    /// Makes the maps of a pass, with a seed and a radius of its own.
    pub(crate) fn maps(
        &self,
        seed: u32,
        radius: f32,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Maps, RenderError> {
        let mut said = Said::default();
        let [global, caustic] = PassKind::of(self.settings, self.compiled);
        if global.is_none() && self.settings.parts() & PART_GLOBAL != 0 {
            self.look_for_light(seed, progress)?;
        }
        let mut whole = [None, None];
        if self.settings.chunk.is_none() {
            let guided = self.settings.keep == Keep::Visible && (global.is_some() || caustic.is_some());
            let seen = if guided { Some(self.look(seed, radius, progress)?) } else { None };
            for (map, kind) in whole.iter_mut().zip([global, caustic]) {
                *map = self.map(kind, seed, radius, seen.as_ref(), &mut said, progress)?;
            }
        }
        // What is left out though the picture would have it.
        let parts = [(Feature::GlobalMap, PART_GLOBAL), (Feature::CausticMap, PART_CAUSTIC)];
        for one in decide(self.compiled, self.settings).iter().filter(|one| !one.modelled) {
            if parts.iter().any(|&(feature, part)| feature == one.feature && self.settings.parts() & part != 0) {
                said.notes.push(format!("no {}: {}", one.feature.title(), one.why));
            }
        }
        Ok(Maps { seed, radius, whole, chunked: Default::default(), said })
    }

    /// Refuses a scene whose lights reach nothing, as its global map would if it had one: by a few photons, and by all where these are lost.
    fn look_for_light(&self, seed: u32, progress: &mut dyn FnMut(Progress) -> bool) -> Result<(), RenderError> {
        let Settings { photons, show, .. } = *self.settings;
        let mut look = |photons| {
            let kind = PassKind::global(photons, show, false);
            trace(self.device, self.compiled, self.buffers, seed, &kind, progress).map(|_| ())
        };
        match look(photons.min(FEW_PHOTONS)) {
            Err(RenderError::NoPhotons { .. }) if photons > FEW_PHOTONS => look(photons),
            looked => looked,
        }
    }

    fn map(
        &self,
        kind: Option<PassKind>,
        seed: u32,
        radius: f32,
        seen: Option<&SeenCells>,
        said: &mut Said,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Option<PhotonMap>, RenderError> {
        let Some(kind) = kind else { return Ok(None) };
        let Self { device, compiled, buffers, settings, .. } = *self;
        let settings = Settings { seed, radius, ..settings.clone() };
        let (map, report) = photon_map(device, compiled, buffers, &settings, &kind, self.photons, seen, progress)?;
        if seen.is_some() {
            let (kept, stored, map) = (report.photons_kept, report.photons_stored, kind.map);
            said.notes.push(format!("{kept} of {stored} photons of the {map} map are near what the camera sees"));
        }
        said.enter(&kind, report);
        Ok(map)
    }

    /// Looks where a pass is going to look for photons.
    fn look(
        &self,
        seed: u32,
        radius: f32,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<SeenCells, RenderError> {
        let Self { device, settings, ref camera, .. } = *self;
        let (low, high) = self.compiled.diffuse_bounds;
        let seen = SeenCells::new(device, low, high, radius)?;
        let [width, height] = settings.size;
        let pixels = width * height;
        let tile = device.scratch::<CameraTile>("camera tile", 1)?;
        let mut pace = Pace::new(device, GPU_FIRST_SAMPLES, GPU_SAMPLES, CPU_SAMPLES);
        let mut first_pixel = 0;
        while first_pixel < pixels {
            if !progress(Progress { phase: "look", done: first_pixel.into(), total: pixels.into() }) {
                return Err(RenderError::Interrupted);
            }
            let pixels = (pace.size() / settings.spp).clamp(1, pixels - first_pixel);
            let samples = pixels * settings.spp;
            let queries = device.scratch::<Query>("sample queries", u64::from(samples))?;
            let vertices = device.scratch::<Vertex>("sample vertices", u64::from(samples))?;
            device.write(&tile, &[CameraTile { first_pixel, pixels, samples: settings.spp, seed }]);
            let mut plan = Plan::new();
            plan.scope("look");
            let from = [&[&tile, camera], &self.buffers.for_camera()[..]].concat();
            plan.each(self.buffers.kernels.camera, samples, &[&from[..], &[&queries, &vertices]].concat());
            seen.plan_mark(device, &mut plan, &queries, samples)?;
            pace.run(|| device.run(&plan))?;
            first_pixel += pixels;
        }
        Ok(seen)
    }
}
