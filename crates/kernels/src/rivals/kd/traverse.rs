//! The walk through the tree.

use super::KD_DEPTH;
use super::node::{KD_LEAF, KdInner, PLACE, root};
use crate::exec::{Input, Local, local};
use crate::gather::{Candidates, distance2};
use crate::layout::Site;

/// References to nodes that are still to be visited: the far child of each inner node above.
struct Stack {
    nodes: Local<u32, { KD_DEPTH as usize }>,
    len: u32,
}

/// Offers `candidates` every photon of the tree that is not beyond their bound: depth first, the child on the query's side of the
/// plane before the other. A slot is a photon's place in the tree, and the tree their `sites`.
///
/// A subtree is left out if the nearest point of its box is beyond the bound. That is never wrong, and takes no margin: rounding is
/// monotonic, so the rounded difference to a photon of the box is along each axis no smaller than that to the box, and so are its
/// square, the sums and what is taken for 0, since the distance to the box's point is computed as that to a photon is
/// ([`distance2`]).
///
/// Returns whether the walk came to its end. It always does, unless the device ends loops early, as llvmpipe does after
/// 65,535 iterations.
#[inline]
#[must_use]
pub(super) fn traverse<M: ?Sized, A: ?Sized, O: ?Sized, C: Candidates<M, A, O>>(
    position: [f32; 3],
    tree: &Input<Site>,
    photons: u32,
    arrivals: &A,
    memory: &mut M,
    output: &mut O,
    candidates: &mut C,
) -> bool {
    let mut stack = Stack { nodes: local![0; KD_DEPTH as usize], len: 0 };
    let mut at = root(photons);
    let mut walking = photons > 0;
    while walking {
        let mut descends = false;
        if at & KD_LEAF != 0 {
            let slot = at & PLACE;
            let d2 = distance2(position, tree[slot as usize].position());
            if d2 <= candidates.bound() {
                candidates.offer(memory, output, d2, slot, tree, arrivals);
            }
        } else {
            let node = KdInner::read(tree, at);
            let nearest = [
                clamp(position[0], node.low[0], node.high[0]),
                clamp(position[1], node.low[1], node.high[1]),
                clamp(position[2], node.low[2], node.high[2]),
            ];
            if distance2(position, nearest) <= candidates.bound() {
                let is_left = position[node.axis as usize] < node.plane;
                stack.nodes[stack.len as usize] = if is_left { node.right } else { node.left };
                stack.len += 1;
                at = if is_left { node.left } else { node.right };
                descends = true;
            }
        }
        if !descends {
            walking = stack.len > 0;
            if walking {
                stack.len -= 1;
                at = stack.nodes[stack.len as usize];
            }
        }
    }
    !walking
}

#[inline]
fn clamp(x: f32, low: f32, high: f32) -> f32 {
    if x < low {
        low
    } else if x > high {
        high
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::super::coordinate;
    use super::*;
    use crate::num::pcg4d;

    /// The point of a box that stands for it is no farther than any point in it, to the last bit, at all scales.
    #[test]
    fn a_box_is_no_farther_than_what_is_in_it() {
        let mut equal = 0;
        for i in 0..300_000u32 {
            // Coordinates of any exponent up to 2⁶⁰, or all of one scale, so that differences cancel; subnormals and zeros, too.
            let number = |n: u32| {
                let random = pcg4d([i, n, 1, 2]);
                let spread = [3, 40, 180][(i % 3) as usize];
                let exponent = 187 - (random[1] % spread) - if i % 7 == 0 { 110 } else { 0 };
                let exponent = if random[2].is_multiple_of(16) { 0 } else { exponent.min(250) };
                f32::from_bits((random[0] & 0x807f_ffff) | exponent << 23)
            };
            let triple = |n: u32| [number(n), number(n + 1), number(n + 2)];
            let (query, a, b) = (triple(0), triple(3), triple(6));
            let nearest = core::array::from_fn(|axis| {
                let (a, b) = (coordinate(a[axis]), coordinate(b[axis]));
                clamp(query[axis], a.min(b), a.max(b))
            });
            let bound = distance2(query, nearest);
            for photon in [a, b] {
                assert!(bound <= distance2(query, photon), "{query:?} {a:?} {b:?}");
                equal += u32::from(bound == distance2(query, photon));
            }
        }
        assert!(equal > 1000, "the bound is often reached: {equal}");
    }
}
