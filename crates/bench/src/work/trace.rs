//! Tracing photons: count, scan, store.

use super::{Trouble, Units, Work, timed};
use crate::digest::Digest;
use crate::row::Sample;
use caustic_device::{Buffer, Device, Plan};
use caustic_kernels::layout::Photon;
use caustic_kernels::sort::SCAN_BLOCK;
use caustic_kernels::trace::{PhotonPass, RAY_GLOBAL, Tally};
use caustic_photon_map::scan;
use caustic_renderer::SceneBuffers;
use caustic_renderer::scene::{CompiledScene, Scene};

/// Paths of one dispatch: few enough for a GPU's watchdog, enough to fill it.
const CHUNK: u32 = 1 << 20;
/// Photons whose position and power are checked.
const CHECKED: usize = 1 << 16;

pub(super) struct Trace<'a> {
    device: &'a Device,
    scene: CompiledScene,
    plan: Plan,
    photons: Buffer,
    stored: u32,
    /// Rays of all paths.
    segments: u64,
}

impl<'a> Trace<'a> {
    pub(super) fn new(device: &'a Device, n: u32, scene: &str) -> Result<Self, Trouble> {
        let scene = Scene::load(scene).map_err(|error| Trouble::Fail(error.to_string()))?.compile();
        let scene_buffers = SceneBuffers::new(device, &scene)?;
        let kernels = scene_buffers.kernels;
        let counts = device.scratch::<u32>("photon counts", n.into())?;
        let fates = device.scratch::<u32>("photon fates", n.min(CHUNK).into())?;
        let segments = device.scratch::<u32>("photon segments", n.min(CHUNK).into())?;
        let tallies = device.scratch::<Tally>("photon tallies", n.min(CHUNK).into())?;
        let lights = device.upload("lights of a pass", &scene.lights_for(n, RAY_GLOBAL))?;
        let mut passes = Vec::new();
        for first in (0..n).step_by(CHUNK as usize) {
            let paths = CHUNK.min(n - first);
            let pass =
                PhotonPass { emitted: n, first, paths, rays: RAY_GLOBAL, seed: 0, stored_from: 0, thin: 1, chunk: 0 };
            passes.push((paths, device.upload("photon pass", &[pass])?));
        }
        let mut plan = Plan::new();
        let mut walked = 0;
        plan.scope("count");
        for (paths, pass) in &passes {
            let outputs = [&counts, &fates, &segments, &tallies];
            let buffers = [&[pass], &scene_buffers.for_photons(&lights)[..], &outputs].concat();
            plan.each(kernels.count, *paths, &buffers);
            // What a pass counts is overwritten by the next: summed here, once.
            let mut once = Plan::new();
            once.each(kernels.count, *paths, &buffers);
            device.run(&once)?;
            let counted: Vec<u32> = device.read(&segments, u64::from(*paths))?;
            walked += counted.into_iter().map(u64::from).sum::<u64>();
        }
        plan.scope("scan");
        let [offsets, block_offsets, totals] = scan(device, &mut plan, &counts, n)?;
        // Once before anything is measured: it says how many photons there will be.
        device.run(&plan)?;
        let totals: Vec<u32> = device.read(&totals, n.div_ceil(SCAN_BLOCK).into())?;
        let stored = totals.iter().map(|&total| u64::from(total)).sum::<u64>();
        let photons = device.scratch::<Photon>("photons", stored)?;
        plan.scope("store");
        for (paths, pass) in &passes {
            let places = [&counts, &offsets, &block_offsets, &photons];
            plan.each(kernels.store, *paths, &[&[pass], &scene_buffers.for_photons(&lights)[..], &places].concat());
        }
        Ok(Self { device, scene, plan, photons, stored: stored as u32, segments: walked })
    }

    fn read(&self) -> Result<Vec<Photon>, Trouble> {
        Ok(self.device.read(&self.photons, self.stored.into())?)
    }
}

impl Work for Trace<'_> {
    fn run(&mut self) -> Result<Sample, Trouble> {
        timed(self.device, &self.plan)
    }

    fn digest(&mut self) -> Result<String, Trouble> {
        let mut digest = Digest::default();
        digest.add(&self.read()?);
        Ok(digest.hex())
    }

    /// There is no brute force for a path. What can be said without one: photons lie on diffuse surfaces and carry power.
    fn check(&mut self) -> Result<(usize, usize), Trouble> {
        let photons = self.read()?;
        let checked = &photons[..photons.len().min(CHECKED)];
        let (low, high) = self.scene.diffuse_bounds;
        let wrong = checked.iter().filter(|photon| {
            let inside = (0..3).all(|axis| (low[axis]..=high[axis]).contains(&photon.position[axis]));
            let power = photon.power.iter().all(|power| power.is_finite() && *power >= 0.0);
            !inside || !power || photon.primitive >= self.scene.info.primitives
        });
        Ok((checked.len(), wrong.count()))
    }

    /// Rays of all paths, each walked twice: once to count what it stores and once to store it.
    fn units(&self) -> Units {
        Units { count: 2.0 * self.segments as f64, name: "segments", parts: &["count", "store"] }
    }

    /// Paths are bound by arithmetic.
    fn bytes(&self) -> Option<u64> {
        None
    }
}
