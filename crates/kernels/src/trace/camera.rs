//! Camera paths, down to the first diffuse surface.

use super::MAX_BOUNCES;
use super::bvh::BvhNode;
use super::intersect::{LOST, MISS, closest_hit, leave, surface_at};
use super::material::scatter_specular;
use super::scene::{Light, MATERIAL_LAMBERTIAN, Material, NO_LIGHT, Primitive, SceneInfo};
use super::vector::{dot, normalize};
use crate::exec::{Input, Store};
use crate::layout::Query;
use crate::num::{Rng, div, pcg4d, shuffle_index, sobol2};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Stream of the camera's random numbers; the photon passes have 0 and 1.
const STREAM: u32 = 2;
/// Key of the sequence that places samples on the film; [`direct`](super::direct) has others.
const FILM_KEY: u32 = 0x5f1a_0000;

/// A pinhole camera.
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
    /// Unit normal of the side that is seen.
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
#[inline]
pub fn trace_camera<Q: Store<Query> + ?Sized, V: Store<Vertex> + ?Sized>(
    i: u32,
    tile: &CameraTile,
    camera: &Camera,
    info: &SceneInfo,
    nodes: &Input<BvhNode>,
    primitives: &Input<Primitive>,
    materials: &Input<Material>,
    lights: &Input<Light>,
    queries: &mut Q,
    vertices: &mut V,
) {
    if i >= tile.pixels * tile.samples {
        return;
    }
    let pixel = tile.first_pixel + i / tile.samples;
    let sample = i % tile.samples;
    let rng = Rng { seed: tile.seed, stream: STREAM ^ (sample << 8), index: pixel };
    let jitter = pixel_sobol(pixel, sample, tile.seed, FILM_KEY);
    let x = (pixel % camera.width) as f32 + jitter[0];
    let y = (pixel / camera.width) as f32 + jitter[1];
    let mut direction = normalize(
        Vec3::from_array(camera.corner) + Vec3::from_array(camera.right) * x + Vec3::from_array(camera.down) * y,
    );
    let mut origin = Vec3::from_array(camera.origin);
    let mut throughput = Vec3::ONE;
    let mut query = Query { position: [0.0; 3], active: 0 };
    let mut vertex =
        Vertex { normal: [0.0; 3], primitive: LOST, weight: [0.0; 3], emitted: [0.0; 3], rays: 0, distance: 0.0 };
    let mut bounce = 0;
    while bounce < MAX_BOUNCES {
        vertex.rays += 1;
        let hit = closest_hit(origin, direction, info, nodes, primitives);
        if hit.primitive == MISS || hit.primitive == LOST {
            vertex.primitive = hit.primitive;
            break;
        }
        vertex.distance += hit.t;
        let primitive = primitives[hit.primitive as usize];
        let material = materials[primitive.material as usize];
        let (point, normal) = surface_at(origin, direction, hit.t, &primitive);
        let cos = dot(direction, normal);
        if primitive.light != NO_LIGHT && cos < 0.0 {
            vertex.emitted = (throughput * Vec3::from_array(lights[primitive.light as usize].emission)).to_array();
        }
        if material.kind == MATERIAL_LAMBERTIAN {
            let facing = if cos > 0.0 { -normal } else { normal };
            query = Query { position: point.to_array(), active: 1 };
            vertex.normal = facing.to_array();
            vertex.primitive = hit.primitive;
            let reflected = throughput * Vec3::from_array(material.reflectance);
            vertex.weight = (reflected * div(1.0, core::f32::consts::PI)).to_array();
            break;
        }
        let draw = rng.draw4(bounce);
        let scattered = scatter_specular(&material, direction, normal, draw[0]);
        throughput *= scattered.weight;
        direction = scattered.direction;
        origin = leave(point, scattered.side, &primitive);
        bounce += 1;
    }
    queries.set(i, query);
    vertices.set(i, vertex);
}

/// Sample `sample` of a pixel's own shuffled and scrambled (0, 2)-sequence: the samples of a pixel are stratified, and those
/// of different pixels and purposes are independent.
#[inline]
#[must_use]
pub(super) fn pixel_sobol(pixel: u32, sample: u32, seed: u32, key: u32) -> [f32; 2] {
    let scramble = pcg4d([pixel, key, seed, STREAM]);
    sobol2(shuffle_index(sample, scramble[2]), [scramble[0], scramble[1]])
}
