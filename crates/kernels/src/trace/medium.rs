//! What lies between surfaces: nothing, or the inside of a dielectric.
//!
//! A path keeps the dielectric that it entered last and has not left; dielectrics do not overlap. What it meets there, the
//! bottom of a pool for one, is seen through n² times less radiance (Nicodemus 1963), while a photon's power stays what it is.

use super::scene::{MATERIAL_DIELECTRIC, MATERIAL_ROUGH_DIELECTRIC, Material};
use super::surface::Surface;
use super::vector::dot;
use crate::num::{div, exp, max};
use glam::Vec3;

/// The index of a material of which the inside is nothing.
pub const VACUUM: u32 = 0xffff_ffff;

/// Share of what a path began with below which a medium's roulette begins.
const FAINT: f32 = 1.0 / 64.0;

/// Russian roulette in a medium: what the power or throughput of a path, of which a medium has left `left` of `start`, is multiplied with: 1, or where
/// little is left 2 or 0, by the uniform number `u`. Total reflection can keep light in a medium for hundreds of bounces; without
/// this, paths would go on with next to nothing.
#[inline]
#[must_use]
pub fn roulette(left: Vec3, start: Vec3, u: f32) -> f32 {
    let brightest = |v: Vec3| max(v.x, max(v.y, v.z));
    if brightest(left) >= brightest(start) * FAINT {
        1.0
    } else if u < 0.5 {
        2.0
    } else {
        0.0
    }
}

/// Whether the material has an inside.
#[inline]
#[must_use]
pub fn is_dielectric(material: &Material) -> bool {
    material.kind == MATERIAL_DIELECTRIC || material.kind == MATERIAL_ROUGH_DIELECTRIC
}

/// The medium of the segment at whose end a ray of direction cosine `cos` to the outward normal meets a material of this index: a
/// path that began inside of a dielectric learns so when it meets it from there.
#[inline]
#[must_use]
pub fn medium_before(medium: u32, met: &Material, index: u32, cos: f32) -> u32 {
    if medium == VACUUM && cos > 0.0 && is_dielectric(met) { index } else { medium }
}

/// The medium after a surface of outward normal `normal` that a ray of direction cosine `cos` met and leaves on the side `side`.
#[inline]
#[must_use]
pub fn medium_after(medium: u32, met: &Material, index: u32, cos: f32, normal: Vec3, side: Vec3) -> u32 {
    let outside = dot(side, normal) > 0.0;
    let crossed = outside == (cos > 0.0);
    if !crossed || !is_dielectric(met) {
        medium
    } else if outside {
        VACUUM
    } else {
        index
    }
}

/// Whether a direction that a sampler drew about the shading normal goes through a surface that lets nothing through: it is absorbed.
#[inline]
#[must_use]
pub fn leaks(met: &Material, surface: &Surface, cos: f32, side: Vec3) -> bool {
    surface.smooth && !is_dielectric(met) && (dot(side, surface.normal) > 0.0) == (cos > 0.0)
}

/// Whether the inside of the material takes anything from light. Where it does not, nothing grows faint in it, and [`roulette`] has no part.
#[inline]
#[must_use]
pub fn absorbs(material: &Material) -> bool {
    let [red, green, blue] = material.absorption;
    red + green + blue != 0.0
}

/// Share of the light that is left after `distance` m inside of the material (Beer 1852), for each of red, green and blue.
#[inline]
#[must_use]
pub fn transmittance(material: &Material, distance: f32) -> Vec3 {
    if !absorbs(material) {
        return Vec3::ONE;
    }
    let [red, green, blue] = material.absorption;
    Vec3::new(exp(-(red * distance)), exp(-(green * distance)), exp(-(blue * distance)))
}

/// What radiance inside of the material is multiplied with when it is seen from outside: 1 / n².
#[inline]
#[must_use]
pub fn seen_from_outside(material: &Material) -> f32 {
    div(1.0, material.ior * material.ior)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_knows_what_it_is_in() {
        let water = Material { kind: MATERIAL_DIELECTRIC, ior: 1.33, ..Material::default() };
        let wall = Material::default();
        let up = Vec3::Y;
        // In, off the bottom, totally reflected at the surface, off a wall, and out.
        let inside = medium_after(VACUUM, &water, 3, -0.5, up, -up);
        assert_eq!(inside, 3);
        assert_eq!(medium_after(3, &wall, 1, -0.5, up, up), 3);
        assert_eq!(medium_after(3, &water, 3, 0.5, up, -up), 3);
        assert_eq!(medium_after(3, &water, 3, 0.5, up, up), VACUUM);
        // Reflected outside; and begun inside.
        assert_eq!(medium_after(VACUUM, &water, 3, -0.5, up, up), VACUUM);
        assert_eq!([medium_before(VACUUM, &water, 3, 0.5), medium_before(VACUUM, &water, 3, -0.5)], [3, VACUUM]);
    }

    #[test]
    fn what_is_faint_goes_on_half_of_the_time_with_twice_the_power() {
        let start = Vec3::new(8.0, 1.0, 0.0);
        assert_eq!(roulette(Vec3::new(0.1, 0.125, 0.0), start, 0.9), 1.0);
        assert_eq!([0.0, 0.499, 0.5, 0.9].map(|u| roulette(Vec3::splat(0.1), start, u)), [2.0, 2.0, 0.0, 0.0]);
    }

    #[test]
    fn absorption_is_exponential_in_the_way() {
        let water = Material { absorption: [0.5, 0.0, 2.0], ..Material::default() };
        let [one, two] = [1.5, 3.0].map(|way| transmittance(&water, way));
        assert!((one * one - two).abs().max_element() < 1e-6);
        assert!((one - Vec3::new((-0.75f32).exp(), 1.0, (-3.0f32).exp())).abs().max_element() < 1e-6);
    }
}
