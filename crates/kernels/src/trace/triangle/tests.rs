//! Tests of rays against triangles.

use super::*;
use crate::num::pcg4d;
use crate::trace::vector::{dot, normalize};
use crate::trace::{PRIMITIVE_TRIANGLE, Primitive, intersect, leave};
use std::vec::Vec;

/// Four numbers from −1 to 1.
fn random(i: u32, stream: u32) -> [f32; 4] {
    pcg4d([i, stream, 0x7219, 3]).map(|x| (f64::from(x) / 2_147_483_648.0 - 1.0) as f32)
}

fn triangle([a, b, c]: [Vec3; 3]) -> Primitive {
    let normal = (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize().as_vec3();
    Primitive {
        kind: PRIMITIVE_TRIANGLE,
        position: a.to_array(),
        normal: normal.to_array(),
        sides: [b.to_array(), c.to_array()],
        ..Primitive::default()
    }
}

/// A closed mesh around `centre`: an octahedron whose triangles are cut in four `depth` times, its corners moved at random and all of it
/// flattened along z, so that there are needles and steep bends.
fn closed(centre: Vec3, size: f32, depth: u32, flat: f32) -> Vec<[Vec3; 3]> {
    let corners = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let mut mesh: Vec<[Vec3; 3]> = Vec::new();
    for octant in 0..8usize {
        let [x, y, z] = [corners[octant & 1], corners[2 + (octant >> 1 & 1)], corners[4 + (octant >> 2)]];
        mesh.push(if octant.count_ones() % 2 == 0 { [x, y, z] } else { [y, x, z] });
    }
    for _ in 0..depth {
        mesh = mesh
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalize);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let moved = |v: Vec3| {
        // The same for all triangles of a corner: made of its coordinates, which are the same to the bit.
        let seed = pcg4d([v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), 5]);
        let at = v * (1.0 + seed[0] as f32 * (0.2 / 4_294_967_296.0));
        centre + Vec3::new(at.x, at.y, at.z * flat) * size
    };
    mesh.iter().map(|corners| corners.map(moved)).collect()
}

/// Of rays from inside that aim at corners, edges and anything: how many find no way out.
fn escapes(mesh: &[[Vec3; 3]], centre: Vec3, rays: u32) -> u32 {
    let mut escaped = 0;
    for i in 0..rays {
        let r = random(i, 1);
        let [a, b, c] = mesh[(i.wrapping_mul(0x9e37_79b9) >> 8) as usize % mesh.len()];
        let aim = match i % 4 {
            0 => a,
            1 => a + (b - a) * (0.5 + 0.5 * r[0]),
            2 => (a + b + c) * (1.0 / 3.0),
            _ => centre + Vec3::new(r[0], r[1], r[2]) * (a - centre).length(),
        };
        let direction = normalize(aim - centre);
        let shear = Shear::new(direction);
        let met = mesh.iter().any(|&corners| meet_triangle(centre, direction, shear, corners) > 0.0);
        escaped += u32::from(!met);
    }
    escaped
}

#[test]
fn no_ray_leaves_a_closed_mesh() {
    for (i, (offset, size, flat)) in
        [(0.0, 1.0, 1.0), (1000.0, 1.0, 1.0), (10.0, 1e-3, 0.3), (0.0, 1e-6, 1e-2), (3e5, 2e4, 1e-3)]
            .into_iter()
            .enumerate()
    {
        let centre = Vec3::new(offset, -0.7 * offset, 0.3 * offset);
        for depth in [0, 2, 3] {
            let mesh = closed(centre, size, depth, flat);
            let escaped = escapes(&mesh, centre, 8000);
            assert_eq!(escaped, 0, "case {i}, {} triangles", mesh.len());
        }
    }
}

/// The test above must be able to fail: a corner of one triangle is moved outwards by a few units in the last place.
#[test]
fn a_crack_of_some_units_in_the_last_place_is_seen() {
    let mut mesh = closed(Vec3::ZERO, 1.0, 2, 1.0);
    for [a, b, c] in &mut mesh {
        // Away from the opposite side's line, so that a gap opens.
        *a += ((*b + *c) * 0.5 - *a) * 4e-7;
    }
    assert!(escapes(&mesh, Vec3::ZERO, 40_000) > 0);
}

#[test]
fn hits_are_where_f64_says() {
    let mut met = 0;
    for i in 0..100_000 {
        let [r, s, t, o] = [random(i, 2), random(i, 3), random(i, 4), random(i, 5)];
        let scale = 10f32.powi((i % 13) as i32 - 6);
        let v = |x: [f32; 4]| Vec3::new(x[0], x[1], x[2]) * scale;
        let corners = [v(r), v(s), v(t)];
        let origin = v(o) * 2.0;
        let aim = corners[0] * (r[3].abs() * 0.5) + corners[1] * (s[3].abs() * 0.5) + corners[2] * (t[3].abs() * 0.5);
        let direction = normalize(aim - origin);
        let found = meet_triangle(origin, direction, Shear::new(direction), corners);
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let (o, d) = (origin.as_dvec3(), direction.as_dvec3());
        let (e, f) = (b - a, c - a);
        let normal = e.cross(f);
        let slope = normal.normalize().dot(d);
        if slope.abs() < 1e-3 {
            continue;
        }
        // Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
        let p = d.cross(f);
        let det = e.dot(p);
        let from = o - a;
        let u = from.dot(p) / det;
        let q = from.cross(e);
        let w = d.dot(q) / det;
        let expected = f.dot(q) / det;
        let margin = u.min(w).min(1.0 - u - w);
        let height = normal.length() / e.length().max(f.length()).max((f - e).length());
        if margin.abs() * height < 1e-5 * f64::from(scale) || expected.abs() < 1e-4 * f64::from(scale) {
            continue;
        }
        assert_eq!(found > 0.0, margin > 0.0 && expected > 0.0, "{i}: {found}, {margin}, {expected}");
        if found > 0.0 {
            met += 1;
            let error = (f64::from(found) - expected).abs() * slope.abs();
            assert!(error < 4e-6 * f64::from(scale), "{i}: {found}, {expected}, {slope}");
        }
    }
    assert!(met > 20_000, "{met}");
}

/// Rays in the plane of a triangle and almost in it, and needles: a hit is a number, and where the ray is beside the triangle.
#[test]
fn grazing_rays_meet_a_triangle_within_its_box() {
    let mut met = 0;
    for i in 0..200_000 {
        let [r, s, o] = [random(i, 6), random(i, 7), random(i, 8)];
        let thin = [1.0, 1e-2, 1e-4, 1e-6][(i % 4) as usize];
        let scale = 10f32.powi((i / 4 % 9) as i32 - 4);
        let (x, y) = (normalize(Vec3::new(r[0], r[1], r[2])), normalize(Vec3::new(s[0], s[1], s[2])));
        let a = Vec3::new(o[0], o[1], o[2]) * scale;
        let corners = [a, a + x * scale, a + (x * (0.5 + 0.4 * r[3]) + y * thin) * scale];
        let normal = normalize(cross(corners[1] - a, corners[2] - a));
        let along = normalize(x * s[3] + cross(normal, x) * o[3]);
        let lift = [0.0, 1e-9, 1e-7, -1e-7, 1e-5, 1e-3][(i / 36 % 6) as usize];
        let direction = normalize(along + normal * lift);
        let part = (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0);
        let origin = part - direction * (scale * (1.0 + r[0]));
        let t = meet_triangle(origin, direction, Shear::new(direction), corners);
        assert!(t.is_finite(), "{t}");
        if t > 0.0 {
            met += 1;
            let reach = corners.iter().chain([&origin]).fold(0.0f32, |all, v| all.max(v.abs().max_element()));
            for axis in 0..3 {
                let at = f64::from(origin[axis]) + f64::from(t) * f64::from(direction[axis]);
                let low = corners.iter().fold(f32::MAX, |all, v| all.min(v[axis]));
                let high = corners.iter().fold(f32::MIN, |all, v| all.max(v[axis]));
                // 96 u of the reach is what the host's boxes have room for.
                let room = f64::from(reach) * 96.0 / f64::from(1 << 24);
                assert!(at > f64::from(low) - room && at < f64::from(high) + room, "{i}: {at} of {low} to {high}");
            }
        }
    }
    assert!(met > 20_000, "{met}");
}

#[test]
fn a_ray_that_leaves_a_triangle_does_not_meet_it_again() {
    let mut left = 0;
    for i in 0..100_000 {
        let [r, s, o, d] = [random(i, 9), random(i, 10), random(i, 11), random(i, 12)];
        let offset = [0.0, 1.0, 1e3][(i % 3) as usize];
        let a = Vec3::new(o[0], o[1], o[2]) + Vec3::new(1.0, 0.3, -0.7) * offset;
        let corners = [a, a + Vec3::new(r[0], r[1], r[2]), a + Vec3::new(s[0], s[1], s[2])];
        let wall = triangle(corners);
        let normal = Vec3::from_array(wall.normal);
        let area = cross(corners[1] - a, corners[2] - a).length();
        if area < 0.01 {
            continue;
        }
        let [u, v] = [0.5 + 0.49 * o[3], 0.5 + 0.49 * d[3]];
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let point = a + (corners[1] - a) * u + (corners[2] - a) * v;
        let start = leave(point, normal, &wall);
        let tangent = normalize(cross(normal, Vec3::new(d[0], d[1], d[2])));
        let rise = [1e-7, 1e-6, 1e-4, 1e-2, 1.0][(i / 3 % 5) as usize];
        let direction = normalize(tangent + normal * rise);
        if dot(direction, normal) <= 0.0 {
            continue;
        }
        left += 1;
        let t = intersect(start, direction, &wall);
        assert!(t <= 0.0, "{i}: again after {t}, rise {rise}, offset {offset}");
    }
    assert!(left > 50_000, "{left}");
}

#[test]
fn shares_are_those_of_the_point() {
    for i in 0..10_000 {
        let [r, s, t, w] = [random(i, 13), random(i, 14), random(i, 15), random(i, 16)];
        let corners = [r, s, t].map(|x| Vec3::new(x[0], x[1], x[2]));
        if cross(corners[1] - corners[0], corners[2] - corners[0]).length() < 0.05 {
            continue;
        }
        let (v, w) = (0.5 + 0.5 * w[0], 0.5 + 0.5 * w[1]);
        let (v, w) = if v + w > 1.0 { (1.0 - v, 1.0 - w) } else { (v, w) };
        let point = corners[0] + (corners[1] - corners[0]) * v + (corners[2] - corners[0]) * w;
        let found = shares(corners, point);
        assert!((found[0] + found[1] + found[2] - 1.0).abs() < 1e-6);
        assert!((found[1] - v).abs() < 1e-3 && (found[2] - w).abs() < 1e-3, "{found:?}, {v}, {w}");
    }
}
