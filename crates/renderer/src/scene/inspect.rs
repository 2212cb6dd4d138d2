//! What a scene holds, and what in it is worth a look.

use super::Scene;
use super::content::{Shape, Substance, Surface};
use crate::Feature;
use caustic_kernels::trace::Texture;
use glam::DVec3;
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// What `caustic scene check` says of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Inspection {
    /// Its name.
    pub name: String,
    /// Parallelograms.
    pub quads: usize,
    /// Spheres.
    pub spheres: usize,
    /// Discs.
    pub discs: usize,
    /// Triangles.
    pub triangles: usize,
    /// Triangles that have normals or texture coordinates.
    pub smooth_triangles: usize,
    /// Materials, unused ones included.
    pub materials: usize,
    /// Pictures on them.
    pub textures: usize,
    /// Lights, a triangle or quad that emits one each.
    pub lights: usize,
    /// What the environment was read from, its pixels, and the radiance that it has on average, W·sr⁻¹·m⁻².
    pub environment: Option<String>,
    /// Lowest corner of the box around all surfaces, m.
    pub low: [f64; 3],
    /// Highest corner, m.
    pub high: [f64; 3],
    /// What kernels have to know of it beside quads, spheres and simple materials.
    pub kernels: Vec<Feature>,
    /// Bytes of its records on a device.
    pub bytes: u64,
    /// What was left out or added when it was read.
    pub notes: Vec<String>,
    /// What may be wrong, each with a remedy.
    pub warnings: Vec<String>,
}

/// Looks at a scene.
pub(super) fn inspect(scene: &Scene) -> Inspection {
    let content = &scene.content;
    let count = |is: fn(&Shape) -> bool| content.surfaces.iter().filter(|surface| is(&surface.shape)).count();
    let (low, high) = content.bounds();
    let compiled = scene.compile();
    let bytes = |records: &[u8]| records.len() as u64;
    let mut warnings = Vec::new();
    unused(scene, &mut warnings);
    glass(scene, &mut warnings);
    small(scene, &mut warnings);
    crossed(scene, &mut warnings);
    thin(scene, &mut warnings);
    Inspection {
        name: scene.name.clone(),
        quads: count(|shape| matches!(shape, Shape::Quad { .. })),
        spheres: count(|shape| matches!(shape, Shape::Sphere { .. })),
        discs: count(|shape| matches!(shape, Shape::Disc { .. })),
        triangles: count(|shape| matches!(shape, Shape::Triangle { .. })),
        smooth_triangles: content.corners.len(),
        materials: content.materials.len(),
        textures: content.textures.len(),
        lights: compiled.lights.len(),
        environment: content.sky.as_ref().map(|sky| {
            let Texture { width, height, .. } = content.textures[sky.texture as usize];
            let mean = (sky.fluence / (4.0 * PI)).to_array().map(|x| format!("{x:.4}")).join(", ");
            format!("{}, {width} × {height} pixels, [{mean}] W/sr/m² on average", sky.name)
        }),
        low: low.to_array(),
        high: high.to_array(),
        kernels: Feature::ALL.into_iter().filter(|feature| compiled.needs & feature.bit() != 0).collect(),
        bytes: bytes(bytemuck::cast_slice(&compiled.nodes))
            + bytes(bytemuck::cast_slice(&compiled.primitives))
            + bytes(bytemuck::cast_slice(&compiled.corners))
            + bytes(bytemuck::cast_slice(&compiled.texels))
            + bytes(bytemuck::cast_slice(&compiled.materials))
            + bytes(bytemuck::cast_slice(&compiled.lights)),
        notes: scene.notes.clone(),
        warnings,
    }
}

/// What has no thickness, in an environment, which comes from all sides.
fn thin(scene: &Scene, warnings: &mut Vec<String>) {
    let content = &scene.content;
    let reflects = |surface: &&Surface| match content.materials[surface.material] {
        Substance::Lambertian(reflectance) => reflectance != DVec3::ZERO,
        ref other => other.is_diffuse(),
    };
    let flat = |surface: &&Surface| matches!(surface.shape, Shape::Quad { .. } | Shape::Disc { .. });
    let count = content.surfaces.iter().filter(flat).filter(reflects).count();
    if content.sky.is_some() && count > 0 {
        warnings.push(format!(
            "{count} quads or discs have no thickness, and photons of the environment on their backs count on their fronts; render with `--surface facing`, or make them boxes"
        ));
    }
}

/// Materials that nothing is made of.
fn unused(scene: &Scene, warnings: &mut Vec<String>) {
    let mut used = vec![false; scene.content.materials.len()];
    for surface in &scene.content.surfaces {
        used[surface.material] = true;
    }
    for (name, index) in &scene.content.names {
        if !used[*index] {
            warnings.push(format!("the material `{name}` is not used; remove it, or name it where it was meant to be"));
        }
    }
}

/// Glass that is not the surface of a body: light that goes in and does not come out has the wrong brightness.
fn glass(scene: &Scene, warnings: &mut Vec<String>) {
    let is_glass = |surface: &Surface| matches!(scene.content.materials[surface.material], Substance::Dielectric(_));
    let mut meshes: BTreeMap<u32, Vec<[DVec3; 3]>> = BTreeMap::new();
    let mut sheets = 0;
    for surface in scene.content.surfaces.iter().filter(|surface| is_glass(surface)) {
        match surface.shape {
            Shape::Triangle { corners } => meshes.entry(surface.object).or_default().push(corners),
            Shape::Quad { .. } | Shape::Disc { .. } => sheets += 1,
            Shape::Sphere { .. } => {}
        }
    }
    if sheets > 0 {
        warnings.push(format!(
            "{sheets} quads or discs are dielectric: see that they close a body together, since a sheet of glass has no inside"
        ));
    }
    for (object, triangles) in meshes {
        let Edges { open, turned } = edges(&triangles);
        if open > 0 {
            warnings.push(format!(
                "the dielectric mesh of object {object} has {open} open edges: it is no closed body, and light gets lost in it; close its holes"
            ));
        }
        if turned > 0 {
            warnings.push(format!(
                "the dielectric mesh of object {object} has {turned} edges between triangles that face opposite ways; make its normals consistent"
            ));
        }
        let volume: f64 = triangles.iter().map(|[a, b, c]| a.dot(b.cross(*c)) / 6.0).sum();
        if open == 0 && turned == 0 && volume < 0.0 {
            warnings.push(format!(
                "the dielectric mesh of object {object} is inside out, so that its inside is taken for the outside; flip its triangles"
            ));
        }
    }
}

struct Edges {
    /// Edges of one triangle only, or of more than two.
    open: usize,
    /// Edges that two triangles run along in the same direction.
    turned: usize,
}

fn edges(triangles: &[[DVec3; 3]]) -> Edges {
    // −0 and 0 are one place.
    let key = |v: DVec3| (v + 0.0).to_array().map(f64::to_bits);
    let mut sides: BTreeMap<[[u64; 3]; 2], (u32, i32)> = BTreeMap::new();
    for corners in triangles {
        for i in 0..3 {
            let (from, to) = (key(corners[i]), key(corners[(i + 1) % 3]));
            let (pair, way) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
            let side = sides.entry(pair).or_default();
            *side = (side.0 + 1, side.1 + way);
        }
    }
    Edges {
        open: sides.values().filter(|(count, _)| count % 2 != 0).count(),
        turned: sides.values().filter(|(count, sum)| count % 2 == 0 && *sum != 0).count(),
    }
}

/// Surfaces that f32 hardly sees at this distance from the origin.
fn small(scene: &Scene, warnings: &mut Vec<String>) {
    let step = scene.content.reach() / f64::from(1 << 20);
    let size = |surface: &Surface| {
        let (low, high) = surface.bounds();
        (high - low).max_element()
    };
    let lost = scene.content.surfaces.iter().filter(|surface| size(surface) < step).count();
    if lost > 0 {
        warnings.push(format!(
            "{lost} surfaces are smaller than {step:.1e} m, a millionth of how far the scene reaches: they come out coarse; leave them out or make the scene smaller"
        ));
    }
}

/// Triangles whose corner normals are on the other side than the triangle.
fn crossed(scene: &Scene, warnings: &mut Vec<String>) {
    let content = &scene.content;
    let first = content.surfaces.len() - content.corners.len();
    let crossed = content.surfaces[first..].iter().zip(&content.corners).filter(|(surface, corners)| {
        let Shape::Triangle { corners: [a, b, c] } = surface.shape else { return false };
        let normal = (b - a).cross(c - a);
        let unpack = caustic_kernels::trace::vector::unpack_direction;
        corners.normals.iter().all(|&packed| {
            let n = unpack(packed);
            DVec3::new(n.x.into(), n.y.into(), n.z.into()).dot(normal) < 0.0
        })
    });
    let count = crossed.count();
    if count > 0 {
        warnings.push(format!(
            "{count} triangles have normals on their back: they look flat; turn their corners round or export the normals again"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_of_a_tetrahedron_are_closed_until_a_side_is_missing_or_turned() {
        let [a, b, c, d] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let mut sides = vec![[a, c, b], [a, b, d], [b, c, d], [c, a, d]];
        let count = |sides: &[[DVec3; 3]]| {
            let Edges { open, turned } = edges(sides);
            (open, turned)
        };
        assert_eq!(count(&sides), (0, 0));
        assert_eq!(count(&sides[1..]), (3, 0));
        sides[0].swap(0, 1);
        assert_eq!(count(&sides), (0, 3));
    }
}
