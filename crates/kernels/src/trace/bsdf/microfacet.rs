//! GGX microfacets (Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007) with Smith's masking
//! and shadowing, in the frame whose third axis is the surface's normal.

use crate::num::{div, max, sin_cos_turns, sqrt};
use crate::trace::vector::{dot, normalize};
use glam::Vec3;

const PI: f32 = core::f32::consts::PI;

/// The roughness α below which a surface is smooth and its lobe a delta lobe. A lobe this narrow is a thousandth of a radian
/// wide; f32 has digits enough for it, but not for much narrower ones.
pub const SMOOTHEST: f32 = 1e-3;

/// D(h): area of the microfacets of unit normal `h`, h.z ≥ 0, per steradian and area of the surface. Walter et al., equation 33,
/// written without differences, so that narrow lobes keep their digits.
#[inline]
#[must_use]
pub fn distribution(alpha: f32, h: Vec3) -> f32 {
    let stretch = div(1.0, alpha);
    let (x, y) = (h.x * stretch, h.y * stretch);
    let k = x * x + y * y + h.z * h.z;
    div(stretch * stretch, PI * k * k)
}

/// √(z² + α²(x² + y²)) of a unit vector: Smith's G₁ is 2z / (z + this). It is the length of v stretched by the roughness, and
/// twice the projected area of the microfacets less z.
#[inline]
#[must_use]
pub fn spread(alpha: f32, v: Vec3) -> f32 {
    sqrt(v.z * v.z + alpha * alpha * (v.x * v.x + v.y * v.y))
}

/// Share of the microfacets turned to `v` that is seen from there, G₁; v.z > 0.
#[inline]
#[must_use]
pub fn masking(alpha: f32, v: Vec3) -> f32 {
    div(2.0 * v.z, v.z + spread(alpha, v))
}

/// Density of [`sample_visible`], sr⁻¹, without the factor v·h of the visible normals' density: D(h)·G₁(v) / v.z. The density
/// of a direction that is reflected at `h` is a quarter of it.
#[inline]
#[must_use]
pub fn visible_density(alpha: f32, v: Vec3, h: Vec3) -> f32 {
    div(2.0 * distribution(alpha, h), v.z + spread(alpha, v))
}

/// A normal among the microfacets that are seen from the unit vector `v`, v.z ≥ 0, from two uniform numbers (Dupuy and Benyoub,
/// "Sampling Visible GGX Normals with Spherical Caps", HPG 2023, listing 3; the density is Heitz's, JCGT 2018).
#[inline]
#[must_use]
pub fn sample_visible(alpha: f32, v: Vec3, u: f32, w: f32) -> Vec3 {
    let stretched = normalize(Vec3::new(v.x * alpha, v.y * alpha, v.z));
    let (sin, cos) = sin_cos_turns(u);
    let z = (1.0 - w) * (1.0 + stretched.z) - stretched.z;
    let r = sqrt(max(0.0, 1.0 - z * z));
    let sum = Vec3::new(r * cos, r * sin, z) + stretched;
    let h = Vec3::new(sum.x * alpha, sum.y * alpha, max(0.0, sum.z));
    // The one cap's rim that is opposite to v has no normal; it is never drawn but by rounding.
    if dot(h, h) > 1e-30 { normalize(h) } else { Vec3::Z }
}

/// What of the light from `v` a perfectly reflecting surface sends to `out` relative to what [`sample_visible`] sends there:
/// G₂ / G₁, Smith's height-correlated G₂ (Heitz, "Understanding the Masking-Shadowing Function", JCGT 2014, equation 99).
#[inline]
#[must_use]
pub fn reflected_share(alpha: f32, v: Vec3, out: Vec3) -> f32 {
    let (from, to) = (spread(alpha, v), spread(alpha, out));
    div(out.z * (v.z + from), out.z * from + v.z * to)
}
