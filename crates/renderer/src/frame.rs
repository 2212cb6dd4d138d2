//! One pass of a picture: photon maps first, then the film, tile by tile.

use crate::buffers::SceneBuffers;
use crate::ledger;
use crate::output::LayerKind;
use crate::pace::Pace;
use crate::photon_file::PhotonFile;
use crate::photons::{PassKind, photon_map};
use crate::report::{MapReport, Progress};
use crate::scene::{CompiledScene, Scene};
use crate::{Integrator, RenderError, Settings};
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::gather::Reach;
use caustic_kernels::layout::{Irradiance, Query};
use caustic_kernels::trace::{
    Camera, CameraTile, FilmTile, GatherTile, LayerPixel, MAX_BOUNCES, PART_CAUSTIC, PART_DIRECT, PART_GLOBAL,
    PART_REACH, Pixel, Vertex,
};
use caustic_photon_map::{PhotonMap, Seen};

/// Camera samples of one tile: the unit of progress. A GPU needs more of them to be busy; it begins with a part of that.
const CPU_SAMPLES: u32 = 1 << 17;
const GPU_FIRST_SAMPLES: u32 = 1 << 19;
const GPU_SAMPLES: u32 = 1 << 21;

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

/// A finished pass.
#[derive(Default)]
pub(crate) struct Pass {
    pub(crate) film: Vec<Pixel>,
    /// Its layers; empty if none are asked for.
    pub(crate) layers: Vec<LayerPixel>,
    /// Whether the film is whole.
    pub(crate) complete: bool,
    pub(crate) maps: Vec<MapReport>,
    pub(crate) notes: Vec<String>,
    /// What makes the picture doubtful.
    pub(crate) problems: Vec<String>,
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

    /// Renders a pass with a seed and a radius of its own.
    pub(crate) fn pass(
        &self,
        seed: u32,
        radius: f32,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Pass, RenderError> {
        let mut pass = Pass::default();
        let [global, caustic] = PassKind::of(self.settings, self.compiled);
        let global = self.map(global, seed, radius, &mut pass, progress)?;
        let caustic = self.map(caustic, seed, radius, &mut pass, progress)?;
        if self.settings.parts() & PART_CAUSTIC != 0 && !self.compiled.has_specular {
            pass.notes.push("no caustic map: nothing in the scene is specular".to_string());
        }
        self.film(seed, global.as_ref(), caustic.as_ref(), &mut pass, progress)?;
        Ok(pass)
    }

    fn map(
        &self,
        kind: Option<PassKind>,
        seed: u32,
        radius: f32,
        pass: &mut Pass,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Option<PhotonMap>, RenderError> {
        let Some(kind) = kind else { return Ok(None) };
        let Self { device, compiled, buffers, settings, .. } = *self;
        let settings = Settings { seed, radius, ..settings.clone() };
        let (map, report) = photon_map(device, compiled, buffers, &settings, &kind, self.photons, progress)?;
        if map.is_none() {
            pass.notes.push(format!("the {} map is empty: no such light was found", kind.map));
        }
        if report.paths_cut > 0 {
            let (cut, map) = (report.paths_cut, kind.map);
            pass.problems.push(format!("{cut} paths of the {map} map were given up after {MAX_BOUNCES} bounces"));
        }
        pass.problems.extend(ledger::problems(kind.map, &report.ledger));
        pass.maps.push(report);
        Ok(map)
    }

    /// Renders the film and its layers.
    fn film(
        &self,
        seed: u32,
        global: Option<&PhotonMap>,
        caustic: Option<&PhotonMap>,
        pass: &mut Pass,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<(), RenderError> {
        let Self { device, settings, .. } = *self;
        let [width, height] = settings.size;
        let pixels = width * height;
        let spp = settings.spp;
        let mut parts = settings.parts();
        parts &= !if global.is_none() { PART_GLOBAL } else { 0 };
        parts &= !if caustic.is_none() { PART_CAUSTIC } else { 0 };
        parts |= if settings.layers.contains(&LayerKind::Radius) { PART_REACH } else { 0 };
        let tiles = Tiles {
            camera: device.scratch::<CameraTile>("camera tile", 1)?,
            gather: device.scratch::<GatherTile>("camera tile of gather", 1)?,
            film: device.scratch::<FilmTile>("camera tile of film", 1)?,
        };
        let film = device.buffer::<Pixel>("film", u64::from(pixels))?;
        let layer_pixels = if settings.needs_layers() { u64::from(pixels) } else { 0 };
        let layers = device.buffer::<LayerPixel>("layers", layer_pixels)?;
        let maps = [global, caustic];
        let mut pace = Pace::new(device, GPU_FIRST_SAMPLES, GPU_SAMPLES, CPU_SAMPLES);
        // A sample is as much work as the rays that it sends out.
        let each = spp.saturating_mul(if parts & PART_GLOBAL != 0 { settings.final_gather.max(1) } else { 1 });
        // The plan of a tile, and of how many pixels it is.
        let mut plan = (0, Plan::new());
        let mut complete = true;
        let mut first_pixel = 0;
        while first_pixel < pixels {
            complete = progress(Progress { phase: "image", done: first_pixel.into(), total: pixels.into() });
            if !complete {
                break;
            }
            let tile_pixels = (pace.size() / each).clamp(1, pixels);
            if plan.0 != tile_pixels {
                // The last one's buffers go first.
                plan.1 = Plan::new();
                plan = (tile_pixels, self.tile_plan(tile_pixels, parts, maps, &tiles, [&film, &layers])?);
            }
            let pixels = tile_pixels.min(pixels - first_pixel);
            let rays = settings.final_gather;
            device.write(&tiles.camera, &[CameraTile { first_pixel, pixels, samples: spp, seed }]);
            device.write(&tiles.gather, &[GatherTile { first_pixel, pixels, samples: spp, rays, seed }]);
            device.write(&tiles.film, &[FilmTile { first_pixel, pixels, samples: spp, parts }]);
            pace.run(|| device.run(&plan.1))?;
            first_pixel += pixels;
        }
        pass.film = device.read(&film, u64::from(pixels))?;
        pass.layers = device.read(&layers, layer_pixels)?;
        pass.complete = complete;
        Ok(())
    }

    /// The stages of one tile. Only those whose part is wanted are in it.
    fn tile_plan(
        &self,
        pixels: u32,
        parts: u32,
        maps: [Option<&PhotonMap>; 2],
        tiles: &Tiles,
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
            plan.each(Kernel::TracePaths, samples, &[&from[..], &[&vertices]].concat());
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
        for (map, name) in maps.into_iter().zip(["sample global", "sample caustic"]) {
            let estimate = device.scratch::<Irradiance>(name, records(map.is_some()))?;
            if let Some(map) = map {
                plan.scope(name.trim_start_matches("sample "));
                if name == "sample global" && settings.final_gather > 0 {
                    self.plan_final_gather(&mut plan, map, samples, &tiles.gather, &queries, &vertices, &estimate)?;
                } else {
                    self.plan_estimate(&mut plan, map, &queries, &vertices, samples, &estimate)?;
                }
            }
            estimates.push(estimate);
            reaches.push(match map.filter(|_| parts & PART_REACH != 0) {
                Some(map) => map.plan_reaches(device, &mut plan, &queries, samples, settings.k)?,
                None => device.scratch::<Reach>("reaches", 0)?,
            });
        }
        plan.scope("image");
        let light = [&vertices, &direct, &estimates[0], &estimates[1]];
        plan.each(Kernel::DevelopFilm, pixels, &[&[&tiles.film], &light[..], &[film]].concat());
        if settings.needs_layers() {
            let reaches = [&reaches[0], &reaches[1], layers];
            plan.each(Kernel::DevelopLayers, pixels, &[&[&tiles.film], &light[..], &reaches].concat());
        }
        Ok(plan)
    }

    /// What a map says of points on surfaces.
    fn plan_estimate(
        &self,
        plan: &mut Plan,
        map: &PhotonMap,
        queries: &Buffer,
        vertices: &Buffer,
        count: u32,
        out: &Buffer,
    ) -> Result<(), RenderError> {
        let seen = Seen { queries, surfaces: Some([vertices, &self.buffers.primitives]) };
        Ok(map.plan_estimate(self.device, plan, seen, count, &self.settings.estimate(), out)?)
    }

    /// What a map says of what points see around them.
    fn plan_final_gather(
        &self,
        plan: &mut Plan,
        map: &PhotonMap,
        samples: u32,
        tile: &Buffer,
        queries: &Buffer,
        vertices: &Buffer,
        out: &Buffer,
    ) -> Result<(), RenderError> {
        let count = samples * self.settings.final_gather;
        let seen_queries = self.device.scratch::<Query>("gather queries", u64::from(count))?;
        let seen_vertices = self.device.scratch::<Vertex>("gather vertices", u64::from(count))?;
        let estimates = self.device.scratch::<Irradiance>("gather estimates", u64::from(count))?;
        let ends = [queries, vertices, &seen_queries, &seen_vertices];
        plan.each(Kernel::TraceGather, count, &[&[tile], &self.buffers.for_camera()[..], &ends].concat());
        self.plan_estimate(plan, map, &seen_queries, &seen_vertices, count, &estimates)?;
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
