//! Rays against primitives.

use super::bvh::{BvhNode, INNER, LEAF_BITS, Slabs, list_of};
use super::known::{ALL, Known};
use super::scene::{Material, PRIMITIVE_DISC, PRIMITIVE_QUAD, PRIMITIVE_TRIANGLE, Primitive, SceneInfo};
use super::surface::{Corners, is_hole};
use super::texture::{Texel, Texture};
use super::triangle::{Shear, meet_triangle};
use super::vector::dot;
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
/// tree, there is one answer. The direction has unit length. Where a primitive has a hole it is not met.
///
/// One loop looks for the next primitive and another meets it, so that the lanes of a subgroup meet theirs together (Aila and
/// Laine, "Understanding the Efficiency of Ray Traversal on GPUs", HPG 2009).
#[inline]
#[must_use]
pub fn closest_hit(
    known: impl Known,
    origin: Vec3,
    direction: Vec3,
    info: &SceneInfo,
    nodes: &Input<BvhNode>,
    primitives: &Input<Primitive>,
    materials: &Input<Material>,
    corners: &Input<Corners>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> Hit {
    let slabs = Slabs::new(origin, direction);
    let shear = shear_of(known, direction);
    let mut best = Hit { t: f32::MAX, primitive: MISS };
    let mut lost = false;
    let mut at = list_of(known, direction, info.lists) * info.nodes;
    let end = at + info.nodes;
    while at < end {
        let mut leaf = INNER;
        while at < end && leaf == INNER {
            let node = nodes[at as usize];
            let met = slabs.meet(known, &node, best.t);
            leaf = if met { node.leaf } else { INNER };
            at = if met { at + 1 } else { node.skip };
        }
        let mut i = leaf & FIRST;
        let last = i + (leaf >> LEAF_BITS);
        while i < last {
            let t = meet(known, origin, direction, shear, &primitives[i as usize]);
            if t > 0.0 && (t < best.t || (t == best.t && i < best.primitive)) {
                let hit = Hit { t, primitive: i };
                let hole = known.textures()
                    && info.holes != 0
                    && is_hole(origin, direction, hit, info, primitives, materials, corners, textures, texels);
                if !hole {
                    best = hit;
                }
            }
            i += 1;
        }
        lost |= i != last;
    }
    // Not what the loop ended with: a compiler would take that for known, and a device that ended it early would not be noticed.
    if lost || at != end {
        best.primitive = LOST;
    }
    best
}

/// Whether something stands between `origin` and `origin + distance·direction`, other than primitive `except`: [`BLOCKED`],
/// [`MISS`] or [`LOST`].
#[inline]
#[must_use]
pub fn occluded(
    known: impl Known,
    origin: Vec3,
    direction: Vec3,
    distance: f32,
    except: u32,
    info: &SceneInfo,
    nodes: &Input<BvhNode>,
    primitives: &Input<Primitive>,
    materials: &Input<Material>,
    corners: &Input<Corners>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> u32 {
    let slabs = Slabs::new(origin, direction);
    let shear = shear_of(known, direction);
    let mut found = MISS;
    let mut lost = false;
    let mut at = list_of(known, direction, info.lists) * info.nodes;
    let end = at + info.nodes;
    while at < end && found == MISS {
        let mut leaf = INNER;
        while at < end && leaf == INNER {
            let node = nodes[at as usize];
            let met = slabs.meet(known, &node, distance);
            leaf = if met { node.leaf } else { INNER };
            at = if met { at + 1 } else { node.skip };
        }
        let mut i = leaf & FIRST;
        let last = i + (leaf >> LEAF_BITS);
        while i < last && found == MISS {
            if i != except {
                let t = meet(known, origin, direction, shear, &primitives[i as usize]);
                if t > 0.0 && t < distance {
                    let hit = Hit { t, primitive: i };
                    let hole = known.textures()
                        && info.holes != 0
                        && is_hole(origin, direction, hit, info, primitives, materials, corners, textures, texels);
                    if !hole {
                        found = BLOCKED;
                    }
                }
            }
            i += 1;
        }
        lost |= i != last;
    }
    if found == MISS && (lost || at != end) { LOST } else { found }
}

/// The smallest positive t at which the ray meets a primitive of any kind, or what is not positive.
#[inline]
#[must_use]
pub fn intersect(origin: Vec3, direction: Vec3, primitive: &Primitive) -> f32 {
    meet(ALL, origin, direction, Shear::new(direction), primitive)
}

#[inline]
fn shear_of(known: impl Known, direction: Vec3) -> Shear {
    if known.meshes() { Shear::new(direction) } else { Shear::default() }
}

/// [`intersect`] of a ray whose shear is known.
#[inline]
fn meet(known: impl Known, origin: Vec3, direction: Vec3, shear: Shear, primitive: &Primitive) -> f32 {
    let position = Vec3::from_array(primitive.position);
    if known.meshes() && primitive.kind == PRIMITIVE_TRIANGLE {
        return meet_triangle(origin, direction, shear, corners_of(primitive));
    }
    if primitive.kind == PRIMITIVE_QUAD || (known.meshes() && primitive.kind == PRIMITIVE_DISC) {
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
        let u = abs(dot(local, Vec3::from_array(primitive.sides[0])));
        let v = abs(dot(local, Vec3::from_array(primitive.sides[1])));
        let edge = 0.5 + primitive.size;
        if known.meshes() && primitive.kind == PRIMITIVE_DISC && u * u + v * v > edge * edge {
            return 0.0;
        }
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

/// The corners of a triangle, m.
#[inline]
#[must_use]
pub fn corners_of(triangle: &Primitive) -> [Vec3; 3] {
    [Vec3::from_array(triangle.position), Vec3::from_array(triangle.sides[0]), Vec3::from_array(triangle.sides[1])]
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
#[path = "intersect/tests.rs"]
mod tests;
