//! Tests of rays against primitives.

use super::*;
use crate::trace::scene::PRIMITIVE_SPHERE;
use crate::trace::surface::point_of;
use crate::trace::vector::{cross, normalize};

fn sphere(radius: f32) -> Primitive {
    Primitive { kind: PRIMITIVE_SPHERE, size: radius, ..Primitive::default() }
}

#[test]
fn a_ray_meets_a_sphere_outside_inside_and_not_at_all() {
    let along = Vec3::new(0.0, 0.0, 1.0);
    assert_eq!(intersect(Vec3::new(0.0, 0.0, -3.0), along, &sphere(1.0)), 2.0);
    assert_eq!(intersect(Vec3::ZERO, along, &sphere(1.0)), 1.0);
    assert_eq!(intersect(Vec3::new(0.0, 1.5, -3.0), along, &sphere(1.0)), 0.0);
    assert!(intersect(Vec3::new(0.0, 0.0, 3.0), along, &sphere(1.0)) <= 0.0);
}

#[test]
fn a_quad_ends_at_its_edges() {
    let quad = Primitive {
        kind: PRIMITIVE_QUAD,
        position: [0.0; 3],
        normal: [0.0, 0.0, 1.0],
        sides: [[0.5, 0.0, 0.0], [0.0, 0.5, 0.0]],
        ..Primitive::default()
    };
    let down = Vec3::new(0.0, 0.0, -1.0);
    assert_eq!(intersect(Vec3::new(0.999, -0.999, 2.0), down, &quad), 2.0);
    assert_eq!(intersect(Vec3::new(1.001, 0.0, 2.0), down, &quad), 0.0);
    assert_eq!(intersect(Vec3::new(0.0, 0.0, 2.0), Vec3::X, &quad), 0.0);
}

/// Rays that almost lie in the plane, at any scale: they meet the quad where f64 says, or pass it where that is a matter of
/// rounding; what is no number is never a hit.
#[test]
fn grazing_rays_meet_a_quad_where_f64_says() {
    let mut met = 0;
    for i in 0..40_000u32 {
        let random = crate::num::pcg4d([i, 0x6a2e, 0, 0]).map(|x| x as f32 / 4_294_967_296.0);
        let scale = 10f32.powi((i % 13) as i32 - 6);
        let quad = Primitive {
            kind: PRIMITIVE_QUAD,
            position: [0.3 * scale, -0.2 * scale, 0.1 * scale],
            normal: [0.0, 0.0, 1.0],
            sides: [[0.5 / scale, 0.0, 0.0], [0.0, 0.5 / scale, 0.0]],
            size: 2e-6,
            ..Primitive::default()
        };
        let slope = [0.0, 1e-38, 1e-20, 1e-9, 1e-7, 1e-5, 1e-3, 0.1][(i / 13 % 8) as usize];
        let direction = normalize(Vec3::new(1.0, random[0] - 0.5, -slope));
        let origin = Vec3::new(-2.0 * scale, (random[1] - 0.5) * scale, (0.1 + slope * 3.0 * random[2]) * scale);
        let t = intersect(origin, direction, &quad);
        assert!(t.is_finite() && t >= 0.0, "{t}");
        let [o, d] = [origin, direction].map(|v| v.to_array().map(f64::from));
        let position = quad.position.map(f64::from);
        if t > 0.0 {
            met += 1;
            // The plane's distance is a difference of floats, exact to a rounding of the larger.
            let height = o[2] + f64::from(t) * d[2] - position[2];
            assert!(height.abs() <= 1e-6 * f64::from(scale), "{height} at {scale}");
            for axis in 0..2 {
                let local = (o[axis] + f64::from(t) * d[axis] - position[axis]).abs() / f64::from(scale);
                assert!(local <= 1.0 + 1e-5, "{local}");
            }
        }
    }
    assert!(met > 3000, "{met}");
}

/// Whatever rounding does to a ray that touches a sphere where it starts, its hit is on the sphere.
#[test]
fn a_hit_is_on_the_sphere_even_of_a_tangent() {
    let mut met = 0;
    for i in 0..200_000u32 {
        let random = crate::num::pcg4d([i, 0x7a9e, 0, 0]).map(|x| x as f32 / 2_147_483_648.0 - 1.0);
        let outward = normalize(Vec3::new(random[0], random[1], random[2] + 1e-6));
        let across = normalize(cross(outward, Vec3::new(random[3], 0.3, random[0])));
        let origin = outward * (1.0 + ((i % 7) as f32 - 3.0) * 6e-8);
        let slope = [0.0, 1e-10, -1e-10, 1e-7, -1e-7, 1e-4, -1e-4, -1e-2][(i / 7 % 8) as usize];
        let direction = normalize(across + outward * slope);
        let t = intersect(origin, direction, &sphere(1.0));
        if t > 0.0 {
            met += 1;
            let along = |axis: usize| f64::from(origin[axis]) + f64::from(direction[axis]) * f64::from(t);
            let at = (along(0).powi(2) + along(1).powi(2) + along(2).powi(2)).sqrt();
            assert!((at - 1.0).abs() < 2048.0 / f64::from(1 << 24), "{at} from the centre after {t}, slope {slope}");
        }
    }
    assert!(met > 20_000, "{met}");
}

#[test]
fn a_ray_that_leaves_a_surface_does_not_meet_it_again() {
    let mut i = 0;
    while i < 10_000 {
        let s = i as f32;
        let centre = Vec3::new(s * 0.37 - 900.0, (s * 0.11).sin() * 50.0, s * 1e-3);
        let ball = Primitive { position: centre.to_array(), ..sphere(0.35) };
        let outward = normalize(Vec3::new((s * 1.3).sin(), (s * 2.1).cos(), (s * 0.7).sin() + 0.01));
        let from = centre + outward * 10.0;
        let t = intersect(from, -outward, &ball);
        let (point, normal) = point_of(ALL, from, -outward, t, &ball);
        assert!(intersect(leave(point, normal, &ball), outward, &ball) <= 0.0, "{i}");
        i += 1;
    }
}
