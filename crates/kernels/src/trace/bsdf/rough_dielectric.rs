//! Glass with a rough surface: reflection and refraction at GGX microfacets (Walter et al., "Microfacet Models for Refraction through
//! Rough Surfaces", EGSR 2007).
//!
//! As at smooth glass, the factor by which radiance changes across the interface is left out: it is the medium's business.

use super::fresnel::fresnel;
use super::microfacet::{SMOOTHEST, masking, reflected_share, sample_visible, visible_density};
use super::{Scattered, scatter_specular};
use crate::num::{abs, div, sqrt};
use crate::trace::scene::Material;
use crate::trace::vector::{dot, from_frame, normalize, to_frame};
use glam::Vec3;

/// cos of the angle of refraction for light at `cos` to a microfacet and the ratio `eta` = n_i / n_t, and the share that is
/// reflected; (0, 1) beyond the critical angle.
#[inline]
fn at_facet(cos: f32, eta: f32) -> (f32, f32) {
    let sin2 = eta * eta * (1.0 - cos * cos);
    if sin2 >= 1.0 {
        return (0.0, 1.0);
    }
    let cos_t = sqrt(1.0 - sin2);
    (cos_t, fresnel(cos, cos_t, eta))
}

/// The normal of the side that light of direction `d` comes from, and n_i / n_t there.
#[inline]
fn side(material: &Material, d: Vec3, n: Vec3) -> (Vec3, f32) {
    if dot(d, n) > 0.0 { (-n, material.ior) } else { (n, div(1.0, material.ior)) }
}

/// Solid angle of microfacet normals per solid angle of directions refracted at them (Walter et al., equation 17).
#[inline]
fn facets_of_refracted(cos: f32, cos_t: f32, eta: f32) -> f32 {
    let sum = eta * cos - cos_t;
    div(cos_t, sum * sum)
}

/// Draws a direction; `u[2]` decides between reflection and refraction. What the microfacets send to the wrong side is absorbed.
#[inline]
#[must_use]
pub fn sample(material: &Material, d: Vec3, n: Vec3, u: [f32; 3]) -> Scattered {
    let alpha = material.roughness;
    if alpha < SMOOTHEST {
        return scatter_specular(material, d, n, u[2]);
    }
    let (facing, eta) = side(material, d, n);
    let v = to_frame(facing, -d);
    let h = sample_visible(alpha, v, u[0], u[1]);
    let cos = dot(v, h);
    let (cos_t, reflected) = at_facet(cos, eta);
    let reflects = u[2] < reflected;
    let out = if reflects { h * (2.0 * cos) - v } else { h * (eta * cos - cos_t) - v * eta };
    let mut share = 0.0;
    let mut pdf = 0.0;
    if reflects && cos > 0.0 && out.z > 0.0 {
        share = reflected_share(alpha, v, out);
        pdf = 0.25 * reflected * visible_density(alpha, v, h);
    }
    if !reflects && cos > 0.0 && out.z < 0.0 {
        share = masking(alpha, Vec3::new(out.x, out.y, -out.z));
        pdf = (1.0 - reflected) * visible_density(alpha, v, h) * cos * facets_of_refracted(cos, cos_t, eta);
    }
    let direction = from_frame(facing, out.x, out.y, out.z);
    let weight = Vec3::from_array(material.reflectance) * share;
    Scattered { direction, side: if reflects { facing } else { -facing }, weight, pdf, diffuse: false }
}

/// f·|cos θ_o| for light from `d` to `out`, and the density of [`sample`]; 0 for smooth glass.
#[inline]
#[must_use]
pub fn evaluate(material: &Material, d: Vec3, out: Vec3, n: Vec3) -> (Vec3, f32) {
    let alpha = material.roughness;
    let (facing, eta) = side(material, d, n);
    let v = to_frame(facing, -d);
    let out = to_frame(facing, out);
    if alpha < SMOOTHEST || v.z <= 0.0 || out.z == 0.0 {
        return (Vec3::ZERO, 0.0);
    }
    let reflects = out.z > 0.0;
    let sum = if reflects { v + out } else { v * eta + out };
    if dot(sum, sum) < 1e-12 {
        return (Vec3::ZERO, 0.0);
    }
    let mut h = normalize(sum);
    if h.z < 0.0 {
        h = -h;
    }
    let cos = dot(v, h);
    if cos <= 0.0 || (!reflects && dot(out, h) >= 0.0) {
        return (Vec3::ZERO, 0.0);
    }
    let (cos_t, reflected) = at_facet(cos, eta);
    let facets = visible_density(alpha, v, h);
    let pdf = if reflects {
        0.25 * reflected * facets
    } else if reflected < 1.0 {
        (1.0 - reflected) * facets * cos * facets_of_refracted(cos, cos_t, eta)
    } else {
        0.0
    };
    let share =
        if reflects { reflected_share(alpha, v, out) } else { masking(alpha, Vec3::new(out.x, out.y, abs(out.z))) };
    (Vec3::from_array(material.reflectance) * (share * pdf), pdf)
}
