//! A photon pass: count, scan, store, build.

use crate::buffers::SceneBuffers;
use crate::ledger::Books;
use crate::pace::Pace;
use crate::photon_file::PhotonFile;
use crate::report::{MapReport, Progress};
use crate::scene::CompiledScene;
use crate::{Feature, RenderError, Settings, Show, decide};
use caustic_device::{Buffer, Device, Plan};
use caustic_kernels::grid::HASH_LINEAR;
use caustic_kernels::layout::Photon;
use caustic_kernels::sort::SCAN_BLOCK;
use caustic_kernels::trace::{FATE_CUT, FATE_LANDED, PhotonPass, RAY_CAUSTIC, RAY_GLOBAL, Tally};
use caustic_photon_map::{MapOptions, PhotonMap, SeenCells, plan_grid, scan};

/// Paths of one dispatch: few enough for progress and for a GPU's watchdog, enough to fill it.
pub(crate) const CHUNK: u32 = 1 << 20;
/// Paths of a GPU's first dispatch.
const FIRST_CHUNK: u32 = 1 << 18;
/// Photons that are looked at to choose the width of cells.
const SAMPLE: u64 = 4096;
/// Most photons of a map.
const MAX_STORED: u32 = 1 << 30;

/// Which photons a pass traces and stores.
pub(crate) struct PassKind {
    /// Name of the map.
    pub(crate) map: &'static str,
    /// Name of the phase in progress reports.
    pub(crate) phase: &'static str,
    /// Flag that sets the number of photons.
    pub(crate) flag: &'static str,
    /// Photons emitted.
    pub(crate) emitted: u32,
    /// [`PhotonPass::rays`].
    pub(crate) rays: u32,
    /// [`PhotonPass::stored_from`].
    pub(crate) stored_from: u32,
    /// [`PhotonPass::thin`].
    pub(crate) thin: u32,
    /// Whether an empty map is an error: it was asked for by name.
    pub(crate) wanted: bool,
}

impl PassKind {
    /// The passes that a picture needs: of the global map and of the caustic one, if it is wanted and there can be one.
    pub(crate) fn of(settings: &Settings, scene: &CompiledScene) -> [Option<Self>; 2] {
        let Settings { photons, caustic_photons, show, final_gather, thin, .. } = *settings;
        let modelled = |feature| decide(scene, settings).iter().any(|one| one.feature == feature && one.modelled);
        [
            modelled(Feature::GlobalMap).then(|| Self::global(photons, show, final_gather > 0)),
            modelled(Feature::CausticMap).then(|| Self::caustic(caustic_photons, show)),
        ]
        .map(|kind| kind.map(|kind| Self { thin, ..kind }))
    }

    /// Direct light comes from shadow rays, so the global map of a picture holds only what was reflected before; shown by
    /// itself, it holds all, as it does for a final gather, whose rays see direct light as well.
    pub(crate) fn global(emitted: u32, show: Show, gathered: bool) -> Self {
        Self {
            map: "global",
            phase: "global photons",
            flag: "photons",
            emitted,
            rays: RAY_GLOBAL,
            stored_from: u32::from(show != Show::MapGlobal && !gathered),
            thin: 1,
            wanted: show != Show::Beauty,
        }
    }

    /// Light that comes to a diffuse surface through mirrors and glass alone.
    pub(crate) fn caustic(emitted: u32, show: Show) -> Self {
        Self {
            map: "caustic",
            phase: "caustic photons",
            flag: "caustic-photons",
            emitted,
            rays: RAY_CAUSTIC,
            stored_from: 0,
            thin: 1,
            wanted: show != Show::Beauty,
        }
    }
}

/// Traces the photons of a pass, or takes them from a file, and builds the map of those near cells that are `seen`, or of all. There is no map
/// if nothing was stored.
pub(crate) fn photon_map(
    device: &Device,
    scene: &CompiledScene,
    buffers: &SceneBuffers,
    settings: &Settings,
    kind: &PassKind,
    file: Option<&PhotonFile>,
    seen: Option<&SeenCells>,
    progress: &mut dyn FnMut(Progress) -> bool,
) -> Result<(Option<PhotonMap>, MapReport), RenderError> {
    let (photons, mut report) = match file {
        Some(file) => file.upload(device, kind)?,
        None => trace(device, scene, buffers, settings.seed, kind, progress)?,
    };
    let Some(mut unsorted) = photons else { return Ok((None, report)) };
    if let Some(seen) = seen {
        (unsorted, report.photons_kept) = seen.keep(device, &unsorted, report.photons_stored)?;
    }
    let stored = u64::from(report.photons_kept);
    let (low, high) = scene.diffuse_bounds;
    let positions = sample(device, &unsorted, stored)?;
    let options = MapOptions { radius: settings.radius, hash: settings.hash, table: settings.table, cell: None };
    let grid = plan_grid(low, high, stored, &positions, &options)?;
    let mut plan = Plan::new();
    plan.scope(kind.map);
    let plan_map = if settings.compact { PhotonMap::plan_compact } else { PhotonMap::plan };
    let map = plan_map(device, &mut plan, &unsorted, grid)?;
    if settings.estimate().needs_sides() {
        map.plan_sides(&mut plan, &buffers.primitives);
    }
    device.run(&plan)?;
    report.table_entries = grid.table;
    report.linear = grid.hash == HASH_LINEAR;
    report.bytes = map.bytes();
    if settings.health {
        report.health = Some(map.health(device)?);
    }
    Ok((Some(map), report))
}

/// Positions of some of the `stored` photons of a pass, m. Paths are independent, so the first photons are as good a sample as any.
pub(crate) fn sample(device: &Device, photons: &Buffer, stored: u64) -> Result<Vec<[f32; 3]>, RenderError> {
    let first: Vec<Photon> = device.read(photons, stored.min(SAMPLE))?;
    Ok(first.iter().map(|photon| photon.position).collect())
}

/// Traces the photons of a pass, in the order of their paths. There is no buffer if nothing was stored.
pub(crate) fn trace(
    device: &Device,
    scene: &CompiledScene,
    buffers: &SceneBuffers,
    seed: u32,
    kind: &PassKind,
    progress: &mut dyn FnMut(Progress) -> bool,
) -> Result<(Option<Buffer>, MapReport), RenderError> {
    // Every light emits one photon at least.
    let emitted = kind.emitted.max(scene.fewest_photons(kind.rays));
    let lights = scene.lights_for(emitted, kind.rays);
    let light_buffer = device.upload("lights of a pass", &lights)?;
    let mut books = Books::new(lights.len());
    let mut report = MapReport::new(kind.map, emitted);
    let counts = device.scratch::<u32>("photon counts", u64::from(emitted))?;
    let total = 2 * u64::from(emitted);
    let mut tick = |done: u32, times: u64| {
        let done = u64::from(done) + times * u64::from(emitted);
        let goes_on = progress(Progress { phase: kind.phase, done, total });
        if goes_on { Ok(()) } else { Err(RenderError::Interrupted) }
    };
    let fates = device.scratch::<u32>("photon fates", u64::from(emitted.min(CHUNK)))?;
    let segments = device.scratch::<u32>("photon segments", u64::from(emitted.min(CHUNK)))?;
    let tallies = device.scratch::<Tally>("photon tallies", u64::from(emitted.min(CHUNK)))?;
    let mut landed = 0u64;
    let mut pace = Pace::new(device, FIRST_CHUNK, CHUNK, CHUNK);
    // The dispatches: stored photons are traced in the same ones.
    let mut chunks: Vec<PhotonPass> = Vec::new();
    let mut first = 0;
    while first < emitted {
        tick(first, 0)?;
        let PassKind { rays, stored_from, thin, .. } = *kind;
        let paths = pace.size().min(emitted - first);
        let pass = PhotonPass { emitted, first, paths, rays, seed, stored_from, thin };
        chunks.push(pass);
        first += paths;
        let params = device.upload("photon pass", &[pass])?;
        let mut plan = Plan::new();
        plan.scope(kind.map);
        let outputs = [&counts, &fates, &segments, &tallies];
        plan.each(
            buffers.kernels.count,
            pass.paths,
            &[&[&params], &buffers.for_photons(&light_buffer)[..], &outputs].concat(),
        );
        let [_, _, block_fates] = scan(device, &mut plan, &fates, pass.paths)?;
        let [_, _, block_segments] = scan(device, &mut plan, &segments, pass.paths)?;
        books.plan(device, &mut plan, &pass, &lights, &tallies)?;
        pace.run(|| device.run(&plan))?;
        books.enter(device)?;
        let blocks = u64::from(pass.paths.div_ceil(SCAN_BLOCK));
        report.segments += device.read::<u32>(&block_segments, blocks)?.into_iter().map(u64::from).sum::<u64>();
        for fates in device.read::<u32>(&block_fates, blocks)? {
            landed += u64::from(fates % FATE_CUT / FATE_LANDED);
            report.paths_cut += fates / FATE_CUT;
        }
    }
    drop((fates, segments, tallies));
    report.ledger = books.ledgers();
    let mut plan = Plan::new();
    plan.scope(kind.map);
    let [offsets, block_offsets, block_totals] = scan(device, &mut plan, &counts, emitted)?;
    device.run(&plan)?;

    // The one read-back: how many photons there are, so that the map has exactly the size it needs.
    let totals: Vec<u32> = device.read(&block_totals, u64::from(emitted.div_ceil(SCAN_BLOCK)))?;
    let stored: u64 = totals.iter().map(|&total| u64::from(total)).sum();
    if stored > u64::from(MAX_STORED) {
        let fits = u64::from(emitted) * u64::from(MAX_STORED) / stored;
        let (map, flag) = (kind.map, kind.flag);
        return Err(RenderError::TooManyPhotons { map, stored, max: MAX_STORED, flag, emitted: fits });
    }
    if landed == 0 && kind.stored_from == 1 {
        let remedy =
            "none of them met a diffuse surface; see that the lights face the scene, or emit more with --photons";
        return Err(RenderError::NoPhotons { map: kind.map, emitted, remedy });
    }
    if stored == 0 {
        if kind.wanted {
            let remedy = "there is no light of this kind to show; use --show beauty, or emit more photons";
            return Err(RenderError::NoPhotons { map: kind.map, emitted, remedy });
        }
        return Ok((None, report));
    }
    report.photons_stored = stored as u32;
    report.photons_kept = report.photons_stored;

    let unsorted = device.scratch::<Photon>("photons", stored)?;
    for pass in &chunks {
        tick(pass.first, 1)?;
        let params = device.upload("photon pass", &[*pass])?;
        let mut plan = Plan::new();
        plan.scope(kind.map);
        let places = [&counts, &offsets, &block_offsets, &unsorted];
        plan.each(
            buffers.kernels.store,
            pass.paths,
            &[&[&params], &buffers.for_photons(&light_buffer)[..], &places].concat(),
        );
        device.run(&plan)?;
    }
    tick(emitted, 1)?;
    Ok((Some(unsorted), report))
}
