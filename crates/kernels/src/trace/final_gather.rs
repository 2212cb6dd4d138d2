//! Final gather: indirect light at a point from what its hemisphere sees of the global map, so that no estimate is looked at directly
//! (Jensen, "Realistic Image Synthesis Using Photon Mapping", 2001, section 9.2).

use super::bsdf::entrance;
use super::bvh::BvhNode;
use super::camera::{Vertex, first_diffuse, pixel_sobol};
use super::intersect::leave;
use super::known::Known;
use super::scene::{Light, Material, PRIMITIVE_SPHERE, Primitive, SceneInfo};
use super::surface::Corners;
use super::texture::{Texel, Texture};
use super::vector::{dot, sample_cosine};
use crate::exec::{Input, Store};
use crate::gather::CUT_SHORT;
use crate::layout::{Irradiance, Query};
use crate::num::{Rng, div};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Stream of the random numbers of these rays.
const STREAM: u32 = 4;
/// Key of the sequence that spreads a pixel's rays over hemispheres.
const KEY: u32 = 0x5f1a_0004;

/// The samples for which rays are gathered.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GatherTile {
    /// First pixel, counted row by row.
    pub first_pixel: u32,
    /// Pixels in the tile.
    pub pixels: u32,
    /// Camera samples a pixel.
    pub samples: u32,
    /// Rays a camera sample.
    pub rays: u32,
    /// Seed of the random numbers.
    pub seed: u32,
}

/// Sends ray `i` of the tile from its sample's point, with the density cos θ / π, and follows it to the next diffuse surface.
#[inline]
pub fn trace_gather<Q: Store<Query> + ?Sized, V: Store<Vertex> + ?Sized>(
    known: impl Known,
    i: u32,
    tile: &GatherTile,
    info: &SceneInfo,
    nodes: &Input<BvhNode>,
    primitives: &Input<Primitive>,
    materials: &Input<Material>,
    lights: &Input<Light>,
    corners: &Input<Corners>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
    queries: &Input<Query>,
    vertices: &Input<Vertex>,
    gather_queries: &mut Q,
    gather_vertices: &mut V,
) {
    let sample = i / tile.rays;
    if sample >= tile.pixels * tile.samples {
        return;
    }
    let query = queries[sample as usize];
    let mut found = Query { position: [0.0; 3], active: 0 };
    let mut seen = Vertex {
        normal: [0.0; 3],
        primitive: super::MISS,
        weight: [0.0; 3],
        emitted: [0.0; 3],
        rays: 0,
        distance: 0.0,
    };
    if query.active != 0 {
        let vertex = vertices[sample as usize];
        let normal = Vec3::from_array(vertex.normal);
        let pixel = tile.first_pixel + sample / tile.samples;
        let number = (sample % tile.samples) * tile.rays + i % tile.rays;
        let at = pixel_sobol(pixel, number, tile.seed, KEY);
        let direction = sample_cosine(normal, at[0], at[1]);
        let primitive = primitives[vertex.primitive as usize];
        // The side that is seen, of the surface as it is: a shading normal may send rays through it.
        let mut side = normal;
        if primitive.kind != PRIMITIVE_SPHERE {
            side = Vec3::from_array(primitive.normal);
            side = if dot(side, normal) < 0.0 { -side } else { side };
        }
        if dot(direction, side) > 0.0 {
            let origin = leave(Vec3::from_array(query.position), side, &primitive);
            let rng = Rng { seed: tile.seed, stream: STREAM ^ (number << 8), index: pixel };
            (found, seen) = first_diffuse(
                known, rng, origin, direction, info, nodes, primitives, materials, lights, corners, textures, texels,
            );
            let enters = entrance(known, &materials[primitive.material as usize], dot(direction, normal));
            seen.weight = (Vec3::from_array(seen.weight) * enters).to_array();
        }
    }
    gather_queries.set(i, found);
    gather_vertices.set(i, seen);
}

/// Irradiance of sample `i` from its rays: π times the mean of the radiance they bring, since they are drawn with cos θ / π. What they
/// see of lights is left out: that is direct light, or a caustic.
#[inline]
pub fn sum_gather<I: Store<Irradiance> + ?Sized>(
    i: u32,
    tile: &GatherTile,
    gather_vertices: &Input<Vertex>,
    estimates: &Input<Irradiance>,
    irradiance: &mut I,
) {
    if i >= tile.pixels * tile.samples {
        return;
    }
    let mut sum = Vec3::ZERO;
    let mut lost_digits = Vec3::ZERO;
    let mut photons = 0;
    let mut ray = 0;
    while ray < tile.rays {
        let at = (i * tile.rays + ray) as usize;
        let estimate = estimates[at];
        // Compensated, as the film is.
        let term = Vec3::from_array(gather_vertices[at].weight) * Vec3::from_array(estimate.rgb) - lost_digits;
        let next = sum + term;
        lost_digits = (next - sum) - term;
        sum = next;
        photons =
            if estimate.photons == CUT_SHORT || photons == CUT_SHORT { CUT_SHORT } else { photons + estimate.photons };
        ray += 1;
    }
    let scale = div(core::f32::consts::PI, tile.rays as f32);
    irradiance.set(i, Irradiance { rgb: (sum * scale).to_array(), photons });
}
