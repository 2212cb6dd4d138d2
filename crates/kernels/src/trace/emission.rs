//! How photons leave the lights.

use super::known::Known;
use super::light::{emission_at, is_surface, light_point, place_on_light, spot_falloff};
use super::photons::{PhotonPass, RAY_GLOBAL};
use super::scene::{
    LIGHT_DIRECTIONAL, LIGHT_ENVIRONMENT, LIGHT_SPHERE, LIGHT_SPOT, Light, NO_LIGHT, SceneInfo, Target,
};
use super::sky::{sample_sky, sky_radiance};
use super::surface::Corners;
use super::texture::{Texel, Texture};
use super::vector::{axis_direction, cone, cone_density, dot, sample_cone, sample_cosine, sample_disc};
use crate::exec::Input;
use crate::num::{Rng, div};
use glam::Vec3;

const PI: f32 = core::f32::consts::PI;

/// A photon that has just been emitted.
pub struct Emitted {
    /// Where, m.
    pub origin: Vec3,
    /// Unit normal of the light there, if it is a surface.
    pub normal: Vec3,
    /// Unit direction of travel.
    pub direction: Vec3,
    /// Power, W, for each of red, green and blue; 0 if it was aimed where the light does not shine.
    pub power: Vec3,
    /// The primitive it left, or [`NO_LIGHT`].
    pub primitive: u32,
}

/// The light that emits photon `index` of a pass: the host has given each light its photons, one light's after another's.
#[inline]
#[must_use]
pub fn light_of_photon(index: u32, info: &SceneInfo, lights: &Input<Light>) -> u32 {
    // The last whose first photon is not beyond it and that has any.
    let mut first = 0;
    let mut last = info.lights - 1;
    while first < last {
        let middle = (first + last) / 2;
        let light = lights[middle as usize];
        if index >= light.first_photon + light.photons {
            first = middle + 1;
        } else {
            last = middle;
        }
    }
    first
}

/// Emits photon `index` of the pass.
///
/// Its power is emission over the density with which place and direction were drawn, over the number of photons that its light
/// emits. For a whole light this is Φ / n for every photon, and Φ is π·L·A of a surface, 4π·I of a point light, E·A of a directional
/// light's disc A, which covers the scene. Of an environment, a direction is drawn by its picture, with density p, then a place on such a disc across
/// it, and Φ / n is L·A / (n·p). Photons for the caustic map are aimed: a target is drawn among those that the light
/// can see, then a direction in the cone that it fills; of a directional light or an environment, a place in its shadow. The density is then the
/// mean over these targets of the reciprocals of the cones or shadows that hold it, so that they may overlap.
#[inline]
#[must_use]
pub fn emit(
    known: impl Known,
    index: u32,
    pass: &PhotonPass,
    info: &SceneInfo,
    lights: &Input<Light>,
    targets: &Input<Target>,
    corners: &Input<Corners>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> Emitted {
    let rng = Rng { seed: pass.seed, stream: pass.rays, index };
    let place = rng.draw4(0);
    let aim = rng.draw4(1);
    let light = lights[light_of_photon(index, info, lights) as usize];
    let share = div(1.0, light.photons as f32);
    let mut emission = Vec3::from_array(light.emission);
    if known.lamps() && light.kind == LIGHT_DIRECTIONAL {
        let (direction, middle) = (Vec3::from_array(light.normal), Vec3::from_array(light.position));
        return emit_parallel(pass.rays, &light, direction, middle, emission * share, targets, place, aim);
    }
    if known.sky() && light.kind == LIGHT_ENVIRONMENT {
        let drawn = sample_sky(&light, aim[0], aim[1], info, textures, texels);
        let radiance = sky_radiance(&light, drawn.direction, info, textures, texels);
        let middle = Vec3::from_array(light.position) + drawn.direction * light.edges[0][0];
        let irradiance = radiance * div(share, drawn.density);
        return emit_parallel(pass.rays, &light, -drawn.direction, middle, irradiance, targets, place, aim);
    }
    let mut origin = light_point(known, &light, place[1], place[2]);
    if known.textures() {
        let uv = place_on_light(known, &light, place[1], place[2], info, corners);
        emission = emission_at(known, &light, uv, textures, texels);
    }
    let mut normal = Vec3::from_array(light.normal);
    if known.lamps() && light.kind == LIGHT_SPHERE {
        normal = sample_cone(Vec3::Z, 2.0, place[1], place[2]);
        origin = Vec3::from_array(light.position) + normal * light.edges[0][0];
    }
    let surface = is_surface(known, &light);

    if pass.rays == RAY_GLOBAL {
        if surface {
            let direction = sample_cosine(normal, aim[0], aim[1]);
            return Emitted {
                origin,
                normal,
                direction,
                power: emission * (PI * light.area * share),
                primitive: light.primitive,
            };
        }
        if known.lamps() && light.kind == LIGHT_SPOT {
            let direction = sample_cone(normal, light.edges[0][1], aim[0], aim[1]);
            let solid_angle = 2.0 * PI * light.edges[0][1];
            let power = emission * (spot_falloff(&light, direction) * solid_angle * share);
            return Emitted { origin, normal, direction, power, primitive: NO_LIGHT };
        }
        let direction = sample_cone(Vec3::Z, 2.0, aim[0], aim[1]);
        return Emitted { origin, normal, direction, power: emission * (4.0 * PI * share), primitive: NO_LIGHT };
    }

    let chosen = choose_target(aim[2], &light);
    let target = targets[chosen as usize];
    let axis = Vec3::from_array(target.centre) - origin;
    let direction = sample_cone(axis_direction(axis), cone(axis, target.radius), aim[0], aim[1]);
    let mut density = 0.0;
    let mut j = light.first_target;
    while j < light.first_target + light.targets {
        let target = targets[j as usize];
        let axis = Vec3::from_array(target.centre) - origin;
        let one_minus_cos = cone(axis, target.radius);
        // The chosen cone holds its direction whatever rounding says of one on its rim.
        if j == chosen || dot(direction, axis_direction(axis)) >= 1.0 - one_minus_cos {
            density += cone_density(one_minus_cos);
        }
        j += 1;
    }
    let per_direction = div(light.targets as f32, density) * share;
    if surface {
        let cos = dot(direction, normal);
        let lit = if cos > 0.0 { cos * light.area * per_direction } else { 0.0 };
        return Emitted { origin, normal, direction, power: emission * lit, primitive: light.primitive };
    }
    let mut power = emission * per_direction;
    if known.lamps() && light.kind == LIGHT_SPOT {
        power *= spot_falloff(&light, direction);
    }
    Emitted { origin, normal, direction, power, primitive: NO_LIGHT }
}

/// One of the targets of a light.
#[inline]
fn choose_target(u: f32, light: &Light) -> u32 {
    let mut chosen = (u * light.targets as f32) as u32;
    if chosen >= light.targets {
        chosen = light.targets - 1;
    }
    light.first_target + chosen
}

/// Emits a photon of parallel light of a direction, whose `emission` is its irradiance over the number of its photons: from a disc of the light's
/// radius about `middle`, before the scene, or from the targets' shadows in the disc's plane.
#[inline]
fn emit_parallel(
    rays: u32,
    light: &Light,
    direction: Vec3,
    middle: Vec3,
    emission: Vec3,
    targets: &Input<Target>,
    place: [f32; 4],
    aim: [f32; 4],
) -> Emitted {
    let [x, y] = sample_disc(place[1], place[2]);
    if rays == RAY_GLOBAL {
        let radius = light.edges[0][0];
        let origin = middle + across(direction, x, y) * radius;
        return Emitted { origin, normal: direction, direction, power: emission * light.area, primitive: NO_LIGHT };
    }
    let chosen = choose_target(aim[2], light);
    let target = targets[chosen as usize];
    let origin = shadow(&target, direction, middle) + across(direction, x, y) * target.radius;
    let mut density = 0.0;
    let mut j = light.first_target;
    while j < light.first_target + light.targets {
        let target = targets[j as usize];
        let off = origin - shadow(&target, direction, middle);
        let radius2 = target.radius * target.radius;
        if j == chosen || dot(off, off) <= radius2 {
            density += div(1.0, PI * radius2);
        }
        j += 1;
    }
    let power = emission * div(light.targets as f32, density);
    Emitted { origin, normal: direction, direction, power, primitive: NO_LIGHT }
}

/// A target's centre, moved along `direction` into the plane through `middle`.
#[inline]
fn shadow(target: &Target, direction: Vec3, middle: Vec3) -> Vec3 {
    let centre = Vec3::from_array(target.centre);
    centre - direction * dot(centre - middle, direction)
}

/// The vector (x, y) across the unit vector `n`.
#[inline]
fn across(n: Vec3, x: f32, y: f32) -> Vec3 {
    let (t, s) = super::vector::frame(n);
    t * x + s * y
}
