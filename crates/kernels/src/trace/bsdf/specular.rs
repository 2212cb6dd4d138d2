//! Ideal mirrors and smooth glass: delta lobes.

use super::fresnel::fresnel;
use super::{Scattered, delta};
use crate::num::{div, sqrt};
use crate::trace::scene::{MATERIAL_MIRROR, Material};
use crate::trace::vector::{dot, normalize, reflect};
use glam::Vec3;

/// Follows a ray of unit direction `d` at a mirror or dielectric with outward normal `n`. `u` decides between reflection and
/// refraction, each with its Fresnel chance, so that the weight stays 1.
///
/// Radiance also changes by the square of the relative index when it crosses an interface. Lights, cameras and diffuse
/// surfaces stand outside of glass, so every path crosses in and out and the factors cancel.
#[inline]
#[must_use]
pub fn scatter_specular(material: &Material, d: Vec3, n: Vec3, u: f32) -> Scattered {
    let cos = dot(d, n);
    let facing = if cos > 0.0 { -n } else { n };
    let mirrored = reflect(d, facing);
    let weight = Vec3::from_array(material.reflectance);
    if material.kind == MATERIAL_MIRROR {
        return delta(mirrored, facing, weight);
    }
    let cos_i = if cos > 0.0 { cos } else { -cos };
    let eta = if cos > 0.0 { material.ior } else { div(1.0, material.ior) };
    let sin2_t = eta * eta * (1.0 - cos_i * cos_i);
    if sin2_t >= 1.0 {
        return delta(mirrored, facing, weight);
    }
    let cos_t = sqrt(1.0 - sin2_t);
    if u < fresnel(cos_i, cos_t, eta) {
        return delta(mirrored, facing, weight);
    }
    let refracted = normalize(d * eta + facing * (eta * cos_i - cos_t));
    delta(refracted, -facing, weight)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::bsdf::tests::NOTHING;
    use crate::trace::scene::MATERIAL_DIELECTRIC;

    const GLASS: Material =
        Material { reflectance: [1.0; 3], kind: MATERIAL_DIELECTRIC, ior: 1.5, survival: 1.0, ..NOTHING };

    #[test]
    fn refraction_obeys_snell() {
        let d = normalize(Vec3::new(0.6, -0.8, 0.0));
        let out = scatter_specular(&GLASS, d, Vec3::Y, 0.999);
        assert!((out.direction.x - 0.6 / 1.5).abs() < 1e-6, "sin t = sin i / 1.5");
        assert!(out.direction.y < 0.0 && out.side.y < 0.0, "it goes on below");
        let back = scatter_specular(&GLASS, -out.direction, Vec3::Y, 0.999);
        assert!((back.direction + d).length() < 1e-6, "light's path can be reversed");
    }

    /// On both sides of the critical angle, float by float, and up to grazing: a unit direction on the right side, and no
    /// number that is none.
    #[test]
    fn the_critical_angle_is_crossed_without_a_gap() {
        for ior in [1.0, 1.000_001, 1.33, 1.5, 2.4, 1000.0] {
            let glass = Material { ior, ..GLASS };
            // From inside: the ray goes along the outward normal. sin of the critical angle is 1 / ior.
            let critical = 1.0 / ior;
            let mut sines: std::vec::Vec<f32> =
                (0..64u32).map(|i| f32::from_bits(critical.to_bits() - 32 + i)).collect();
            sines.extend([0.0, 1e-6, 0.5, 0.999_999_9, 1.0]);
            let mut kinds = [0, 0];
            for sine in sines.into_iter().filter(|&sine| sine <= 1.0) {
                let cosine = (1.0 - f64::from(sine) * f64::from(sine)).max(0.0).sqrt() as f32;
                for (d, u) in [(Vec3::new(sine, cosine, 0.0), 0.9999), (Vec3::new(sine, -cosine, 0.0), 0.0)] {
                    let out = scatter_specular(&glass, d, Vec3::Y, u);
                    assert!((out.direction.length() - 1.0).abs() < 1e-6, "{ior}, {sine}: {:?}", out.direction);
                    assert!(out.weight == Vec3::ONE && out.side.y.abs() == 1.0);
                    // It leaves to the side it goes to, but for the rounding of a grazing direction.
                    assert!(dot(out.direction, out.side) > -1e-6, "{ior}, {sine}: {:?} {:?}", out.direction, out.side);
                    kinds[usize::from(out.side.y < 0.0)] += 1;
                }
            }
            assert!(kinds[0] > 0 && kinds[1] > 0, "{ior}: one of reflection and refraction never happened");
        }
    }

    #[test]
    fn light_inside_glass_beyond_the_critical_angle_stays_inside() {
        let d = normalize(Vec3::new(0.8, 0.6, 0.0));
        let out = scatter_specular(&GLASS, d, Vec3::Y, 0.999);
        assert!((out.direction.y + d.y).abs() < 1e-6 && out.side.y < 0.0);
    }
}
