//! The TOML format, field by field, before anything is checked. docs/scene-format.md is its reference for users.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

/// A scene needs a camera, at least one surface (quad, sphere, disc or mesh) and at least one light: a surface with a `radiance`, or one of `lights`.
/// Lengths are metres, from −10⁹ to 10⁹; colours are linear `[red, green, blue]` with the primaries of sRGB.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    /// What the scene shows, in one line.
    #[serde(default)]
    pub description: String,
    /// Scene files whose materials, surfaces and lights are part of the scene, relative to this one.
    #[serde(default)]
    pub include: Vec<String>,
    /// Where the picture is taken from. Files that are included have none.
    pub camera: Option<CameraTable>,
    /// Defaults for the settings of a render.
    #[serde(default)]
    pub render: RenderTable,
    /// Materials by name.
    #[serde(default)]
    pub materials: BTreeMap<String, MaterialTable>,
    /// Parallelograms. A scene may have 4194304 surfaces, triangles included.
    #[serde(default)]
    pub quads: Vec<QuadTable>,
    /// Spheres.
    #[serde(default)]
    pub spheres: Vec<SphereTable>,
    /// Discs.
    #[serde(default)]
    pub discs: Vec<DiscTable>,
    /// Meshes of triangles.
    #[serde(default)]
    pub meshes: Vec<MeshTable>,
    /// Meshes once more, elsewhere.
    #[serde(default)]
    pub instances: Vec<InstanceTable>,
    /// Lights that are not surfaces. With quads, spheres, discs and triangles that emit there may be 4096.
    #[serde(default)]
    pub lights: Vec<LightTable>,
}

/// `[camera]`: a pinhole camera, or one with a thin lens.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraTable {
    /// Where it stands, m; not inside of a dielectric sphere.
    pub position: Numbers<3>,
    /// What is in the middle of the picture, m; not the position.
    pub target: Numbers<3>,
    /// The direction that points up in the picture, of any length, not along the view; `[0, 1, 0]` if it is not given.
    pub up: Option<Numbers<3>>,
    /// Angle between the picture's lower and upper edge, 0.01 to 179 degrees.
    pub vertical_fov_degrees: f64,
    /// Radius of a thin lens, 0 to 10⁹ m: what is not in focus is blurred; 0, a pinhole, if it is not given.
    pub lens_radius: Option<f64>,
    /// Distance along the view to the plane that is in focus, 10⁻⁶ to 10⁹ m; that of the target if it is not given.
    pub focus_distance: Option<f64>,
}

/// `[render]`: defaults for the settings of a render, which the command line's flags override.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RenderTable {
    /// Width and height of the picture, each 1 to 65536 pixels.
    pub size: Option<Numbers<2>>,
    /// Photons emitted for the global map, 1 to 2²⁹.
    pub photons: Option<i64>,
    /// Photons emitted for the caustic map, 0 to 2²⁹.
    pub caustic_photons: Option<i64>,
    /// Photons in an estimate, at most; 1 to 1024.
    pub k: Option<i64>,
    /// Radius within which an estimate looks for photons, m; above 0.
    pub radius: Option<f64>,
    /// Samples a pixel, 1 to 65536.
    pub spp: Option<i64>,
}

/// `[materials.NAME]`: what a surface does with light.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialTable {
    /// Which kind it is.
    pub kind: MaterialKind,
    /// Share of the light that is reflected, 0 to 1, for each of red, green and blue; of a conductor, head on. The base colour of plastic and of
    /// the metallic-roughness model. Must be given, but not of a dielectric.
    pub reflectance: Option<Numbers<3>>,
    /// Index of refraction: of a dielectric, 0.1 to 10, which must be given, a rough one's not nearer to 1 than 0.05; of a coat, 1 to 10, 1.5 if it
    /// is not given.
    pub ior: Option<f64>,
    /// A PNG or JPEG file (sRGB, 8 bits), relative to the scene's, that the reflectance is multiplied with; not of a dielectric. By the texture
    /// coordinates of a mesh, or from corner to corner of a quad or disc; spheres have none.
    pub texture: Option<String>,
    /// Another whose green multiplies `roughness` and whose blue multiplies `metallic`, as in glTF.
    pub roughness_texture: Option<String>,
    /// Another that bends the normal, as in glTF: red to the right, green up, blue along the normal.
    pub normal_texture: Option<String>,
    /// What red and green of that are multiplied with, 0 to 100; 1 if it is not given.
    pub normal_scale: Option<f64>,
    /// Another that the radiance of surfaces that emit is multiplied with.
    pub emission_texture: Option<String>,
    /// Alpha of `texture`, 0.001 to 1, below which the surface has holes; none if it is not given. Not of a surface that emits.
    pub alpha_cutoff: Option<f64>,
    /// Perceptual roughness, 0 to 1: the square root of the GGX α, as in glTF; below 0.032 a surface is smooth. 0 if it is not given, and 1 of the
    /// metallic-roughness model.
    pub roughness: Option<f64>,
    /// Share that is metal, 0 to 1, of the metallic-roughness model; 1 if it is not given.
    pub metallic: Option<f64>,
    /// Absorption coefficients of the inside of a dielectric, 0 to 10⁷ m⁻¹: after d metres the share e^(−absorption · d) is left (Beer–Lambert);
    /// 0 if they are not given.
    pub absorption: Option<Numbers<3>>,
}

/// The kinds of materials.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum MaterialKind {
    /// Reflects `reflectance` of the light, evenly in all directions.
    Lambertian,
    /// Reflects `reflectance` of the light as a mirror.
    Mirror,
    /// Glass or water: reflects and refracts by Fresnel's equations; `ior`, `roughness`, `absorption`.
    Dielectric,
    /// Metal: reflects `reflectance` head on and more at grazing angles (Schlick 1994); `roughness`.
    Conductor,
    /// A coat of `ior` and `roughness` over a diffuse base of `reflectance`.
    Plastic,
    /// The model of glTF 2.0: plastic at `metallic = 0`, a conductor at 1, with the base colour as `reflectance`.
    MetallicRoughness,
}

/// `[[quads]]`: a parallelogram, whose front is the side to which `edge_u` × `edge_v` points. That matters only if it emits: from its front alone, with
/// the power π · radiance · area.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct QuadTable {
    /// What messages call it.
    pub name: Option<String>,
    /// One of its corners, m.
    pub corner: Numbers<3>,
    /// From that corner to the next, at least 10⁻⁶ m.
    pub edge_u: Numbers<3>,
    /// From that corner to the one before, at least 10⁻⁶ m; not parallel to `edge_u`.
    pub edge_v: Numbers<3>,
    /// Its material; a quad that emits may have none and is then black.
    pub material: Option<String>,
    /// Radiance that the front emits in every direction, 0 to 10⁹ W·sr⁻¹·m⁻²; not of a mirror or dielectric.
    pub radiance: Option<Numbers<3>>,
}

/// `[[spheres]]`: a sphere. One that emits has the power 4π² · radius² · radiance.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SphereTable {
    /// What messages call it.
    pub name: Option<String>,
    /// Centre, m.
    pub centre: Numbers<3>,
    /// Radius, 10⁻⁶ to 10⁹ m.
    pub radius: f64,
    /// Its material; a sphere that emits may have none and is then black.
    pub material: Option<String>,
    /// Radiance that the outside emits in every direction, 0 to 10⁹ W·sr⁻¹·m⁻²; not of a mirror or dielectric.
    pub radiance: Option<Numbers<3>>,
}

/// `[[discs]]`: a disc. One that emits has the power π² · radius² · radiance.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DiscTable {
    /// What messages call it.
    pub name: Option<String>,
    /// Centre, m.
    pub centre: Numbers<3>,
    /// The direction its front looks to, of any length.
    pub normal: Numbers<3>,
    /// Radius, 10⁻⁶ to 10⁹ m.
    pub radius: f64,
    /// Its material; a disc that emits may have none and is then black.
    pub material: Option<String>,
    /// Radiance that the front emits in every direction, 0 to 10⁹ W·sr⁻¹·m⁻²; not of a mirror or dielectric.
    pub radiance: Option<Numbers<3>>,
}

/// `[[meshes]]`: triangles, from a file or given here.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshTable {
    /// What messages and instances call it.
    pub name: Option<String>,
    /// A .ply, .obj, .gltf or .glb file, relative to the scene's; or "built-in:hall", "built-in:landscape".
    pub file: Option<String>,
    /// In place of a file: points, m.
    pub vertices: Option<Vec<Numbers<3>>>,
    /// Indices of three vertices each, counted from 0, counter-clockwise as the front is seen.
    pub triangles: Option<Vec<Numbers<3>>>,
    /// Normals, one a vertex, of any length: the surface looks as smooth as they say.
    pub normals: Option<Vec<Numbers<3>>>,
    /// Texture coordinates, one a vertex, within ±8192, v downwards.
    pub uv: Option<Vec<Numbers<2>>>,
    /// Its material; the file's own if there is none.
    pub material: Option<String>,
    /// Radiance that the front of each triangle emits, W·sr⁻¹·m⁻², each a light; the file's own if there is none.
    pub radiance: Option<Numbers<3>>,
    /// Whether triangles look flat, whatever normals there are.
    #[serde(default)]
    pub flat: bool,
    /// Whether only its instances are seen.
    #[serde(default)]
    pub hidden: bool,
    /// Where it is put; as it is if there is none.
    pub place: Option<PlaceTable>,
}

/// `[[instances]]`: a mesh once more, elsewhere.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct InstanceTable {
    /// What messages call it.
    pub name: Option<String>,
    /// The name of the mesh.
    pub mesh: String,
    /// Its material; the mesh's own if there is none.
    pub material: Option<String>,
    /// Where it is put. The mesh's own place does not count.
    pub place: PlaceTable,
}

/// `place`: scaled, then turned about x, y and z in this order, then moved; or a matrix.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PlaceTable {
    /// By how much it is moved, m.
    pub translate: Option<Numbers<3>>,
    /// Angles about x, then y, then z, degrees.
    pub rotate_degrees: Option<Numbers<3>>,
    /// Factor on lengths.
    pub scale: Option<f64>,
    /// Three rows of four numbers, the last of each the translation, m, in place of the others.
    pub matrix: Option<Rows>,
}

/// Three rows of a matrix.
#[derive(Debug, Deserialize, JsonSchema)]
pub(super) struct Rows(pub [Numbers<4>; 3]);

/// `[[lights]]`: a light that is not a surface. Photons and shadow rays are shared among all lights in proportion to their power (of what is infinitely
/// far away, what comes to the sphere around the scene), but none gets less than an eighth of an equal share.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LightTable {
    /// What messages call it.
    pub name: Option<String>,
    /// Which kind it is.
    pub kind: LightKind,
    /// Where a point or spot is, m; not inside of a dielectric sphere.
    pub position: Option<Numbers<3>>,
    /// Intensity in every direction of a point, and within `inner_degrees` of a spot, 0 to 10⁹ W·sr⁻¹. The power of a point is 4π · intensity.
    pub intensity: Option<Numbers<3>>,
    /// Where a spot shines, or the way directional light travels; of any length.
    pub direction: Option<Numbers<3>>,
    /// Angle from a spot's axis up to which it has its full intensity, 0 to `outer_degrees`; 0 if it is not given.
    pub inner_degrees: Option<f64>,
    /// Angle from a spot's axis from which on it is dark, 0.1 to 90 degrees; between the two the intensity falls as 3x² − 2x³ in the cosine.
    pub outer_degrees: Option<f64>,
    /// Irradiance of directional light on what faces it, 0 to 10⁹ W·m⁻².
    pub irradiance: Option<Numbers<3>>,
    /// Radiance of an environment, 0 to 10⁹ W·sr⁻¹·m⁻², the same from everywhere; with a file, what its pixels are multiplied with, 1 if it is not
    /// given.
    pub radiance: Option<Numbers<3>>,
    /// An EXR or HDR file, relative to the scene's, of up to 8192 pixels a side: the environment by longitude and latitude, with −z in its middle, +x to
    /// the right of it and +y at its upper edge. Or "built-in:sky".
    pub file: Option<String>,
    /// Angle by which an environment is turned about the y axis, counter-clockwise as seen from above, degrees; 0 if it is not given.
    pub rotation_degrees: Option<f64>,
}

/// The kinds of lights that are not surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum LightKind {
    /// Shines evenly in all directions.
    Point,
    /// Shines within a cone.
    Spot,
    /// Shines in one direction, from infinitely far away, as the sun does.
    Directional,
    /// Shines from all around, from infinitely far away. A scene has one at most.
    Environment,
}

/// An array of exactly `N` numbers. (Serde's own arrays ignore what follows the last.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Numbers<const N: usize>(pub [f64; N]);

impl<'de, const N: usize> Deserialize<'de> for Numbers<N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Exactly<const N: usize>;
        impl<'de, const N: usize> Visitor<'de> for Exactly<N> {
            type Value = Numbers<N>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "an array of {N} numbers")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Numbers<N>, A::Error> {
                let mut numbers = [0.0; N];
                for (i, number) in numbers.iter_mut().enumerate() {
                    *number = seq.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &self))?;
                }
                let mut length = N;
                while seq.next_element::<serde::de::IgnoredAny>()?.is_some() {
                    length += 1;
                }
                if length == N { Ok(Numbers(numbers)) } else { Err(A::Error::invalid_length(length, &self)) }
            }
        }
        deserializer.deserialize_seq(Exactly)
    }
}

impl<const N: usize> JsonSchema for Numbers<N> {
    fn schema_name() -> Cow<'static, str> {
        format!("Numbers{N}").into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "array", "items": { "type": "number" }, "minItems": N, "maxItems": N })
    }
}
