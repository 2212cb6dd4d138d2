//! Tests of surfaces.

use super::*;
use crate::num::pcg4d;
use crate::trace::ALL;
use crate::trace::vector::{pack_direction, reflect};
use crate::trace::{PRIMITIVE_TRIANGLE, WRAP_REPEAT};

/// A vector of components from −1 to 1.
fn random(i: u32, stream: u32) -> Vec3 {
    let random = pcg4d([i, stream, 0x50f4, 3]).map(|x| (f64::from(x) / 2_147_483_648.0 - 1.0) as f32);
    Vec3::new(random[0], random[1], random[2])
}

#[test]
fn a_reflection_at_a_shading_normal_stays_on_its_side() {
    for i in 0..100_000 {
        let normal = normalize(random(i, 0));
        let d = normalize(random(i, 1) + normal * [0.0, 1e-3, 1e-6][(i % 3) as usize]);
        let shading = random(i, 2);
        let n = usable(shading, normal, d);
        let front = if dot(d, normal) > 0.0 { -normal } else { normal };
        assert!((n.length() - 1.0).abs() < 1e-5, "{i}: {n:?}");
        let facing = if dot(d, normal) > 0.0 { -n } else { n };
        // Of a normal that is dropped only the surface's own side counts.
        assert!(dot(reflect(d, facing), front) > -1e-6, "{i}: {}", dot(reflect(d, facing), front));
    }
}

#[test]
fn a_shading_normal_that_can_be_used_is_left_as_it_is() {
    let normal = Vec3::Z;
    let d = normalize(Vec3::new(0.3, 0.1, -1.0));
    let shading = normalize(Vec3::new(0.1, -0.2, 1.0));
    assert!((usable(shading * 3.0, normal, d) - shading).length() < 1e-6);
    // From behind it is the same normal, since it belongs to the front.
    assert!((usable(shading, normal, -d) - shading).length() < 1e-6);
    assert_eq!(usable(-shading, normal, d), normal);
    assert_eq!(usable(Vec3::ZERO, normal, d), normal);
}

#[test]
fn normals_and_coordinates_are_mixed_by_the_point() {
    let triangle = Primitive {
        kind: PRIMITIVE_TRIANGLE,
        position: [0.0, 0.0, 0.0],
        normal: [0.0, 0.0, 1.0],
        sides: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        ..Primitive::default()
    };
    let tilted = [Vec3::new(-0.3, 0.0, 1.0), Vec3::new(0.3, 0.0, 1.0), Vec3::new(0.0, 0.3, 1.0)].map(normalize);
    let corners = [Corners { normals: tilted.map(pack_direction), uv: [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]] }];
    let info = SceneInfo { first_corners: 7, ..SceneInfo::default() };
    let (origin, direction) = (Vec3::new(0.5, 0.25, 2.0), Vec3::NEG_Z);
    let hit = |primitive| Hit { t: 2.0, primitive };
    let surface = surface_at(ALL, origin, direction, hit(7), &info, &triangle, &corners);
    assert!(surface.smooth && surface.normal == Vec3::Z);
    let expected = normalize(tilted[0] * 0.25 + tilted[1] * 0.5 + tilted[2] * 0.25);
    assert!((surface.shading - expected).length() < 1e-4, "{:?}", surface.shading);
    assert!((surface.uv[0] - 0.5).abs() < 1e-6 && (surface.uv[1] - 0.75).abs() < 1e-6, "{:?}", surface.uv);
    // A triangle before the first with corners has none.
    let flat = surface_at(ALL, origin, direction, hit(6), &info, &triangle, &corners);
    assert!(!flat.smooth && flat.shading == Vec3::Z);
}

#[test]
fn a_texture_multiplies_the_reflectance() {
    let half = 0x3800; // 0.5
    let texels = [Texel { rg: half | 0x3c00 << 16, ba: 0 }];
    let textures = [Texture { first: 0, width: 1, height: 1, wrap: WRAP_REPEAT }];
    let plain = Material { reflectance: [0.8, 0.4, 0.6], survival: 0.8, texture: NO_TEXTURE, ..Material::default() };
    let materials = [plain, Material { texture: 0, ..plain }];
    assert_eq!(material_at(ALL, 0, [0.3, 0.7], &materials, &textures, &texels), plain);
    let textured = material_at(ALL, 1, [0.3, 0.7], &materials, &textures, &texels);
    assert_eq!((textured.reflectance, textured.survival), ([0.4, 0.4, 0.0], 0.4));
}
