//! What lies in the tree.
//!
//! The tree is a list of quads of 16 bytes in preorder. A photon is one quad, a [`Site`]; an inner node is two: the lowest corner of
//! its box and its link, then the highest corner and its plane. The left child follows at once. n photons take 3n − 2 quads, which
//! is 48 bytes a photon. The thesis's node also stores the photon's power; ours is found by its index.

use crate::exec::{Input, Store};
use crate::layout::Site;

/// Bits of a link that are the place of the right child.
pub const KD_PLACE_BITS: u32 = 29;
/// Bits of a link that are the axis, after the place.
pub const KD_AXIS_BITS: u32 = 2;
/// Bit of a reference that says that it is to a photon; the bit of a link that says so of the right child.
pub const KD_LEAF: u32 = 1 << 31;
const _: () = assert!(KD_PLACE_BITS + KD_AXIS_BITS < 32);
/// Bits of a reference that are a place.
pub(super) const PLACE: u32 = (1 << KD_PLACE_BITS) - 1;

/// Quads of a tree of so many photons.
#[inline]
#[must_use]
pub fn kd_quads(photons: u32) -> u32 {
    if photons == 0 { 0 } else { 3 * photons - 2 }
}

/// Reference to the root of a tree.
#[inline]
pub(super) fn root(photons: u32) -> u32 {
    if photons == 1 { KD_LEAF } else { 0 }
}

/// An inner node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KdInner {
    /// Lowest corner of the box of its photons, m, each coordinate as [`coordinate`](super::coordinate) has it.
    pub low: [f32; 3],
    /// Highest corner, m.
    pub high: [f32; 3],
    /// Where it is split, m: what is left has no larger coordinate, what is right no smaller one.
    pub plane: f32,
    /// Along which axis.
    pub axis: u32,
    /// Reference to the left child.
    pub left: u32,
    /// Reference to the right child.
    pub right: u32,
}

impl KdInner {
    /// The one at a place.
    #[inline]
    #[must_use]
    pub fn read(tree: &Input<Site>, place: u32) -> Self {
        let first = tree[place as usize];
        let second = tree[(place + 1) as usize];
        let link = first.photon();
        let right = link & PLACE;
        Self {
            low: first.position(),
            high: second.position(),
            plane: f32::from_bits(second.photon()),
            axis: (link >> KD_PLACE_BITS) & ((1 << KD_AXIS_BITS) - 1),
            // A photon takes one quad, whatever is larger four at least.
            left: (place + 2) | if right == place + 3 { KD_LEAF } else { 0 },
            right: right | (link & KD_LEAF),
        }
    }
}

/// Where the right child of an inner node lies whose left child has `left` photons.
#[inline]
pub(super) fn right_place(place: u32, left: u32) -> u32 {
    place + 3 * left
}

/// Writes an inner node of `photons` photons, `left` of them in its left child.
#[inline]
pub(super) fn write_inner<T: Store<Site> + ?Sized>(
    tree: &mut T,
    place: u32,
    low: [f32; 3],
    high: [f32; 3],
    axis: u32,
    plane: f32,
    left: u32,
    photons: u32,
) {
    let leaf = if photons - left == 1 { KD_LEAF } else { 0 };
    let link = right_place(place, left) | (axis << KD_PLACE_BITS) | leaf;
    tree.set(place, Site::new(low, link));
    tree.set(place + 1, Site::new(high, plane.to_bits()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inner_node_reads_as_it_was_written() {
        let (low, high) = ([-1.0, 0.0, 2.0], [1.0, 0.5, 3.0]);
        for (axis, left, photons, children) in [
            (0, 1, 2, [3 | KD_LEAF, 4 | KD_LEAF]),
            (1, 1, 9, [3 | KD_LEAF, 4]),
            (2, 5, 9, [3, 16]),
            (2, 8, 9, [3, 25 | KD_LEAF]),
        ] {
            let mut tree = [Site::default(); 8];
            write_inner(tree.as_mut_slice(), 1, low, high, axis, 0.25, left, photons);
            let node = KdInner { low, high, plane: 0.25, axis, left: children[0], right: children[1] };
            assert_eq!(KdInner::read(&tree, 1), node);
            // The children's subtrees fill what is left of this one's.
            assert_eq!(node.right & PLACE, (node.left & PLACE) + kd_quads(left));
            assert_eq!((node.right & PLACE) + kd_quads(photons - left), 1 + kd_quads(photons));
        }
        assert_eq!([0, 1, 2, 33].map(kd_quads), [0, 1, 4, 97]);
    }
}
