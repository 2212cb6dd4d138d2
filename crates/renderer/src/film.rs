//! The film of a pass, or some pixels of it, tile by tile.

use crate::frame::{CPU_SAMPLES, Frame, GPU_FIRST_SAMPLES, GPU_SAMPLES, Maps};
use crate::lattice::{self, Lattice, Points};
use crate::output::LayerKind;
use crate::pace::Pace;
use crate::report::Progress;
use crate::work::WorkUnit;
use crate::{Integrator, RenderError, Settings};
use caustic_device::{Buffer, Kernel, Plan};
use caustic_kernels::gather::Reach;
use caustic_kernels::layout::{Irradiance, Query};
use caustic_kernels::trace::{
    CameraTile, FilmTile, GatherTile, LayerPixel, PART_BIAS, PART_CAUSTIC, PART_DIRECT, PART_GLOBAL, PART_REACH, Pixel,
    Vertex,
};
use caustic_photon_map::{Estimate, PhotonMap, Seen};

/// Pixels of a pass, from the first that was asked for; fewer than that if the caller stopped it.
pub(crate) struct Pixels {
    pub(crate) film: Vec<Pixel>,
    /// Their layers; empty if none are asked for.
    pub(crate) layers: Vec<LayerPixel>,
}

/// What says how much light of photons arrives at camera samples: of the global map and of the caustic one, where there are photons.
#[derive(Clone, Copy)]
pub(crate) enum Light<'a> {
    /// Maps.
    Maps([Option<&'a PhotonMap>; 2]),
    /// Estimates that were made before, of the samples from those of this pixel on.
    Known(u32, [Option<&'a [Irradiance]>; 2]),
}

impl<'a> Light<'a> {
    /// Whether there is some, by map.
    fn is_there(&self) -> [bool; 2] {
        match self {
            Self::Maps(maps) => maps.map(|map| map.is_some()),
            Self::Known(_, estimates) => estimates.map(|estimates| estimates.is_some()),
        }
    }

    fn maps(&self) -> [Option<&'a PhotonMap>; 2] {
        match self {
            Self::Maps(maps) => *maps,
            Self::Known(..) => [None, None],
        }
    }
}

/// The pixels of a unit while they are developed.
pub(crate) struct Film<'a> {
    frame: &'a Frame<'a>,
    pub(crate) unit: WorkUnit,
    seed: u32,
    /// The first pixel that is not developed.
    pub(crate) next: u32,
    tiles: Tiles,
    lattice: Option<Lattice>,
    pace: Pace,
    // Pixels are written where they are in the picture.
    film: Buffer,
    layers: Buffer,
}

/// Parameters of the stages of a tile, written anew for each tile.
struct Tiles {
    camera: Buffer,
    gather: Buffer,
    film: Buffer,
}

/// The stages of a tile of so many pixels, and where they look for light that is known.
struct Planned {
    pixels: u32,
    plan: Plan,
    estimates: Vec<Buffer>,
}

impl<'a> Film<'a> {
    pub(crate) fn new(frame: &'a Frame<'a>, unit: WorkUnit, maps: &Maps) -> Result<Self, RenderError> {
        let Frame { device, settings, .. } = *frame;
        let lattice = (settings.interpolate > 0 && maps.whole[0].is_some())
            .then(|| Lattice::new(device, frame.scene, settings, maps.radius))
            .transpose()?;
        let layer_pixels = if settings.needs_layers() { u64::from(unit.end()) } else { 0 };
        Ok(Self {
            frame,
            unit,
            seed: maps.seed,
            next: unit.first_pixel,
            tiles: Tiles {
                camera: device.scratch::<CameraTile>("camera tile", 1)?,
                gather: device.scratch::<GatherTile>("camera tile of gather", 1)?,
                film: device.scratch::<FilmTile>("camera tile of film", 1)?,
            },
            lattice,
            pace: Pace::new(device, GPU_FIRST_SAMPLES, GPU_SAMPLES, CPU_SAMPLES),
            film: device.buffer::<Pixel>("film", u64::from(unit.end()))?,
            layers: device.buffer::<LayerPixel>("layers", layer_pixels)?,
        })
    }

    /// Develops the pixels up to `end`. Returns whether `progress` lets it go on.
    pub(crate) fn develop(
        &mut self,
        end: u32,
        light: Light<'_>,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<bool, RenderError> {
        let Frame { device, settings, .. } = *self.frame;
        let parts = parts(settings, light);
        let (spp, rays) = (settings.spp, settings.final_gather);
        // A sample is as much work as the rays that it sends out.
        let each = spp.saturating_mul(if parts & PART_GLOBAL != 0 { rays.max(1) } else { 1 });
        let mut planned: Option<Planned> = None;
        while self.next < end {
            let first_pixel = self.next;
            let (done, total) = (u64::from(first_pixel - self.unit.first_pixel), u64::from(self.unit.pixels));
            if !progress(Progress { phase: "image", done, total }) {
                return Ok(false);
            }
            let wanted = (self.pace.size() / each).clamp(1, self.unit.pixels);
            // The last one's buffers go first.
            let Planned { pixels: most, plan, estimates } = match planned.take().filter(|plan| plan.pixels == wanted) {
                Some(planned) => planned,
                None => self.plan(wanted, parts, light)?,
            };
            let pixels = most.min(end - first_pixel);
            let tile = CameraTile { first_pixel, pixels, samples: spp, seed: self.seed };
            device.write(&self.tiles.camera, &[tile]);
            if let Some(lattice) = &self.lattice {
                lattice.write(device, &tile, most, rays);
            }
            let gather = GatherTile { first_pixel, pixels, samples: spp, rays, seed: self.seed };
            device.write(&self.tiles.gather, &[gather]);
            device.write(&self.tiles.film, &[FilmTile { first_pixel, pixels, samples: spp, parts }]);
            if let Light::Known(first, known) = light {
                let at = (first_pixel - first) as usize * spp as usize;
                for (buffer, known) in estimates.iter().zip(known).filter_map(|(buffer, known)| Some((buffer, known?)))
                {
                    device.write(buffer, &known[at..][..pixels as usize * spp as usize]);
                }
            }
            self.pace.run(|| device.run(&plan))?;
            self.next += pixels;
            planned = Some(Planned { pixels: most, plan, estimates });
        }
        Ok(true)
    }

    /// What is developed.
    pub(crate) fn finish(self) -> Result<Pixels, RenderError> {
        let device = self.frame.device;
        let (first, next) = (self.unit.first_pixel as usize, u64::from(self.next));
        let layer_pixels = if self.frame.settings.needs_layers() { next } else { 0 };
        let mut film: Vec<Pixel> = device.read(&self.film, next)?;
        let mut layers: Vec<LayerPixel> = device.read(&self.layers, layer_pixels)?;
        film.drain(..first);
        layers.drain(..first.min(layers.len()));
        Ok(Pixels { film, layers })
    }

    /// The stages of one tile. Only those whose part is wanted are in it.
    fn plan(&self, pixels: u32, parts: u32, light: Light<'_>) -> Result<Planned, RenderError> {
        let Self { tiles, lattice, film, layers, .. } = self;
        let lattice = lattice.as_ref();
        let Frame { device, settings, ref camera, buffers: scene, .. } = *self.frame;
        let maps = light.maps();
        let kernels = scene.kernels;
        let samples = pixels * settings.spp;
        let paths = settings.integrator == Integrator::Path;
        let records = |wanted: bool| if wanted { u64::from(samples) } else { 0 };
        let queries = device.scratch::<Query>("sample queries", records(!paths))?;
        let vertices = device.scratch::<Vertex>("sample vertices", u64::from(samples))?;
        let direct = device.scratch::<Irradiance>("sample direct", records(parts & PART_DIRECT != 0))?;
        let mut plan = Plan::new();
        plan.scope("image");
        let from = [&[&tiles.camera, camera], &scene.for_camera()[..]].concat();
        if paths {
            plan.each(kernels.paths, samples, &[&from[..], &[&vertices]].concat());
        } else {
            plan.each(kernels.camera, samples, &[&from[..], &[&queries, &vertices]].concat());
        }
        if parts & PART_DIRECT != 0 {
            let scene = scene.for_camera();
            let samples_of = [&queries, &vertices, &direct];
            plan.each(kernels.direct, samples, &[&[&tiles.camera], &scene[..], &samples_of].concat());
        }
        let mut estimates = Vec::new();
        let mut reaches = Vec::new();
        let mut halves = Vec::new();
        let names = ["sample global", "sample caustic"];
        for ((map, is_there), name) in maps.into_iter().zip(light.is_there()).zip(names) {
            let estimate = device.scratch::<Irradiance>(name, records(is_there))?;
            if let Some(map) = map {
                plan.scope(name.trim_start_matches("sample "));
                let points = Points { queries: &queries, vertices: &vertices, count: samples, gather: &tiles.gather };
                let global = name == "sample global";
                let light = |plan: &mut Plan, points: Points<'_>, out: &Buffer| {
                    if global && settings.final_gather > 0 {
                        return self.frame.plan_final_gather(plan, map, points, out);
                    }
                    let Points { queries, vertices, count, .. } = points;
                    self.frame.plan_estimate(plan, map, &settings.estimate(), [queries, vertices], count, out)
                };
                match lattice.filter(|_| global) {
                    Some(lattice) => {
                        let scene = &scene.for_camera();
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
                self.frame.plan_estimate(&mut plan, &map, &how, [&queries, &vertices], samples, &of_half)?;
            }
            halves.push(of_half);
            estimates.push(estimate);
            reaches.push(match map.filter(|_| parts & PART_REACH != 0) {
                Some(map) => map.plan_reaches(device, &mut plan, &queries, samples, settings.k, settings.nearest)?,
                None => device.scratch::<Reach>("reaches", 0)?,
            });
        }
        plan.scope("image");
        let found = [&vertices, &direct, &estimates[0], &estimates[1]];
        plan.each(Kernel::DevelopFilm, pixels, &[&[&tiles.film], &found[..], &[film]].concat());
        if settings.needs_layers() {
            let beside = [&reaches[0], &reaches[1], &halves[0], &halves[1], layers];
            plan.each(Kernel::DevelopLayers, pixels, &[&[&tiles.film], &found[..], &beside].concat());
        }
        Ok(Planned { pixels, plan, estimates })
    }
}

/// Parts of the light that the film adds up.
fn parts(settings: &Settings, light: Light<'_>) -> u32 {
    let [global, caustic] = light.is_there();
    let mut parts = settings.parts();
    parts &= !if global { 0 } else { PART_GLOBAL };
    parts &= !if caustic { 0 } else { PART_CAUSTIC };
    parts |= if settings.layers.contains(&LayerKind::Radius) { PART_REACH } else { 0 };
    parts | if settings.layers.contains(&LayerKind::Bias) { PART_BIAS } else { 0 }
}

impl Frame<'_> {
    /// Renders the pixels of a unit and their layers.
    pub(crate) fn film(
        &self,
        unit: WorkUnit,
        maps: &mut Maps,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Pixels, RenderError> {
        let mut film = Film::new(self, unit, maps)?;
        match self.settings.chunk {
            Some(chunk) => self.develop_in_batches(&mut film, maps, chunk, progress)?,
            None => {
                let light = Light::Maps([0, 1].map(|i| maps.whole[i].as_ref()));
                film.develop(unit.end(), light, progress)?;
            }
        }
        film.finish()
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
