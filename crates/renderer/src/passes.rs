//! The passes of a render by themselves, for those who put something else between them.

use crate::buffers::SceneBuffers;
use crate::output::Image;
use crate::photons::PassKind;
use crate::scene::Scene;
use crate::trace::trace;
use crate::{RenderError, Show};
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::layout::{Irradiance, Photon, Query};
use caustic_kernels::trace::{CameraTile, FilmTile, PART_GLOBAL, Pixel, Vertex};

/// Traces the photons of [`Show::MapGlobal`], all that land, or of [`Show::MapCaustic`], those that meet mirrors or glass first: in the
/// order of their paths. `emitted` photons share the power of the lights.
///
/// # Errors
/// [`RenderError::NoPhotons`], [`RenderError::TooManyPhotons`] and those of devices.
pub fn trace_photons(
    device: &Device,
    scene: &Scene,
    show: Show,
    emitted: u32,
    seed: u32,
) -> Result<Vec<Photon>, RenderError> {
    let scene = scene.compile();
    let buffers = SceneBuffers::new(device, &scene)?;
    let kind = if show == Show::MapCaustic {
        PassKind::caustic(emitted, show)
    } else {
        PassKind::global(emitted, show, false)
    };
    let (photons, report) = trace(device, &scene, &buffers, seed, &kind, &mut |_| true)?;
    photons.map_or(Ok(Vec::new()), |photons| Ok(device.read(&photons, u64::from(report.photons_stored))?))
}

/// What a camera sees: a point of a diffuse surface for each sample of each pixel, or nothing.
pub struct View {
    /// Records of [`Query`], the samples of a pixel one after another.
    pub queries: Buffer,
    vertices: Buffer,
    size: [u32; 2],
    samples: u32,
}

impl View {
    /// Traces the camera paths of a picture of `size` pixels with `samples` a pixel.
    ///
    /// # Errors
    /// Those of devices.
    pub fn new(device: &Device, scene: &Scene, size: [u32; 2], samples: u32, seed: u32) -> Result<Self, RenderError> {
        let [width, height] = size;
        let count = width * height * samples;
        let buffers = SceneBuffers::new(device, &scene.compile())?;
        let tile = CameraTile { first_pixel: 0, pixels: width * height, samples, seed };
        let tile = device.upload("camera tile", &[tile])?;
        let camera = device.upload("camera", &[scene.camera(width, height)])?;
        let queries = device.buffer::<Query>("sample queries", u64::from(count))?;
        let vertices = device.buffer::<Vertex>("sample vertices", u64::from(count))?;
        let mut plan = Plan::new();
        let seen = [&queries, &vertices];
        plan.each(buffers.kernels.camera, count, &[&[&tile, &camera], &buffers.for_camera()[..], &seen].concat());
        device.run(&plan)?;
        Ok(Self { queries, vertices, size, samples })
    }

    /// Number of queries.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.size[0] * self.size[1] * self.samples
    }

    /// The picture that estimates at its queries make: a direct visualisation of photons.
    ///
    /// # Errors
    /// Those of devices.
    ///
    /// # Panics
    /// If there are not as many estimates as queries.
    pub fn develop(&self, device: &Device, estimates: &[Irradiance]) -> Result<Image, RenderError> {
        assert_eq!(estimates.len(), self.count() as usize, "an estimate for each query");
        let [width, height] = self.size;
        let pixels = width * height;
        let tile = FilmTile { first_pixel: 0, pixels, samples: self.samples, parts: PART_GLOBAL };
        let tile = device.upload("camera tile of film", &[tile])?;
        let global = device.upload("sample global", estimates)?;
        let nothing = device.buffer::<Irradiance>("sample direct", 0)?;
        let film = device.buffer::<Pixel>("film", u64::from(pixels))?;
        let mut plan = Plan::new();
        plan.each(Kernel::DevelopFilm, pixels, &[&tile, &self.vertices, &nothing, &global, &nothing, &film]);
        device.run(&plan)?;
        let film: Vec<Pixel> = device.read(&film, u64::from(pixels))?;
        Ok(Image { width, height, rgb: film.iter().map(|pixel| pixel.rgb).collect() })
    }
}
