//! A scene in a device's buffers, and the kernels that trace it.

use crate::scene::CompiledScene;
use caustic_device::{Buffer, Device, Error, Kernel, Masked};

/// The tracing kernels, with what they know.
#[derive(Clone, Copy, Debug)]
pub struct Tracers {
    /// Counts what photon paths store.
    pub count: Masked,
    /// Stores it.
    pub store: Masked,
    /// Follows camera paths.
    pub camera: Masked,
    /// Shades what they found.
    pub direct: Masked,
    /// Follows paths to the lights.
    pub paths: Masked,
    /// Follows rays of the final gather.
    pub gather: Masked,
}

impl Tracers {
    /// Those that know what a mask of [`known`](caustic_kernels::trace::known) says.
    #[must_use]
    pub fn knowing(mask: u32) -> Self {
        Self {
            count: Kernel::CountPhotons.knowing(mask),
            store: Kernel::StorePhotons.knowing(mask),
            camera: Kernel::TraceCamera.knowing(mask),
            direct: Kernel::ShadeDirect.knowing(mask),
            paths: Kernel::TracePaths.knowing(mask),
            gather: Kernel::TraceGather.knowing(mask),
        }
    }
}

/// The scene in a device's buffers.
pub struct SceneBuffers {
    /// The kernels that the scene needs, and no more.
    pub kernels: Tracers,
    /// A `SceneInfo`.
    pub info: Buffer,
    /// `BvhNode`s.
    pub nodes: Buffer,
    /// `Primitive`s.
    pub primitives: Buffer,
    /// `Material`s.
    pub materials: Buffer,
    /// `Light`s.
    pub lights: Buffer,
    /// `Target`s.
    pub targets: Buffer,
    /// `Corners`.
    pub corners: Buffer,
    /// `Texture`s.
    pub textures: Buffer,
    /// `Texel`s.
    pub texels: Buffer,
}

impl SceneBuffers {
    /// Uploads a scene.
    ///
    /// # Errors
    /// Those of devices.
    pub fn new(device: &Device, scene: &CompiledScene) -> Result<Self, Error> {
        Ok(Self {
            kernels: Tracers::knowing(scene.known),
            info: device.upload("scene: info", &[scene.info])?,
            nodes: device.upload("scene: nodes", &scene.nodes)?,
            primitives: device.upload("scene: primitives", &scene.primitives)?,
            materials: device.upload("scene: materials", &scene.materials)?,
            lights: device.upload("scene: lights", &scene.lights)?,
            targets: device.upload("scene: targets", &scene.targets)?,
            corners: device.upload("scene: corners", &scene.corners)?,
            textures: device.upload("scene: textures", &scene.textures)?,
            texels: device.upload("scene: texels", &scene.texels)?,
        })
    }

    /// What the kernels of photons take after their pass; `lights` are those of [`CompiledScene::lights_for`].
    #[must_use]
    pub fn for_photons<'a>(&'a self, lights: &'a Buffer) -> [&'a Buffer; 9] {
        let Self { info, nodes, primitives, materials, targets, corners, textures, texels, .. } = self;
        [info, nodes, primitives, materials, lights, targets, corners, textures, texels]
    }

    /// What the kernels of camera samples take after their parameters.
    #[must_use]
    pub fn for_camera(&self) -> [&Buffer; 8] {
        let Self { info, nodes, primitives, materials, lights, corners, textures, texels, .. } = self;
        [info, nodes, primitives, materials, lights, corners, textures, texels]
    }
}
