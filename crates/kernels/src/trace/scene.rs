//! The scene as the kernels see it.

use bytemuck::{Pod, Zeroable};

/// A parallelogram.
pub const PRIMITIVE_QUAD: u32 = 0;
/// A sphere.
pub const PRIMITIVE_SPHERE: u32 = 1;
/// Ideal diffuse reflection, f_r = ρ/π.
pub const MATERIAL_LAMBERTIAN: u32 = 0;
/// Perfect specular reflection.
pub const MATERIAL_MIRROR: u32 = 1;
/// Smooth dielectric.
pub const MATERIAL_DIELECTRIC: u32 = 2;
/// Dielectric with a rough surface, of GGX microfacets.
pub const MATERIAL_ROUGH_DIELECTRIC: u32 = 3;
/// Reflection at GGX microfacets or a smooth coat, over a diffuse base: metals, plastic, glTF's metallic-roughness model.
pub const MATERIAL_LAYERED: u32 = 4;
/// A quad that emits the same radiance from every point in every direction of its front side.
pub const LIGHT_AREA: u32 = 0;
/// A point that emits the same intensity in every direction.
pub const LIGHT_POINT: u32 = 1;
/// [`Primitive::light`] of what does not emit.
pub const NO_LIGHT: u32 = 0xffff_ffff;

/// How many of each the scene has.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SceneInfo {
    /// Number of primitives.
    pub primitives: u32,
    /// Number of lights.
    pub lights: u32,
    /// Number of specular objects at which caustic photons are aimed.
    pub targets: u32,
    /// Number of nodes of the tree for each octant of directions.
    pub nodes: u32,
}

/// A quad or a sphere.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Primitive {
    /// [`PRIMITIVE_QUAD`] or [`PRIMITIVE_SPHERE`].
    pub kind: u32,
    /// Index of its material.
    pub material: u32,
    /// Index of its light, or [`NO_LIGHT`].
    pub light: u32,
    /// Radius of a sphere, m. How far a quad reaches beyond its edges, in lengths of them: as far as rounding goes, so that quads
    /// that share an edge leave no crack between them.
    pub size: f32,
    /// Centre, m.
    pub position: [f32; 3],
    /// Unit normal of a quad: u × v, its front side.
    pub normal: [f32; 3],
    /// Dual vectors of a quad's edges u and v, m⁻¹: their products with (point − centre) are the point's coordinates along u and v, −½ to ½.
    pub duals: [[f32; 3]; 2],
}

/// What a surface does with light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Material {
    /// Reflectance, 0 to 1, for each of red, green and blue; of a dielectric, 1; the base colour of a layered material.
    pub reflectance: [f32; 3],
    /// One of the `MATERIAL_` kinds.
    pub kind: u32,
    /// Index of refraction of a dielectric, or of a layered material's coat, against the medium outside.
    pub ior: f32,
    /// Chance with which a photon survives here: the largest reflectance, so that its power never grows. Of a layered material, 0 if
    /// it is black and 1 otherwise: its survival depends on the direction.
    pub survival: f32,
    /// GGX roughness α of a rough dielectric or a layered material; below [`SMOOTHEST`](super::bsdf::SMOOTHEST) it is smooth.
    pub roughness: f32,
    /// Share of a layered material that is metal, 0 to 1.
    pub metallic: f32,
    /// Absorption coefficient of the inside of a dielectric, m⁻¹, for each of red, green and blue.
    pub absorption: [f32; 3],
}

/// A light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Light {
    /// Radiance of an area light, W·sr⁻¹·m⁻², or intensity of a point light, W·sr⁻¹, for each of red, green and blue.
    pub emission: [f32; 3],
    /// [`LIGHT_AREA`] or [`LIGHT_POINT`].
    pub kind: u32,
    /// Corner of an area light or place of a point light, m.
    pub position: [f32; 3],
    /// Index of the primitive that emits, or [`NO_LIGHT`] for a point light.
    pub primitive: u32,
    /// Edges of an area light, m.
    pub edges: [[f32; 3]; 2],
    /// Side to which an area light emits, a unit vector.
    pub normal: [f32; 3],
    /// Area of an area light, m².
    pub area: f32,
    /// Chance of choosing this light.
    pub probability: f32,
    /// Sum of the chances of this light and those before it; exactly 1 for the last.
    pub cumulative: f32,
}

/// The sphere around a specular object, at which caustic photons are aimed.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Target {
    /// Centre, m.
    pub centre: [f32; 3],
    /// Radius, m.
    pub radius: f32,
}

const _: () = {
    assert!(size_of::<SceneInfo>() == 16);
    assert!(size_of::<Primitive>() == 64);
    assert!(size_of::<Material>() == 44);
    assert!(size_of::<Light>() == 80);
    assert!(size_of::<Target>() == 16);
};
