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
        Ok(Self { device, cpu: Device::cpu(), scene, uploaded: None, view: None })
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

    /// The first `count` photons of a map: the same, whatever was asked for before.
    ///
    /// # Errors
    /// Those of devices.
    pub fn first(&mut self, map: Map, count: u32) -> Result<Vec<Photon>, Trouble> {
        let show = match map {
            Map::Global => Show::MapGlobal,
            Map::Caustic => Show::MapCaustic,
        };
        let mut emitted = PROBE;
        loop {
            let mut photons = trace_photons(self.device, &self.scene, show, emitted, 0)?;
            let stored = photons.len() as u32;
            if stored >= count {
                photons.truncate(count as usize);
                // Each of fewer photons carries more.
                let share = stored as f32 / count as f32;
                for photon in &mut photons {
                    photon.power = photon.power.map(|power| power * share);
                }
                return Ok(photons);
            }
            // A little more than it should take.
            emitted = (f64::from(emitted) * f64::from(count) / f64::from(stored.max(1)) * 1.02) as u32 + PROBE;
        }
    }

    /// The photons that were put there last.
    ///
    /// # Panics
    /// If none were.
    #[must_use]
    pub fn uploaded(&self) -> &Photons {
        &self.uploaded.as_ref().expect("photons are uploaded first").photons
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
