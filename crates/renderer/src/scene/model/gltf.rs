//! glTF 2.0 and GLB (Khronos Group, "glTF 2.0 Specification", 2021).

use super::accessor::{numbers, view};
use super::picture::decode;
use super::{Finish, Model, Part, companion};
use crate::scene::content::{PointLight, Spot, Sun, Viewpoint};
use crate::scene::text::one_line;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use caustic_kernels::trace::{WRAP_CLAMP, WRAP_MIRROR, WRAP_REPEAT};
use glam::{DAffine2, DAffine3, DMat4, DVec2, DVec3};
use gltf::camera::Projection;
use gltf::khr_lights_punctual::Kind;
use gltf::material::AlphaMode;
use gltf::mesh::Mode;
use gltf::texture::{Info, WrappingMode};
use gltf::{Document, Gltf, Node, Semantic, buffer, image};
use std::f64::consts::FRAC_PI_2;
use std::path::Path;

/// Deepest nesting of nodes, and most of them: what instances multiply ends somewhere.
const MAX_DEPTH: u32 = 128;
const MAX_NODES: u32 = 1 << 20;
/// Lumens a watt with which photometric units are taken for radiometric ones, as exporters do.
const LUMENS_PER_WATT: f64 = 683.0;
/// Narrowest cone of a spot, radians.
const NARROWEST: f64 = 1e-3;

/// Reads a file's bytes; buffers and pictures that are not in it lie next to it.
pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Model, String> {
    let invalid =
        |error: gltf::Error| format!("is not valid glTF 2.0: {}; export it again", one_line(&error.to_string()));
    // The crate's validation looks positions up before it has seen that they are there.
    let unchecked = Gltf::from_slice_without_validation(bytes).map_err(invalid)?;
    let json = unchecked.document.as_json();
    let primitives = json.meshes.iter().flat_map(|mesh| &mesh.primitives);
    if primitives.flat_map(|primitive| primitive.attributes.values()).any(|at| at.value() >= json.accessors.len()) {
        return Err("has a mesh of an accessor that is not there; export it again".to_string());
    }
    let Gltf { document, blob } = Gltf::from_slice(bytes).map_err(invalid)?;
    let buffers = buffers(&document, blob, path)?;
    let mut model = Model::default();
    let mut file =
        File { document: &document, buffers: &buffers, path, model: &mut model, nodes: 0, transforms: Vec::new() };
    file.materials()?;
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or("has no scene, so there is nothing to see; export one")?;
    for node in scene.nodes() {
        file.node(&node, DAffine3::IDENTITY, 0)?;
    }
    if document.animations().next().is_some() {
        model.left_out.insert("animations".to_string());
    }
    Ok(model)
}

fn buffers(document: &Document, blob: Option<Vec<u8>>, path: &Path) -> Result<Vec<Vec<u8>>, String> {
    let mut blob = blob;
    document
        .buffers()
        .map(|buffer| match buffer.source() {
            buffer::Source::Bin => blob.take().ok_or("lacks its binary part; export it again".to_string()),
            buffer::Source::Uri(uri) => resource(uri, path),
        })
        .collect()
}

/// The bytes that a URI stands for.
fn resource(uri: &str, path: &Path) -> Result<Vec<u8>, String> {
    let Some(data) = uri.strip_prefix("data:") else { return companion(path, &decoded(uri)) };
    let data = data.split_once(',').map_or("", |(_, data)| data);
    STANDARD.decode(data).map_err(|error| format!("has a data URI that is not base64: {error}; export it again"))
}

/// A URI's `%20` and the like as characters.
fn decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let code = (*first == b'%').then(|| tail.get(..2)).flatten();
        let code = code.and_then(|code| u8::from_str_radix(std::str::from_utf8(code).ok()?, 16).ok());
        bytes.push(code.unwrap_or(*first));
        rest = if code.is_some() { &tail[2..] } else { tail };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// What is said of pictures that are not laid out by the first texture coordinates.
const ANOTHER_UV: &str = "pictures that have texture coordinates of their own";

/// A picture's `KHR_texture_transform`: scaled, turned, moved.
fn transform(info: &Info<'_>) -> DAffine2 {
    info.texture_transform().map_or(DAffine2::IDENTITY, |transform| {
        let [scale, offset] = [transform.scale(), transform.offset()].map(|v| DVec2::from_array(v.map(f64::from)));
        // Counter-clockwise as the picture is seen, whose v grows downwards.
        DAffine2::from_scale_angle_translation(scale, -f64::from(transform.rotation()), offset)
    })
}

/// A file while it is read.
struct File<'a> {
    document: &'a Document,
    buffers: &'a [Vec<u8>],
    path: &'a Path,
    model: &'a mut Model,
    nodes: u32,
    /// What texture coordinates of each finish go through.
    transforms: Vec<DAffine2>,
}

impl File<'_> {
    fn left_out(&mut self, what: &str) {
        self.model.left_out.insert(what.to_string());
    }

    /// All materials; the last finish is that of meshes without a material.
    fn materials(&mut self) -> Result<(), String> {
        for material in self.document.materials() {
            let surface = material.pbr_metallic_roughness();
            let [r, g, b, alpha] = surface.base_color_factor().map(f64::from);
            let strength = f64::from(material.emissive_strength().unwrap_or(1.0));
            let emission = DVec3::from_array(material.emissive_factor().map(f64::from)) * strength;
            let mut finish = Finish {
                coated: true,
                base: DVec3::new(r, g, b),
                metallic: surface.metallic_factor().into(),
                roughness: surface.roughness_factor().into(),
                transmission: material.transmission().map_or(0.0, |t| t.transmission_factor().into()),
                ior: material.ior().unwrap_or(1.5).into(),
                emission,
                ..Finish::default()
            };
            finish.picture = self.picture_of(surface.base_color_texture(), true)?;
            finish.roughness_picture = self.picture_of(surface.metallic_roughness_texture(), false)?;
            finish.emission_picture = self.picture_of(material.emissive_texture(), true)?;
            if let Some(normal) = material.normal_texture() {
                if normal.tex_coord() == 0 {
                    let scale = f64::from(normal.scale()).clamp(0.0, 100.0);
                    finish.normal_picture = Some((self.picture(&normal.texture(), false)?, scale));
                } else {
                    self.left_out(ANOTHER_UV);
                }
            }
            if material.occlusion_texture().is_some() {
                self.left_out("occlusion maps: light that does not come is traced");
            }
            match material.alpha_mode() {
                AlphaMode::Opaque => {}
                AlphaMode::Mask if emission.max_element() > 0.0 => self.left_out("holes of surfaces that emit"),
                // The picture's alpha times the factor is below the cutoff.
                AlphaMode::Mask => {
                    let cutoff = f64::from(material.alpha_cutoff().unwrap_or(0.5));
                    finish.cutoff = if cutoff > 0.0 { (cutoff / alpha.max(1e-6)).clamp(1e-3, 2.0) } else { 0.0 };
                }
                AlphaMode::Blend => self.left_out("alpha that blends: surfaces are opaque"),
            }
            let infos =
                [surface.base_color_texture(), surface.metallic_roughness_texture(), material.emissive_texture()];
            let transforms: Vec<DAffine2> = infos.iter().flatten().map(transform).collect();
            self.transforms.push(transforms.first().copied().unwrap_or(DAffine2::IDENTITY));
            if transforms.windows(2).any(|two| two[0] != two[1]) {
                self.left_out("texture transforms that differ among the pictures of a material");
            }
            self.model.finishes.push(finish);
        }
        self.transforms.push(DAffine2::IDENTITY);
        self.model.finishes.push(Finish { coated: true, base: DVec3::ONE, ..Finish::default() });
        Ok(())
    }

    /// The picture that is told of, if it has the first texture coordinates.
    fn picture_of(&mut self, info: Option<Info<'_>>, srgb: bool) -> Result<Option<usize>, String> {
        let Some(info) = info else { return Ok(None) };
        let other = info.texture_transform().and_then(|transform| transform.tex_coord());
        if other.unwrap_or(info.tex_coord()) != 0 {
            self.left_out(ANOTHER_UV);
            return Ok(None);
        }
        self.picture(&info.texture(), srgb).map(Some)
    }

    fn picture(&mut self, texture: &gltf::Texture<'_>, srgb: bool) -> Result<usize, String> {
        let sampler = texture.sampler();
        let wrap = |mode: WrappingMode| match mode {
            WrappingMode::ClampToEdge => WRAP_CLAMP,
            WrappingMode::MirroredRepeat => WRAP_MIRROR,
            WrappingMode::Repeat => WRAP_REPEAT,
        };
        let wrap = wrap(sampler.wrap_s()) + 4 * wrap(sampler.wrap_t());
        let image = texture.source();
        let of = |problem: String| format!("has image {}, which {problem}", image.index());
        let picture = match image.source() {
            image::Source::View { view: from, .. } => decode(view(&from, self.buffers)?, wrap, srgb).map_err(of)?,
            image::Source::Uri { uri, .. } => decode(&resource(uri, self.path)?, wrap, srgb).map_err(of)?,
        };
        // Textures of one image are one picture, unless they go on differently beyond its edges.
        let pictures = &mut self.model.pictures;
        if let Some(at) = pictures.iter().position(|known| *known == picture) {
            return Ok(at);
        }
        pictures.push(picture);
        Ok(pictures.len() - 1)
    }

    fn node(&mut self, node: &Node<'_>, outer: DAffine3, depth: u32) -> Result<(), String> {
        self.nodes += 1;
        if depth > MAX_DEPTH || self.nodes > MAX_NODES {
            return Err(format!(
                "has nodes in a circle, or deeper than {MAX_DEPTH} or more than {MAX_NODES}; export it again"
            ));
        }
        let matrix = node.transform().matrix().map(|column| column.map(f64::from));
        let place = outer * DAffine3::from_mat4(DMat4::from_cols_array_2d(&matrix));
        if !place.is_finite() {
            return Err(format!("has node {} at a place that is no number; export it again", node.index()));
        }
        let flattened = place.matrix3.determinant() == 0.0;
        if flattened && node.mesh().is_some() {
            self.left_out("meshes that their nodes scale to nothing");
        }
        if let Some(mesh) = node.mesh().filter(|_| !flattened) {
            if node.skin().is_some() || mesh.weights().is_some() {
                self.left_out("skins and morph targets: meshes are as they were modelled");
            }
            for primitive in mesh.primitives() {
                let name = mesh.name().or_else(|| node.name()).unwrap_or("").to_string();
                let part = self.part(&primitive, name)?;
                self.model.parts.push(part.moved(&place));
            }
        }
        if let Some(camera) = node.camera() {
            match camera.projection() {
                Projection::Perspective(lens) => self.model.cameras.push(Viewpoint {
                    position: place.translation,
                    target: place.transform_point3(DVec3::NEG_Z),
                    up: place.transform_vector3(DVec3::Y),
                    vertical_fov_degrees: f64::from(lens.yfov()).to_degrees(),
                    lens_radius: 0.0,
                    focus: 1.0,
                }),
                Projection::Orthographic(_) => self.left_out("orthographic cameras"),
            }
        }
        if let Some(light) = node.light() {
            let colour = DVec3::from_array(light.color().map(f64::from));
            let power = colour * (f64::from(light.intensity()) / LUMENS_PER_WATT);
            let (position, direction) =
                (place.translation, place.transform_vector3(DVec3::NEG_Z).normalize_or(DVec3::NEG_Y));
            let point = PointLight { position, intensity: power, spot: None };
            match light.kind() {
                Kind::Point => self.model.points.push(point),
                Kind::Spot { inner_cone_angle, outer_cone_angle } => {
                    // 1 − cos without cancellation; between the two there has to be a rim.
                    let depth = |angle: f64| 2.0 * (angle / 2.0).sin().powi(2);
                    let outer = f64::from(outer_cone_angle).clamp(NARROWEST, FRAC_PI_2);
                    let inner = f64::from(inner_cone_angle).clamp(0.0, outer * 0.999);
                    let spot = Spot { axis: direction, inner: depth(inner), outer: depth(outer) };
                    self.model.points.push(PointLight { spot: Some(spot), ..point });
                }
                Kind::Directional => self.model.suns.push(Sun { direction, irradiance: power }),
            }
        }
        for child in node.children() {
            self.node(&child, place, depth + 1)?;
        }
        Ok(())
    }

    fn part(&mut self, primitive: &gltf::Primitive<'_>, name: String) -> Result<Part, String> {
        let finish = primitive.material().index().unwrap_or(self.model.finishes.len() - 1);
        let mut part = Part { name, finish: Some(finish), ..Part::default() };
        if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
            self.left_out("points and lines");
            return Ok(part);
        }
        let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(part) };
        part.positions = numbers(&positions, self.buffers)?.into_iter().map(DVec3::from_array).collect();
        if let Some(normals) = primitive.get(&Semantic::Normals) {
            part.normals = numbers(&normals, self.buffers)?.into_iter().map(DVec3::from_array).collect();
        }
        if let Some(uv) = primitive.get(&Semantic::TexCoords(0)) {
            let transform = self.transforms[finish];
            let moved = |uv: [f64; 2]| transform.transform_point2(DVec2::from_array(uv)).to_array();
            part.uv = numbers(&uv, self.buffers)?.into_iter().map(moved).collect();
        }
        if primitive.get(&Semantic::Colors(0)).is_some() {
            self.left_out("colours of points");
        }
        let points = part.positions.len();
        if [part.normals.len(), part.uv.len()].iter().any(|&count| count != 0 && count != points) {
            return Err(
                "has a mesh whose normals or texture coordinates are not as many as its points; export it again".into(),
            );
        }
        let corners: Vec<u32> = match primitive.indices() {
            Some(indices) => numbers::<1>(&indices, self.buffers)?.into_iter().map(|[index]| index as u32).collect(),
            None => (0..points as u32).collect(),
        };
        part.triangles = match primitive.mode() {
            Mode::TriangleStrip => (2..corners.len())
                .map(|i| if i % 2 == 0 { [i - 2, i - 1, i] } else { [i - 1, i - 2, i] }.map(|at| corners[at]))
                .collect(),
            Mode::TriangleFan => super::fan(&corners).collect(),
            _ => corners.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]).collect(),
        };
        Ok(part)
    }
}
