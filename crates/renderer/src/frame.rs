//! One pass of a picture: photon maps first, then the film or some pixels of it, tile by tile.

use crate::buffers::SceneBuffers;
use crate::lattice::{self, Lattice, Points};
use crate::ledger;
use crate::output::LayerKind;
use crate::pace::Pace;
use crate::photon_file::PhotonFile;
use crate::photons::{PassKind, photon_map, trace};
use crate::report::{MapReport, Progress};
use crate::scene::{CompiledScene, Scene};
use crate::work::WorkUnit;
use crate::{Feature, Integrator, Keep, RenderError, Settings, decide};
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::gather::Reach;
use caustic_kernels::layout::{Irradiance, Query};
use caustic_kernels::trace::{
    Camera, CameraTile, FilmTile, GatherTile, LayerPixel, MAX_BOUNCES, PART_BIAS, PART_CAUSTIC, PART_DIRECT,
    PART_GLOBAL, PART_REACH, Pixel, Vertex,
};
use caustic_photon_map::{Estimate, PhotonMap, Seen, SeenCells};

/// Camera samples of one tile: the unit of progress. A GPU needs more of them to be busy; it begins with a part of that.
pub(crate) const CPU_SAMPLES: u32 = 1 << 17;
const GPU_FIRST_SAMPLES: u32 = 1 << 19;
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

/// The photon maps of a pass.
pub(crate) struct Maps {
    seed: u32,
    radius: f32,
    global: Option<PhotonMap>,
    caustic: Option<PhotonMap>,
    pub(crate) said: Said,
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

/// Pixels of a pass, from the first that was asked for; fewer than that if the caller stopped it.
pub(crate) struct Pixels {
    pub(crate) film: Vec<Pixel>,
    /// Their layers; empty if none are asked for.
    pub(crate) layers: Vec<LayerPixel>,
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
        let guided = self.settings.keep == Keep::Visible && (global.is_some() || caustic.is_some());
        let seen = if guided { Some(self.look(seed, radius, progress)?) } else { None };
        let global = self.map(global, seed, radius, seen.as_ref(), &mut said, progress)?;
        let caustic = self.map(caustic, seed, radius, seen.as_ref(), &mut said, progress)?;
        // What is left out though the picture would have it.
        let parts = [(Feature::GlobalMap, PART_GLOBAL), (Feature::CausticMap, PART_CAUSTIC)];
        for one in decide(self.compiled, self.settings).iter().filter(|one| !one.modelled) {
            if parts.iter().any(|&(feature, part)| feature == one.feature && self.settings.parts() & part != 0) {
                said.notes.push(format!("no {}: {}", one.feature.title(), one.why));
            }
        }
        Ok(Maps { seed, radius, global, caustic, said })
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
        if map.is_none() {
            said.notes.push(format!("the {} map is empty: no such light was found", kind.map));
        }
        if seen.is_some() {
            let (kept, stored, map) = (report.photons_kept, report.photons_stored, kind.map);
            said.notes.push(format!("{kept} of {stored} photons of the {map} map are near what the camera sees"));
        }
        if report.paths_cut > 0 {
            let (cut, map) = (report.paths_cut, kind.map);
            said.problems.push(format!("{cut} paths of the {map} map were given up after {MAX_BOUNCES} bounces"));
        }
        said.problems.extend(ledger::problems(kind.map, &report.ledger));
        said.reports.push(report);
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

    /// Renders the pixels of a unit and their layers.
    pub(crate) fn film(
        &self,
        unit: WorkUnit,
        maps: &Maps,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Pixels, RenderError> {
        let Self { device, settings, .. } = *self;
        let seed = maps.seed;
        let of_light = [maps.global.as_ref(), maps.caustic.as_ref()];
        let [global, caustic] = of_light;
        let (first, end) = (unit.first_pixel, unit.end());
        let spp = settings.spp;
        let mut parts = settings.parts();
        parts &= !if global.is_none() { PART_GLOBAL } else { 0 };
        parts &= !if caustic.is_none() { PART_CAUSTIC } else { 0 };
        parts |= if settings.layers.contains(&LayerKind::Radius) { PART_REACH } else { 0 };
        parts |= if settings.layers.contains(&LayerKind::Bias) { PART_BIAS } else { 0 };
        let tiles = Tiles {
            camera: device.scratch::<CameraTile>("camera tile", 1)?,
            gather: device.scratch::<GatherTile>("camera tile of gather", 1)?,
            film: device.scratch::<FilmTile>("camera tile of film", 1)?,
        };
        let lattice = (settings.interpolate > 0 && parts & PART_GLOBAL != 0)
            .then(|| Lattice::new(device, self.scene, settings, maps.radius))
            .transpose()?;
        // Pixels are written where they are in the picture.
        let film = device.buffer::<Pixel>("film", u64::from(end))?;
        let layer_pixels = if settings.needs_layers() { u64::from(end) } else { 0 };
        let layers = device.buffer::<LayerPixel>("layers", layer_pixels)?;
        let mut pace = Pace::new(device, GPU_FIRST_SAMPLES, GPU_SAMPLES, CPU_SAMPLES);
        // A sample is as much work as the rays that it sends out.
        let each = spp.saturating_mul(if parts & PART_GLOBAL != 0 { settings.final_gather.max(1) } else { 1 });
        // The plan of a tile, and of how many pixels it is.
        let mut plan = (0, Plan::new());
        let mut first_pixel = first;
        while first_pixel < end {
            let (done, total) = (u64::from(first_pixel - first), u64::from(unit.pixels));
            if !progress(Progress { phase: "image", done, total }) {
                break;
            }
            let tile_pixels = (pace.size() / each).clamp(1, unit.pixels);
            if plan.0 != tile_pixels {
                // The last one's buffers go first.
                plan.1 = Plan::new();
                plan = (
                    tile_pixels,
                    self.tile_plan(tile_pixels, parts, of_light, &tiles, lattice.as_ref(), [&film, &layers])?,
                );
            }
            let pixels = tile_pixels.min(end - first_pixel);
            let rays = settings.final_gather;
            let tile = CameraTile { first_pixel, pixels, samples: spp, seed };
            device.write(&tiles.camera, &[tile]);
            if let Some(lattice) = &lattice {
                lattice.write(device, &tile, tile_pixels, rays);
            }
            device.write(&tiles.gather, &[GatherTile { first_pixel, pixels, samples: spp, rays, seed }]);
            device.write(&tiles.film, &[FilmTile { first_pixel, pixels, samples: spp, parts }]);
            pace.run(|| device.run(&plan.1))?;
            first_pixel += pixels;
        }
        let mut film: Vec<Pixel> = device.read(&film, u64::from(first_pixel))?;
        let mut layers: Vec<LayerPixel> = device.read(&layers, layer_pixels.min(u64::from(first_pixel)))?;
        film.drain(..first as usize);
        layers.drain(..(first as usize).min(layers.len()));
        Ok(Pixels { film, layers })
    }

    /// The stages of one tile. Only those whose part is wanted are in it.
    fn tile_plan(
        &self,
        pixels: u32,
        parts: u32,
        maps: [Option<&PhotonMap>; 2],
        tiles: &Tiles,
        lattice: Option<&Lattice>,
        [film, layers]: [&Buffer; 2],
    ) -> Result<Plan, RenderError> {
        let Self { device, settings, ref camera, .. } = *self;
        let kernels = self.buffers.kernels;
        let samples = pixels * settings.spp;
        let paths = settings.integrator == Integrator::Path;
        let records = |wanted: bool| if wanted { u64::from(samples) } else { 0 };
        let queries = device.scratch::<Query>("sample queries", records(!paths))?;
        let vertices = device.scratch::<Vertex>("sample vertices", u64::from(samples))?;
        let direct = device.scratch::<Irradiance>("sample direct", records(parts & PART_DIRECT != 0))?;
        let mut plan = Plan::new();
        plan.scope("image");
        let from = [&[&tiles.camera, camera], &self.buffers.for_camera()[..]].concat();
        if paths {
            plan.each(kernels.paths, samples, &[&from[..], &[&vertices]].concat());
        } else {
            plan.each(kernels.camera, samples, &[&from[..], &[&queries, &vertices]].concat());
        }
        if parts & PART_DIRECT != 0 {
            let scene = self.buffers.for_camera();
            let samples_of = [&queries, &vertices, &direct];
            plan.each(kernels.direct, samples, &[&[&tiles.camera], &scene[..], &samples_of].concat());
        }
        let mut estimates = Vec::new();
        let mut reaches = Vec::new();
        let mut halves = Vec::new();
        for (map, name) in maps.into_iter().zip(["sample global", "sample caustic"]) {
            let estimate = device.scratch::<Irradiance>(name, records(map.is_some()))?;
            if let Some(map) = map {
                plan.scope(name.trim_start_matches("sample "));
                let points = Points { queries: &queries, vertices: &vertices, count: samples, gather: &tiles.gather };
                let global = name == "sample global";
                let light = |plan: &mut Plan, points: Points<'_>, out: &Buffer| {
                    if global && settings.final_gather > 0 {
                        return self.plan_final_gather(plan, map, points, out);
                    }
                    let Points { queries, vertices, count, .. } = points;
                    self.plan_estimate(plan, map, &settings.estimate(), [queries, vertices], count, out)
                };
                match lattice.filter(|_| global) {
                    Some(lattice) => {
                        let scene = &self.buffers.for_camera();
                        let tile = lattice::Tile { pixels, camera, scene, points };
                        lattice.plan(device, &mut plan, &tile, kernels.camera, light, &estimate)?;
                    }
                    None => light(&mut plan, points, &estimate)?,
                }
            }
            // A search of half the area ends where that of the whole has been: it cannot be cut short alone.
            let half = map.filter(|_| parts & PART_BIAS != 0);
            let of_half = device.scratch::<Irradiance>("sample of half", records(half.is_some()))?;
            if let Some(map) = half {
                let (map, how) = (map.halved(device)?, settings.estimate().halved());
                self.plan_estimate(&mut plan, &map, &how, [&queries, &vertices], samples, &of_half)?;
            }
            halves.push(of_half);
            estimates.push(estimate);
            reaches.push(match map.filter(|_| parts & PART_REACH != 0) {
                Some(map) => map.plan_reaches(device, &mut plan, &queries, samples, settings.k, settings.nearest)?,
                None => device.scratch::<Reach>("reaches", 0)?,
            });
        }
        plan.scope("image");
        let light = [&vertices, &direct, &estimates[0], &estimates[1]];
        plan.each(Kernel::DevelopFilm, pixels, &[&[&tiles.film], &light[..], &[film]].concat());
        if settings.needs_layers() {
            let beside = [&reaches[0], &reaches[1], &halves[0], &halves[1], layers];
            plan.each(Kernel::DevelopLayers, pixels, &[&[&tiles.film], &light[..], &beside].concat());
        }
        Ok(plan)
    }

    /// What a map says of points on surfaces.
    fn plan_estimate(
        &self,
        plan: &mut Plan,
        map: &PhotonMap,
        how: &Estimate,
        [queries, vertices]: [&Buffer; 2],
        count: u32,
        out: &Buffer,
    ) -> Result<(), RenderError> {
        let seen = Seen { queries, surfaces: Some([vertices, &self.buffers.primitives]) };
        Ok(map.plan_estimate(self.device, plan, seen, count, how, out)?)
    }

    /// What a map says of what points see around them.
    fn plan_final_gather(
        &self,
        plan: &mut Plan,
        map: &PhotonMap,
        Points { queries, vertices, count: samples, gather: tile }: Points<'_>,
        out: &Buffer,
    ) -> Result<(), RenderError> {
        let count = samples * self.settings.final_gather;
        let seen_queries = self.device.scratch::<Query>("gather queries", u64::from(count))?;
        let seen_vertices = self.device.scratch::<Vertex>("gather vertices", u64::from(count))?;
        let estimates = self.device.scratch::<Irradiance>("gather estimates", u64::from(count))?;
        let ends = [queries, vertices, &seen_queries, &seen_vertices];
        plan.each(self.buffers.kernels.gather, count, &[&[tile], &self.buffers.for_camera()[..], &ends].concat());
        let how = self.settings.estimate();
        self.plan_estimate(plan, map, &how, [&seen_queries, &seen_vertices], count, &estimates)?;
        plan.each(Kernel::SumGather, samples, &[tile, &seen_vertices, &estimates, out]);
        Ok(())
    }
}

/// Parameters of the stages of a tile, written anew for each tile.
struct Tiles {
    camera: Buffer,
    gather: Buffer,
    film: Buffer,
}
