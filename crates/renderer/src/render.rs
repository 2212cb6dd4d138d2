//! The render: photon maps first, then the image, tile by tile.

use crate::buffers::SceneBuffers;
use crate::ledger;
use crate::output::Image;
use crate::pace::Pace;
use crate::photons::{PassKind, photon_map};
use crate::report::{MapReport, Progress, RenderReport};
use crate::scene::{CompiledScene, Scene};
use crate::{RenderError, Settings};
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::layout::{Irradiance, Query};
use caustic_kernels::trace::{
    CameraTile, FilmTile, PART_CAUSTIC, PART_DIRECT, PART_GLOBAL, Pixel, RAY_CAUSTIC, Vertex,
};
use caustic_photon_map::PhotonMap;
use std::time::Instant;

/// Camera samples of one tile: the unit of progress. A GPU needs more of them to be busy; it begins with a part of that.
const CPU_SAMPLES: u32 = 1 << 17;
const GPU_FIRST_SAMPLES: u32 = 1 << 19;
const GPU_SAMPLES: u32 = 1 << 21;

/// A finished render.
pub struct Rendered {
    /// The image: radiance, W·sr⁻¹·m⁻².
    pub image: Image,
    /// What the render did.
    pub report: RenderReport,
}

/// Renders a scene. `progress` is called now and then, and the render stops when it returns false: with
/// [`RenderError::Interrupted`] while there is no image yet, afterwards with the rows that are finished.
///
/// # Errors
/// All of [`RenderError`].
pub fn render(
    scene: &Scene,
    settings: &Settings,
    device: &Device,
    progress: &mut dyn FnMut(Progress) -> bool,
) -> Result<Rendered, RenderError> {
    settings.validate()?;
    let start = Instant::now();
    let compiled = scene.compile();
    let buffers = SceneBuffers::new(device, &compiled)?;
    let mut notes = scene.notes.clone();
    let mut maps = Vec::new();
    let mut map = |kind: Option<PassKind>| match kind {
        Some(kind) => build(device, &compiled, &buffers, settings, &kind, &mut maps, &mut notes, progress),
        None => Ok(None),
    };
    let global = map(global_pass(settings))?;
    let caustic = map(caustic_pass(settings, &compiled))?;
    if settings.show.parts() & PART_CAUSTIC != 0 && !compiled.has_specular {
        notes.push("no caustic map: nothing in the scene is specular".to_string());
    }

    let camera = Camera { device, scene, buffers: &buffers, settings };
    let (film, complete) = camera.film(global.as_ref(), caustic.as_ref(), progress)?;
    let count = |of: fn(&Pixel) -> u32| film.iter().map(|pixel| u64::from(of(pixel))).sum::<u64>();
    let cut_short = count(|pixel| pixel.cut_short);
    if cut_short > 0 {
        return Err(RenderError::CutShort { device: device.name(), searches: cut_short });
    }
    let lost = count(|pixel| pixel.lost);
    if lost > 0 {
        notes.push(format!("{lost} camera paths were given up among mirrors and glass; they count as black"));
    }
    let not_finite = count(|pixel| pixel.not_finite);
    if not_finite > 0 {
        notes.push(format!(
            "{not_finite} camera samples were not finite and count as black: a radius or power is extreme"
        ));
    }
    let mut problems: Vec<String> = maps.iter().flat_map(|map| ledger::problems(map.map, &map.ledger)).collect();
    problems.extend(maps.iter().filter(|map| map.paths_cut > 0).map(|map| cut(map)));
    problems.extend(
        [(lost, "given up"), (not_finite, "not finite")]
            .into_iter()
            .filter(|(samples, _)| *samples > 0)
            .map(|(samples, what)| format!("{samples} camera samples were {what}")),
    );
    let [width, height] = settings.size;
    let image = Image { width, height, rgb: film.iter().map(|pixel| pixel.rgb).collect() };
    let report = RenderReport {
        device: device.name(),
        complete,
        seconds: start.elapsed().as_secs_f64(),
        maps,
        camera_rays: count(|pixel| pixel.rays),
        notes,
        problems,
        stages: device.stage_times(),
        buffers: device.buffer_bytes(),
        peak_bytes: device.total_bytes().1,
        mean_radiance: mean(&image),
    };
    Ok(Rendered { image, report })
}

/// Mean radiance of an image, W·sr⁻¹·m⁻².
fn mean(image: &Image) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for pixel in &image.rgb {
        for (sum, &value) in sum.iter_mut().zip(pixel) {
            *sum += f64::from(value);
        }
    }
    sum.map(|sum| sum / image.rgb.len() as f64)
}

fn global_pass(settings: &Settings) -> Option<PassKind> {
    let wanted = settings.show.parts() & PART_GLOBAL != 0;
    wanted.then(|| PassKind::global(settings.photons, settings.show))
}

fn caustic_pass(settings: &Settings, scene: &CompiledScene) -> Option<PassKind> {
    let wanted = settings.show.parts() & PART_CAUSTIC != 0;
    let aimed = scene.fewest_photons(RAY_CAUSTIC) > 0;
    let possible = wanted && scene.has_specular && aimed && settings.caustic_photons > 0;
    possible.then(|| PassKind::caustic(settings.caustic_photons, settings.show))
}

fn build(
    device: &Device,
    scene: &CompiledScene,
    buffers: &SceneBuffers,
    settings: &Settings,
    kind: &PassKind,
    maps: &mut Vec<MapReport>,
    notes: &mut Vec<String>,
    progress: &mut dyn FnMut(Progress) -> bool,
) -> Result<Option<PhotonMap>, RenderError> {
    let (map, report) = photon_map(device, scene, buffers, settings, kind, progress)?;
    if map.is_none() {
        notes.push(format!("the {} map is empty: no such light was found", kind.map));
    }
    if report.paths_cut > 0 {
        notes.push(cut(&report));
    }
    notes.extend(ledger::problems(kind.map, &report.ledger));
    maps.push(report);
    Ok(map)
}

fn cut(report: &MapReport) -> String {
    format!("{} paths of the {} map were given up after 1024 bounces", report.paths_cut, report.map)
}

/// The second pass.
struct Camera<'a> {
    device: &'a Device,
    scene: &'a Scene,
    buffers: &'a SceneBuffers,
    settings: &'a Settings,
}

impl Camera<'_> {
    /// Renders the film and returns it with whether it is whole.
    fn film(
        &self,
        global: Option<&PhotonMap>,
        caustic: Option<&PhotonMap>,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<(Vec<Pixel>, bool), RenderError> {
        let Self { device, settings, .. } = *self;
        let [width, height] = settings.size;
        let pixels = width * height;
        let spp = settings.spp;
        let mut parts = settings.show.parts();
        parts &= !if global.is_none() { PART_GLOBAL } else { 0 };
        parts &= !if caustic.is_none() { PART_CAUSTIC } else { 0 };
        let tile_buffer = device.scratch::<CameraTile>("camera tile", 1)?;
        let film_tile_buffer = device.scratch::<FilmTile>("camera tile of film", 1)?;
        let film = device.buffer::<Pixel>("film", u64::from(pixels))?;
        let maps = [global, caustic];
        let mut pace = Pace::new(device, GPU_FIRST_SAMPLES, GPU_SAMPLES, CPU_SAMPLES);
        // The plan of a tile, and of how many pixels it is.
        let mut plan = (0, Plan::new());
        let mut complete = true;
        let mut first_pixel = 0;
        while first_pixel < pixels {
            complete = progress(Progress { phase: "image", done: first_pixel.into(), total: pixels.into() });
            if !complete {
                break;
            }
            let tile_pixels = (pace.size() / spp).clamp(1, pixels);
            if plan.0 != tile_pixels {
                // The last one's buffers go first.
                plan.1 = Plan::new();
                let buffers = [&tile_buffer, &film_tile_buffer, &film];
                plan = (tile_pixels, self.tile_plan(tile_pixels, parts, maps, buffers)?);
            }
            let pixels = tile_pixels.min(pixels - first_pixel);
            device.write(&tile_buffer, &[CameraTile { first_pixel, pixels, samples: spp, seed: settings.seed }]);
            device.write(&film_tile_buffer, &[FilmTile { first_pixel, pixels, samples: spp, parts }]);
            pace.run(|| device.run(&plan.1))?;
            first_pixel += pixels;
        }
        Ok((device.read(&film, u64::from(pixels))?, complete))
    }

    /// The stages of one tile. Only those whose part is wanted are in it.
    fn tile_plan(
        &self,
        pixels: u32,
        parts: u32,
        maps: [Option<&PhotonMap>; 2],
        [tile, film_tile, film]: [&Buffer; 3],
    ) -> Result<Plan, RenderError> {
        let Self { device, settings, .. } = *self;
        let SceneBuffers { kernels, info, nodes, primitives, materials, lights, .. } = self.buffers;
        let [width, height] = settings.size;
        let samples = pixels * settings.spp;
        let records = |wanted: bool| if wanted { u64::from(samples) } else { 0 };
        let camera = device.upload("camera", &[self.scene.camera(width, height)])?;
        let queries = device.scratch::<Query>("sample queries", u64::from(samples))?;
        let vertices = device.scratch::<Vertex>("sample vertices", u64::from(samples))?;
        let direct = device.scratch::<Irradiance>("sample direct", records(parts & PART_DIRECT != 0))?;
        let mut plan = Plan::new();
        plan.scope("image");
        let seen = [&queries, &vertices];
        plan.each(kernels.camera, samples, &[&[tile, &camera], &self.buffers.for_camera()[..], &seen].concat());
        if parts & PART_DIRECT != 0 {
            plan.each(
                kernels.direct,
                samples,
                &[tile, info, nodes, primitives, materials, lights, &queries, &vertices, &direct],
            );
        }
        let mut estimates = Vec::new();
        for (map, name) in maps.into_iter().zip(["sample global", "sample caustic"]) {
            let estimate = device.scratch::<Irradiance>(name, records(map.is_some()))?;
            if let Some(map) = map {
                plan.scope(name.trim_start_matches("sample "));
                map.plan_irradiance(device, &mut plan, &queries, samples, settings.k, settings.gather, &estimate)?;
            }
            estimates.push(estimate);
        }
        plan.scope("image");
        plan.each(Kernel::DevelopFilm, pixels, &[film_tile, &vertices, &direct, &estimates[0], &estimates[1], film]);
        Ok(plan)
    }
}
