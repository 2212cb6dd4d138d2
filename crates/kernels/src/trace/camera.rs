//! Camera paths, down to the first diffuse surface.

use super::MAX_BOUNCES;
use super::bsdf::{albedo_diffuse, is_glossy, sample_specular, specular_chance};
use super::bvh::BvhNode;
use super::intersect::{LOST, MISS, closest_hit, leave};
use super::known::Known;
use super::light::{emission_at, look_density, power_heuristic};
use super::medium::{VACUUM, absorbs, leaks, medium_after, medium_before, roulette};
use super::next_event::{next_event, outside, through};
use super::scene::{Light, MATERIAL_LAMBERTIAN, Material, NO_LIGHT, Primitive, SceneInfo};
use super::sky::leaving;
use super::surface::{Corners, surface_of};
use super::texture::{Texel, Texture};
use super::vector::{dot, invert_disc, normalize, sample_disc};
use crate::exec::{Input, Store};
use crate::layout::Query;
use crate::num::{Rng, abs, div, max, pcg4d, shuffle_index, sobol2};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Stream of the camera's random numbers; the photon passes have 0 and 1.
const STREAM: u32 = 2;
/// Key of the sequence that places samples on the film; [`direct`](super::direct) has others.
pub(super) const FILM_KEY: u32 = 0x5f1a_0000;
/// Key of the sequence that places samples on the lens.
const LENS_KEY: u32 = 0x5f1a_0003;
/// First dimension of the numbers for shadow rays of glossy surfaces; bounces have those below.
const SHADOW_DIMENSION: u32 = MAX_BOUNCES;
/// First dimension of the numbers for a medium's roulette.
const FAINT_DIMENSION: u32 = 2 * MAX_BOUNCES;
/// A throughput below which a path has ended: a product of it is no longer a normal float.
const NOTHING: f32 = 1e-30;

/// A camera: a pinhole, or a thin lens.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Camera {
    /// Where it stands, m.
    pub origin: [f32; 3],
    /// Pixels in a row.
    pub width: u32,
    /// From the camera to the top left corner of the film, at distance 1.
    pub corner: [f32; 3],
    /// Pixels in a column.
    pub height: u32,
    /// One pixel to the right.
    pub right: [f32; 3],
    /// One pixel down.
    pub down: [f32; 3],
    /// Two radii of the lens across each other and the view, m; none of a pinhole.
    pub lens: [[f32; 3]; 2],
    /// Distance of the plane that is in focus, m.
    pub focus: f32,
    /// 1 if samples are spread over their pixels; 0 if all are in the corner.
    pub jitter: f32,
}

/// The part of the film that one plan renders.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct CameraTile {
    /// First pixel, counted row by row.
    pub first_pixel: u32,
    /// Pixels in the tile.
    pub pixels: u32,
    /// Samples a pixel.
    pub samples: u32,
    /// Seed of the random numbers.
    pub seed: u32,
}

/// What a sample of the camera needs to know beside its [`Query`] to be shaded.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Vertex {
    /// Unit shading normal of the side that is seen.
    pub normal: [f32; 3],
    /// Index of the primitive, [`MISS`] or [`LOST`].
    pub primitive: u32,
    /// Radiance towards the camera for an irradiance of 1: the path's throughput times ρ/π, sr⁻¹.
    pub weight: [f32; 3],
    /// Radiance that the path found on lights, W·sr⁻¹·m⁻², times its throughput.
    pub emitted: [f32; 3],
    /// Rays that the path took.
    pub rays: u32,
    /// Length of the path, m.
    pub distance: f32,
}

/// Follows sample `i` of the tile through mirrors and glass to the first diffuse surface.
///
/// Where a surface has both a diffuse lobe and another, one of them is chosen: through the diffuse one the path ends, through the other
/// it goes on. What a glossy lobe sees of the lights comes both from a shadow ray and from paths that meet a light, each
/// weighed by the power heuristic.
#[inline]
pub fn trace_camera<Q: Store<Query> + ?Sized, V: Store<Vertex> + ?Sized>(
    known: impl Known,
    i: u32,
    tile: &CameraTile,
    camera: &Camera,
    info: &SceneInfo,
    nodes: &Input<BvhNode>,
    primitives: &Input<Primitive>,
    materials: &Input<Material>,
    lights: &Input<Light>,
    corners: &Input<Corners>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
    queries: &mut Q,
    vertices: &mut V,
) {
    if i >= tile.pixels * tile.samples {
        return;
    }
    let pixel = tile.first_pixel + i / tile.samples;
    let sample = i % tile.samples;
    let rng = Rng { seed: tile.seed, stream: STREAM ^ (sample << 8), index: pixel };
    let (origin, direction) = eye_ray(camera, pixel, sample, tile.seed);
    let (query, vertex) = first_diffuse(
        known, rng, origin, direction, info, nodes, primitives, materials, lights, corners, textures, texels,
    );
    queries.set(i, query);
    vertices.set(i, vertex);
}

/// Follows a path through mirrors and glass to the first diffuse surface: where that is, and what the path knows of it.
#[inline]
pub(super) fn first_diffuse(
    known: impl Known,
    rng: Rng,
    mut origin: Vec3,
    mut direction: Vec3,
    info: &SceneInfo,
    nodes: &Input<BvhNode>,
    primitives: &Input<Primitive>,
    materials: &Input<Material>,
    lights: &Input<Light>,
    corners: &Input<Corners>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> (Query, Vertex) {
    let mut throughput = Vec3::ONE;
    let mut query = Query { position: [0.0; 3], active: 0 };
    let mut vertex =
        Vertex { normal: [0.0; 3], primitive: LOST, weight: [0.0; 3], emitted: [0.0; 3], rays: 0, distance: 0.0 };
    let mut emitted = Vec3::ZERO;
    let mut medium = VACUUM;
    // Density with which the glossy lobe of the last surface drew the direction; 0 where shadow rays do not draw it.
    let mut density = 0.0;
    let mut bounce = 0;
    while bounce < MAX_BOUNCES {
        vertex.rays += 1;
        let hit = closest_hit(known, origin, direction, info, nodes, primitives, materials, corners, textures, texels);
        if hit.primitive == MISS || hit.primitive == LOST {
            vertex.primitive = hit.primitive;
            if known.sky() && hit.primitive == MISS {
                let found = leaving(direction, density, info, lights, textures, texels);
                emitted += throughput * found * outside(medium, materials);
            }
            break;
        }
        vertex.distance += hit.t;
        let primitive = primitives[hit.primitive as usize];
        let (surface, material) =
            surface_of(known, origin, direction, hit, info, &primitive, materials, corners, textures, texels);
        let point = surface.position;
        let cos = dot(direction, surface.normal);
        // Radiance inside of a medium, seen from where the camera is.
        let mut seen = 1.0;
        if known.media() {
            medium = medium_before(medium, &material, primitive.material, cos);
            if medium != VACUUM {
                throughput *= through(medium, hit.t, materials);
                if absorbs(&materials[medium as usize]) {
                    throughput *= roulette(throughput, Vec3::ONE, rng.draw4(FAINT_DIMENSION + bounce)[0]);
                }
                if throughput == Vec3::ZERO {
                    vertex.primitive = MISS;
                    break;
                }
            }
            seen = outside(medium, materials);
        }
        if primitive.light != NO_LIGHT && cos < 0.0 {
            let light = lights[primitive.light as usize];
            let mut found = throughput * emission_at(known, &light, surface.uv, textures, texels);
            if known.media() {
                found *= seen;
            }
            if known.gloss() && density > 0.0 {
                found *= power_heuristic(density, look_density(known, &light, origin, direction, hit.t));
            }
            emitted += found;
        }
        if material.kind == MATERIAL_LAMBERTIAN {
            query = Query { position: point.to_array(), active: 1 };
            vertex.normal = surface.facing(surface.shading, direction).to_array();
            vertex.primitive = hit.primitive;
            let mut reflected = throughput * Vec3::from_array(material.reflectance);
            if known.media() {
                reflected *= seen;
            }
            vertex.weight = (reflected * div(1.0, core::f32::consts::PI)).to_array();
            break;
        }
        let draw = rng.draw4(bounce);
        let cos_seen = abs(dot(direction, surface.shading));
        let chance = if known.gloss() { specular_chance(known, &material, cos_seen) } else { 1.0 };
        if known.gloss() && is_glossy(&material) && info.lights > 0 {
            let random = rng.draw4(SHADOW_DIMENSION + bounce);
            let place = [random[0], random[1], random[2]];
            let lit = next_event::<true>(
                known,
                direction,
                cos,
                &surface,
                &primitive,
                primitive.material,
                &material,
                chance,
                medium,
                place,
                info,
                nodes,
                primitives,
                materials,
                lights,
                corners,
                textures,
                texels,
            );
            emitted += throughput * lit.0;
            vertex.rays += lit.1;
            if lit.2 {
                vertex.primitive = LOST;
                break;
            }
        }
        if known.gloss() && draw[3] >= chance {
            query = Query { position: point.to_array(), active: 1 };
            vertex.normal = surface.facing(surface.shading, direction).to_array();
            vertex.primitive = hit.primitive;
            let reflected = throughput * albedo_diffuse(known, &material, cos_seen) * seen;
            vertex.weight = (reflected * div(1.0, core::f32::consts::PI * (1.0 - chance))).to_array();
            break;
        }
        let scattered = sample_specular(known, &material, direction, surface.shading, [draw[1], draw[2], draw[0]]);
        throughput *= scattered.weight;
        if known.gloss() && chance < 1.0 {
            throughput *= div(1.0, chance);
        }
        if known.gloss() {
            density = scattered.pdf * chance;
        }
        direction = scattered.direction;
        let side = surface.side(scattered.side, direction);
        if leaks(&material, &surface, cos, side) {
            throughput = Vec3::ZERO;
        }
        if known.media() {
            medium = medium_after(medium, &material, primitive.material, cos, surface.normal, side);
        }
        origin = leave(point, side, &primitive);
        if max(throughput.x, max(throughput.y, throughput.z)) < NOTHING {
            vertex.primitive = MISS;
            break;
        }
        bounce += 1;
    }
    vertex.emitted = emitted.to_array();
    (query, vertex)
}

/// The ray of a sample: its origin and unit direction.
#[inline]
pub(super) fn eye_ray(camera: &Camera, pixel: u32, sample: u32, seed: u32) -> (Vec3, Vec3) {
    let jitter = pixel_sobol(pixel, sample, seed, FILM_KEY);
    let x = (pixel % camera.width) as f32 + jitter[0] * camera.jitter;
    let y = (pixel / camera.width) as f32 + jitter[1] * camera.jitter;
    let origin = Vec3::from_array(camera.origin);
    let forward =
        Vec3::from_array(camera.corner) + Vec3::from_array(camera.right) * x + Vec3::from_array(camera.down) * y;
    if camera.focus > 0.0 {
        // The film's plane is at distance 1, so this is the point in focus; all of the lens sees it at one place.
        let [u, v] = pixel_sobol(pixel, sample, seed, LENS_KEY);
        let on_lens = lens_point(camera, u, v);
        return (origin + on_lens, normalize(forward * camera.focus - on_lens));
    }
    (origin, normalize(forward))
}

/// Point (u, v) of the lens, evenly drawn, from its middle, m.
#[inline]
#[must_use]
pub fn lens_point(camera: &Camera, u: f32, v: f32) -> Vec3 {
    let [x, y] = sample_disc(u, v);
    Vec3::from_array(camera.lens[0]) * x + Vec3::from_array(camera.lens[1]) * y
}

/// Density with which [`lens_point`] draws each point of the lens, m⁻².
#[inline]
#[must_use]
pub fn lens_density(camera: &Camera) -> f32 {
    let radius = Vec3::from_array(camera.lens[0]);
    div(1.0, core::f32::consts::PI * dot(radius, radius))
}

/// The numbers from which [`lens_point`] draws a point.
#[inline]
#[must_use]
pub fn invert_lens(camera: &Camera, point: Vec3) -> [f32; 2] {
    let [a, b] = [Vec3::from_array(camera.lens[0]), Vec3::from_array(camera.lens[1])];
    invert_disc([div(dot(point, a), dot(a, a)), div(dot(point, b), dot(b, b))])
}

/// Sample `sample` of a pixel's own shuffled and scrambled (0, 2)-sequence: the samples of a pixel are stratified, and those
/// of different pixels and purposes are independent.
#[inline]
#[must_use]
pub(super) fn pixel_sobol(pixel: u32, sample: u32, seed: u32, key: u32) -> [f32; 2] {
    let scramble = pcg4d([pixel, key, seed, STREAM]);
    sobol2(shuffle_index(sample, scramble[2]), [scramble[0], scramble[1]])
}
