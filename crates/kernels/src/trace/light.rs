//! Lights as a point of a surface sees them.

use super::known::Known;
use super::scene::{
    LIGHT_AREA, LIGHT_DIRECTIONAL, LIGHT_DISC, LIGHT_ENVIRONMENT, LIGHT_SPHERE, LIGHT_SPOT, LIGHT_TRIANGLE, Light,
    NO_TEXTURE, SceneInfo,
};
use super::sky::{invert_sky, look_at_sky};
use super::solid_angle::Fan;
use super::surface::Corners;
use super::texture::{Texel, Texture, texel_at};
use super::vector::{cone, cone_density, cross, dot, invert_cone, invert_disc, normalize, sample_cone, sample_disc};
use crate::exec::Input;
use crate::num::{div, max, min, sqrt};
use glam::Vec3;

const PI: f32 = core::f32::consts::PI;

/// Farther than any surface: where directional light and an environment are.
pub const FAR_AWAY: f32 = 1e30;

/// One place of a light, as it is seen from a point.
pub struct Glimpse {
    /// Unit direction to it.
    pub direction: Vec3,
    /// Distance, m; 0 if there is nothing to be seen.
    pub distance: f32,
    /// Radiance, W·sr⁻¹·m⁻², of what has an area or fills a solid angle; intensity, W·sr⁻¹, of a point or spot; irradiance of what faces it, W·m⁻², of a
    /// directional light.
    pub emission: Vec3,
    /// What the emission is divided by: the distance squared, m², or 1.
    pub(super) spread: f32,
    /// What it is multiplied with: one over the density with which the place was drawn, m² or sr.
    pub(super) extent: f32,
    /// Cosine of the angle at which an area is seen.
    pub(super) slant: f32,
}

impl Glimpse {
    /// Irradiance for an emission of 1 on a surface that sees the light at an angle of cosine `cos`, over the `chance` with which the
    /// light was drawn.
    #[inline]
    #[must_use]
    pub fn geometry(&self, cos: f32, chance: f32) -> f32 {
        div(cos, self.spread * chance) * self.slant * self.extent
    }
}

/// Chooses light by `u`, each with the chance that the host gave it.
#[inline]
#[must_use]
pub fn choose_light(u: f32, info: &SceneInfo, lights: &Input<Light>) -> u32 {
    // The first whose sum of chances is above u.
    let mut first = 0;
    let mut last = info.lights - 1;
    while first < last {
        let middle = (first + last) / 2;
        if u >= lights[middle as usize].cumulative {
            first = middle + 1;
        } else {
            last = middle;
        }
    }
    first
}

/// Whether the light is a surface.
#[inline]
#[must_use]
pub fn is_surface(known: impl Known, light: &Light) -> bool {
    is_flat(known, light) || (known.lamps() && light.kind == LIGHT_SPHERE)
}

/// Whether the light is a flat surface, which shines from its front.
#[inline]
#[must_use]
pub fn is_flat(known: impl Known, light: &Light) -> bool {
    light.kind == LIGHT_AREA || (known.lamps() && (light.kind == LIGHT_TRIANGLE || light.kind == LIGHT_DISC))
}

/// Whether a ray can find the light by itself.
#[inline]
#[must_use]
pub fn can_be_met(known: impl Known, light: &Light) -> bool {
    is_surface(known, light) || (known.sky() && light.kind == LIGHT_ENVIRONMENT)
}

/// Point (u, v) of a flat light, evenly drawn, or the place of a point light.
#[inline]
#[must_use]
pub fn light_point(known: impl Known, light: &Light, u: f32, v: f32) -> Vec3 {
    let position = Vec3::from_array(light.position);
    let (mut u, mut v) = (u, v);
    if known.lamps() && light.kind == LIGHT_TRIANGLE && u + v > 1.0 {
        // The other half of the parallelogram, turned onto this one.
        u = 1.0 - u;
        v = 1.0 - v;
    }
    if known.lamps() && light.kind == LIGHT_DISC {
        [u, v] = sample_disc(u, v);
    }
    if is_flat(known, light) {
        position + Vec3::from_array(light.edges[0]) * u + Vec3::from_array(light.edges[1]) * v
    } else {
        position
    }
}

/// Texture coordinates of the point (u, v) of a flat light that has a texture.
#[inline]
#[must_use]
pub(super) fn place_on_light(
    known: impl Known,
    light: &Light,
    u: f32,
    v: f32,
    info: &SceneInfo,
    corners: &Input<Corners>,
) -> [f32; 2] {
    if light.texture == NO_TEXTURE {
        return [0.0; 2];
    }
    if known.lamps() && light.kind == LIGHT_DISC {
        let [x, y] = sample_disc(u, v);
        return [x * 0.5 + 0.5, y * 0.5 + 0.5];
    }
    if !known.lamps() || light.kind != LIGHT_TRIANGLE {
        return [u, v];
    }
    let (mut u, mut v) = (u, v);
    if u + v > 1.0 {
        u = 1.0 - u;
        v = 1.0 - v;
    }
    let uv = corners[(light.primitive - info.first_corners) as usize].uv;
    let rest = max(0.0, 1.0 - u - v);
    [uv[0][0] * rest + uv[1][0] * u + uv[2][0] * v, uv[0][1] * rest + uv[1][1] * u + uv[2][1] * v]
}

/// Emission of a light at texture coordinates `uv`.
#[inline]
#[must_use]
pub(super) fn emission_at(
    known: impl Known,
    light: &Light,
    uv: [f32; 2],
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> Vec3 {
    let emission = Vec3::from_array(light.emission);
    if known.textures() && light.texture != NO_TEXTURE {
        return emission * texel_at(&textures[light.texture as usize], uv, texels).truncate();
    }
    emission
}

/// How much of its intensity a spot light sends in a direction: 1 within the inner cone, 0 outside of the outer one, and between
/// them 3x² − 2x³ of how far the cosine has come.
#[inline]
#[must_use]
pub fn spot_falloff(light: &Light, direction: Vec3) -> f32 {
    let [inner, outer, _] = light.edges[0];
    let off = 1.0 - dot(direction, Vec3::from_array(light.normal));
    if off <= inner {
        return 1.0;
    }
    let x = max(0.0, min(1.0, div(outer - off, outer - inner)));
    x * x * (3.0 - 2.0 * x)
}

/// Looks from a point at the place (u, v) of a light: a sphere is drawn evenly by the solid angle that it fills (Shirley, Wang and Zimmerman, "Monte
/// Carlo Techniques for Direct Lighting Calculations", ACM TOG 1996), and so is a flat one that is near; others evenly by area.
#[inline]
#[must_use]
pub fn look(
    known: impl Known,
    light: &Light,
    from: Vec3,
    u: f32,
    v: f32,
    info: &SceneInfo,
    corners: &Input<Corners>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> Glimpse {
    if known.sky() && light.kind == LIGHT_ENVIRONMENT {
        return look_at_sky(light, u, v, info, textures, texels);
    }
    let mut glimpse = Glimpse {
        direction: Vec3::Z,
        distance: 0.0,
        emission: Vec3::from_array(light.emission),
        spread: 1.0,
        extent: 1.0,
        slant: 1.0,
    };
    if known.lamps() && light.kind == LIGHT_DIRECTIONAL {
        glimpse.direction = -Vec3::from_array(light.normal);
        glimpse.distance = FAR_AWAY;
        return glimpse;
    }
    if known.lamps() && light.kind == LIGHT_SPHERE {
        let axis = Vec3::from_array(light.position) - from;
        let radius = light.edges[0][0];
        if dot(axis, axis) <= radius * radius {
            return glimpse; // from inside, which does not shine
        }
        let one_minus_cos = cone(axis, radius);
        let direction = sample_cone(normalize(axis), one_minus_cos, u, v);
        // Where the ray meets the sphere; at its rim, where rounding may let it miss, the point nearest to the centre.
        let along = dot(axis, direction);
        let root = radius * radius - (dot(axis, axis) - along * along);
        glimpse.direction = direction;
        glimpse.distance = along - sqrt(max(0.0, root));
        glimpse.extent = 2.0 * PI * one_minus_cos;
        return glimpse;
    }
    let mut place = [u, v];
    let mut solid_angle = 0.0;
    if is_flat(known, light) {
        let fan = Fan::new(known, light, from);
        solid_angle = fan.solid_angle;
        if solid_angle > 0.0 {
            place = fan.place(known, light, u, v);
        }
        if place[0] < 0.0 {
            return glimpse; // beside a disc
        }
    }
    let to_light = light_point(known, light, place[0], place[1]) - from;
    let distance2 = dot(to_light, to_light);
    let distance = sqrt(distance2);
    if distance > 0.0 {
        glimpse.direction = to_light * div(1.0, distance);
        glimpse.distance = distance;
        glimpse.spread = distance2;
        if is_flat(known, light) {
            if solid_angle > 0.0 {
                glimpse.spread = 1.0;
                glimpse.extent = solid_angle;
            } else {
                glimpse.slant = max(0.0, -dot(Vec3::from_array(light.normal), glimpse.direction));
                glimpse.extent = light.area;
            }
            if known.textures() {
                let uv = place_on_light(known, light, place[0], place[1], info, corners);
                glimpse.emission = emission_at(known, light, uv, textures, texels);
            }
        }
        if known.lamps() && light.kind == LIGHT_SPOT {
            glimpse.emission *= spot_falloff(light, -glimpse.direction);
        }
    }
    glimpse
}

/// Density, sr⁻¹, with which a light is chosen and [`look`] draws this direction from the point `from`, where a ray of that direction meets
/// the light's front at the distance `distance`.
#[inline]
#[must_use]
pub fn look_density(known: impl Known, light: &Light, from: Vec3, direction: Vec3, distance: f32) -> f32 {
    if known.lamps() && light.kind == LIGHT_SPHERE {
        let one_minus_cos = cone(Vec3::from_array(light.position) - from, light.edges[0][0]);
        return light.probability * cone_density(one_minus_cos);
    }
    let solid_angle = Fan::new(known, light, from).solid_angle;
    if solid_angle > 0.0 {
        return div(light.probability, solid_angle);
    }
    let slant = max(0.0, -dot(Vec3::from_array(light.normal), direction));
    let seen = slant * light.area;
    if seen > 0.0 { div(distance * distance * light.probability, seen) } else { 0.0 }
}

/// The numbers (u, v) from which [`look`] draws this direction from the point `from`, of a light that rays can meet and a direction that it draws. A
/// triangle has two, of which these are the ones whose sum is at most 1.
#[inline]
#[must_use]
pub fn invert_look(
    known: impl Known,
    light: &Light,
    from: Vec3,
    direction: Vec3,
    info: &SceneInfo,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> [f32; 2] {
    if light.kind == LIGHT_ENVIRONMENT {
        return invert_sky(light, direction, info, textures, texels);
    }
    let position = Vec3::from_array(light.position);
    if light.kind == LIGHT_SPHERE {
        let axis = position - from;
        return invert_cone(normalize(axis), cone(axis, light.edges[0][0]), direction);
    }
    let normal = Vec3::from_array(light.normal);
    let distance = div(dot(position - from, normal), dot(direction, normal));
    let local = (from + direction * distance) - position;
    let [a, b] = [Vec3::from_array(light.edges[0]), Vec3::from_array(light.edges[1])];
    // Coordinates along the edges, by their dual vectors.
    let (across_a, across_b) = (cross(b, normal), cross(normal, a));
    let place = [div(dot(local, across_a), dot(a, across_a)), div(dot(local, across_b), dot(b, across_b))];
    let fan = Fan::new(known, light, from);
    if light.kind == LIGHT_DISC {
        return if fan.solid_angle > 0.0 {
            fan.invert(place[0] * 0.5 + 0.5, place[1] * 0.5 + 0.5)
        } else {
            invert_disc(place)
        };
    }
    if fan.solid_angle > 0.0 { fan.invert(place[0], place[1]) } else { place }
}

/// The weight of a sample of density `mine` beside another way of drawing it, of density `other`: the power heuristic (Veach, "Robust Monte
/// Carlo Methods for Light Transport Simulation", 1997, section 9.2.3, β = 2). The two ways' weights add up to 1.
#[inline]
#[must_use]
pub fn power_heuristic(mine: f32, other: f32) -> f32 {
    // By the ratio, whose square cannot overflow where it matters.
    if mine <= 0.0 {
        return 0.0;
    }
    let ratio = min(1e9, div(other, mine));
    div(1.0, 1.0 + ratio * ratio)
}

#[cfg(test)]
mod tests;
