//! A pass whose maps are not in memory at once: all photons go by, a map of each chunk of them after another, for each batch of camera samples.

use crate::chunk::Chunk;
use crate::film::{Film, Light};
use crate::frame::{Frame, Maps};
use crate::photons::{PassKind, grid};
use crate::report::{MapReport, Progress};
use crate::trace::Tracing;
use crate::{Integrator, RenderError, Settings};
use caustic_device::{Buffer, Plan};
use caustic_kernels::layout::{Irradiance, Photon, Query};
use caustic_kernels::trace::{CameraTile, Vertex};
use caustic_photon_map::{DensitySums, LargestPower, MapError, NEIGHBOURS_AT_ONCE, NearestPower, PhotonMap, Points};

/// Samples whose sums are searched for at once: 32 bytes each while they are sorted.
const SUMS_AT_ONCE: u32 = 1 << 20;

/// Samples that are searched for at once.
pub(crate) fn at_once(settings: &Settings) -> u32 {
    match settings.integrator {
        Integrator::Progressive => SUMS_AT_ONCE,
        _ => NEIGHBOURS_AT_ONCE / (settings.k + 1),
    }
}

/// A batch of camera samples.
struct Batch {
    points: Vec<Points>,
    samples: u64,
    /// The parts of the work on photons that are done and that there are.
    part: (u32, u32),
}

impl Frame<'_> {
    /// Develops a film batch by batch, as far as `progress` lets it.
    pub(crate) fn develop_in_batches(
        &self,
        film: &mut Film<'_>,
        maps: &mut Maps,
        chunk: Chunk,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<(), RenderError> {
        let kinds = PassKind::of(self.settings, self.compiled);
        let (first, end) = (film.unit.first_pixel, film.unit.end());
        // Batches of one size, so that the memory of one serves the next.
        let batches = film.unit.pixels.div_ceil(chunk.pixels(self.settings));
        let pixels = film.unit.pixels.div_ceil(batches);
        while film.next < end {
            let from = film.next;
            let to = end.min(from + pixels);
            let part = ((from - first) / pixels, batches);
            let light = self.look_at(from, to, maps.seed, progress).and_then(|points| {
                let samples = u64::from(to - from) * u64::from(self.settings.spp);
                self.light_of(&Batch { points, samples, part }, &kinds, maps, chunk, progress)
            });
            let light = match light {
                // What there is can be shown.
                Err(RenderError::Interrupted) if from > first => return Ok(()),
                light => light?,
            };
            self.device.trim();
            let known = Light::Known(from, [0, 1].map(|i| light[i].as_deref()));
            if !film.develop(to, known, progress)? {
                return Ok(());
            }
        }
        Ok(())
    }

    /// The points that the camera sees through some pixels.
    fn look_at(
        &self,
        from: u32,
        to: u32,
        seed: u32,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Vec<Points>, RenderError> {
        let Self { device, settings, ref camera, .. } = *self;
        let kernel = self.buffers.kernels.camera;
        let at_once = (at_once(settings) / settings.spp).max(1);
        let mut all = Vec::new();
        for first_pixel in (from..to).step_by(at_once as usize) {
            let pixels = at_once.min(to - first_pixel);
            if !progress(Progress { phase: "look", done: (first_pixel - from).into(), total: (to - from).into() }) {
                return Err(RenderError::Interrupted);
            }
            let count = pixels * settings.spp;
            let tile = CameraTile { first_pixel, pixels, samples: settings.spp, seed };
            let tile = device.upload("camera tile", &[tile])?;
            let queries = device.scratch::<Query>("sample queries", u64::from(count))?;
            let vertices = device.scratch::<Vertex>("sample vertices", u64::from(count))?;
            let mut plan = Plan::new();
            plan.scope("look");
            let from = [&[&tile, camera], &self.buffers.for_camera()[..]].concat();
            plan.each(kernel, count, &[&from[..], &[&queries, &vertices]].concat());
            device.run(&plan)?;
            all.push(Points { queries, count });
        }
        Ok(all)
    }

    /// The light of photons at a batch, by map.
    fn light_of(
        &self,
        batch: &Batch,
        kinds: &[Option<PassKind>; 2],
        maps: &mut Maps,
        chunk: Chunk,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<[Option<Vec<Irradiance>>; 2], RenderError> {
        let mut light = [None, None];
        for (i, kind) in kinds.iter().enumerate() {
            // An empty map stays empty.
            let Some(kind) = kind.as_ref().filter(|_| maps.chunked[i].stored != Some(0)) else { continue };
            let settings = Settings { seed: maps.seed, radius: maps.radius, ..self.settings.clone() };
            let pass = Pass { frame: self, kind, settings: &settings, chunk, part: batch.part };
            let points = batch.points.clone();
            let (estimates, mut report) = match settings.integrator {
                Integrator::Progressive => pass.within(points, &mut maps.chunked[i].largest, progress)?,
                _ => pass.nearest(points, progress)?,
            };
            report.host_bytes += 2 * batch.samples * size_of::<Irradiance>() as u64;
            light[i] = (report.photons_stored > 0).then_some(estimates);
            if maps.chunked[i].stored.is_none() {
                maps.chunked[i].stored = Some(report.photons_stored);
                maps.said.enter(kind, report);
            }
        }
        Ok(light)
    }
}

/// The photons of a map, for a batch.
struct Pass<'a> {
    frame: &'a Frame<'a>,
    kind: &'a PassKind,
    settings: &'a Settings,
    chunk: Chunk,
    part: (u32, u32),
}

impl Pass<'_> {
    /// Estimates from all photons within the radius.
    fn within(
        &self,
        points: Vec<Points>,
        largest: &mut LargestPower,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<(Vec<Irradiance>, MapReport), RenderError> {
        let device = self.frame.device;
        let sums = DensitySums::new(device, points)?;
        loop {
            // Sums are aligned to the largest power of all, which is known when all have come by. Most often it is as good as the first
            // chunk's; if it is not, all come by once more.
            let (mut added, mut wrong) = (false, false);
            let report = self.each(progress, &mut |photons, stored| {
                let (mut map, own) = self.build_below(&photons, stored, *largest)?;
                let misaligned = largest.is_below(&own);
                wrong |= misaligned && added;
                largest.raise(&own);
                if misaligned && !wrong {
                    drop(map);
                    map = self.build_below(&photons, stored, *largest)?.0;
                }
                drop(photons);
                if !wrong {
                    sums.add(&map)?;
                    added = true;
                }
                Ok(map)
            })?;
            if !wrong {
                return Ok((sums.irradiance(self.settings.radius, largest)?, report));
            }
            sums.clear();
        }
    }

    /// Estimates from the k nearest.
    fn nearest(
        &self,
        points: Vec<Points>,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<(Vec<Irradiance>, MapReport), RenderError> {
        let (device, settings) = (self.frame.device, self.settings);
        let mut nearest = NearestPower::new(device, points, settings.k, settings.gather)?;
        let mut most = 0;
        let mut report = self.each(progress, &mut |photons, stored| {
            let records: Vec<Photon> = device.read(&photons, stored.into())?;
            let powers: Vec<_> = records.iter().map(|photon| photon.power).collect();
            drop(records);
            let map = self.build(&photons, stored, PhotonMap::plan)?;
            drop(photons);
            nearest.add(&map, &powers)?;
            most = most.max(size_of_val(&powers[..]) as u64);
            Ok(map)
        })?;
        report.host_bytes = nearest.bytes() + nearest.bytes_while_added() + most;
        Ok((nearest.irradiance(settings.radius), report))
    }

    /// Traces the photons and shows `see` chunk by chunk: photons, and how many. It returns the map that it has made of them.
    fn each(
        &self,
        progress: &mut dyn FnMut(Progress) -> bool,
        see: &mut dyn FnMut(Buffer, u32) -> Result<PhotonMap, RenderError>,
    ) -> Result<MapReport, RenderError> {
        let Self { kind, settings, chunk, part: (done, of), .. } = *self;
        let Frame { device, compiled, buffers, .. } = *self.frame;
        let mut tracing = Tracing::new(device, compiled, buffers, settings.seed, kind)?;
        let mut told = MapReport::new(kind.map, 0);
        let emitted = tracing.emitted();
        let (chunks, paths) = chunk.cut(emitted);
        for first in (0..emitted).step_by(paths as usize) {
            // Who has chunks is short of memory: what the device keeps for later would be as much again.
            device.trim();
            let before = 2 * (u64::from(done) * u64::from(emitted) + u64::from(first));
            let total = 2 * u64::from(of) * u64::from(emitted);
            let mut tick = |paths: u64| progress(Progress { phase: kind.phase, done: before + paths, total });
            let photons = tracing.chunk(first..emitted.min(first + paths), &mut tick)?;
            if let Some((photons, stored)) = photons {
                told.tell(&see(photons, stored)?);
            }
        }
        let MapReport { table_entries, linear, bytes, .. } = told;
        Ok(MapReport { table_entries, linear, bytes, chunks, ..tracing.finish()? })
    }

    /// The map of a chunk.
    fn build<T>(
        &self,
        photons: &Buffer,
        stored: u32,
        plan_map: impl FnOnce(
            &caustic_device::Device,
            &mut Plan,
            &Buffer,
            caustic_kernels::grid::Grid,
        ) -> Result<T, MapError>,
    ) -> Result<T, RenderError> {
        let Frame { device, compiled, .. } = *self.frame;
        let grid = grid(device, compiled, self.settings, photons, stored)?;
        let mut plan = Plan::new();
        plan.scope(self.kind.map);
        let map = plan_map(device, &mut plan, photons, grid)?;
        device.run(&plan)?;
        Ok(map)
    }

    /// The map of a chunk, its powers aligned to `largest`, and their own largest.
    fn build_below(
        &self,
        photons: &Buffer,
        stored: u32,
        largest: LargestPower,
    ) -> Result<(PhotonMap, LargestPower), RenderError> {
        let (map, own) = self.build(photons, stored, |device, plan, photons, grid| {
            PhotonMap::plan_below(device, plan, photons, grid, largest)
        })?;
        Ok((map, LargestPower(self.frame.device.read::<[f32; 3]>(&own, 1)?[0])))
    }
}
