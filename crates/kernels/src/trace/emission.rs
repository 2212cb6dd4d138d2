//! How photons leave the lights.

use super::photons::{PhotonPass, RAY_GLOBAL};
use super::scene::{LIGHT_AREA, Light, NO_LIGHT, SceneInfo, Target};
use super::vector::{dot, normalize, sample_cone, sample_cosine};
use crate::exec::Input;
use crate::num::{Rng, div, sqrt};
use glam::Vec3;

const PI: f32 = core::f32::consts::PI;

/// A photon that has just been emitted.
pub struct Emitted {
    /// Where, m.
    pub origin: Vec3,
    /// Unit direction of travel.
    pub direction: Vec3,
    /// Power, W, for each of red, green and blue; 0 if it was aimed where the light does not shine.
    pub power: Vec3,
    /// The primitive it left, or [`NO_LIGHT`].
    pub primitive: u32,
}

/// Chooses light by `u`, each with the chance that the host gave it.
#[inline]
#[must_use]
pub fn choose_light(u: f32, info: &SceneInfo, lights: &Input<Light>) -> u32 {
    let mut chosen = 0;
    while chosen + 1 < info.lights && u >= lights[chosen as usize].cumulative {
        chosen += 1;
    }
    chosen
}

/// Point (u, v) of an area light, or the place of a point light.
#[inline]
#[must_use]
pub fn light_point(light: &Light, u: f32, v: f32) -> Vec3 {
    let position = Vec3::from_array(light.position);
    if light.kind == LIGHT_AREA {
        position + Vec3::from_array(light.edges[0]) * u + Vec3::from_array(light.edges[1]) * v
    } else {
        position
    }
}

/// Emits photon `index` of the pass.
///
/// Its power is emission over the density with which place and direction were drawn, over the number of photons emitted.
/// For a whole light this is Φ / n for every photon: Φ = π·L·A of an area light, 4π·I of a point light. Photons for the
/// caustic map are aimed: a target is drawn, then a direction in the cone that it fills. The density of a direction is then
/// the mean over all targets of 1/Ω of those whose cones hold it, so that cones may overlap.
#[inline]
#[must_use]
pub fn emit(
    index: u32,
    pass: &PhotonPass,
    info: &SceneInfo,
    lights: &Input<Light>,
    targets: &Input<Target>,
) -> Emitted {
    let rng = Rng { seed: pass.seed, stream: pass.rays, index };
    let place = rng.draw4(0);
    let aim = rng.draw4(1);
    let light = lights[choose_light(place[0], info, lights) as usize];
    let origin = light_point(&light, place[1], place[2]);
    let normal = Vec3::from_array(light.normal);
    let emission = Vec3::from_array(light.emission);
    let share = div(1.0, pass.emitted as f32 * light.probability);

    if pass.rays == RAY_GLOBAL {
        if light.kind == LIGHT_AREA {
            let direction = sample_cosine(normal, aim[0], aim[1]);
            return Emitted {
                origin,
                direction,
                power: emission * (PI * light.area * share),
                primitive: light.primitive,
            };
        }
        let direction = sample_cone(Vec3::Z, 2.0, aim[0], aim[1]);
        return Emitted { origin, direction, power: emission * (4.0 * PI * share), primitive: NO_LIGHT };
    }

    let mut chosen = (aim[2] * info.targets as f32) as u32;
    if chosen >= info.targets {
        chosen = info.targets - 1;
    }
    let target = targets[chosen as usize];
    let axis = Vec3::from_array(target.centre) - origin;
    let direction = sample_cone(axis_direction(axis), cone(axis, target.radius), aim[0], aim[1]);
    let mut density = 0.0;
    let mut j = 0;
    while j < info.targets {
        let target = targets[j as usize];
        let axis = Vec3::from_array(target.centre) - origin;
        let one_minus_cos = cone(axis, target.radius);
        // The chosen cone holds its direction whatever rounding says of one on its rim.
        if j == chosen || dot(direction, axis_direction(axis)) >= 1.0 - one_minus_cos {
            density += div(1.0, 2.0 * PI * one_minus_cos);
        }
        j += 1;
    }
    let per_direction = div(info.targets as f32, density) * share;
    if light.kind == LIGHT_AREA {
        let cos = dot(direction, normal);
        let lit = if cos > 0.0 { cos * light.area * per_direction } else { 0.0 };
        return Emitted { origin, direction, power: emission * lit, primitive: light.primitive };
    }
    Emitted { origin, direction, power: emission * per_direction, primitive: NO_LIGHT }
}

/// The direction of `axis`, any direction for none.
#[inline]
fn axis_direction(axis: Vec3) -> Vec3 {
    if dot(axis, axis) > 0.0 { normalize(axis) } else { Vec3::Z }
}

/// 1 − cos of the half angle of the cone that a sphere at `axis` fills; 2, every direction, from inside it.
#[inline]
fn cone(axis: Vec3, radius: f32) -> f32 {
    let distance2 = dot(axis, axis);
    if distance2 <= radius * radius {
        return 2.0;
    }
    let sin2 = div(radius * radius, distance2);
    div(sin2, 1.0 + sqrt(1.0 - sin2))
}
