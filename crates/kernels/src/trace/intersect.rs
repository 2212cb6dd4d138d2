//! Rays against primitives.

use super::bvh::{BvhNode, INNER, LEAF_BITS, Slabs, octant};
use super::scene::{PRIMITIVE_QUAD, Primitive, SceneInfo};
use super::vector::{dot, normalize};
use crate::exec::Input;
use crate::num::{abs, div, max, sqrt};
use glam::Vec3;

/// [`Hit::primitive`] of a ray that hit nothing.
pub const MISS: u32 = 0xffff_ffff;
/// [`Hit::primitive`] of a ray that was not followed to its end: after [`MAX_BOUNCES`](super::MAX_BOUNCES), or because the
/// device ends loops early, as llvmpipe does after 65,535 iterations.
pub const LOST: u32 = 0xffff_fffe;

/// What [`occluded`] says of a ray that something stands in the way of.
pub const BLOCKED: u32 = 0;

/// Farthest that a ray reaches, in lengths of its direction.
const FARTHEST: f32 = 1e30;
/// 32 units in the last place of 1.
const UNITS: f32 = 3.814_697_3e-6;
/// The bits of a leaf's first primitive.
const FIRST: u32 = (1 << LEAF_BITS) - 1;
/// 2⁻¹³.
const TOUCHING: f32 = 1.220_703_1e-4;

/// The nearest thing a ray meets.
#[derive(Clone, Copy)]
pub struct Hit {
    /// Where, in lengths of the ray's direction.
    pub t: f32,
    /// What: an index of a primitive, [`MISS`] or [`LOST`].
    pub primitive: u32,
}

/// The nearest primitive along `origin + t·direction`, t > 0, and of those equally near the one of the lowest index: whatever the
/// tree, there is one answer. The direction has unit length.
///
/// One loop looks for the next primitive and another meets it, so that the lanes of a subgroup meet theirs together (Aila and
/// Laine, "Understanding the Efficiency of Ray Traversal on GPUs", HPG 2009).
#[inline]
#[must_use]
pub fn closest_hit(
    origin: Vec3,
    direction: Vec3,
    info: &SceneInfo,
    nodes: &Input<BvhNode>,
    primitives: &Input<Primitive>,
) -> Hit {
    let slabs = Slabs::new(origin, direction);
    let mut best = Hit { t: f32::MAX, primitive: MISS };
    let mut lost = false;
    let mut at = octant(direction) * info.nodes;
    let end = at + info.nodes;
    while at < end {
        let mut leaf = INNER;
        while at < end && leaf == INNER {
            let node = nodes[at as usize];
            let met = slabs.meet(&node, best.t);
            leaf = if met { node.leaf } else { INNER };
            at = if met { at + 1 } else { node.skip };
        }
        let mut i = leaf & FIRST;
        let last = i + (leaf >> LEAF_BITS);
        while i < last {
            let t = intersect(origin, direction, &primitives[i as usize]);
            if t > 0.0 && (t < best.t || (t == best.t && i < best.primitive)) {
                best = Hit { t, primitive: i };
            }
            i += 1;
        }
        lost |= i < last;
    }
    if lost || at < end {
        best.primitive = LOST;
    }
    best
}

/// Whether something stands between `origin` and `origin + distance·direction`, other than primitive `except`: [`BLOCKED`],
/// [`MISS`] or [`LOST`].
#[inline]
#[must_use]
pub fn occluded(
    origin: Vec3,
    direction: Vec3,
    distance: f32,
    except: u32,
    info: &SceneInfo,
    nodes: &Input<BvhNode>,
    primitives: &Input<Primitive>,
) -> u32 {
    let slabs = Slabs::new(origin, direction);
    let mut found = MISS;
    let mut lost = false;
    let mut at = octant(direction) * info.nodes;
    let end = at + info.nodes;
    while at < end && found == MISS {
        let mut leaf = INNER;
        while at < end && leaf == INNER {
            let node = nodes[at as usize];
            let met = slabs.meet(&node, distance);
            leaf = if met { node.leaf } else { INNER };
            at = if met { at + 1 } else { node.skip };
        }
        let mut i = leaf & FIRST;
        let last = i + (leaf >> LEAF_BITS);
        while i < last && found == MISS {
            if i != except {
                let t = intersect(origin, direction, &primitives[i as usize]);
                if t > 0.0 && t < distance {
                    found = BLOCKED;
                }
            }
            i += 1;
        }
        lost |= i < last;
    }
    if found == MISS && (lost || at < end) { LOST } else { found }
}

/// The smallest positive t at which the ray meets the primitive, or 0.
#[inline]
#[must_use]
pub fn intersect(origin: Vec3, direction: Vec3, primitive: &Primitive) -> f32 {
    let position = Vec3::from_array(primitive.position);
    if primitive.kind == PRIMITIVE_QUAD {
        let normal = Vec3::from_array(primitive.normal);
        let slope = dot(normal, direction);
        if slope == 0.0 {
            return 0.0;
        }
        let t = div(dot(normal, position - origin), slope);
        // Grazing rays meet the plane too far away for floats, which then are no numbers to compare.
        #[allow(clippy::manual_range_contains)] // plain comparisons, without a range between them and the GPU
        if t <= 0.0 || t > FARTHEST {
            return 0.0;
        }
        let local = origin + direction * t - position;
        let u = abs(dot(local, Vec3::from_array(primitive.duals[0])));
        let v = abs(dot(local, Vec3::from_array(primitive.duals[1])));
        let edge = 0.5 + primitive.size;
        return if u <= edge && v <= edge { t } else { 0.0 };
    }
    // Haines et al., "Precision Improvements for Ray/Sphere Intersection" (Ray Tracing Gems, chapter 7): the
    // discriminant from the ray's distance to the centre, and the root without cancellation from the other one.
    let f = origin - position;
    let b = -dot(f, direction);
    let nearest = f + direction * b;
    let discriminant = primitive.size * primitive.size - dot(nearest, nearest);
    if discriminant < 0.0 {
        return 0.0;
    }
    let root = sqrt(discriminant);
    let q = if b < 0.0 { b - root } else { b + root };
    let c = dot(f, f) - primitive.size * primitive.size;
    // A discriminant that is not 0 is at least 2⁻²⁵ r². So this is a ray that touches the sphere where it starts, and rounding is
    // all that c has: the quotient could be a hit far from the sphere.
    let other = if abs(q) < primitive.size * TOUCHING { 0.0 } else { div(c, q) };
    let near = if q < other { q } else { other };
    let far = if q < other { other } else { q };
    if near > 0.0 { near } else { far }
}

/// The point of a hit and the surface's unit normal there: a quad's front side, a sphere's outside.
///
/// The point is put back onto the surface, so that its error is a rounding of the point itself and not of the ray's length. On
/// a quad it is also drawn towards the middle, by more than a quad reaches beyond its edges: at a closed corner no point
/// comes to lie behind the other wall.
#[inline]
#[must_use]
pub fn surface_at(origin: Vec3, direction: Vec3, t: f32, primitive: &Primitive) -> (Vec3, Vec3) {
    let position = Vec3::from_array(primitive.position);
    let point = origin + direction * t;
    if primitive.kind == PRIMITIVE_QUAD {
        let normal = Vec3::from_array(primitive.normal);
        let local = point - position;
        (position + (local - normal * dot(normal, local)) * (1.0 - 8.0 * primitive.size), normal)
    } else {
        let normal = normalize(point - position);
        (position + normal * primitive.size, normal)
    }
}

/// Moves the start of a ray off the primitive it leaves, along the unit normal of the side it leaves to, by 32 units in the
/// last place of the largest coordinate that the point was computed from.
///
/// That is a few times the rounding error of a point on a plane or a sphere and of its distance to it, at any scale, and
/// nothing like a fixed length (Wächter and Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing
/// Gems, chapter 6, who take units of each coordinate, and a fixed length near 0; Pharr, Jakob and Humphreys, "Physically
/// Based Rendering", 4th edition, section 6.8, for the bounds).
#[inline]
#[must_use]
pub fn leave(point: Vec3, normal: Vec3, primitive: &Primitive) -> Vec3 {
    let position = primitive.position;
    let place = max(abs(position[0]), max(abs(position[1]), abs(position[2])));
    let reach = max(abs(point.x), max(abs(point.y), abs(point.z)));
    point + normal * (max(reach, max(place, primitive.size)) * UNITS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::scene::PRIMITIVE_SPHERE;

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
            duals: [[0.5, 0.0, 0.0], [0.0, 0.5, 0.0]],
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
                duals: [[0.5 / scale, 0.0, 0.0], [0.0, 0.5 / scale, 0.0]],
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
            let across = normalize(super::super::vector::cross(outward, Vec3::new(random[3], 0.3, random[0])));
            let origin = outward * (1.0 + ((i % 7) as f32 - 3.0) * 6e-8);
            let slope = [0.0, 1e-10, -1e-10, 1e-7, -1e-7, 1e-4, -1e-4, -1e-2][(i / 7 % 8) as usize];
            let direction = normalize(across + outward * slope);
            let t = intersect(origin, direction, &sphere(1.0));
            if t > 0.0 {
                met += 1;
                let along = |axis: usize| f64::from(origin[axis]) + f64::from(direction[axis]) * f64::from(t);
                let at = (along(0).powi(2) + along(1).powi(2) + along(2).powi(2)).sqrt();
                assert!(
                    (at - 1.0).abs() < 2048.0 / f64::from(1 << 24),
                    "{at} from the centre after {t}, slope {slope}"
                );
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
            let (point, normal) = surface_at(from, -outward, t, &ball);
            assert!(intersect(leave(point, normal, &ball), outward, &ball) <= 0.0, "{i}");
            i += 1;
        }
    }
}
