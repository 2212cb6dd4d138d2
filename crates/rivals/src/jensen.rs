//! Jensen's kd-tree (thesis, sections 2.1.2 and 4.3), built on the host.

use crate::{PhotonIndex, Photons};
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::layout::{Photon, Site};
use caustic_kernels::rivals::{SearchParams, jensen_word};
use caustic_photon_map::{MapError, Neighbours, RADII, capacity};
use rayon::prelude::*;

/// Most photons of a tree: their indices have 30 bits.
const MAX_PHOTONS: u32 = 1 << 30;
/// Subtrees that a thread takes at least: those of the deepest levels are too small to be handed around singly.
const SUBTREES: usize = 256;

/// A left-balanced kd-tree. Photons are read from the device, and the tree is built by the CPU's threads and uploaded, whatever the
/// device: its search is a kernel like any other.
pub(crate) struct JensenTree {
    nodes: Buffer,
    count: u32,
    radius: f32,
}

impl JensenTree {
    pub(crate) fn build(device: &Device, photons: &Photons, radius: f32) -> Result<Self, MapError> {
        if !RADII.contains(&radius) {
            return Err(MapError::Radius { radius });
        }
        let count = photons.count;
        if count > MAX_PHOTONS {
            return Err(MapError::TooMany { what: "photons", count: u64::from(count), max: MAX_PHOTONS });
        }
        let given: Vec<Photon> = device.read(&photons.buffer, u64::from(count))?;
        let nodes = device.upload("kd-tree: nodes", &balanced(&given, photons.low, photons.high))?;
        Ok(Self { nodes, count, radius })
    }
}

impl PhotonIndex for JensenTree {
    fn search(&self, device: &Device, queries: &Buffer, count: u32, k: u32) -> Result<Neighbours, MapError> {
        let found = Neighbours::new(device, count, k)?;
        let kernel = match capacity(k)? {
            17 => Kernel::JensenNeighbours17,
            65 => Kernel::JensenNeighbours65,
            257 => Kernel::JensenNeighbours257,
            _ => Kernel::JensenNeighbours1025,
        };
        let params = SearchParams { queries: count, k, photons: self.count, radius2: self.radius * self.radius };
        let params = device.upload("kd-tree: params", &[params])?;
        let mut plan = Plan::new();
        plan.each(kernel, count, &[&params, queries, &self.nodes, &found.neighbours, &found.counts]);
        device.run(&plan)?;
        Ok(found)
    }

    fn bytes(&self) -> u64 {
        self.nodes.bytes()
    }
}

/// A photon that is not yet a node.
#[derive(Clone, Copy)]
struct Point {
    position: [f32; 3],
    photon: u32,
}

/// The photons of a subtree, and its box: that of all photons, cut at the planes above.
struct Subtree<'a> {
    points: &'a mut [Point],
    low: [f32; 3],
    high: [f32; 3],
}

/// The nodes, level by level, after one that is none. A level is a run of the array, and its subtrees are independent of each
/// other: threads share them out.
fn balanced(photons: &[Photon], low: [f32; 3], high: [f32; 3]) -> Vec<Site> {
    let mut points: Vec<Point> =
        (0..).zip(photons).map(|(photon, given)| Point { position: given.position, photon }).collect();
    let mut nodes = Vec::with_capacity(points.len() + 1);
    nodes.push(Site::default());
    let mut level = vec![Subtree { points: &mut points, low, high }];
    level.retain(|subtree| !subtree.points.is_empty());
    while !level.is_empty() {
        let split: Vec<_> = level.into_par_iter().with_min_len(SUBTREES).map(split).collect();
        nodes.extend(split.iter().map(|(node, _)| *node));
        level = split.into_iter().flat_map(|(_, below)| below).filter(|below| !below.points.is_empty()).collect();
    }
    nodes
}

/// The root of a subtree, and what lies below it: across the longest side of the box, at the photon that leaves both sides balanced. Photons on
/// the plane are on either side, ordered by index, so that there is one tree.
fn split(subtree: Subtree<'_>) -> (Site, [Subtree<'_>; 2]) {
    let Subtree { points, low, high } = subtree;
    let side = |axis: usize| f64::from(high[axis]) - f64::from(low[axis]);
    let longest = if side(1) >= side(2) { 1 } else { 2 };
    let axis = if side(0) >= side(longest) { 0 } else { longest };
    let order = |a: &Point, b: &Point| {
        (a.position[axis] + 0.0).total_cmp(&(b.position[axis] + 0.0)).then(a.photon.cmp(&b.photon))
    };
    let (left, median, right) = points.select_nth_unstable_by(left_size(points.len()), order);
    let node = Site::new(median.position, jensen_word(median.photon, axis as u32));
    let (mut middle_low, mut middle_high) = (low, high);
    middle_high[axis] = median.position[axis];
    middle_low[axis] = median.position[axis];
    (node, [Subtree { points: left, low, high: middle_high }, Subtree { points: right, low: middle_low, high }])
}

/// Nodes of the left subtree of a left-balanced tree of `n` nodes.
fn left_size(n: usize) -> usize {
    // Nodes of the full levels below the root, and of the last level, of which the left subtree has the first half.
    let levels = (n + 1).ilog2();
    let full = (1usize << levels) - 1;
    let last = n - full;
    full / 2 + last.min(1usize << (levels - 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustic_kernels::num::{pcg4d, u32_to_unit};

    /// Every subtree lies on its side of the planes above, and every photon is a node once.
    #[test]
    fn planes_part_what_is_below_them() {
        for n in [0, 1, 2, 3, 10, 1000] {
            let photons: Vec<Photon> = (0..n)
                .map(|i| {
                    let random = pcg4d([i, 3, 1, 4]);
                    // Many on one plane, and a box that is longest along z.
                    let position = [u32_to_unit(random[0]), (random[1] % 3) as f32, 4.0 * u32_to_unit(random[2])];
                    Photon { position, ..Photon::default() }
                })
                .collect();
            let nodes = balanced(&photons, [0.0; 3], [1.0, 2.0, 4.0]);
            assert_eq!(nodes.len(), n as usize + 1);
            let mut seen: Vec<u32> = nodes[1..].iter().map(|node| node.photon() >> 2).collect();
            seen.sort_unstable();
            assert!(seen.into_iter().eq(0..n));
            for (i, node) in nodes.iter().enumerate().skip(1) {
                let photon = photons[(node.photon() >> 2) as usize];
                assert_eq!(node.position(), photon.position);
                let mut below = i;
                while below > 1 {
                    let above = nodes[below / 2];
                    let axis = (above.photon() & 3) as usize;
                    let (x, plane) = (node.position()[axis], above.position()[axis]);
                    assert!(if below % 2 == 0 { x <= plane } else { x >= plane }, "node {i} of {n}");
                    below /= 2;
                }
            }
            if n > 0 {
                assert_eq!(nodes[1].photon() & 3, 2, "the longest side comes first");
            }
        }
    }

    #[test]
    fn left_subtrees_have_what_a_full_array_gives_them() {
        // Node i of n is below 2 if its path begins so.
        for n in 1..200 {
            let below_2 = |mut node: usize| {
                while node > 3 {
                    node /= 2;
                }
                node == 2
            };
            assert_eq!(left_size(n), (2..=n).filter(|&node| below_2(node)).count(), "{n}");
        }
    }
}
