//! From a checked scene to the kernels' records. Everything is computed in f64 and rounded once.

use super::bvh;
use super::content::{Content, NOTHING, Shape, Substance, Surface};
use super::lights::{Source, chances};
use caustic_kernels::trace::{
    BvhNode, Corners, LIGHT_AREA, LIGHT_POINT, Light, MATERIAL_DIELECTRIC, MATERIAL_LAMBERTIAN, MATERIAL_MIRROR,
    Material, NO_LIGHT, NO_TEXTURE, OCTANTS, PRIMITIVE_DISC, PRIMITIVE_QUAD, PRIMITIVE_SPHERE, PRIMITIVE_TRIANGLE,
    Primitive, SceneInfo, Target, Texel, Texture,
};
use glam::DVec3;
use std::collections::BTreeMap;

/// A scene as the kernels see it.
#[derive(Clone, Debug)]
pub struct CompiledScene {
    /// How many of each there are.
    pub info: SceneInfo,
    /// Whether it takes the FULL kernels to trace it; BASIC ones are faster.
    pub full: bool,
    /// The tree over the primitives: [`SceneInfo::lists`] lists of [`SceneInfo::nodes`] nodes.
    pub nodes: Vec<BvhNode>,
    /// Quads, then spheres, discs and triangles, each in the file's order; those with corners last.
    pub primitives: Vec<Primitive>,
    /// Normals and texture coordinates of the triangles from [`SceneInfo::first_corners`] on.
    pub corners: Vec<Corners>,
    /// Pictures on materials.
    pub textures: Vec<Texture>,
    /// Their texels.
    pub texels: Vec<Texel>,
    /// Materials in the order of their names.
    pub materials: Vec<Material>,
    /// Area lights, then point lights, each in the file's order; at least one.
    pub lights: Vec<Light>,
    /// Spheres around the mirrors and dielectrics, one around a mesh.
    pub targets: Vec<Target>,
    /// Lower and upper corner of a box around all surfaces that store photons, a little larger than they are, m; both are
    /// the origin if no surface does.
    pub diffuse_bounds: ([f32; 3], [f32; 3]),
    /// Whether there are mirrors or dielectrics, so that there may be caustics.
    pub has_specular: bool,
    /// Whether there are Lambertian surfaces, the ones that store photons; black ones count.
    pub has_diffuse: bool,
    /// Power of all lights together, W, for each of red, green and blue: π·L·A of an area light, 4π·I of a point light.
    pub emitted_power_w: [f64; 3],
}

/// Farthest that a quad may reach beyond its edges, in lengths of them, however small it is in its scene.
const MOST_BEYOND: f64 = 1.0 / 1024.0;
/// Most of the way to a triangle's middle by which hits are drawn in, however small it is in its scene.
const MOST_INWARDS: f64 = 1.0 / 64.0;

/// Compiles a scene.
pub(super) fn compile(content: &Content) -> CompiledScene {
    let sources = sources(content);
    let chances = chances(&sources);
    let mut lights = Vec::with_capacity(sources.len());
    let mut light_of = vec![NO_LIGHT; content.surfaces.len()];
    for (source, chance) in sources.iter().zip(chances) {
        if let Some(surface) = source.surface {
            light_of[surface] = lights.len() as u32;
        }
        lights.push(Light { probability: chance.probability, cumulative: chance.cumulative, ..source.light });
    }
    let specular = |surface: &Surface| !matches!(content.materials[surface.material], Substance::Lambertian(_));
    let reach = content.reach();
    let primitives: Vec<Primitive> =
        content.surfaces.iter().zip(&light_of).map(|(surface, &light)| primitive(surface, light, reach)).collect();
    let bvh::Lists { nodes, lists } = bvh::nodes(&primitives, reach);
    let targets = targets(content.surfaces.iter().filter(|surface| specular(surface)));
    let has_diffuse = content.surfaces.iter().any(|surface| !specular(surface));
    let basic = |primitive: &Primitive| matches!(primitive.kind, PRIMITIVE_QUAD | PRIMITIVE_SPHERE);
    let power: DVec3 = sources.iter().map(|source| source.power_w).sum();
    CompiledScene {
        info: SceneInfo {
            primitives: primitives.len() as u32,
            lights: lights.len() as u32,
            targets: targets.len() as u32,
            nodes: nodes.len() as u32 / lists,
            lists,
            first_corners: (primitives.len() - content.corners.len()) as u32,
        },
        full: lists < OCTANTS || !content.textures.is_empty() || !primitives.iter().all(basic),
        corners: content.corners.clone(),
        textures: content.textures.clone(),
        texels: content.texels.clone(),
        materials: content
            .materials
            .iter()
            .zip(&content.pictures)
            .map(|(of, picture)| material(of, *picture))
            .collect(),
        diffuse_bounds: bounds(content.surfaces.iter().filter(|surface| !specular(surface))),
        has_specular: !targets.is_empty(),
        has_diffuse,
        emitted_power_w: power.to_array(),
        nodes,
        primitives,
        lights,
        targets,
    }
}

fn sources(content: &Content) -> Vec<Source> {
    let areas = content.surfaces.iter().enumerate().filter_map(|(i, surface)| {
        let (Shape::Quad { corner, edge_u, edge_v }, Some(radiance)) = (surface.shape, surface.radiance) else {
            return None;
        };
        let normal = edge_u.cross(edge_v);
        let area = normal.length();
        let light = Light {
            emission: rounded(radiance),
            kind: LIGHT_AREA,
            position: rounded(corner),
            primitive: i as u32,
            edges: [rounded(edge_u), rounded(edge_v)],
            normal: rounded(normal / area),
            area: area as f32,
            ..Light::default()
        };
        Some(Source { light, surface: Some(i), power_w: radiance * (std::f64::consts::PI * area) })
    });
    let points = content.points.iter().map(|point| Source {
        light: Light {
            emission: rounded(point.intensity),
            kind: LIGHT_POINT,
            position: rounded(point.position),
            primitive: NO_LIGHT,
            ..Light::default()
        },
        surface: None,
        power_w: point.intensity * (4.0 * std::f64::consts::PI),
    });
    areas.chain(points).collect()
}

/// `reach` is the largest coordinate of the scene, m.
fn primitive(surface: &Surface, light: u32, reach: f64) -> Primitive {
    let shared = Primitive { material: surface.material as u32, light, ..Primitive::default() };
    match surface.shape {
        Shape::Sphere { centre, radius } => {
            Primitive { kind: PRIMITIVE_SPHERE, size: radius as f32, position: rounded(centre), ..shared }
        }
        Shape::Triangle { corners: [a, b, c] } => {
            let normal = (b - a).cross(c - a);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            // A point of an edge comes away from it by a third of this part of the triangle's smallest height.
            let inwards = 24.0 * 2f64.powi(-21) * reach * longest / normal.length();
            Primitive {
                kind: PRIMITIVE_TRIANGLE,
                size: inwards.min(MOST_INWARDS) as f32,
                position: rounded(a),
                normal: rounded(normal.normalize()),
                sides: [rounded(b), rounded(c)],
                ..shared
            }
        }
        Shape::Quad { corner, edge_u, edge_v } | Shape::Disc { corner, edge_u, edge_v } => {
            let normal = edge_u.cross(edge_v);
            let square = normal.length_squared();
            let duals = [edge_v.cross(normal) / square, normal.cross(edge_u) / square];
            // A hit is wrong by some units in the last place of the scene's coordinates; as a part of the quad's smaller height:
            let rounding = 2f64.powi(-21) * reach * duals[0].length().max(duals[1].length());
            Primitive {
                kind: if matches!(surface.shape, Shape::Disc { .. }) { PRIMITIVE_DISC } else { PRIMITIVE_QUAD },
                size: rounding.min(MOST_BEYOND) as f32,
                position: rounded(corner + (edge_u + edge_v) / 2.0),
                normal: rounded(normal / square.sqrt()),
                sides: duals.map(rounded),
                ..shared
            }
        }
    }
}

fn material(substance: &Substance, picture: Option<u32>) -> Material {
    let (kind, reflectance, ior) = match *substance {
        Substance::Lambertian(reflectance) => (MATERIAL_LAMBERTIAN, reflectance, 1.0),
        Substance::Mirror(reflectance) => (MATERIAL_MIRROR, reflectance, 1.0),
        Substance::Dielectric(ior) => (MATERIAL_DIELECTRIC, DVec3::ONE, ior),
    };
    Material {
        reflectance: rounded(reflectance),
        kind,
        ior: ior as f32,
        survival: reflectance.max_element() as f32,
        texture: picture.unwrap_or(NO_TEXTURE),
        roughness_texture: NO_TEXTURE,
    }
}

/// A sphere around each object that surfaces are of.
fn targets<'a>(surfaces: impl Iterator<Item = &'a Surface>) -> Vec<Target> {
    let mut targets = Vec::new();
    // Boxes of the objects that are of triangles.
    let mut meshes: BTreeMap<u32, (DVec3, DVec3)> = BTreeMap::new();
    for surface in surfaces {
        if matches!(surface.shape, Shape::Triangle { .. }) {
            let (low, high) = surface.bounds();
            let all = meshes.entry(surface.object).or_insert(NOTHING);
            *all = (all.0.min(low), all.1.max(high));
        } else {
            targets.push(target(surface));
        }
    }
    targets.extend(meshes.into_values().map(|(low, high)| Target {
        centre: rounded((low + high) / 2.0),
        radius: ((high - low).length() / 2.0) as f32,
    }));
    targets
}

/// The smallest sphere around a surface that is not a triangle.
fn target(surface: &Surface) -> Target {
    match surface.shape {
        Shape::Sphere { centre, radius } => Target { centre: rounded(centre), radius: radius as f32 },
        Shape::Quad { corner, edge_u, edge_v } => Target {
            centre: rounded(corner + (edge_u + edge_v) / 2.0),
            radius: ((edge_u + edge_v).length().max((edge_u - edge_v).length()) / 2.0) as f32,
        },
        Shape::Disc { .. } | Shape::Triangle { .. } => {
            let (low, high) = surface.bounds();
            Target { centre: rounded((low + high) / 2.0), radius: ((high - low).length() / 2.0) as f32 }
        }
    }
}

/// A box around surfaces. Photons lie on them but for rounding errors, for which it is a little larger.
fn bounds<'a>(surfaces: impl Iterator<Item = &'a Surface>) -> ([f32; 3], [f32; 3]) {
    let (low, high) = surfaces.map(Surface::bounds).fold(NOTHING, |all, one| (all.0.min(one.0), all.1.max(one.1)));
    if low.x > high.x {
        return ([0.0; 3], [0.0; 3]);
    }
    let margin = 1e-6 + 1e-5 * low.abs().max_element().max(high.abs().max_element());
    (rounded(low - margin), rounded(high + margin))
}

fn rounded(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}
