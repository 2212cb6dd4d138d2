//! Unbiased paths from the camera to the lights: the reference that photon maps are held against.
//!
//! At each surface a light is sampled (next event estimation), and a direction is drawn that may meet a light itself; both are combined by
//! the power heuristic (Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, section 9.2). Paths end by
//! Russian roulette.

use super::MAX_BOUNCES;
use super::bvh::BvhNode;
use super::camera::{Camera, CameraTile, Vertex, film_direction};
use super::emission::{choose_light, light_point};
use super::intersect::{LOST, MISS, closest_hit, leave, occluded, surface_at};
use super::material::scatter_specular;
use super::scene::{LIGHT_AREA, Light, MATERIAL_LAMBERTIAN, Material, NO_LIGHT, Primitive, SceneInfo};
use super::vector::{dot, sample_cosine};
use crate::exec::{Input, Store};
use crate::num::{Rng, div, max, sqrt};
use glam::Vec3;

/// Stream of these paths' random numbers.
const STREAM: u32 = 3;
/// Bounces before Russian roulette begins.
const SURE_BOUNCES: u32 = 4;
/// Least chance of going on: a path that is worth little is made worth no more than twenty times that.
const LEAST_CHANCE: f32 = 0.05;
const INVERSE_PI: f32 = core::f32::consts::FRAC_1_PI;

/// A direction drawn at a surface.
struct Drawn {
    direction: Vec3,
    side: Vec3,
    weight: Vec3,
    /// Density, sr⁻¹; 0 of a delta lobe.
    pdf: f32,
}

#[inline]
fn sample(material: &Material, d: Vec3, n: Vec3, u: [f32; 3]) -> Drawn {
    if material.kind == MATERIAL_LAMBERTIAN {
        let side = if dot(d, n) > 0.0 { -n } else { n };
        let direction = sample_cosine(side, u[0], u[1]);
        let pdf = max(0.0, dot(direction, side)) * INVERSE_PI;
        return Drawn { direction, side, weight: Vec3::from_array(material.reflectance), pdf };
    }
    let scattered = scatter_specular(material, d, n, u[2]);
    Drawn { direction: scattered.direction, side: scattered.side, weight: scattered.weight, pdf: 0.0 }
}

/// f·|cos θ| towards `out`, and the density with which it is drawn.
#[inline]
fn evaluate(material: &Material, d: Vec3, out: Vec3, n: Vec3) -> (Vec3, f32) {
    let side = if dot(d, n) > 0.0 { -n } else { n };
    let cos = dot(out, side);
    if material.kind == MATERIAL_LAMBERTIAN && cos > 0.0 {
        (Vec3::from_array(material.reflectance) * (cos * INVERSE_PI), cos * INVERSE_PI)
    } else {
        (Vec3::ZERO, 0.0)
    }
}

/// 1 over the density, sr⁻¹, with which the light's point in direction `direction` and at the squared distance `distance2` is
/// sampled; 0 if it does not shine here.
#[inline]
fn inverse_density(light: &Light, direction: Vec3, distance2: f32) -> f32 {
    let chance = distance2 * light.probability;
    if light.kind != LIGHT_AREA {
        return div(1.0, chance);
    }
    let cos = -dot(Vec3::from_array(light.normal), direction);
    if cos > 0.0 { div(cos * light.area, chance) } else { 0.0 }
}

/// The power heuristic's weight of a sample, from the ratio of the other technique's density to its own.
#[inline]
fn heuristic(ratio: f32) -> f32 {
    div(1.0, 1.0 + ratio * ratio)
}

/// Radiance along sample `i` of the tile, in [`Vertex::emitted`]; the rest of the vertex is that of the first surface.
#[inline]
pub fn trace_paths<V: Store<Vertex> + ?Sized>(
    i: u32,
    tile: &CameraTile,
    camera: &Camera,
    info: &SceneInfo,
    nodes: &Input<BvhNode>,
    primitives: &Input<Primitive>,
    materials: &Input<Material>,
    lights: &Input<Light>,
    vertices: &mut V,
) {
    if i >= tile.pixels * tile.samples {
        return;
    }
    let pixel = tile.first_pixel + i / tile.samples;
    let index = i % tile.samples;
    let rng = Rng { seed: tile.seed, stream: STREAM ^ (index << 8), index: pixel };
    let mut origin = Vec3::from_array(camera.origin);
    let mut direction = film_direction(pixel, index, tile.seed, camera);
    let mut vertex = Vertex { normal: [0.0; 3], primitive: LOST, weight: [0.0; 3], emitted: [0.0; 3], rays: 0 };
    let mut radiance = Vec3::ZERO;
    let mut throughput = Vec3::ONE;
    // Density with which the direction was drawn; 0 where no light was sampled for it.
    let mut pdf = 0.0;
    let mut bounce = 0;
    let mut going = true;
    let mut lost = false;
    while going {
        vertex.rays += 1;
        let hit = closest_hit(origin, direction, info, nodes, primitives);
        if bounce == 0 {
            vertex.primitive = hit.primitive;
        }
        if hit.primitive == MISS || hit.primitive == LOST {
            lost = hit.primitive == LOST;
            break;
        }
        let primitive = primitives[hit.primitive as usize];
        let material = materials[primitive.material as usize];
        let (point, normal) = surface_at(origin, direction, hit.t, &primitive);
        if primitive.light != NO_LIGHT && dot(direction, normal) < 0.0 {
            let light = lights[primitive.light as usize];
            let other = pdf * inverse_density(&light, direction, hit.t * hit.t);
            let share = if pdf == 0.0 { 1.0 } else { heuristic(div(1.0, other)) };
            radiance += throughput * Vec3::from_array(light.emission) * share;
        }

        let draw = rng.draw4(2 * bounce);
        if material.kind == MATERIAL_LAMBERTIAN && info.lights > 0 {
            let side = if dot(direction, normal) > 0.0 { -normal } else { normal };
            let light = lights[choose_light(draw[0], info, lights) as usize];
            let from = leave(point, side, &primitive);
            let to_light = light_point(&light, draw[1], draw[2]) - from;
            let distance2 = dot(to_light, to_light);
            let distance = sqrt(distance2);
            if distance > 0.0 {
                let out = to_light * div(1.0, distance);
                let (value, other) = evaluate(&material, direction, out, normal);
                let inverse = inverse_density(&light, out, distance2);
                if inverse > 0.0 && max(value.x, max(value.y, value.z)) > 0.0 {
                    let blocker = occluded(from, out, distance, light.primitive, info, nodes, primitives);
                    vertex.rays += 1;
                    lost = lost || blocker == LOST;
                    if blocker == MISS {
                        let share = if light.kind == LIGHT_AREA { heuristic(other * inverse) } else { 1.0 };
                        radiance += throughput * value * Vec3::from_array(light.emission) * (inverse * share);
                    }
                }
            }
        }

        let turn = rng.draw4(2 * bounce + 1);
        let drawn = sample(&material, direction, normal, [turn[0], turn[1], turn[2]]);
        throughput *= drawn.weight;
        pdf = drawn.pdf;
        direction = drawn.direction;
        origin = leave(point, drawn.side, &primitive);
        let brightest = max(throughput.x, max(throughput.y, throughput.z));
        bounce += 1;
        if bounce >= SURE_BOUNCES && brightest < 1.0 {
            let chance = max(LEAST_CHANCE, brightest);
            going = turn[3] < chance;
            throughput *= div(1.0, chance);
        }
        going = going && brightest > 0.0;
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
