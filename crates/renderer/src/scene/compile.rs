//! From a checked scene to the kernels' records. Everything is computed in f64 and rounded once.

use super::bvh;
use super::content::{Content, Glass, Layers, NOTHING, Pictures, Shape, Spot, Substance, Surface};
use super::lights::{Source, chances, share_photons};
use super::needs::needs;
use super::substances::smoothest;
use super::targets::{aim, boxed, targets};
use crate::Feature;
use caustic_kernels::trace::{
    BvhNode, Corners, LIGHT_AREA, LIGHT_DIRECTIONAL, LIGHT_DISC, LIGHT_ENVIRONMENT, LIGHT_POINT, LIGHT_SPHERE,
    LIGHT_SPOT, LIGHT_TRIANGLE, Light, MATERIAL_DIELECTRIC, MATERIAL_LAMBERTIAN, MATERIAL_LAYERED, MATERIAL_MIRROR,
    MATERIAL_ROUGH_DIELECTRIC, Material, NO_LIGHT, NO_TEXTURE, PRIMITIVE_DISC, PRIMITIVE_QUAD, PRIMITIVE_SPHERE,
    PRIMITIVE_TRIANGLE, Primitive, RAY_GLOBAL, SceneInfo, Target, Texel, Texture,
};
use glam::DVec3;
use std::f64::consts::PI;

/// A scene as the kernels see it.
#[derive(Clone, Debug)]
pub struct CompiledScene {
    /// How many of each there are.
    pub info: SceneInfo,
    /// What kernels have to [know](caustic_kernels::trace::known) of it.
    pub needs: u32,
    /// What the kernels that trace it know: what they have to, and what is forced.
    pub known: u32,
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
    /// Surfaces that shine, then points and spots, then directional lights, each in the file's order, then the environment; at least one. Their photons are those of a
    /// pass of 2²⁰.
    pub lights: Vec<Light>,
    /// Spheres around what is not purely diffuse, a list for each light that sees others than those before it.
    pub targets: Vec<Target>,
    /// Lower and upper corner of a box around all surfaces that store photons, a little larger than they are, m; both are
    /// the origin if no surface does.
    pub diffuse_bounds: ([f32; 3], [f32; 3]),
    /// Whether there are mirrors, dielectrics or coats, so that there may be caustics.
    pub has_specular: bool,
    /// Whether light that was diffusely reflected may meet a surface again that is not black; if not, a global map holds nothing.
    pub interreflects: bool,
    /// Whether there are surfaces with a diffuse lobe, the ones that store photons; black ones count.
    pub has_diffuse: bool,
    /// Power of all lights together, W, for each of red, green and blue: π·L·A of a surface, 4π·I of a point light, and of what is infinitely far
    /// away what comes to the sphere around the scene.
    pub emitted_power_w: [f64; 3],
}

impl CompiledScene {
    /// The lights with the photons that each of them emits in a pass of `emitted` photons, of kind `rays`: for the caustic map only
    /// those that can see a target.
    #[must_use]
    pub fn lights_for(&self, emitted: u32, rays: u32) -> Vec<Light> {
        let mut lights = self.lights.clone();
        share_photons(&mut lights, emitted, |light| rays == RAY_GLOBAL || light.targets > 0);
        lights
    }

    /// The fewest photons of such a pass: one a light.
    #[must_use]
    pub fn fewest_photons(&self, rays: u32) -> u32 {
        self.lights.iter().filter(|light| rays == RAY_GLOBAL || light.targets > 0).count() as u32
    }
}

/// Farthest that a quad may reach beyond its edges, in lengths of them, however small it is in its scene.
const MOST_BEYOND: f64 = 1.0 / 1024.0;
/// Most of the way to a triangle's middle by which hits are drawn in, however small it is in its scene.
const MOST_INWARDS: f64 = 1.0 / 64.0;

/// A light of which nothing is known yet.
const UNLIT: Light = Light {
    emission: [0.0; 3],
    kind: LIGHT_POINT,
    position: [0.0; 3],
    primitive: NO_LIGHT,
    edges: [[0.0; 3]; 2],
    normal: [0.0; 3],
    area: 0.0,
    probability: 0.0,
    cumulative: 0.0,
    first_photon: 0,
    photons: 0,
    first_target: 0,
    targets: 0,
    texture: NO_TEXTURE,
};

/// Compiles a scene, with the features that are forced though it does not need them.
pub(super) fn compile(content: &Content, forced: &[Feature]) -> CompiledScene {
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
    let specular = |surface: &Surface| content.materials[surface.material].is_specular();
    let diffuse = |surface: &Surface| content.materials[surface.material].is_diffuse();
    let reach = content.reach();
    let primitives: Vec<Primitive> =
        content.surfaces.iter().zip(&light_of).map(|(surface, &light)| primitive(surface, light, reach)).collect();
    let bvh::Lists { nodes, lists } = bvh::nodes(&primitives, reach, forced.contains(&Feature::Tree));
    let has_specular = content.surfaces.iter().any(specular);
    // Without gloss, photons of a forced caustic map go everywhere.
    let everywhere = !has_specular && forced.contains(&Feature::CausticMap);
    let targets = if everywhere {
        vec![boxed(content.bounds())]
    } else {
        targets(content.surfaces.iter().filter(|surface| specular(surface)))
    };
    let targets = aim(&mut lights, &targets);
    share_photons(&mut lights, 1 << 20, |_| true);
    let materials: Vec<Material> =
        content.materials.iter().zip(&content.pictures).map(|(of, pictures)| material(of, *pictures)).collect();
    let needs = needs(content, &primitives, &materials, &lights, lists);
    let power: DVec3 = sources.iter().map(|source| source.power_w).sum();
    CompiledScene {
        info: SceneInfo {
            primitives: primitives.len() as u32,
            lights: lights.len() as u32,
            targets: targets.len() as u32,
            nodes: nodes.len() as u32 / lists,
            lists,
            first_corners: (primitives.len() - content.corners.len()) as u32,
            environment: if content.sky.is_some() { lights.len() as u32 - 1 } else { NO_LIGHT },
            sky: content.sky.as_ref().map_or(NO_TEXTURE, |sky| sky.texture),
            holes: u32::from(content.pictures.iter().any(|pictures| pictures.cutoff > 0.0)),
        },
        needs,
        known: forced.iter().fold(needs, |known, feature| known | feature.bit()),
        corners: content.corners.clone(),
        textures: content.textures.clone(),
        texels: content.texels.clone(),
        materials,
        diffuse_bounds: bounds(content.surfaces.iter().filter(|surface| diffuse(surface))),
        has_specular,
        interreflects: interreflects(content, reach),
        has_diffuse: content.surfaces.iter().any(diffuse),
        emitted_power_w: power.to_array(),
        nodes,
        primitives,
        lights,
        targets,
    }
}

fn sources(content: &Content) -> Vec<Source> {
    let surfaces = content.surfaces.iter().enumerate().filter_map(|(i, surface)| {
        let radiance = surface.radiance?;
        let picture = content.pictures[surface.material].emission;
        let light = Light {
            emission: rounded(radiance),
            primitive: i as u32,
            texture: picture.unwrap_or(NO_TEXTURE),
            ..shape_of_light(&surface.shape)
        };
        let mean = picture.map_or(DVec3::ONE, |at| content.mean_texel(i, at));
        Some(Source { light, surface: Some(i), power_w: radiance * mean * (PI * f64::from(light.area)) })
    });
    let points = content.points.iter().map(|point| {
        let light =
            Light { emission: rounded(point.intensity), kind: LIGHT_POINT, position: rounded(point.position), ..UNLIT };
        let Some(Spot { axis, inner, outer }) = point.spot else {
            return Source { light, surface: None, power_w: point.intensity * (4.0 * PI) };
        };
        let edges = [[inner as f32, outer as f32, 0.0], [0.0; 3]];
        let light = Light { kind: LIGHT_SPOT, normal: rounded(axis), edges, ..light };
        // The falloff 3x² − 2x³ is even about the middle of the rim.
        Source { light, surface: None, power_w: point.intensity * (PI * (inner + outer)) }
    });
    let (low, high) = content.bounds();
    // A little larger than the scene, for rounding.
    let (middle, radius) = ((low + high) / 2.0, (high - low).length() / 2.0 * 1.000_01);
    let suns = content.suns.iter().map(|sun| {
        let area = PI * radius * radius;
        let light = Light {
            emission: rounded(sun.irradiance),
            kind: LIGHT_DIRECTIONAL,
            position: rounded(middle - sun.direction * radius),
            edges: [[radius as f32, 0.0, 0.0], [0.0; 3]],
            normal: rounded(sun.direction),
            area: area as f32,
            ..UNLIT
        };
        Source { light, surface: None, power_w: sun.irradiance * area }
    });
    let sky = content.sky.iter().map(|sky| {
        let (sin, cos) = sky.turned.sin_cos();
        let area = PI * radius * radius;
        let light = Light {
            emission: rounded(sky.emission),
            kind: LIGHT_ENVIRONMENT,
            position: rounded(middle),
            edges: [[radius as f32, 0.0, 0.0], [cos as f32, sin as f32, 0.0]],
            area: area as f32,
            ..UNLIT
        };
        Source { light, surface: None, power_w: sky.fluence * area }
    });
    surfaces.chain(points).chain(suns).chain(sky).collect()
}

/// The light that a surface is.
fn shape_of_light(shape: &Shape) -> Light {
    let flat = |kind, corner: DVec3, edge_u: DVec3, edge_v: DVec3, part: f64| {
        let normal = edge_u.cross(edge_v);
        let area = normal.length();
        Light {
            kind,
            position: rounded(corner),
            edges: [rounded(edge_u), rounded(edge_v)],
            normal: rounded(normal / area),
            area: (area * part) as f32,
            ..UNLIT
        }
    };
    match *shape {
        Shape::Quad { corner, edge_u, edge_v } => flat(LIGHT_AREA, corner, edge_u, edge_v, 1.0),
        Shape::Triangle { corners: [a, b, c] } => flat(LIGHT_TRIANGLE, a, b - a, c - a, 0.5),
        Shape::Sphere { centre, radius } => Light {
            kind: LIGHT_SPHERE,
            position: rounded(centre),
            edges: [[radius as f32, 0.0, 0.0], [0.0; 3]],
            area: (4.0 * PI * radius * radius) as f32,
            ..UNLIT
        },
        // Half its edges are its radii, which span 1 / π of its area.
        Shape::Disc { corner, edge_u, edge_v } => {
            flat(LIGHT_DISC, corner + (edge_u + edge_v) / 2.0, edge_u / 2.0, edge_v / 2.0, PI)
        }
    }
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

fn material(substance: &Substance, pictures: Pictures) -> Material {
    let [texture, roughness_texture, normal_texture] =
        [pictures.colour, pictures.roughness, pictures.normal].map(|at| at.unwrap_or(NO_TEXTURE));
    let (normal_scale, alpha_cutoff) = ((1.0 + pictures.normal_excess) as f32, pictures.cutoff as f32);
    let plain = Material {
        ior: 1.0,
        texture,
        roughness_texture,
        normal_texture,
        normal_scale,
        alpha_cutoff,
        ..Material::default()
    };
    let of = |kind, reflectance: DVec3| Material {
        kind,
        reflectance: rounded(reflectance),
        survival: reflectance.max_element() as f32,
        ..plain
    };
    match *substance {
        Substance::Lambertian(reflectance) => of(MATERIAL_LAMBERTIAN, reflectance),
        Substance::Mirror(reflectance) => of(MATERIAL_MIRROR, reflectance),
        Substance::Dielectric(Glass { ior, alpha, absorption }) => {
            let kind = if alpha < smoothest() { MATERIAL_DIELECTRIC } else { MATERIAL_ROUGH_DIELECTRIC };
            let roughness = if alpha < smoothest() { 0.0 } else { alpha as f32 };
            Material { ior: ior as f32, roughness, absorption: rounded(absorption), ..of(kind, DVec3::ONE) }
        }
        Substance::Layered(Layers { base, metallic, ior, alpha }) => Material {
            ior: ior as f32,
            roughness: alpha as f32,
            metallic: metallic as f32,
            survival: if base == DVec3::ZERO { 0.0 } else { 1.0 },
            ..of(MATERIAL_LAYERED, base)
        },
    }
}

/// Whether light from a diffuse surface may meet a surface that is not black. It cannot where all that is not black is matt and lies in one plane
/// without corner normals: a ray leaves a plane by more than its surfaces deviate from it here (`trace::leave`), and away from it.
fn interreflects(content: &Content, reach: f64) -> bool {
    let black = |surface: &Surface| content.materials[surface.material] == Substance::Lambertian(DVec3::ZERO);
    let mut plane = None;
    for surface in content.surfaces.iter().filter(|surface| !black(surface)) {
        let matt = matches!(content.materials[surface.material], Substance::Lambertian(_));
        let corners = match surface.shape {
            Shape::Quad { corner, edge_u, edge_v } | Shape::Disc { corner, edge_u, edge_v } => {
                [corner, corner + edge_u, corner + edge_v]
            }
            Shape::Triangle { corners } => corners,
            Shape::Sphere { .. } => return true,
        };
        let [a, b, c] = corners;
        let (point, normal) = *plane.get_or_insert_with(|| (a, (b - a).cross(c - a).normalize()));
        let beside = |corner: &DVec3| (*corner - point).dot(normal).abs() > 2f64.powi(-24) * reach;
        if !matt || surface.has_corners || corners.iter().any(beside) || beside(&(b + c - a)) {
            return true;
        }
    }
    false
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
