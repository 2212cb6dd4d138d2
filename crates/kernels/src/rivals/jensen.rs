//! Jensen's kd-tree (thesis, sections 2.1.2 and 4.3): "Realistic Image Synthesis Using Photon Mapping", 2001, chapter 6 and appendix B.
//!
//! A left-balanced tree lies in an array without pointers: the root at 1, the children of node `i` at `2i` and `2i + 1`, and all levels full but the
//! last, which is full from the left. A node is a [`Site`]: the photon's position and, in its fourth word, the photon's index above two bits for the axis
//! across which its subtrees lie ([`jensen_word`]). Such words are in the order of the indices, so that containers that compare them break
//! ties as they should.
//!
//! The tree is built on the host, whatever device searches it, as the software kd-tree of section 4.3 is.

use super::SearchParams;
use crate::exec::{Input, Store};
use crate::gather::{CUT_SHORT, Candidates, Selection, distance2};
use crate::layout::{Neighbour, Query, Site};

/// The fourth word of a node: index of its photon, below 2³⁰, and its axis.
#[inline]
#[must_use]
pub fn jensen_word(photon: u32, axis: u32) -> u32 {
    photon << 2 | axis
}

/// Writes the k nearest neighbours of query `q`, nearest first, to `neighbours[q·k ..]`, and how many there are, or [`CUT_SHORT`], to
/// `counts[q]`. `nodes` begins with a node that is none.
#[inline]
pub fn jensen_neighbours<
    S: Selection + Candidates<(), (), ()>,
    N: Store<Neighbour> + ?Sized,
    C: Store<u32> + ?Sized,
>(
    q: u32,
    mut selection: S,
    params: &SearchParams,
    queries: &Input<Query>,
    nodes: &Input<Site>,
    neighbours: &mut N,
    counts: &mut C,
) {
    if q >= params.queries {
        return;
    }
    let query = queries[q as usize];
    selection.reset(params.k, params.radius2);
    let mut whole = true;
    if query.active != 0 {
        whole = locate(query.position, params.photons, nodes, &mut selection);
        selection.sort(nodes);
    }
    let mut n = 0;
    while n < selection.count() {
        let photon = nodes[selection.slot(n) as usize].photon() >> 2;
        neighbours.set(q * params.k + n, Neighbour { distance2: selection.distance2(n), photon });
        n += 1;
    }
    // Loops that were ended early took this one with them.
    counts.set(q, if whole && n >= selection.count() { n } else { CUT_SHORT });
}

/// Jensen's `locate_photons`: for each node first the subtree on the query's side of its plane, then its photon, then the other subtree if the plane is
/// no farther than the bound. In place of a stack it has the way back in the number of the node and a bit a level, set where the node
/// above still waits for its photon and its other subtree.
///
/// No photon beyond a plane is nearer than the plane, as rounded: subtraction, product and sums of what is not negative are monotonic
/// however they round, and [`distance2`], which takes small sums for 0, measures both. At the bound itself a lower index can still decide, and
/// the subtree is not left out.
///
/// Returns whether the walk came to its end.
#[inline]
fn locate<S: Selection + Candidates<(), (), ()>>(
    position: [f32; 3],
    photons: u32,
    nodes: &Input<Site>,
    selection: &mut S,
) -> bool {
    let mut node = 1;
    let mut waiting = 0u32;
    let mut descends = true;
    let mut walks = photons > 0;
    while walks {
        let site = nodes[node as usize];
        let axis = site.photon() & 3;
        let at = site.position();
        let x = along(position, axis);
        let plane = along(at, axis);
        let near = 2 * node + if x > plane { 1 } else { 0 };
        if descends && near <= photons {
            node = near;
            waiting = waiting << 1 | 1;
        } else {
            let d2 = distance2(position, at);
            if d2 <= selection.bound() {
                selection.offer(&mut (), &mut (), d2, node, nodes, &());
            }
            let far = near ^ 1;
            descends = far <= photons && distance2([x, 0.0, 0.0], [plane, 0.0, 0.0]) <= selection.bound();
            if descends {
                node = far;
                waiting <<= 1;
            } else if waiting == 0 {
                walks = false;
            } else {
                let up = waiting.trailing_zeros() + 1;
                node >>= up;
                waiting >>= up;
            }
        }
    }
    !walks
}

/// A coordinate, chosen without an array that would have to lie in memory.
#[inline]
fn along(position: [f32; 3], axis: u32) -> f32 {
    if axis == 0 {
        position[0]
    } else if axis == 1 {
        position[1]
    } else {
        position[2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gather::Heap;
    use std::vec;
    use std::vec::Vec;

    /// A tree of photons at 0, 1, …, n − 1 along `axis`, each coordinate `same` times. Visited from left to right a tree has its photons in order.
    fn tree(n: u32, axis: u32, same: u32) -> Vec<Site> {
        fn fill(node: u32, axis: u32, same: u32, next: &mut u32, nodes: &mut [Site]) {
            if (node as usize) < nodes.len() {
                fill(2 * node, axis, same, next, nodes);
                let mut position = [0.5; 3];
                position[axis as usize] = (*next / same) as f32;
                // Indices against the order of the coordinates.
                nodes[node as usize] = Site::new(position, jensen_word(1000 - *next, axis));
                *next += 1;
                fill(2 * node + 1, axis, same, next, nodes);
            }
        }
        let mut nodes = vec![Site::default(); n as usize + 1];
        fill(1, axis, same, &mut 0, &mut nodes);
        nodes
    }

    /// Squares of whole numbers, from every place on the line and beside it, with ties: two neighbours or `same` of them are as far.
    #[test]
    fn the_nearest_on_a_line_are_found_with_ties_by_index() {
        for axis in 0..3 {
            for (n, same) in [(0, 1), (1, 1), (2, 1), (3, 1), (6, 1), (31, 1), (100, 1), (100, 7), (64, 64)] {
                let nodes = tree(n, axis, same);
                for (k, radius2) in [(1, 1e9), (5, 1e9), (16, 1e9), (16, 9.0)] {
                    let queries: Vec<Query> = (0..80)
                        .map(|i| {
                            let mut position = [0.5; 3];
                            position[axis as usize] = i as f32 * 0.5 - 4.0;
                            Query { position, active: u32::from(i != 3) }
                        })
                        .collect();
                    let params = SearchParams { queries: 80, k, photons: n, radius2 };
                    let mut neighbours = vec![Neighbour::default(); 80 * k as usize];
                    let mut counts = vec![99; 80];
                    // An invocation too many, which must do nothing.
                    for q in 0..=80 {
                        let (neighbours, counts) = (neighbours.as_mut_slice(), counts.as_mut_slice());
                        jensen_neighbours(q, Heap::<17>::new(), &params, &queries, &nodes, neighbours, counts);
                    }
                    for (q, query) in queries.iter().enumerate() {
                        let mut expected: Vec<(u32, u32)> = (0..n)
                            .map(|i| {
                                let d = query.position[axis as usize] - (i / same) as f32;
                                ((d * d).to_bits(), 1000 - i)
                            })
                            .filter(|&(bits, _)| query.active != 0 && f32::from_bits(bits) <= radius2)
                            .collect();
                        expected.sort_unstable();
                        expected.truncate(k as usize);
                        let found: Vec<_> = neighbours[q * k as usize..][..counts[q] as usize]
                            .iter()
                            .map(|neighbour| (neighbour.distance2.to_bits(), neighbour.photon))
                            .collect();
                        assert_eq!(found, expected, "{n} photons, axis {axis}, k = {k}, query {q}");
                    }
                }
            }
        }
    }

    /// Planes nearer than distances can be told from none: a subtree behind one is not left out.
    #[test]
    fn a_tiny_distance_to_a_plane_counts_as_none() {
        let at = |x: f32, photon: u32| Site::new([x, 0.0, 0.0], jensen_word(photon, 0));
        // All three count as where the query is. The nearest are met first; that beyond the plane has the lowest index.
        let nodes = [Site::default(), at(4e-12, 2), at(0.0, 1), at(8e-12, 3)];
        let queries = [Query { position: [6e-12, 0.0, 0.0], active: 1 }];
        let params = SearchParams { queries: 1, k: 1, photons: 3, radius2: 1.0 };
        let (mut neighbours, mut counts) = (vec![Neighbour::default()], vec![0]);
        let (to, count) = (neighbours.as_mut_slice(), counts.as_mut_slice());
        jensen_neighbours(0, Heap::<17>::new(), &params, &queries, &nodes, to, count);
        assert_eq!((neighbours[0], counts[0]), (Neighbour { distance2: 0.0, photon: 1 }, 1));
    }
}
