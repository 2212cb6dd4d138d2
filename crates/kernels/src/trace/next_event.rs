//! Lights sampled from a surface that a camera path meets, beside paths that meet the lights themselves.

use super::bsdf::{evaluate, evaluate_specular};
use super::bvh::BvhNode;
use super::intersect::{BLOCKED, LOST, leave, occluded};
use super::known::Known;
use super::light::{can_be_met, choose_light, look, power_heuristic};
use super::medium::{VACUUM, medium_after, seen_from_outside, transmittance};
use super::scene::{Light, Material, Primitive, SceneInfo};
use super::surface::{Corners, Surface};
use super::texture::{Texel, Texture};
use super::vector::dot;
use crate::exec::Input;
use crate::num::div;
use glam::Vec3;

/// What a surface sends back along a ray of one place of one light, by a shadow ray, beside paths that meet it: radiance for the path's
/// throughput, the number of rays, and whether one was lost. `GLOSS` leaves the diffuse lobe out; `chance` is the one with which the path goes on through
/// the lobes that are in. `medium` is that of the ray that came here.
#[inline]
pub(super) fn next_event<const GLOSS: bool>(
    known: impl Known,
    direction: Vec3,
    cos: f32,
    surface: &Surface,
    primitive: &Primitive,
    index: u32,
    material: &Material,
    chance: f32,
    medium: u32,
    place: [f32; 3],
    info: &SceneInfo,
    nodes: &Input<BvhNode>,
    primitives: &Input<Primitive>,
    materials: &Input<Material>,
    lights: &Input<Light>,
    corners: &Input<Corners>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> (Vec3, u32, bool) {
    let nothing = (Vec3::ZERO, 0, false);
    let light = lights[choose_light(place[0], info, lights) as usize];
    let glimpse = look(known, &light, surface.position, place[1], place[2], info, corners, textures, texels);
    if glimpse.distance <= 0.0 {
        return nothing;
    }
    let out = glimpse.direction;
    let (value, pdf) = if GLOSS {
        evaluate_specular(known, material, direction, out, surface.shading)
    } else {
        evaluate(known, material, direction, out, surface.shading)
    };
    let geometry = glimpse.geometry(1.0, light.probability);
    let mut radiance = value * glimpse.emission * geometry;
    if radiance.x + radiance.y + radiance.z <= 0.0 {
        return nothing;
    }
    // The sampler's side by the shading normal has to be the side by the surface itself, or light would leak through.
    let by_surface = dot(out, surface.normal) > 0.0;
    if by_surface != (dot(out, surface.shading) > 0.0) {
        return nothing;
    }
    if can_be_met(known, &light) {
        radiance *= power_heuristic(div(1.0, geometry), pdf * chance);
    }
    let side = if by_surface { surface.normal } else { -surface.normal };
    // The light is in the medium that the shadow ray is in.
    if known.media() {
        let medium = medium_after(medium, material, index, cos, surface.normal, side);
        radiance *= through(medium, glimpse.distance, materials) * outside(medium, materials);
    }
    let origin = leave(surface.position, side, primitive);
    let except = light.primitive;
    let blocker = occluded(
        known,
        origin,
        out,
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
    if blocker == BLOCKED { (Vec3::ZERO, 1, false) } else { (radiance, 1, blocker == LOST) }
}

/// Share of the light that is left after some way through a medium.
#[inline]
pub(super) fn through(medium: u32, distance: f32, materials: &Input<Material>) -> Vec3 {
    if medium == VACUUM { Vec3::ONE } else { transmittance(&materials[medium as usize], distance) }
}

/// What radiance inside of a medium is multiplied with where it is seen from outside.
#[inline]
pub(super) fn outside(medium: u32, materials: &Input<Material>) -> f32 {
    if medium == VACUUM { 1.0 } else { seen_from_outside(&materials[medium as usize]) }
}
