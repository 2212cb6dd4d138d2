//! What a case needs before it can be measured: the test scene, its photons and the queries of its pictures.

use crate::case::Map;
use caustic_bench::Trouble;
use caustic_device::Device;
use caustic_kernels::layout::{Photon, Query};
use caustic_renderer::scene::Scene;
use caustic_renderer::{Show, View, trace_photons};
use caustic_rivals::Photons;

/// Paths that tell how many photons a path leaves.
const PROBE: u32 = 1 << 16;

/// The thesis's test scene on the device that measures and on the CPU.
pub struct Stage<'a> {
    /// Where most is measured.
    pub device: &'a Device,
    /// Where the rest is.
    pub cpu: Device,
    scene: Scene,
    /// The photons of each map, as many as were asked for so far.
    traced: [Vec<Photon>; 2],
    uploaded: Option<Uploaded>,
    view: Option<([u32; 2], View, Vec<Query>)>,
}

/// The photons of one case.
struct Uploaded {
    map: Map,
    count: u32,
    on_cpu: bool,
    photons: Photons,
}

impl<'a> Stage<'a> {
    /// The scene of section 4.4.
    ///
    /// # Errors
    /// Never, as long as the built-in scene is what it was.
    pub fn new(device: &'a Device) -> Result<Self, Trouble> {
        let scene = Scene::load("cornell").map_err(|error| Trouble::Fail(error.to_string()))?;
        Ok(Self { device, cpu: Device::cpu(), scene, traced: [Vec::new(), Vec::new()], uploaded: None, view: None })
    }

    /// The device of a case.
    #[must_use]
    pub fn device_of(&self, on_cpu: bool) -> &Device {
        if on_cpu { &self.cpu } else { self.device }
    }

    /// Puts the first `count` photons of a map on a device. Their powers are those of so many paths as left them.
    ///
    /// # Errors
    /// Those of devices.
    pub fn photons(&mut self, map: Map, count: u32, on_cpu: bool) -> Result<(), Trouble> {
        let fits = |of: &Uploaded| of.map == map && of.count == count && of.on_cpu == on_cpu;
        if !self.uploaded.as_ref().is_some_and(fits) {
            self.uploaded = None;
            let photons = self.first(map, count)?;
            let photons = Photons::upload(self.device_of(on_cpu), &photons)?;
            self.uploaded = Some(Uploaded { map, count, on_cpu, photons });
        }
        Ok(())
    }

    /// The first `count` photons of a map.
    ///
    /// # Errors
    /// Those of devices.
    pub fn first(&mut self, map: Map, count: u32) -> Result<Vec<Photon>, Trouble> {
        self.trace(map, count)?;
        let all = &self.traced[map as usize];
        // Each of fewer photons carries more.
        let share = all.len() as f32 / count as f32;
        let scaled = |photon: &Photon| Photon { power: photon.power.map(|power| power * share), ..*photon };
        Ok(all[..count as usize].iter().map(scaled).collect())
    }

    /// The photons that were put there last.
    ///
    /// # Panics
    /// If none were.
    #[must_use]
    pub fn uploaded(&self) -> &Photons {
        &self.uploaded.as_ref().expect("photons are uploaded first").photons
    }

    /// Sees that there are `count` photons of a map.
    fn trace(&mut self, map: Map, count: u32) -> Result<(), Trouble> {
        let traced = &mut self.traced[map as usize];
        let show = match map {
            Map::Global => Show::MapGlobal,
            Map::Caustic => Show::MapCaustic,
        };
        let mut emitted = PROBE;
        while traced.len() < count as usize {
            *traced = trace_photons(self.device, &self.scene, show, emitted, 0)?;
            // A little more than it should take.
            emitted = (f64::from(emitted) * f64::from(count) / traced.len().max(1) as f64 * 1.02) as u32 + PROBE;
        }
        Ok(())
    }

    /// Looks at the scene through a picture of `size` pixels, a query each. Returns the queries.
    ///
    /// # Errors
    /// Those of devices.
    pub fn look(&mut self, size: [u32; 2]) -> Result<&[Query], Trouble> {
        if self.view.as_ref().is_none_or(|view| view.0 != size) {
            self.view = None;
            let view = View::new(self.device, &self.scene, size, 1, 0)?;
            let queries = self.device.read(&view.queries, u64::from(view.count()))?;
            self.view = Some((size, view, queries));
        }
        Ok(self.view().1)
    }

    /// The picture that was looked through last, and its queries.
    ///
    /// # Panics
    /// If none was.
    #[must_use]
    pub fn view(&self) -> (&View, &[Query]) {
        let (_, view, queries) = self.view.as_ref().expect("one looks before one sees");
        (view, queries)
    }
}
