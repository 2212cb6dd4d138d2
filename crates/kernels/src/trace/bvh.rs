//! The bounding volume hierarchy that finds the few primitives a ray can meet.
//!
//! The tree lies in the buffer eight times, once for each octant of directions, depth first and nearer child first. A ray walks
//! one of these lists from front to back and skips what its slabs miss: there is no stack, the index only grows, and the nearer
//! of two children still comes first (Smits, "Efficiency Issues for Ray Tracing", JGT 1998, for skipping). A large scene has fewer
//! lists, 4, 2 or 1, which kernels that know [`MESHES`](super::known::MESHES) can walk: an octant then shares the list of another one.

use super::known::Known;
use crate::num::{abs, fsign, max, min};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// [`BvhNode::leaf`] of a node that has children.
pub const INNER: u32 = 0;
/// Bits of [`BvhNode::leaf`] that are the index of its first primitive; above them stands their number.
pub const LEAF_BITS: u32 = 24;
/// Lists of nodes: one for each octant of directions.
pub const OCTANTS: u32 = 8;
/// Directions are taken for steeper than this along each axis, 2⁻⁴⁰, so that every reciprocal is finite. A ray is off by less than
/// 2⁻³⁸ of the scene for it, and boxes have room for 2⁻¹⁹.
const STEEPEST: f32 = 9.094_947e-13;

/// A node: a box, and some primitives or the subtree that follows. Nodes are numbered through all octants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct BvhNode {
    /// The corner of the box that rays of this octant come to first, m.
    pub near: [f32; 3],
    /// The node after this one's subtree.
    pub skip: u32,
    /// The opposite corner, m.
    pub far: [f32; 3],
    /// First primitive and number of primitives, which follow each other, or [`INNER`].
    pub leaf: u32,
}
const _: () = assert!(size_of::<BvhNode>() == 32);

/// A ray as boxes see it.
#[derive(Clone, Copy)]
pub struct Slabs {
    origin: Vec3,
    inverse: Vec3,
}

impl Slabs {
    /// Of a ray.
    #[inline]
    #[must_use]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        let inverse = Vec3::new(inverse(direction.x), inverse(direction.y), inverse(direction.z));
        Self { origin, inverse }
    }

    /// Whether the ray can meet something in the box, t from 0 to `farthest`.
    ///
    /// The distances to the slabs are wrong by the roundings of a difference, a quotient and a product (Ize, "Robust BVH Ray
    /// Traversal", JCGT 2013): less than 2⁻²⁰ of the scene, for which the host made the boxes larger. So no box is missed of
    /// which a primitive would be hit.
    #[inline]
    #[must_use]
    pub fn meet(self, known: impl Known, node: &BvhNode, farthest: f32) -> bool {
        let mut near = (Vec3::from_array(node.near) - self.origin) * self.inverse;
        let mut far = (Vec3::from_array(node.far) - self.origin) * self.inverse;
        if known.meshes() {
            // The list may be another octant's.
            let swapped = near;
            near = Vec3::new(min(near.x, far.x), min(near.y, far.y), min(near.z, far.z));
            far = Vec3::new(max(swapped.x, far.x), max(swapped.y, far.y), max(swapped.z, far.z));
        }
        // A NaN, which only an origin or a direction that is none can give, is passed over here: the primitives decide.
        max(near.x, max(near.y, max(near.z, 0.0))) <= min(far.x, min(far.y, min(far.z, farthest)))
    }
}

/// The one quotient that is a device's own, within 2.5 ulp of the right one: boxes have room for it, and nothing that a ray meets
/// depends on it.
#[inline]
fn inverse(direction: f32) -> f32 {
    1.0 / if abs(direction) > STEEPEST { direction } else { fsign(direction) * STEEPEST }
}

/// The list of nodes for rays of a direction.
#[inline]
#[must_use]
pub fn list_of(known: impl Known, direction: Vec3, lists: u32) -> u32 {
    if known.meshes() { octant(direction) & lists.wrapping_sub(1) } else { octant(direction) }
}

/// The octant of a direction: a bit for each axis along which it is negative.
#[inline]
#[must_use]
pub fn octant(direction: Vec3) -> u32 {
    (direction.x.to_bits() >> 31) | (direction.y.to_bits() >> 31 << 1) | (direction.z.to_bits() >> 31 << 2)
}
