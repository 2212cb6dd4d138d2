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
/// A point that shines within a cone, less towards its rim.
pub const LIGHT_SPOT: u32 = 2;
/// Parallel light of one direction, as from a sun that is infinitely far away.
pub const LIGHT_DIRECTIONAL: u32 = 3;
/// A sphere whose outside emits the same radiance everywhere and in every direction.
pub const LIGHT_SPHERE: u32 = 4;
/// A triangle that emits as [`LIGHT_AREA`] does.
pub const LIGHT_TRIANGLE: u32 = 5;
/// A disc, or an ellipse, that emits as [`LIGHT_AREA`] does.
pub const LIGHT_DISC: u32 = 6;
/// Radiance from every direction, from infinitely far away, by a picture. A scene has one at most.
pub const LIGHT_ENVIRONMENT: u32 = 7;
/// [`Primitive::light`] of what does not emit.
pub const NO_LIGHT: u32 = 0xffff_ffff;

/// [`Material::texture`] of a material of one colour.
pub const NO_TEXTURE: u32 = 0xffff_ffff;

/// How many of each the scene has.
///
/// All tracing kernels know quads and spheres, lambertian, mirror and clear dielectric materials of one colour, lights of quads and points, pinholes and
/// lenses. What else there is they know by their mask: see [`known`](super::known).
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
    /// Lists of nodes: 8, 4, 2 or 1. Kernels that do not know [`MESHES`](super::known::MESHES) take it for 8.
    pub lists: u32,
    /// First primitive that has [`Corners`](super::Corners): those from here on are triangles with normals and texture coordinates.
    pub first_corners: u32,
    /// Index of the light that is the environment, or [`NO_LIGHT`].
    pub environment: u32,
    /// Index of the environment's picture. After the picture's texels there are tables, of sums of chances in [`Texel::rg`](super::Texel::rg) and the
    /// chances in [`Texel::ba`](super::Texel::ba), as bits of floats that are multiples of 2⁻²⁴: one of its rows, then one a row of its pixels.
    pub sky: u32,
    /// 1 if there are materials with holes, [`Material::alpha_cutoff`], and 0 otherwise.
    pub holes: u32,
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
    /// Reflectance, 0 to 1, for each of red, green and blue; of a dielectric, 1; the base colour of a layered material.
    pub reflectance: [f32; 3],
    /// One of the `MATERIAL_` kinds.
    pub kind: u32,
    /// Index of refraction of a dielectric, or of a layered material's coat, against the medium outside.
    pub ior: f32,
    /// Chance with which a photon survives here: the largest reflectance, so that its power never grows. Of a layered material, 0 if
    /// it is black and 1 otherwise: its survival depends on the direction.
    pub survival: f32,
    /// Index of the texture that [`reflectance`](Self::reflectance) is multiplied with, or [`NO_TEXTURE`].
    pub texture: u32,
    /// Index of the texture of which green multiplies a roughness and blue a metalness, as in glTF, or [`NO_TEXTURE`].
    pub roughness_texture: u32,
    /// GGX roughness α of a rough dielectric or a layered material; below [`SMOOTHEST`](super::bsdf::SMOOTHEST) it is smooth.
    pub roughness: f32,
    /// Share of a layered material that is metal, 0 to 1.
    pub metallic: f32,
    /// Absorption coefficient of the inside of a dielectric, m⁻¹, for each of red, green and blue.
    pub absorption: [f32; 3],
    /// Index of the texture that bends the shading normal, as in glTF: red to the right, green up, blue along the normal, each
    /// from −1 to 1 as 0 to 1; or [`NO_TEXTURE`].
    pub normal_texture: u32,
    /// What red and green of that are multiplied with.
    pub normal_scale: f32,
    /// The surface has holes where the alpha of [`texture`](Self::texture) is below this; 0 if it has none.
    pub alpha_cutoff: f32,
}

/// A light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Light {
    /// Radiance of a surface, W·sr⁻¹·m⁻², intensity of a point or, on its axis, a spot, W·sr⁻¹, irradiance across a directional
    /// light, W·m⁻², or what an environment's picture is multiplied with to give its radiance; for each of red, green and blue.
    pub emission: [f32; 3],
    /// One of the `LIGHT_` kinds.
    pub kind: u32,
    /// Corner of a flat light, centre of a disc or sphere, place of a point or spot, middle of the disc from which a directional
    /// light's photons come, or middle of the scene of an environment, m.
    pub position: [f32; 3],
    /// Index of the primitive that emits, or [`NO_LIGHT`].
    pub primitive: u32,
    /// Edges of a flat light that leave its corner, or two radii of a disc across each other, m. Of a sphere and of the disc from which photons
    /// of a directional light or an environment come, the first number is the radius, m; of a spot, the first two are 1 − cos of the angles
    /// within which it is bright and outside of which it is dark. The second three of an environment begin with the cosine and the sine of the
    /// angle by which it is turned about y.
    pub edges: [[f32; 3]; 2],
    /// Side to which a flat light emits, axis of a spot, or the direction in which directional light travels: a unit vector.
    pub normal: [f32; 3],
    /// Area of a surface or of the disc from which photons of a directional light or an environment come, m².
    pub area: f32,
    /// Chance of choosing this light.
    pub probability: f32,
    /// Sum of the chances of this light and those before it; exactly 1 for the last.
    pub cumulative: f32,
    /// The first of the photons that this light emits in a pass.
    pub first_photon: u32,
    /// How many photons it emits in the pass.
    pub photons: u32,
    /// The first of the targets that it can see.
    pub first_target: u32,
    /// How many targets it can see: they follow each other.
    pub targets: u32,
    /// Index of the texture that the emission of a flat light is multiplied with, or [`NO_TEXTURE`].
    pub texture: u32,
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
    assert!(size_of::<SceneInfo>() == 36);
    assert!(size_of::<Primitive>() == 64);
    assert!(size_of::<Material>() == 64);
    assert!(size_of::<Light>() == 100);
    assert!(size_of::<Target>() == 16);
};
