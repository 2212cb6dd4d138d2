//! Each lobe against its own density, against energy and against reciprocity.

use super::microfacet::{SMOOTHEST, sample_visible, visible_density};
use super::*;
use crate::num::pcg4d;
use crate::trace::ALL;
use crate::trace::chi_square::{limit, of_directions, on_sphere};
use crate::trace::scene::{MATERIAL_DIELECTRIC, MATERIAL_MIRROR, NO_TEXTURE};
use crate::trace::vector::normalize;
use std::vec;
use std::vec::Vec;

/// A black material without anything.
pub(crate) const NOTHING: Material = Material {
    reflectance: [0.0; 3],
    kind: MATERIAL_LAMBERTIAN,
    ior: 1.0,
    survival: 0.0,
    texture: NO_TEXTURE,
    roughness_texture: NO_TEXTURE,
    roughness: 0.0,
    metallic: 0.0,
    absorption: [0.0; 3],
    normal_texture: NO_TEXTURE,
    normal_scale: 1.0,
    alpha_cutoff: 0.0,
};

fn layered(reflectance: [f32; 3], metallic: f32, roughness: f32) -> Material {
    Material { reflectance, kind: MATERIAL_LAYERED, ior: 1.5, survival: 1.0, roughness, metallic, ..NOTHING }
}

fn frosted(ior: f32, roughness: f32) -> Material {
    Material { reflectance: [1.0; 3], kind: MATERIAL_ROUGH_DIELECTRIC, ior, survival: 1.0, roughness, ..NOTHING }
}

/// A material of each kind and roughness.
fn all() -> Vec<Material> {
    let mut all = vec![
        Material { reflectance: [1.0, 0.5, 0.25], survival: 1.0, ..NOTHING },
        Material { reflectance: [1.0, 0.5, 0.25], kind: MATERIAL_MIRROR, survival: 1.0, ..NOTHING },
        Material { reflectance: [1.0; 3], kind: MATERIAL_DIELECTRIC, ior: 1.5, survival: 1.0, ..NOTHING },
    ];
    for roughness in [0.0, 0.1, 0.3, 0.7, 1.0] {
        all.extend([0.0, 0.4, 1.0].map(|metallic| layered([1.0, 0.6, 0.1], metallic, roughness)));
        all.extend([1.5, 1.33, 0.7].map(|ior| frosted(ior, roughness)));
    }
    all
}

fn random(i: u32, stream: u32) -> [f32; 3] {
    let [x, y, z, _] = pcg4d([i, stream, 0xb5df, 0]).map(crate::num::u32_to_unit);
    [x, y, z]
}

/// A normal in general position, and a direction that comes to it at an angle of cosine `cos`, on the side of that sign.
fn arriving(cos: f32) -> (Vec3, Vec3) {
    let n = normalize(Vec3::new(0.3, -0.5, 0.8));
    let (t, _) = crate::trace::vector::frame(n);
    (-(n * cos + t * (1.0 - cos * cos).sqrt()), n)
}

const COSINES: [f32; 8] = [1.0, 0.9, 0.5, 0.2, 0.05, -1.0, -0.6, -0.1];

/// χ² of samples against their density, and its degrees of freedom. What the density leaves of 1 has to be the share of samples without one: of delta
/// lobes and absorption.
fn chi_square(material: &Material, cos: f32, fault: f64) -> (f64, usize) {
    let (d, n) = arriving(cos);
    let sampled = |i| Some(sample(ALL, material, d, n, random(i, 1))).filter(|scattered| scattered.pdf > 0.0);
    let direction = |i| sampled(i).map(|scattered| scattered.direction);
    of_directions(n, direction, |out| evaluate(ALL, material, d, out, n).1, &std::format!("{material:?} at {cos}"))
        .chi_square(fault)
}

#[test]
fn samples_follow_their_density() {
    let mut worst = 0f64;
    for material in all() {
        for cos in [1.0, 0.5, 0.05, -0.6] {
            // A grazing lobe of α = 0.1 is narrower than the quadrature's steps; the Jacobian's test has those.
            let narrow = cos == 0.05 && material.roughness == 0.1;
            let delta = specular_chance(ALL, &material, cos) == 1.0 && !is_glossy(&material);
            if narrow || delta {
                continue;
            }
            let (chi2, cells) = chi_square(&material, cos, 1.0);
            worst = worst.max(chi2 / limit(cells));
            assert!(chi2 < limit(cells), "{material:?} at {cos}: χ² {chi2} of {cells}, limit {}", limit(cells));
        }
    }
    assert!(worst > 0.3, "{worst}: χ² is never this small for random samples");
    // A density that is 6 % too large has to show.
    let (chi2, cells) = chi_square(&layered([0.5; 3], 1.0, 0.7), 0.5, 1.06);
    assert!(chi2 > limit(cells), "{chi2}");
}

/// Weight times density is what evaluation says, and so is the density: of both glossy lobes alone, and of the sum.
#[test]
fn sampling_and_evaluation_agree() {
    let mut compared = 0;
    for material in all() {
        for cos in COSINES {
            let (d, n) = arriving(cos);
            for i in 0..500 {
                for whole in [true, false] {
                    let u = random(i, 2);
                    type Evaluate = fn(&Material, Vec3, Vec3, Vec3) -> (Vec3, f32);
                    let (scattered, evaluated): (Scattered, Evaluate) = if whole {
                        (sample(ALL, &material, d, n, u), |m, d, out, n| evaluate(ALL, m, d, out, n))
                    } else {
                        (sample_specular(ALL, &material, d, n, u), |m, d, out, n| evaluate_specular(ALL, m, d, out, n))
                    };
                    assert!((scattered.direction.length() - 1.0).abs() < 1e-6 && scattered.weight.is_finite());
                    assert!(scattered.weight.min_element() >= 0.0 && scattered.pdf >= 0.0);
                    let leaves = dot(scattered.direction, scattered.side);
                    assert!(scattered.weight == Vec3::ZERO || leaves > -1e-6, "{material:?}: leaves by {leaves}");
                    // Near grazing, a rounding of the direction changes the value by more than what is allowed here.
                    if scattered.pdf == 0.0 || leaves < 0.01 {
                        continue;
                    }
                    let (value, pdf) = evaluated(&material, d, scattered.direction, n);
                    let ours = scattered.weight * scattered.pdf;
                    // Digits are lost in h where it is computed from almost opposite vectors: 10⁻³ is measured at ior 1.33.
                    let close = |a: f32, b: f32| (a - b).abs() <= 4e-3 * a.abs().max(b.abs()) + 1e-6;
                    assert!(close(pdf, scattered.pdf), "{material:?} at {cos}: {pdf} or {}", scattered.pdf);
                    for c in 0..3 {
                        assert!(close(value[c], ours[c]), "{material:?} at {cos}: {value} or {ours}");
                    }
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 100_000, "{compared}");
}

/// Mean weight of stratified samples.
fn albedo(material: &Material, cos: f32, sides: u32) -> Vec3 {
    let (d, n) = arriving(cos);
    let mut sum = Vec3::ZERO;
    for i in 0..sides * sides {
        let [a, b, c] = random(i, 3);
        let u = [((i % sides) as f32 + a) / sides as f32, ((i / sides) as f32 + b) / sides as f32, c];
        sum += sample(ALL, material, d, n, u).weight;
    }
    sum / (sides * sides) as f32
}

/// In a white furnace nothing reflects more than it gets, and what cannot lose light reflects all of it.
#[test]
fn no_material_makes_light_and_lossless_ones_lose_none() {
    for cos in COSINES {
        for material in all() {
            let albedo = albedo(&material, cos, 128);
            // The samples' noise: the standard deviation of a weight is below 1, of the mean of 16384 below 0.008, stratified 0.004.
            assert!(albedo.max_element() < 1.012, "{material:?} at {cos}: {albedo}");
        }
        for material in [
            Material { reflectance: [1.0; 3], ..NOTHING },
            Material { reflectance: [1.0; 3], kind: MATERIAL_MIRROR, ..NOTHING },
            Material { reflectance: [1.0; 3], kind: MATERIAL_DIELECTRIC, ior: 1.5, ..NOTHING },
            layered([1.0; 3], 0.0, 0.0),
            layered([1.0; 3], 0.6, 0.0),
            frosted(1.5, 0.0),
        ] {
            let albedo = albedo(&material, cos, 128);
            assert!((albedo - Vec3::ONE).abs().max_element() < 0.012, "{material:?} at {cos}: {albedo}");
        }
        // Rough ones lose what would be reflected more than once among the facets, and at α = 0.1 that is little.
        for material in [layered([1.0; 3], 1.0, 0.1), frosted(1.5, 0.1)] {
            let albedo = albedo(&material, cos, 128).min_element();
            assert!(albedo > 0.85, "{material:?} at {cos}: {albedo}");
        }
    }
    // A coat that reflected by Fresnel's law over a base that got all the light would show.
    let (d, n) = arriving(0.5);
    let plastic = layered([1.0; 3], 0.0, 0.0);
    let cheating = schlick(0.04, 0.5) + albedo_of_base(&Material { reflectance: [1.0; 3], ..NOTHING }, d, n);
    assert!(cheating > 1.03);
    assert!((schlick(0.04, 0.5) + albedo_of_base(&plastic, d, n) - 1.0).abs() < 2e-3);
}

/// Share of the light from `d` that the diffuse lobe reflects, by quadrature.
fn albedo_of_base(material: &Material, d: Vec3, n: Vec3) -> f32 {
    let mut sum = 0.0;
    for i in 0..1000 {
        let cos = (i as f32 + 0.5) / 1000.0;
        sum += albedo_diffuse(ALL, material, cos).x * 2.0 * cos / 1000.0;
    }
    sum * entrance(ALL, material, dot(d, n))
}

/// Light's way can be reversed: f(a → b) = f(b → a), and of refraction so but for the squares of the indices, which are the
/// media's. f·cos is what is evaluated, so each side is divided by its cosine.
#[test]
fn lobes_are_reciprocal() {
    let mut compared = 0;
    for material in all() {
        for i in 0..2000 {
            let [x, y, _] = random(i, 4);
            let [z, w, _] = random(i, 5);
            let n = normalize(Vec3::new(0.3, -0.5, 0.8));
            let a = on_sphere(n, f64::from(x), f64::from(y));
            let b = on_sphere(n, f64::from(z), f64::from(w));
            let (cos_a, cos_b) = (dot(a, n), dot(b, n));
            if cos_a.abs() < 0.05 || cos_b.abs() < 0.05 {
                continue;
            }
            let there = evaluate(ALL, &material, -a, b, n).0 / cos_b.abs();
            let back = evaluate(ALL, &material, -b, a, n).0 / cos_a.abs();
            let squares = if cos_a * cos_b > 0.0 {
                1.0
            } else {
                // n² of the side of b over that of a.
                let ior = material.ior;
                if cos_b < 0.0 { ior * ior } else { 1.0 / (ior * ior) }
            };
            let difference = (there - back * squares).abs().max_element();
            assert!(
                difference <= 5e-3 * there.max_element() + 1e-5,
                "{material:?}: {there} there, {back} back, times {squares}"
            );
            compared += u32::from(there.max_element() > 1e-3);
        }
    }
    assert!(compared > 10_000, "{compared}");
}

/// The two numbers from which [`sample_visible`] makes the normal `h`, in f64: its inverse. With w the stretched view, h comes
/// from the point c = 2(m·w)m − w of the unit sphere, m being h stretched back.
fn numbers_of(alpha: f64, v: [f64; 3], h: [f64; 3]) -> [f64; 2] {
    let unit = |v: [f64; 3]| {
        let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        v.map(|x| x / length)
    };
    let w = unit([v[0] * alpha, v[1] * alpha, v[2]]);
    let m = unit([h[0] / alpha, h[1] / alpha, h[2]]);
    let along = 2.0 * (m[0] * w[0] + m[1] * w[1] + m[2] * w[2]);
    let c = [0, 1, 2].map(|i| along * m[i] - w[i]);
    let turn = c[1].atan2(c[0]) / core::f64::consts::TAU;
    [turn - turn.floor(), 1.0 - (c[2] + w[2]) / (1.0 + w[2])]
}

/// The sampler's inverse gives its numbers back, and the density is the inverse's Jacobian, down to the narrowest lobes.
#[test]
fn visible_normals_have_an_inverse_whose_jacobian_is_their_density() {
    for alpha in [SMOOTHEST, 0.01, 0.1, 0.5, 1.0] {
        for cos in [1.0, 0.7, 0.2] {
            let v = Vec3::new((1.0f32 - cos * cos).sqrt() * 0.6, (1.0f32 - cos * cos).sqrt() * 0.8, cos);
            for i in 0..300 {
                let [u, w, _] = random(i, 6);
                if !(0.02..0.98).contains(&u) || !(0.02..0.98).contains(&w) {
                    continue;
                }
                let h = sample_visible(alpha, v, u, w);
                let (a, v64) = (f64::from(alpha), v.to_array().map(f64::from));
                let [back_u, back_w] = numbers_of(a, v64, h.to_array().map(f64::from));
                let off = (back_u - f64::from(u)).abs().max((back_w - f64::from(w)).abs());
                // Roundings of h, 6·10⁻⁸, against the width α of the lobe, where it is steepest.
                assert!(off < 2e-3, "{alpha}, {cos}: ({u}, {w}) came back as ({back_u}, {back_w})");
                // Two small steps across h, in units of the lobe's width.
                let step = 1e-4 * a;
                let (t, s) = crate::trace::vector::frame(h);
                let moved = |x: Vec3, by: f64| {
                    let p = [0, 1, 2].map(|c| f64::from(h[c]) + f64::from(x[c]) * by);
                    let length = p.iter().map(|p| p * p).sum::<f64>().sqrt();
                    numbers_of(a, v64, p.map(|p| p / length))
                };
                let slope = |x: Vec3| {
                    let (ahead, behind) = (moved(x, step), moved(x, -step));
                    [0, 1].map(|i| (ahead[i] - behind[i]) / (2.0 * step))
                };
                let (along, across) = (slope(t), slope(s));
                let jacobian = (along[0] * across[1] - along[1] * across[0]).abs();
                let density = f64::from(visible_density(alpha, v, h) * dot(v, h));
                assert!((density / jacobian - 1.0).abs() < 5e-3, "{alpha}, {cos}: {density}, slope {jacobian}");
            }
        }
    }
}

/// Just above the limit below which it is smooth, a lobe has the mean direction, the width and the energy that lead to the
/// delta lobe: there is no step.
#[test]
fn rough_lobes_become_delta_lobes() {
    for cos in [1.0, 0.7, 0.3, -0.5] {
        let (d, n) = arriving(cos);
        for make in [
            (|roughness| layered([1.0, 0.6, 0.1], 1.0, roughness)) as fn(f32) -> Material,
            |roughness| layered([0.2, 0.6, 0.9], 0.0, roughness),
            |roughness| frosted(1.5, roughness),
        ] {
            let mean = |roughness: f32| {
                let material = make(roughness);
                let (mut weight, mut direction) = (Vec3::ZERO, Vec3::ZERO);
                for i in 0..40_000 {
                    let scattered = sample(ALL, &material, d, n, random(i, 7));
                    if scattered.diffuse {
                        continue; // the base does not know roughness
                    }
                    weight += scattered.weight / 40_000.0;
                    direction += scattered.direction * (scattered.weight.x / 40_000.0);
                }
                (weight, direction)
            };
            let (smooth, rough) = (mean(SMOOTHEST * 0.5), mean(SMOOTHEST));
            let off = (smooth.0 - rough.0).abs().max_element().max((smooth.1 - rough.1).abs().max_element());
            // The same numbers decide, so what differs is the lobe: O(α) on the directions of either side.
            assert!(off < 2e-3, "{:?} at {cos}: {smooth:?} and {rough:?}", make(SMOOTHEST));
            // And one that is much wider is seen to be wider than that.
            let wide = mean(0.3);
            assert!((smooth.1 - wide.1).abs().max_element() > 2e-3, "{:?} at {cos}", make(0.3));
        }
    }
}
