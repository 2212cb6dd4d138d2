//! A coat over a diffuse base: plastic, metals (which have no base) and what lies between them, glTF's metallic-roughness model.
//!
//! The coat reflects by Schlick's F at GGX microfacets. What it does not reflect enters the base, and leaves it by the same law: with
//! t(θ) = 1 − F(θ) of the coat alone, the diffuse lobe is f = t(θ_i)·t(θ_o)·ρ / (π·T), where T = 20/21·(1 − F₀) is the mean of t
//! (Shirley et al., "A Practitioners' Assessment of Light Reflection Models", Pacific Graphics 1997, section 4, with that
//! mean in closed form). A smooth coat over a white base thus reflects everything, in every direction, and the lobe is a product of a
//! function of each direction: photons carry the one, the eye's path the other.

use super::fresnel::{head_on, schlick, schlick_rgb};
use super::microfacet::{SMOOTHEST, distribution, reflected_share, sample_visible, spread, visible_density};
use super::{Scattered, delta};
use crate::num::div;
use crate::trace::scene::Material;
use crate::trace::vector::{dot, from_frame, normalize, reflect, to_frame};
use glam::Vec3;

/// One over the mean of 1 − (1 − cos θ)⁵ over the projected hemisphere.
const MEAN: f32 = 21.0 / 20.0;

/// What the surface reflects head on, not counting its base: glTF 2.0, appendix B.3.5.
#[inline]
fn specular_colour(material: &Material) -> Vec3 {
    let coat = head_on(material.ior);
    Vec3::splat(coat) + (Vec3::from_array(material.reflectance) - Vec3::splat(coat)) * material.metallic
}

/// Share of the light at angle `cos` that enters the base, or leaves it: t(θ).
#[inline]
#[must_use]
pub fn entrance(material: &Material, cos: f32) -> f32 {
    1.0 - schlick(head_on(material.ior), cos)
}

/// t(θ_o)·ρ / T: π times the diffuse lobe, per unit of light that has entered.
#[inline]
#[must_use]
pub fn albedo(material: &Material, cos_out: f32) -> Vec3 {
    let coat = head_on(material.ior);
    // t / T = falling · 21/20, whatever F₀ is.
    let leaving = div(1.0 - schlick(coat, cos_out), 1.0 - coat) * MEAN;
    Vec3::from_array(material.reflectance) * ((1.0 - material.metallic) * leaving)
}

/// Chance of drawing the coat's lobe instead of the base's for light at angle `cos`: its share of what is reflected, as far
/// as that is known beforehand.
#[inline]
#[must_use]
pub fn coat_chance(material: &Material, cos: f32) -> f32 {
    let coat = sum(schlick_rgb(specular_colour(material), cos));
    let base = sum(Vec3::from_array(material.reflectance)) * (1.0 - material.metallic) * entrance(material, cos);
    if base > 0.0 { div(coat, coat + base) } else { 1.0 }
}

#[inline]
fn sum(v: Vec3) -> f32 {
    v.x + v.y + v.z
}

/// Draws a direction from the coat's lobe alone. What its microfacets send into the surface is absorbed.
#[inline]
#[must_use]
pub fn sample_coat(material: &Material, d: Vec3, facing: Vec3, u: f32, w: f32) -> Scattered {
    let colour = specular_colour(material);
    let alpha = material.roughness;
    if alpha < SMOOTHEST {
        return delta(reflect(d, facing), facing, schlick_rgb(colour, -dot(d, facing)));
    }
    let v = to_frame(facing, -d);
    let h = sample_visible(alpha, v, u, w);
    let cos = dot(v, h);
    let out = h * (2.0 * cos) - v;
    let mut weight = Vec3::ZERO;
    let mut pdf = 0.0;
    if out.z > 0.0 && cos > 0.0 {
        weight = schlick_rgb(colour, cos) * reflected_share(alpha, v, out);
        pdf = 0.25 * visible_density(alpha, v, h);
    }
    Scattered { direction: from_frame(facing, out.x, out.y, out.z), side: facing, weight, pdf, diffuse: false }
}

/// f·cos θ_o of the coat's lobe for light from `d` to `out`, and the density of [`sample_coat`]; 0 for a smooth coat.
#[inline]
#[must_use]
pub fn evaluate_coat(material: &Material, d: Vec3, out: Vec3, facing: Vec3) -> (Vec3, f32) {
    let alpha = material.roughness;
    let v = to_frame(facing, -d);
    let out = to_frame(facing, out);
    if alpha < SMOOTHEST || out.z <= 0.0 || v.z <= 0.0 {
        return (Vec3::ZERO, 0.0);
    }
    let h = normalize(v + out);
    let shadowing = out.z * spread(alpha, v) + v.z * spread(alpha, out);
    let value =
        schlick_rgb(specular_colour(material), dot(v, h)) * div(distribution(alpha, h) * out.z, 2.0 * shadowing);
    (value, 0.25 * visible_density(alpha, v, h))
}
