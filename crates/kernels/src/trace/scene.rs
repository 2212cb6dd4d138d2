//! The scene as the kernels see it.

use bytemuck::{Pod, Zeroable};

/// A parallelogram.
pub const PRIMITIVE_QUAD: u32 = 0;
/// A sphere.
pub const PRIMITIVE_SPHERE: u32 = 1;
/// A triangle.
pub const PRIMITIVE_TRIANGLE: u32 = 2;
/// The ellipse that touches the sides of a quad in their middles; a disc if the quad is a square.
pub const PRIMITIVE_DISC: u32 = 3;
/// Ideal diffuse reflection, f_r = ρ/π.
pub const MATERIAL_LAMBERTIAN: u32 = 0;
/// Perfect specular reflection.
pub const MATERIAL_MIRROR: u32 = 1;
/// Smooth dielectric without absorption.
pub const MATERIAL_DIELECTRIC: u32 = 2;
/// A quad that emits the same radiance from every point in every direction of its front side.
pub const LIGHT_AREA: u32 = 0;
/// A point that emits the same intensity in every direction.
pub const LIGHT_POINT: u32 = 1;
/// [`Primitive::light`] of what does not emit.
pub const NO_LIGHT: u32 = 0xffff_ffff;

/// [`Material::texture`] of a material of one colour.
pub const NO_TEXTURE: u32 = 0xffff_ffff;

/// How many of each the scene has.
///
/// The tracing kernels exist twice: BASIC ones know quads and spheres, and lambertian, mirror and dielectric materials of one colour;
/// FULL ones know everything. Both are one body, and give a scene that BASIC ones can trace the same bits.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SceneInfo {
    /// Number of primitives.
    pub primitives: u32,
    /// Number of lights.
    pub lights: u32,
    /// Number of specular objects at which caustic photons are aimed.
    pub targets: u32,
    /// Number of nodes of the tree, of each of its lists.
    pub nodes: u32,
    /// Lists of nodes: 8, 4, 2 or 1. BASIC kernels take it for 8.
    pub lists: u32,
    /// First primitive that has [`Corners`](super::Corners): those from here on are triangles with normals and texture coordinates.
    pub first_corners: u32,
}

/// A quad, a sphere, a triangle or a disc.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Primitive {
    /// One of the `PRIMITIVE_` constants.
    pub kind: u32,
    /// Index of its material.
    pub material: u32,
    /// Index of its light, or [`NO_LIGHT`].
    pub light: u32,
    /// Radius of a sphere, m. How far a quad or disc reaches beyond its edges, in lengths of them: as far as rounding goes, so that
    /// quads that share an edge leave no crack between them. The part of the way to its middle by which a triangle draws hits in.
    pub size: f32,
    /// Centre, m; of a triangle its first corner.
    pub position: [f32; 3],
    /// Unit normal of what is flat: u × v, its front side, from which a triangle's corners are seen counter-clockwise.
    pub normal: [f32; 3],
    /// Of a quad or disc the dual vectors of its edges u and v, m⁻¹: their products with (point − centre) are the point's coordinates along
    /// u and v, −½ to ½. Of a triangle its second and third corner, m.
    pub sides: [[f32; 3]; 2],
}

/// What a surface does with light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Material {
    /// Reflectance, 0 to 1, for each of red, green and blue; of a dielectric, 1.
    pub reflectance: [f32; 3],
    /// [`MATERIAL_LAMBERTIAN`], [`MATERIAL_MIRROR`] or [`MATERIAL_DIELECTRIC`].
    pub kind: u32,
    /// Index of refraction of a dielectric against the medium outside.
    pub ior: f32,
    /// Chance with which a photon survives here: the largest reflectance, so that its power never grows.
    pub survival: f32,
    /// Index of the texture that [`reflectance`](Self::reflectance) is multiplied with, or [`NO_TEXTURE`].
    pub texture: u32,
    /// Index of the texture of which green multiplies a roughness and blue a metalness, as in glTF, or [`NO_TEXTURE`].
    pub roughness_texture: u32,
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
    assert!(size_of::<SceneInfo>() == 24);
    assert!(size_of::<Primitive>() == 64);
    assert!(size_of::<Material>() == 32);
    assert!(size_of::<Light>() == 80);
    assert!(size_of::<Target>() == 16);
};
