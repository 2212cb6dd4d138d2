//! OBJ and MTL (Wavefront, "Object Files" and "Material Library File Format").

use super::picture::decode;
use super::{Finish, Model, Part, companion};
use crate::scene::text::one_line;
use caustic_kernels::trace::WRAP_REPEAT;
use glam::DVec3;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::Path;
use tobj::{LoadError, LoadOptions};

/// Index of refraction from which on a transparent material of illumination model 4, 6, 7 or 9 is glass.
const GLASS: [u8; 4] = [4, 6, 7, 9];

/// Reads a file's bytes; material libraries and pictures lie next to it.
pub(super) fn read(mut bytes: &[u8], path: &Path) -> Result<Model, String> {
    let options = LoadOptions { triangulate: true, single_index: true, ignore_points: true, ignore_lines: true };
    let left_out = RefCell::new(BTreeSet::new());
    let loaded = tobj::load_obj_buf(&mut bytes, &options, |library| {
        let name = library.to_string_lossy();
        companion(path, &name)
            .map_err(|_| LoadError::OpenFileFailed)
            .and_then(|bytes| tobj::load_mtl_buf(&mut &bytes[..]))
            .inspect_err(|_| {
                left_out
                    .borrow_mut()
                    .insert(format!("the material library `{}`, which cannot be read", one_line(&name)));
            })
    });
    let (models, materials) = loaded
        .map_err(|error| format!("is not a whole OBJ file: {}; export it again", one_line(&error.to_string())))?;
    let mut left_out = left_out.into_inner();
    let mut pictures = Vec::new();
    let mut finishes: Vec<Finish> = Vec::new();
    for material in materials.unwrap_or_default() {
        let vector = |rgb: Option<[f32; 3]>| rgb.map(|rgb| DVec3::from_array(rgb.map(f64::from)));
        let base = vector(material.diffuse).unwrap_or(DVec3::splat(0.8));
        let specular = vector(material.specular).unwrap_or(DVec3::ZERO);
        let model = material.illumination_model.unwrap_or(2);
        let mut finish = Finish { base, ..Finish::default() };
        if GLASS.contains(&model) || material.dissolve.is_some_and(|dissolve| dissolve < 0.5) {
            finish.transmission = 1.0;
            finish.ior = f64::from(material.optical_density.unwrap_or(1.5));
        } else if (model == 3 || model == 5) && base.max_element() <= specular.max_element() {
            // Ray-traced reflection of a material without much else.
            (finish.base, finish.metallic, finish.roughness) = (specular, 1.0, 0.0);
        }
        let emissive = material.emissive.or_else(|| ke(&material));
        finish.emission = vector(emissive).unwrap_or(DVec3::ZERO);
        if let Some(file) = &material.diffuse_texture {
            // Options such as `-s 2 2 1` stand before the name.
            let name = file.split_whitespace().next_back().unwrap_or(file).replace('\\', "/");
            match companion(path, &name).and_then(|bytes| decode(&bytes, WRAP_REPEAT * 5, true)) {
                Ok(picture) => {
                    finish.picture = Some(pictures.len());
                    // The picture is the colour; Kd is often left black beside it.
                    finish.base = if base.max_element() > 0.0 { base } else { DVec3::ONE };
                    pictures.push(picture);
                }
                Err(_) => {
                    left_out.insert(format!("the picture `{}`, which cannot be read", one_line(&name)));
                }
            }
        }
        let others = [&material.normal_texture, &material.specular_texture, &material.dissolve_texture];
        if others.iter().any(|texture| texture.is_some()) {
            left_out.insert("pictures that are not of colours".to_string());
        }
        finishes.push(finish);
    }
    let none = finishes.len();
    finishes.push(Finish::default());
    let parts = models.into_iter().map(|model| part(model, none)).collect();
    Ok(Model { parts, finishes, pictures, left_out, ..Model::default() })
}

/// `Ke`, where the parser does not know it.
fn ke(material: &tobj::Material) -> Option<[f32; 3]> {
    let text = material.unknown_param.get("Ke")?;
    let numbers: Vec<f32> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    numbers.try_into().ok()
}

fn part(model: tobj::Model, none: usize) -> Part {
    let tobj::Mesh { positions, normals, texcoords, indices, material_id, .. } = model.mesh;
    let vectors = |numbers: &[f32]| -> Vec<DVec3> {
        numbers.chunks_exact(3).map(|v| DVec3::new(v[0].into(), v[1].into(), v[2].into())).collect()
    };
    let positions = vectors(&positions);
    let whole = |count: usize| count == positions.len();
    let mut normals = vectors(&normals);
    normals.truncate(if whole(normals.len()) { normals.len() } else { 0 });
    let mut uv: Vec<[f64; 2]> = texcoords.chunks_exact(2).map(|v| [v[0].into(), 1.0 - f64::from(v[1])]).collect();
    uv.truncate(if whole(uv.len()) { uv.len() } else { 0 });
    let triangles = indices.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]).collect();
    let finish = material_id.filter(|&id| id < none).unwrap_or(none);
    Part { name: model.name, positions, normals, uv, triangles, finish: Some(finish) }
}
