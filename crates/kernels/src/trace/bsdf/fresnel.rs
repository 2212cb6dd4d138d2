//! How much a smooth interface reflects.

use crate::num::div;
use glam::Vec3;

/// Fresnel reflectance of a smooth dielectric for unpolarised light; `cos_i` and `cos_t` are the cosines of the angles of
/// incidence and refraction and `eta` the ratio of the indices, n_i / n_t.
#[inline]
#[must_use]
pub fn fresnel(cos_i: f32, cos_t: f32, eta: f32) -> f32 {
    let parallel = div(cos_i - eta * cos_t, cos_i + eta * cos_t);
    let perpendicular = div(eta * cos_i - cos_t, eta * cos_i + cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// What a dielectric of index `ior` reflects head on.
#[inline]
#[must_use]
pub fn head_on(ior: f32) -> f32 {
    let amplitude = div(ior - 1.0, ior + 1.0);
    amplitude * amplitude
}

/// What is left of 1 − F on the way from head on, where it is 1, to grazing, where it is 0: 1 − (1 − cos θ)⁵.
#[inline]
fn falling(cos: f32) -> f32 {
    let x = 1.0 - cos;
    let x2 = x * x;
    1.0 - x2 * x2 * x
}

/// Schlick's approximation, F = F₀ + (1 − F₀)(1 − cos θ)⁵ ("An Inexpensive BRDF Model for Physically-based Rendering",
/// Eurographics 1994), for one reflectance head on.
#[inline]
#[must_use]
pub fn schlick(head_on: f32, cos: f32) -> f32 {
    1.0 - (1.0 - head_on) * falling(cos)
}

/// [`schlick`] for each of red, green and blue.
#[inline]
#[must_use]
pub fn schlick_rgb(head_on: Vec3, cos: f32) -> Vec3 {
    Vec3::ONE - (Vec3::ONE - head_on) * falling(cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glass_reflects_four_percent_head_on_and_all_at_grazing_angles() {
        assert!((fresnel(1.0, 1.0, 1.0 / 1.5) - 0.04).abs() < 1e-6);
        assert!((fresnel(0.0, (1.0f32 - 1.0 / 2.25).sqrt(), 1.0 / 1.5) - 1.0).abs() < 1e-6);
        assert!((head_on(1.5) - 0.04).abs() < 1e-7);
    }

    /// Schlick's formula stays within 0.04 of Fresnel's for glass, everywhere (the paper says so of its figure 1), and meets
    /// it at both ends.
    #[test]
    fn schlick_follows_fresnel() {
        for i in 0..=1000 {
            let cos = i as f32 / 1000.0;
            let exact = fresnel(cos, (1.0 - (1.0 - cos * cos) / 2.25).sqrt(), 1.0 / 1.5);
            let ours = schlick(0.04, cos);
            assert!((ours - exact).abs() < 0.04, "{cos}: {ours} against {exact}");
            assert_eq!(schlick_rgb(Vec3::splat(0.04), cos), Vec3::splat(ours));
        }
        assert_eq!((schlick(0.04, 0.0), schlick(0.25, 1.0)), (1.0, 0.25));
    }
}
