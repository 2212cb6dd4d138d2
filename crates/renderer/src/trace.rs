//! Photon paths on a device: count, scan, store, for all paths of a pass or some after others.

use crate::RenderError;
use crate::buffers::SceneBuffers;
use crate::ledger::Books;
use crate::pace::Pace;
use crate::photons::PassKind;
use crate::report::{MapReport, Progress};
use crate::scene::CompiledScene;
use caustic_device::{Buffer, Device, Plan};
use caustic_kernels::gather::CUT_SHORT;
use caustic_kernels::layout::Photon;
use caustic_kernels::sort::SCAN_BLOCK;
use caustic_kernels::trace::{FATE_CUT, FATE_LANDED, Light, PhotonPass, Tally};
use caustic_photon_map::scan;
use std::ops::Range;

/// Paths of one dispatch: few enough for progress and for a GPU's watchdog, enough to fill it.
pub(crate) const DISPATCH: u32 = 1 << 20;
/// Paths of a GPU's first dispatch.
const FIRST_DISPATCH: u32 = 1 << 18;
/// Most photons of a map.
const MAX_STORED: u32 = 1 << 30;

/// Traces the photons of a pass, in the order of their paths. There is no buffer if nothing was stored.
pub(crate) fn trace(
    device: &Device,
    scene: &CompiledScene,
    buffers: &SceneBuffers,
    seed: u32,
    kind: &PassKind,
    progress: &mut dyn FnMut(Progress) -> bool,
) -> Result<(Option<Buffer>, MapReport), RenderError> {
    let mut tracing = Tracing::new(device, scene, buffers, seed, kind)?;
    let total = 2 * u64::from(tracing.emitted());
    let mut tick = |done: u64| progress(Progress { phase: kind.phase, done, total });
    let photons = tracing.chunk(0..tracing.emitted(), &mut tick)?;
    Ok((photons.map(|(photons, _)| photons), tracing.finish()?))
}

/// The paths of a pass, and what those that were traced have come to. A path is a function of its number, so it does not matter which ones are
/// traced together.
pub(crate) struct Tracing<'a> {
    device: &'a Device,
    buffers: &'a SceneBuffers,
    kind: &'a PassKind,
    seed: u32,
    lights: Vec<Light>,
    light_buffer: Buffer,
    books: Books,
    landed: u64,
    stored: u64,
    report: MapReport,
}

impl<'a> Tracing<'a> {
    pub(crate) fn new(
        device: &'a Device,
        scene: &CompiledScene,
        buffers: &'a SceneBuffers,
        seed: u32,
        kind: &'a PassKind,
    ) -> Result<Self, RenderError> {
        // Every light emits one photon at least.
        let emitted = kind.emitted.max(scene.fewest_photons(kind.rays));
        let lights = scene.lights_for(emitted, kind.rays);
        let light_buffer = device.upload("lights of a pass", &lights)?;
        let (books, report) = (Books::new(lights.len()), MapReport::new(kind.map, emitted));
        Ok(Self { device, buffers, kind, seed, lights, light_buffer, books, landed: 0, stored: 0, report })
    }

    /// Photons that the pass emits.
    pub(crate) fn emitted(&self) -> u32 {
        self.report.photons_emitted
    }

    /// Traces the paths with these numbers. Returns their photons, in the order of paths, and how many there are; nothing if there are none. `tick` is
    /// told of twice as many paths as there are.
    pub(crate) fn chunk(
        &mut self,
        numbers: Range<u32>,
        tick: &mut dyn FnMut(u64) -> bool,
    ) -> Result<Option<(Buffer, u32)>, RenderError> {
        let (device, kernels) = (self.device, self.buffers.kernels);
        let PassKind { map, rays, stored_from, thin, .. } = *self.kind;
        let (chunk, end, all) = (numbers.start, numbers.end, numbers.end - numbers.start);
        let mut tick = |path: u32, times: u64| {
            let goes_on = tick(u64::from(path - chunk) + times * u64::from(all));
            if goes_on { Ok(()) } else { Err(RenderError::Interrupted) }
        };
        let counts = device.scratch::<u32>("photon counts", all.into())?;
        let fates = device.scratch::<u32>("photon fates", all.min(DISPATCH).into())?;
        let segments = device.scratch::<u32>("photon segments", all.min(DISPATCH).into())?;
        let tallies = device.scratch::<Tally>("photon tallies", all.min(DISPATCH).into())?;
        let mut pace = Pace::new(device, FIRST_DISPATCH, DISPATCH, DISPATCH);
        // Stored photons are traced in the same dispatches.
        let mut dispatches: Vec<PhotonPass> = Vec::new();
        let mut first = chunk;
        while first < end {
            tick(first, 0)?;
            let paths = pace.size().min(end - first);
            let (emitted, seed) = (self.emitted(), self.seed);
            let pass = PhotonPass { emitted, first, paths, rays, seed, stored_from, thin, chunk };
            dispatches.push(pass);
            first += paths;
            let params = device.upload("photon pass", &[pass])?;
            let mut plan = Plan::new();
            plan.scope(map);
            let outputs = [&counts, &fates, &segments, &tallies];
            let from = self.buffers.for_photons(&self.light_buffer);
            plan.each(kernels.count, paths, &[&[&params], &from[..], &outputs].concat());
            let [_, _, block_fates] = scan(device, &mut plan, &fates, paths)?;
            let [_, _, block_segments] = scan(device, &mut plan, &segments, paths)?;
            self.books.plan(device, &mut plan, &pass, &self.lights, &tallies)?;
            pace.run(|| device.run(&plan))?;
            self.books.enter(device)?;
            let blocks = u64::from(paths.div_ceil(SCAN_BLOCK));
            self.report.segments +=
                device.read::<u32>(&block_segments, blocks)?.into_iter().map(u64::from).sum::<u64>();
            for fates in device.read::<u32>(&block_fates, blocks)? {
                self.landed += u64::from(fates % FATE_CUT / FATE_LANDED);
                self.report.paths_cut += fates / FATE_CUT;
            }
        }
        drop((fates, segments, tallies));
        let mut plan = Plan::new();
        plan.scope(map);
        let [offsets, block_offsets, block_totals] = scan(device, &mut plan, &counts, all)?;
        device.run(&plan)?;

        // The one read-back: how many photons there are, so that the map has exactly the size it needs.
        let totals: Vec<u32> = device.read(&block_totals, u64::from(all.div_ceil(SCAN_BLOCK)))?;
        let stored: u64 = totals.iter().map(|&total| u64::from(total)).sum();
        self.stored += stored;
        self.check(stored, all, end)?;
        if stored == 0 {
            return Ok(None);
        }
        let unsorted = device.scratch::<Photon>("photons", stored)?;
        for pass in &dispatches {
            tick(pass.first, 1)?;
            let params = device.upload("photon pass", &[*pass])?;
            let mut plan = Plan::new();
            plan.scope(map);
            let from = self.buffers.for_photons(&self.light_buffer);
            let places = [&counts, &offsets, &block_offsets, &unsorted];
            plan.each(kernels.store, pass.paths, &[&[&params], &from[..], &places].concat());
            device.run(&plan)?;
        }
        tick(end, 1)?;
        Ok(Some((unsorted, stored as u32)))
    }

    /// Refuses more photons than a map holds, or than estimates and reports count. `stored` are of the last `paths` paths, up to `end`.
    fn check(&self, stored: u64, paths: u32, end: u32) -> Result<(), RenderError> {
        let PassKind { map, flag, .. } = *self.kind;
        let fits = |paths: u32, max: u32, stored: u64| u64::from(paths) * u64::from(max) / stored;
        if stored > u64::from(MAX_STORED) {
            let emitted = fits(paths, MAX_STORED, stored);
            return Err(RenderError::TooManyPhotons { map, stored, max: MAX_STORED, flag: "chunk", emitted });
        }
        const MAX_COUNT: u32 = CUT_SHORT - 1;
        if self.stored > u64::from(MAX_COUNT) {
            let (stored, emitted) = (self.stored, fits(end, MAX_COUNT, self.stored));
            return Err(RenderError::TooManyPhotons { map, stored, max: MAX_COUNT, flag, emitted });
        }
        Ok(())
    }

    /// What became of all paths.
    ///
    /// # Errors
    /// [`RenderError::NoPhotons`] where there should be some.
    pub(crate) fn finish(self) -> Result<MapReport, RenderError> {
        let (kind, emitted) = (self.kind, self.emitted());
        let no_photons = |remedy| Err(RenderError::NoPhotons { map: kind.map, emitted, remedy });
        if self.landed == 0 && kind.stored_from == 1 {
            return no_photons(
                "none of them met a diffuse surface; see that the lights face the scene, or emit more with --photons",
            );
        }
        if self.stored == 0 && kind.wanted {
            return no_photons("there is no light of this kind to show; use --show beauty, or emit more photons");
        }
        let photons = self.stored as u32;
        let ledger = self.books.ledgers();
        Ok(MapReport { photons_stored: photons, photons_kept: photons, ledger, ..self.report })
    }
}
