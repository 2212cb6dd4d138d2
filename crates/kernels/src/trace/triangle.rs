//! Rays against triangles, without cracks (Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2013).
//!
//! Corners are moved into a frame in which the ray is an axis, one frame for all triangles. There three edge functions say on
//! which side of each edge the ray passes. A product's rounding is monotonic, so that the difference of two products has the right
//! sign or is 0, and two triangles see the edge that they share with opposite signs: no ray passes between them, however
//! small they are in their scene.

use super::vector::cross;
use crate::num::{abs, div, max, min};
use glam::Vec3;

/// Directions along which a triangle's box is not asked where the ray is in it.
const ALONG: f32 = 1e-12;
/// 2⁻¹⁹: where the ray is in the box of three corners is known to this part of the largest coordinate, with room to spare.
const SLACK: f32 = 1.907_348_6e-6;

/// A ray's direction as triangles see it.
#[derive(Clone, Copy, Default)]
pub struct Shear {
    /// The axis along which the direction is longest.
    axis: u32,
    /// The direction along the other two, in lengths of that along the first.
    x: f32,
    y: f32,
    /// The reciprocal of the direction along the first.
    z: f32,
}

impl Shear {
    /// Of a unit direction.
    #[inline]
    #[must_use]
    pub fn new(direction: Vec3) -> Self {
        let (x, y, z) = (abs(direction.x), abs(direction.y), abs(direction.z));
        let mut axis = 2;
        if x > y && x > z {
            axis = 0;
        } else if y > z {
            axis = 1;
        }
        let turned = turned(direction, axis);
        let z = div(1.0, turned.z);
        Self { axis, x: turned.x * z, y: turned.y * z, z }
    }

    /// A corner in the ray's frame, in which the ray comes along the third axis.
    #[inline]
    fn apply(self, corner: Vec3) -> Vec3 {
        let p = turned(corner, self.axis);
        Vec3::new(p.x - self.x * p.z, p.y - self.y * p.z, self.z * p.z)
    }
}

/// `v` with axis `axis` as the third.
#[inline]
fn turned(v: Vec3, axis: u32) -> Vec3 {
    let mut turned = v;
    if axis == 0 {
        turned = Vec3::new(v.y, v.z, v.x);
    } else if axis == 1 {
        turned = Vec3::new(v.z, v.x, v.y);
    }
    turned
}

/// Where the ray meets the triangle of these corners, in lengths of its direction: below 0 if that is behind its start, 0 if it does not.
/// Both sides are met, and edges belong to the triangle.
#[inline]
#[must_use]
pub fn meet_triangle(origin: Vec3, direction: Vec3, shear: Shear, corners: [Vec3; 3]) -> f32 {
    let [a, b, c] = [corners[0] - origin, corners[1] - origin, corners[2] - origin];
    let [p, q, r] = [shear.apply(a), shear.apply(b), shear.apply(c)];
    let u = r.x * q.y - r.y * q.x;
    let v = p.x * r.y - p.y * r.x;
    let w = q.x * p.y - q.y * p.x;
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    let all = u + v + w;
    if !inside || all == 0.0 {
        return 0.0;
    }
    // A mean of the corners' distances, so never outside of theirs; but anywhere between them when the ray almost lies in the plane
    // and the weights are all rounding. What is met must be in the tree's boxes, so it is drawn to where the ray is in the box of the
    // corners.
    let t = div(u * p.z + v * q.z + w * r.z, all);
    let reach = max(largest(a), max(largest(b), max(largest(c), largest(origin)))) * SLACK;
    let low = lower(a, lower(b, c));
    let high = -lower(-a, lower(-b, -c));
    let mut from = -f32::MAX;
    let mut to = f32::MAX;
    let mut axis = 0;
    while axis < 3 {
        let d = turned(direction, axis).z;
        if abs(d) > ALONG {
            let inverse = div(1.0, d);
            let one = (turned(low, axis).z - reach) * inverse;
            let other = (turned(high, axis).z + reach) * inverse;
            from = max(from, min(one, other));
            to = min(to, max(one, other));
        }
        axis += 1;
    }
    if from <= to { max(from, min(t, to)) } else { t }
}

/// The part of each corner in a point of the triangle's plane: barycentric coordinates, none of them below 0.
#[inline]
#[must_use]
pub fn shares(corners: [Vec3; 3], point: Vec3) -> [f32; 3] {
    let [a, b, c] = corners;
    let normal = cross(b - a, c - a);
    let area = super::vector::dot(normal, normal);
    let to = point - a;
    let v = div(super::vector::dot(cross(to, c - a), normal), area);
    let w = div(super::vector::dot(cross(b - a, to), normal), area);
    let v = max(0.0, min(v, 1.0));
    let w = max(0.0, min(w, 1.0 - v));
    [1.0 - v - w, v, w]
}

/// The larger of the absolute values of the coordinates.
#[inline]
fn largest(v: Vec3) -> f32 {
    max(abs(v.x), max(abs(v.y), abs(v.z)))
}

/// The smaller of each coordinate.
#[inline]
fn lower(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(min(a.x, b.x), min(a.y, b.y), min(a.z, b.z))
}

#[cfg(test)]
mod tests;
