//! What surfaces do with light: each material as a sum of lobes that can be drawn from and evaluated.
//!
//! | kind | lobes |
//! | --- | --- |
//! | lambertian | diffuse |
//! | mirror, dielectric | delta |
//! | rough dielectric | glossy, on both sides; delta below [`SMOOTHEST`] |
//! | layered | glossy, or delta below [`SMOOTHEST`], over diffuse |
//!
//! A diffuse lobe is a product f = [`entrance`](fn@entrance)(θ_i) · [`albedo_diffuse`](fn@albedo_diffuse)(θ_o) / π: photons are stored with the power that enters, and their
//! irradiance is multiplied with the albedo. Both sides of a surface are made of its material. Directions are unit vectors, the
//! one of arriving light points the way it travels, and the densities of directions are in sr⁻¹. The functions serve photons and eye paths alike:
//! lobes are reciprocal, but for the square of the index of refraction, which is left to the media.

mod fresnel;
mod layered;
mod microfacet;
mod rough_dielectric;
mod specular;
#[cfg(test)]
pub(super) mod tests;

pub use fresnel::{fresnel, schlick};
pub use microfacet::SMOOTHEST;
pub use specular::scatter_specular;

use super::known::Known;
use super::scene::{MATERIAL_LAMBERTIAN, MATERIAL_LAYERED, MATERIAL_ROUGH_DIELECTRIC, Material};
use super::vector::{dot, sample_cosine};
use crate::num::{abs, div, max};
use glam::Vec3;

const PI: f32 = core::f32::consts::PI;

/// A ray after a surface.
pub struct Scattered {
    /// Unit direction.
    pub direction: Vec3,
    /// Unit normal of the side on which it leaves.
    pub side: Vec3,
    /// Factor on its power or throughput, for each of red, green and blue: f·|cos θ| over the density, and over the chance of a
    /// delta lobe. 0 where it is absorbed.
    pub weight: Vec3,
    /// Density with which the direction was drawn, sr⁻¹; 0 of a delta lobe and where the ray is absorbed.
    pub pdf: f32,
    /// Whether the diffuse lobe was drawn.
    pub diffuse: bool,
}

/// A ray after a delta lobe.
#[inline]
fn delta(direction: Vec3, side: Vec3, weight: Vec3) -> Scattered {
    Scattered { direction, side, weight, pdf: 0.0, diffuse: false }
}

/// The normal of the side that light of direction `d` comes from.
#[inline]
#[must_use]
pub fn facing(d: Vec3, n: Vec3) -> Vec3 {
    if dot(d, n) > 0.0 { -n } else { n }
}

/// Draws a direction from the whole of a material, for light of direction `d` and the outward normal `n`, with three uniform numbers.
#[inline]
#[must_use]
pub fn sample(known: impl Known, material: &Material, d: Vec3, n: Vec3, u: [f32; 3]) -> Scattered {
    let side = facing(d, n);
    let chance = specular_chance(known, material, -dot(d, side));
    if u[2] >= chance {
        let direction = sample_cosine(side, u[0], u[1]);
        let (value, pdf) = evaluate(known, material, d, direction, n);
        let weight = if pdf > 0.0 { value * div(1.0, pdf) } else { Vec3::ZERO };
        return Scattered { direction, side, weight, pdf, diffuse: true };
    }
    // What is left of the number is uniform again.
    let rest = if chance < 1.0 { div(u[2], chance) } else { u[2] };
    let mut scattered = sample_specular(known, material, d, n, [u[0], u[1], rest]);
    if chance < 1.0 {
        if scattered.pdf > 0.0 {
            let (value, pdf) = evaluate(known, material, d, scattered.direction, n);
            scattered.weight = if pdf > 0.0 { value * div(1.0, pdf) } else { Vec3::ZERO };
            scattered.pdf = pdf;
        } else {
            scattered.weight *= div(1.0, chance);
        }
    }
    scattered
}

/// f·|cos θ| of all lobes that are not delta lobes, for light from `d` to `out`, and the density with which [`sample`] draws
/// `out` from them, sr⁻¹.
#[inline]
#[must_use]
pub fn evaluate(known: impl Known, material: &Material, d: Vec3, out: Vec3, n: Vec3) -> (Vec3, f32) {
    let (mut value, mut pdf) = evaluate_specular(known, material, d, out, n);
    let side = facing(d, n);
    let (cos, cos_out) = (-dot(d, side), dot(out, side));
    let chance = specular_chance(known, material, cos);
    if chance < 1.0 {
        pdf *= chance;
        if cos_out > 0.0 {
            let lambert = cos_out * (1.0 / PI);
            value += albedo_diffuse(known, material, cos_out) * (entrance(known, material, cos) * lambert);
            pdf += (1.0 - chance) * lambert;
        }
    }
    (value, pdf)
}

/// Draws a direction from the lobes that are not diffuse. `u[2]` decides between reflection and refraction.
#[inline]
#[must_use]
pub fn sample_specular(known: impl Known, material: &Material, d: Vec3, n: Vec3, u: [f32; 3]) -> Scattered {
    if known.gloss() && material.kind == MATERIAL_LAYERED {
        return layered::sample_coat(material, d, facing(d, n), u[0], u[1]);
    }
    if known.gloss() && material.kind == MATERIAL_ROUGH_DIELECTRIC {
        return rough_dielectric::sample(material, d, n, u);
    }
    scatter_specular(material, d, n, u[2])
}

/// f·|cos θ| of the glossy lobe, for light from `d` to `out`, and the density with which [`sample_specular`] draws `out`, sr⁻¹.
#[inline]
#[must_use]
pub fn evaluate_specular(known: impl Known, material: &Material, d: Vec3, out: Vec3, n: Vec3) -> (Vec3, f32) {
    if known.gloss() && material.kind == MATERIAL_LAYERED {
        return layered::evaluate_coat(material, d, out, facing(d, n));
    }
    if known.gloss() && material.kind == MATERIAL_ROUGH_DIELECTRIC {
        return rough_dielectric::evaluate(material, d, out, n);
    }
    (Vec3::ZERO, 0.0)
}

/// Chance with which [`sample`] draws from the lobes that are not diffuse, for light at an angle of cosine `cos`: 0 for a lambertian
/// material, 1 where nothing is diffuse.
#[inline]
#[must_use]
pub fn specular_chance(known: impl Known, material: &Material, cos: f32) -> f32 {
    if known.gloss() && material.kind == MATERIAL_LAYERED {
        layered::coat_chance(material, cos)
    } else if material.kind == MATERIAL_LAMBERTIAN {
        0.0
    } else {
        1.0
    }
}

/// Whether the material has a lobe that is neither diffuse nor a delta lobe, so that light straight from the lights can be evaluated.
#[inline]
#[must_use]
pub fn is_glossy(material: &Material) -> bool {
    (material.kind == MATERIAL_LAYERED || material.kind == MATERIAL_ROUGH_DIELECTRIC) && material.roughness >= SMOOTHEST
}

/// Whether the material has a diffuse lobe that reflects anything, so that its surfaces store photons.
#[inline]
#[must_use]
pub fn is_diffuse(material: &Material) -> bool {
    let layered = material.kind == MATERIAL_LAYERED && material.metallic < 1.0;
    let [red, green, blue] = material.reflectance;
    (material.kind == MATERIAL_LAMBERTIAN || layered) && max(red, max(green, blue)) > 0.0
}

/// Share of the light at an angle of cosine `cos` that reaches the diffuse lobe.
#[inline]
#[must_use]
pub fn entrance(known: impl Known, material: &Material, cos: f32) -> f32 {
    if known.gloss() && material.kind == MATERIAL_LAYERED { layered::entrance(material, abs(cos)) } else { 1.0 }
}

/// What an irradiance that has entered is multiplied with, over π, to give the radiance of the diffuse lobe at an angle of cosine
/// `cos_out`.
#[inline]
#[must_use]
pub fn albedo_diffuse(known: impl Known, material: &Material, cos_out: f32) -> Vec3 {
    if known.gloss() && material.kind == MATERIAL_LAYERED {
        layered::albedo(material, abs(cos_out))
    } else if material.kind == MATERIAL_LAMBERTIAN {
        Vec3::from_array(material.reflectance)
    } else {
        Vec3::ZERO
    }
}
