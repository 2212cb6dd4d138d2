//! Light that arrives straight from the lights, by shadow rays.

use super::bvh::BvhNode;
use super::camera::{CameraTile, Vertex, pixel_sobol};
use super::emission::{choose_light, light_point};
use super::intersect::{LOST, MISS, leave, occluded};
use super::scene::{LIGHT_AREA, Light, PRIMITIVE_SPHERE, Primitive, SceneInfo};
use super::vector::dot;
use crate::exec::{Input, Store};
use crate::gather::CUT_SHORT;
use crate::layout::{Irradiance, Query};
use crate::num::{div, sqrt};
use glam::Vec3;

const POINT_KEY: u32 = 0x5f1a_0001;
const CHOICE_KEY: u32 = 0x5f1a_0002;

/// Irradiance of vertex `i` from one point of one light: L·cos θ·cos θ'·A / d² over the light's chance, or I·cos θ / d² for
/// a point light. Glass blocks shadow rays: what it lets through is a caustic. In place of photons it counts shadow rays.
#[inline]
pub fn shade_direct<const FULL: bool, D: Store<Irradiance> + ?Sized>(
    i: u32,
    tile: &CameraTile,
    info: &SceneInfo,
    nodes: &Input<BvhNode>,
    primitives: &Input<Primitive>,
    lights: &Input<Light>,
    queries: &Input<Query>,
    vertices: &Input<Vertex>,
    direct: &mut D,
) {
    if i >= tile.pixels * tile.samples {
        return;
    }
    let query = queries[i as usize];
    let mut result = Irradiance { rgb: [0.0; 3], photons: 0 };
    if query.active != 0 && info.lights > 0 {
        let pixel = tile.first_pixel + i / tile.samples;
        let sample = i % tile.samples;
        let choice = pixel_sobol(pixel, sample, tile.seed, CHOICE_KEY);
        let at = pixel_sobol(pixel, sample, tile.seed, POINT_KEY);
        let light = lights[choose_light(choice[0], info, lights) as usize];
        let vertex = vertices[i as usize];
        let normal = Vec3::from_array(vertex.normal);
        let primitive = primitives[vertex.primitive as usize];
        // The side that is seen, of the surface as it is.
        let mut side = normal;
        if FULL && primitive.kind != PRIMITIVE_SPHERE {
            side = Vec3::from_array(primitive.normal);
            side = if dot(side, normal) < 0.0 { -side } else { side };
        }
        let origin = leave(Vec3::from_array(query.position), side, &primitive);
        let to_light = light_point(&light, at[0], at[1]) - origin;
        let distance2 = dot(to_light, to_light);
        let distance = sqrt(distance2);
        if distance > 0.0 {
            let direction = to_light * div(1.0, distance);
            let cos = dot(normal, direction);
            let mut geometry = 0.0;
            if cos > 0.0 && dot(side, direction) > 0.0 {
                geometry = div(cos, distance2 * light.probability);
                if light.kind == LIGHT_AREA {
                    let cos_light = -dot(Vec3::from_array(light.normal), direction);
                    geometry = if cos_light > 0.0 { geometry * cos_light * light.area } else { 0.0 };
                }
            }
            if geometry > 0.0 {
                let blocker = occluded::<FULL>(origin, direction, distance, light.primitive, info, nodes, primitives);
                result.photons = 1;
                if blocker == MISS {
                    result.rgb = (Vec3::from_array(light.emission) * geometry).to_array();
                } else if blocker == LOST {
                    result.photons = CUT_SHORT;
                }
            }
        }
    }
    direct.set(i, result);
}
