//! Models: meshes from PLY, OBJ and glTF files, with the materials, lights and cameras that these have.

mod accessor;
mod gltf;
mod obj;
mod picture;
mod ply;

pub(super) use picture::Picture;

use super::content::{Pictures, PointLight, Sun, Viewpoint};
use super::error::SceneError;
use super::text::one_line;
use glam::{DAffine3, DVec3};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Endings of the files that are models.
pub(super) const ENDINGS: [&str; 4] = ["ply", "obj", "gltf", "glb"];
/// Most bytes of a model, and of each file that it refers to.
const MAX_BYTES: u64 = 1 << 30;

/// What a model file holds.
#[derive(Default)]
pub(super) struct Model {
    pub parts: Vec<Part>,
    pub finishes: Vec<Finish>,
    pub pictures: Vec<Picture>,
    pub cameras: Vec<Viewpoint>,
    pub points: Vec<PointLight>,
    pub suns: Vec<Sun>,
    /// What the file has that is not rendered, each in a few words.
    pub left_out: BTreeSet<String>,
}

/// A mesh of one material.
#[derive(Clone, Default)]
pub(super) struct Part {
    pub name: String,
    /// m.
    pub positions: Vec<DVec3>,
    /// One a position, of any length; or none.
    pub normals: Vec<DVec3>,
    /// One a position, v downwards; or none.
    pub uv: Vec<[f64; 2]>,
    /// Indices of positions, counter-clockwise from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Index of its finish.
    pub finish: Option<usize>,
}

/// A material as model files have it: glTF's metallic-roughness with transmission.
#[derive(Clone, Debug)]
pub(super) struct Finish {
    /// Whether it has a coat that shines, as all of glTF's have.
    pub coated: bool,
    /// Base colour, linear.
    pub base: DVec3,
    pub metallic: f64,
    pub roughness: f64,
    /// Share of light that passes.
    pub transmission: f64,
    pub ior: f64,
    /// W·sr⁻¹·m⁻².
    pub emission: DVec3,
    /// Index of the picture that the base colour is multiplied with.
    pub picture: Option<usize>,
    /// Index of the picture that roughness and metalness are multiplied with.
    pub roughness_picture: Option<usize>,
    /// Index of the picture that bends the normal, and the factor on its slopes.
    pub normal_picture: Option<(usize, f64)>,
    /// Index of the picture that emission is multiplied with.
    pub emission_picture: Option<usize>,
    /// Alpha of the picture of the base colour below which there are holes; 0 if there are none.
    pub cutoff: f64,
}

impl Finish {
    /// Its pictures, when those of the model have become `added` of a scene.
    pub fn pictures(&self, added: &[u32]) -> Pictures {
        Pictures {
            colour: self.picture.map(|at| added[at]),
            // What a glass has of them is not rendered.
            roughness: self.roughness_picture.map(|at| added[at]).filter(|_| self.transmission <= 0.5),
            normal: self.normal_picture.map(|(at, _)| added[at]),
            normal_excess: self.normal_picture.map_or(0.0, |(_, scale)| scale - 1.0),
            emission: self.emission_picture.map(|at| added[at]),
            cutoff: if self.picture.is_some() { self.cutoff } else { 0.0 },
        }
    }
}

impl Default for Finish {
    fn default() -> Self {
        Self {
            coated: false,
            base: DVec3::splat(0.8),
            metallic: 0.0,
            roughness: 1.0,
            transmission: 0.0,
            ior: 1.5,
            emission: DVec3::ZERO,
            picture: None,
            roughness_picture: None,
            normal_picture: None,
            emission_picture: None,
            cutoff: 0.0,
        }
    }
}

impl Part {
    /// This part, elsewhere.
    pub fn moved(&self, place: &DAffine3) -> Self {
        let normals = place.matrix3.inverse().transpose();
        let mut part = self.clone();
        part.positions.iter_mut().for_each(|position| *position = place.transform_point3(*position));
        part.normals.iter_mut().for_each(|normal| *normal = normals * *normal);
        if place.matrix3.determinant() < 0.0 {
            part.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        part
    }

    /// What is wrong with it, if anything.
    fn fault(&self) -> Option<String> {
        let points = self.positions.len();
        let mut indices = self.triangles.iter().flatten();
        if let Some(index) = indices.find(|&&index| index as usize >= points) {
            return Some(format!("a triangle of {} has corner {index}, but there are {points} points", self.called()));
        }
        let far = |x: &f64| !(x.abs() <= super::check::LARGEST);
        let numbers = self.positions.iter().map(DVec3::to_array);
        if let Some(at) = numbers.clone().position(|p| p.iter().any(far)) {
            let limit = super::check::LARGEST;
            return Some(format!("point {at} of {} is not from −{limit} to {limit} m", self.called()));
        }
        if self.normals.iter().any(|n| !n.is_finite()) || self.uv.iter().flatten().any(|x| !(x.abs() <= MOST_UV)) {
            return Some(format!(
                "a normal or texture coordinate of {} is no number, or beyond ±{MOST_UV}",
                self.called()
            ));
        }
        None
    }

    fn called(&self) -> String {
        if self.name.is_empty() { "a mesh".to_string() } else { format!("the mesh `{}`", one_line(&self.name)) }
    }
}

/// Largest texture coordinate: there f32 still has a thousandth of a picture.
const MOST_UV: f64 = 8192.0;

/// Whether a file of this name is a model.
pub(super) fn is_model(path: &Path) -> bool {
    ending(path).is_some_and(|ending| ENDINGS.contains(&ending.as_str()))
}

fn ending(path: &Path) -> Option<String> {
    path.extension().map(|ending| ending.to_string_lossy().to_lowercase())
}

/// Reads a model.
pub(super) fn read(path: &Path) -> Result<Model, SceneError> {
    let error = |problem: String| SceneError::Model { path: one_line(&path.to_string_lossy()), problem };
    let bytes = bytes_of(path).map_err(error)?;
    let read = match ending(path).as_deref() {
        Some("ply") => ply::read(&bytes),
        Some("obj") => obj::read(&bytes, path),
        Some("gltf" | "glb") => gltf::read(&bytes, path),
        _ => Err("is no model: give a .ply, .obj, .gltf or .glb file".to_string()),
    };
    let mut model = read.map_err(error)?;
    model.parts.retain(|part| !part.triangles.is_empty());
    if let Some(fault) = model.parts.iter().find_map(Part::fault) {
        return Err(error(format!("is broken: {fault}; export it again")));
    }
    if model.parts.is_empty() {
        let also = if model.left_out.is_empty() {
            String::new()
        } else {
            format!(" (left out: {})", model.left_out.iter().cloned().collect::<Vec<_>>().join("; "))
        };
        return Err(error(format!("has no triangles, so there is nothing to see{also}; export a mesh")));
    }
    Ok(model)
}

/// The bytes of a model or of a file that it refers to.
fn bytes_of(path: &Path) -> Result<Vec<u8>, String> {
    if path.is_dir() {
        return Err("cannot be read: it is a folder; give a file".to_string());
    }
    let remedy = "give the path of a file that can be read";
    let file = File::open(path).map_err(|error| format!("cannot be read: {error}; {remedy}"))?;
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(|error| format!("cannot be read: {error}; {remedy}"))?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(format!("is larger than {MAX_BYTES} bytes, the most a model may have; split it"));
    }
    Ok(bytes)
}

/// The bytes of a file that a model refers to, next to it.
fn companion(path: &Path, name: &str) -> Result<Vec<u8>, String> {
    let beside = path.parent().unwrap_or(Path::new("")).join(name);
    bytes_of(&beside).map_err(|problem| format!("refers to the file `{}`, which {problem}", one_line(name)))
}

/// The picture in a file, in linear light.
pub(super) fn picture(path: &Path, srgb: bool) -> Result<Picture, String> {
    bytes_of(path).and_then(|bytes| picture::decode(&bytes, caustic_kernels::trace::WRAP_REPEAT, srgb))
}

/// A polygon as triangles, a fan from its first corner.
fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    (2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]])
}

#[cfg(test)]
mod tests;
