//! Unbiased paths from the camera to the lights: the reference that photon maps are held against.
//!
//! At each surface a light is sampled (next event estimation), and a direction is drawn that may meet a light itself; both are combined by
//! the power heuristic (Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, section 9.2). Paths end by
//! Russian roulette.

use super::MAX_BOUNCES;
use super::bsdf::sample;
use super::bvh::BvhNode;
use super::camera::{Camera, CameraTile, Vertex, eye_ray};
use super::intersect::{LOST, MISS, closest_hit, leave};
use super::known::Known;
use super::light::{emission_at, look_density, power_heuristic};
use super::medium::{VACUUM, leaks, medium_after, medium_before};
use super::next_event::{next_event, outside, through};
use super::scene::{Light, Material, NO_LIGHT, Primitive, SceneInfo};
use super::sky::leaving;
use super::surface::{Corners, surface_of};
use super::texture::{Texel, Texture};
use super::vector::dot;
use crate::exec::{Input, Store};
use crate::num::{Rng, div, max};
use glam::Vec3;

/// Stream of these paths' random numbers.
const STREAM: u32 = 3;
/// Bounces before Russian roulette begins.
const SURE_BOUNCES: u32 = 4;
/// Least chance of going on: a path that is worth little is made worth no more than twenty times that.
const LEAST_CHANCE: f32 = 0.05;
/// A throughput below which a path has ended: a product of it is no longer a normal float.
const NOTHING: f32 = 1e-30;

/// Radiance along sample `i` of the tile, in [`Vertex::emitted`]; of the rest of the vertex, the primitive is the first that was met,
/// or [`LOST`] if any ray of the path was.
#[inline]
pub fn trace_paths<V: Store<Vertex> + ?Sized>(
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
    vertices: &mut V,
) {
    if i >= tile.pixels * tile.samples {
        return;
    }
    let pixel = tile.first_pixel + i / tile.samples;
    let index = i % tile.samples;
    let rng = Rng { seed: tile.seed, stream: STREAM ^ (index << 8), index: pixel };
    let (mut origin, mut direction) = eye_ray(camera, pixel, index, tile.seed);
    let mut vertex =
        Vertex { normal: [0.0; 3], primitive: LOST, weight: [0.0; 3], emitted: [0.0; 3], rays: 0, distance: 0.0 };
    let mut radiance = Vec3::ZERO;
    let mut throughput = Vec3::ONE;
    let mut medium = VACUUM;
    // Density with which the direction was drawn; 0 where no light was sampled for it.
    let mut density = 0.0;
    let mut bounce = 0;
    let mut going = true;
    let mut lost = false;
    while going {
        vertex.rays += 1;
        let hit = closest_hit(known, origin, direction, info, nodes, primitives, materials, corners, textures, texels);
        if bounce == 0 {
            vertex.primitive = hit.primitive;
        }
        if hit.primitive == MISS || hit.primitive == LOST {
            lost = lost || hit.primitive == LOST;
            if known.sky() && hit.primitive == MISS {
                let found = leaving(direction, density, info, lights, textures, texels);
                radiance += throughput * found * outside(medium, materials);
            }
            break;
        }
        let primitive = primitives[hit.primitive as usize];
        let (surface, material) =
            surface_of(known, origin, direction, hit, info, &primitive, materials, corners, textures, texels);
        let cos = dot(direction, surface.normal);
        // Radiance inside of a medium, seen from where the camera is.
        let mut seen = 1.0;
        if known.media() {
            medium = medium_before(medium, &material, primitive.material, cos);
            throughput *= through(medium, hit.t, materials);
            seen = outside(medium, materials);
        }
        if primitive.light != NO_LIGHT && cos < 0.0 {
            let light = lights[primitive.light as usize];
            let mut share = 1.0;
            if density > 0.0 {
                share = power_heuristic(density, look_density(known, &light, origin, direction, hit.t));
            }
            let emission = emission_at(known, &light, surface.uv, textures, texels);
            radiance += throughput * emission * (share * seen);
        }

        let draw = rng.draw4(2 * bounce);
        if info.lights > 0 {
            let place = [draw[0], draw[1], draw[2]];
            let index = primitive.material;
            let lit = next_event::<false>(
                known, direction, cos, &surface, &primitive, index, &material, 1.0, medium, place, info, nodes,
                primitives, materials, lights, corners, textures, texels,
            );
            radiance += throughput * lit.0;
            vertex.rays += lit.1;
            lost = lost || lit.2;
        }

        let turn = rng.draw4(2 * bounce + 1);
        let scattered = sample(known, &material, direction, surface.shading, [turn[0], turn[1], turn[2]]);
        throughput *= scattered.weight;
        density = scattered.pdf;
        direction = scattered.direction;
        let side = surface.side(scattered.side, direction);
        if leaks(&material, &surface, cos, side) {
            throughput = Vec3::ZERO;
        }
        if known.media() {
            medium = medium_after(medium, &material, primitive.material, cos, surface.normal, side);
        }
        origin = leave(surface.position, side, &primitive);
        let brightest = max(throughput.x, max(throughput.y, throughput.z));
        bounce += 1;
        if bounce >= SURE_BOUNCES && brightest < 1.0 {
            let chance = max(LEAST_CHANCE, brightest);
            going = turn[3] < chance;
            throughput *= div(1.0, chance);
        }
        going = going && brightest >= NOTHING;
        if going && bounce == MAX_BOUNCES {
            lost = true;
            going = false;
        }
    }
    if lost {
        vertex.primitive = LOST;
    }
    vertex.emitted = radiance.to_array();
    vertices.set(i, vertex);
}
