//! The TOML format, field by field, before anything is checked. docs/scene-format.md is its reference for users.

use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use std::collections::BTreeMap;
use std::fmt;

/// A scene file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    /// What the scene shows, in one line.
    #[serde(default)]
    pub description: String,
    /// Files whose materials, surfaces and lights are part of the scene, relative to this one.
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
    /// Parallelograms, those that emit among them.
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
    /// Lights that are not surfaces.
    #[serde(default)]
    pub lights: Vec<LightTable>,
}

/// `[camera]`: a pinhole camera.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraTable {
    /// Where it stands, m.
    pub position: Numbers<3>,
    /// What it looks at, m.
    pub target: Numbers<3>,
    /// The direction that points up in the picture, of any length; +y if it is not given.
    pub up: Option<Numbers<3>>,
    /// Angle between the picture's lower and upper edge, degrees.
    pub vertical_fov_degrees: f64,
}

/// `[render]`: defaults for the settings of a render.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RenderTable {
    /// Width and height of the picture, pixels.
    pub size: Option<Numbers<2>>,
    /// Photons emitted for the global map.
    pub photons: Option<i64>,
    /// Photons emitted for the caustic map.
    pub caustic_photons: Option<i64>,
    /// Photons in an estimate, at most.
    pub k: Option<i64>,
    /// Radius within which an estimate looks for photons, m.
    pub radius: Option<f64>,
    /// Samples a pixel.
    pub spp: Option<i64>,
}

/// `[materials.NAME]`: what a surface does with light.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialTable {
    /// Which kind it is.
    pub kind: MaterialKind,
    /// Share of the light that is reflected, for each of red, green and blue; of a lambertian or mirror.
    pub reflectance: Option<Numbers<3>>,
    /// Index of refraction of a dielectric.
    pub ior: Option<f64>,
    /// A PNG or JPEG file, relative to the scene's, that the reflectance is multiplied with; of a lambertian or mirror.
    pub texture: Option<String>,
}

/// The kinds of materials.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum MaterialKind {
    /// Reflects evenly in all directions.
    Lambertian,
    /// Reflects as a perfect mirror.
    Mirror,
    /// Reflects and refracts as smooth, clear glass.
    Dielectric,
}

/// `[[quads]]`: a parallelogram, whose front is the side to which `edge_u` × `edge_v` points.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct QuadTable {
    /// What messages call it.
    pub name: Option<String>,
    /// One of its corners, m.
    pub corner: Numbers<3>,
    /// From that corner to the next, m.
    pub edge_u: Numbers<3>,
    /// From that corner to the one before, m.
    pub edge_v: Numbers<3>,
    /// Its material; a quad that emits may have none and is then black.
    pub material: Option<String>,
    /// Radiance that the front emits, W·sr⁻¹·m⁻².
    pub radiance: Option<Numbers<3>>,
}

/// `[[spheres]]`: a sphere.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SphereTable {
    /// What messages call it.
    pub name: Option<String>,
    /// Centre, m.
    pub centre: Numbers<3>,
    /// Radius, m.
    pub radius: f64,
    /// Its material.
    pub material: String,
}

/// `[[discs]]`: a disc.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DiscTable {
    /// What messages call it.
    pub name: Option<String>,
    /// Centre, m.
    pub centre: Numbers<3>,
    /// The direction its front looks to, of any length.
    pub normal: Numbers<3>,
    /// Radius, m.
    pub radius: f64,
    /// Its material.
    pub material: String,
}

/// `[[meshes]]`: triangles, from a file or given here.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshTable {
    /// What messages and instances call it.
    pub name: Option<String>,
    /// A .ply, .obj, .gltf or .glb file, relative to the scene's.
    pub file: Option<String>,
    /// Points, m.
    pub vertices: Option<Vec<Numbers<3>>>,
    /// Indices of three vertices each, counted from 0, counter-clockwise as the front is seen.
    pub triangles: Option<Vec<Numbers<3>>>,
    /// Normals at the vertices, of any length: the surface looks as smooth as they say.
    pub normals: Option<Vec<Numbers<3>>>,
    /// Texture coordinates at the vertices, v downwards.
    pub uv: Option<Vec<Numbers<2>>>,
    /// Its material; the file's own if there is none.
    pub material: Option<String>,
    /// Radiance that the front emits, W·sr⁻¹·m⁻²; the file's own if there is none.
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
#[derive(Debug, Deserialize)]
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
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PlaceTable {
    /// m.
    pub translate: Option<Numbers<3>>,
    /// About x, then y, then z, degrees.
    pub rotate_degrees: Option<Numbers<3>>,
    /// Factor on lengths.
    pub scale: Option<f64>,
    /// Three rows of four numbers, the last of each the translation, in place of the others.
    pub matrix: Option<Rows>,
}

/// Three rows of a matrix.
#[derive(Debug, Deserialize)]
pub(super) struct Rows(pub [Numbers<4>; 3]);

/// `[[lights]]`: a light that is not a surface.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LightTable {
    /// What messages call it.
    pub name: Option<String>,
    /// Which kind it is: only points so far, which need no further look.
    #[serde(rename = "kind")]
    pub _kind: LightKind,
    /// Where it is, m.
    pub position: Numbers<3>,
    /// Intensity in every direction, W·sr⁻¹.
    pub intensity: Numbers<3>,
}

/// The kinds of lights that are not surfaces.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum LightKind {
    /// Shines evenly in all directions.
    Point,
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
