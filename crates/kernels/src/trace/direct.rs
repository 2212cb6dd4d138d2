//! Light that arrives straight from the lights, by shadow rays.

use super::bsdf::entrance;
use super::bvh::BvhNode;
use super::camera::{CameraTile, Vertex, pixel_sobol};
use super::intersect::{LOST, MISS, leave, occluded};
use super::known::Known;
use super::light::{choose_light, look};
use super::scene::{Light, Material, PRIMITIVE_SPHERE, Primitive, SceneInfo};
use super::surface::Corners;
use super::texture::{Texel, Texture};
use super::vector::dot;
use crate::exec::{Input, Store};
use crate::gather::CUT_SHORT;
use crate::layout::{Irradiance, Query};
use glam::Vec3;

const POINT_KEY: u32 = 0x5f1a_0001;
const CHOICE_KEY: u32 = 0x5f1a_0002;

/// Irradiance of vertex `i` from one point of one light: L·cos θ·cos θ'·A / d² over the light's chance, or I·cos θ / d² for
/// a point light; as much of it as reaches the diffuse lobe. Glass blocks shadow rays: what it lets through is a caustic. In place
/// of photons it counts shadow rays.
#[inline]
pub fn shade_direct<D: Store<Irradiance> + ?Sized>(
    known: impl Known,
    i: u32,
    tile: &CameraTile,
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
        if known.bent() && primitive.kind != PRIMITIVE_SPHERE {
            side = Vec3::from_array(primitive.normal);
            side = if dot(side, normal) < 0.0 { -side } else { side };
        }
        let origin = leave(Vec3::from_array(query.position), side, &primitive);
        let glimpse = look(known, &light, origin, at[0], at[1], info, corners, textures, texels);
        if glimpse.distance > 0.0 {
            let direction = glimpse.direction;
            let cos = dot(normal, direction);
            let mut geometry = 0.0;
            if cos > 0.0 && dot(side, direction) > 0.0 {
                geometry = glimpse.geometry(cos, light.probability);
                if known.gloss() {
                    geometry *= entrance(known, &materials[primitive.material as usize], cos);
                }
            }
            if geometry > 0.0 {
                let except = light.primitive;
                let blocker = occluded(
                    known,
                    origin,
                    direction,
                    glimpse.distance,
                    except,
                    info,
                    nodes,
                    primitives,
                    materials,
                    corners,
                    textures,
                    texels,
                );
                result.photons = 1;
                if blocker == MISS {
                    result.rgb = (glimpse.emission * geometry).to_array();
                } else if blocker == LOST {
                    result.photons = CUT_SHORT;
                }
            }
        }
    }
    direct.set(i, result);
}
