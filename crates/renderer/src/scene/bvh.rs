//! The bounding volume hierarchy of a scene: boxes around what the kernels' intersection accepts, a tree over them from the crate
//! `obvhs`, and the tree's nodes in the order in which rays of each octant walk them.
//!
//! Nothing that a ray meets depends on the tree, only how long it takes to find it: every box holds every point that the
//! intersection of its primitive, with all its roundings, can take for a hit. So the boxes are made of the rounded records and
//! not of the scene, and are larger than the primitives by bounds of these roundings. Lengths are in m; u = 2⁻²⁴ is the
//! unit roundoff, and R the scene's reach, the largest coordinate of anything in it, where rays start included.

use caustic_kernels::trace::{
    BvhNode, INNER, LEAF_BITS, OCTANTS, PRIMITIVE_SPHERE, PRIMITIVE_TRIANGLE, Primitive, corners_of,
};
use glam::{DMat3, DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use std::time::Duration;

/// Lower and upper corner.
type Bounds = ([f32; 3], [f32; 3]);

/// Most primitives of a scene that is one leaf: on a CPU a tree is faster from about 24 on.
pub(crate) const FEW: usize = 16;
/// Bounds of nothing.
const NOTHING: Bounds = ([f32::MAX; 3], [f32::MIN; 3]);
/// The unit roundoff of f32.
const U: f64 = 1.0 / (1 << 24) as f64;
/// Room for the roundings of the kernel's slab test, (corner − origin)·(1/d): of the difference, of a quotient within 2.5 ulp and
/// of the product, 7 u of at most 2 R together, and for directions that it takes for steeper than they are.
const SLABS: f64 = 32.0 * U;

/// Most bytes of nodes, while there is more than one list.
const LISTS_BYTES: usize = 64 << 20;

/// The nodes of a scene.
pub(super) struct Lists {
    /// Lists of equal length, one after another.
    pub nodes: Vec<BvhNode>,
    /// How many: one for each octant of directions, or fewer for a large scene.
    pub lists: u32,
}

/// The nodes of a scene. Octants that share a list walk it in the order of the one that has the list's number: some find the farther
/// child first, and what is near a little later.
///
/// Up to [`FEW`] primitives are one leaf, unless a tree is `wanted`.
pub(super) fn nodes(primitives: &[Primitive], reach: f64, wanted: bool) -> Lists {
    let boxes: Vec<Bounds> = primitives.iter().map(|primitive| bounds(primitive, reach)).collect();
    let tree = Tree::new(&boxes, if wanted { 1 } else { FEW });
    let mut lists = OCTANTS;
    while lists > 1 && lists as usize * tree.0.len() * size_of::<BvhNode>() > LISTS_BYTES {
        lists /= 2;
    }
    Lists { nodes: (0..lists).flat_map(|octant| tree.flattened(octant)).collect(), lists }
}

/// A box around all points that the kernels take for points of a primitive.
fn bounds(primitive: &Primitive, reach: f64) -> Bounds {
    if primitive.kind == PRIMITIVE_TRIANGLE {
        let [a, b, c] = corners_of(primitive).map(glam::Vec3::as_dvec3);
        // A ray that is taken to meet the triangle passes it within 17 u R, from the roundings of the corners in its frame; where it is in
        // the box is known to 70 u R (`trace::triangle`).
        return outwards(a.min(b).min(c), a.max(b).max(c), reach * (96.0 * U + SLABS));
    }
    let centre = vector(primitive.position);
    let half = if primitive.kind == PRIMITIVE_SPHERE {
        let radius = f64::from(primitive.size);
        // The hits of `intersect` are at most R·84 u farther from the centre than the radius, from its two roots' distance to the
        // true ones; where both roots are small beside the radius, 2⁻¹⁴ of it.
        DVec3::splat(radius * (1.0 + 2048.0 * U) + reach * (128.0 * U + SLABS))
    } else {
        quad(primitive, centre, reach)
    };
    outwards(centre - half, centre + half, 0.0)
}

/// A box and `margin` around it, rounded outwards.
fn outwards(low: DVec3, high: DVec3, margin: f64) -> Bounds {
    let low = (low - margin).to_array().map(|x| (x as f32).next_down());
    (low, (high + margin).to_array().map(|x| (x as f32).next_up()))
}

/// Half the sides of a quad's box, or that of the quad around a disc.
///
/// A hit is a point p of which `intersect` found |a·p| ≤ ½ + size for each of the duals a, and which lies in the plane but for the
/// rounding of t. With the normal as third row the duals are a matrix, and its inverse takes these three bounds to bounds of the
/// coordinates.
fn quad(primitive: &Primitive, centre: DVec3, reach: f64) -> DVec3 {
    let duals = primitive.sides.map(vector);
    let edges = DMat3::from_cols(duals[0], duals[1], vector(primitive.normal)).transpose().inverse();
    let edge = (0.5 + f64::from(primitive.size)) * (1.0 + 4.0 * U);
    // Three roundings of a product a·p, each of at most |a|·|p|; quads of almost parallel edges, of which the quotient is large, have
    // duals so long that this is a part of p itself. Scenes are checked to keep it below a half.
    let amplified = 3.1 * U * (duals[0].length() * edges.x_axis.length() + duals[1].length() * edges.y_axis.length());
    let within = |reach: f64, products: [f64; 2]| {
        // t is wrong by 38 u R across the plane, and each coordinate of p = o + t·d − centre by 6 u R.
        let across = 64.0 * U * reach;
        let along = |i: usize| edge + products[i] + duals[i].abs().element_sum() * 8.0 * U * reach;
        [along(0), along(1), across]
    };
    let sides = |[along_u, along_v, across]: [f64; 3]| {
        edges.x_axis.abs() * along_u + edges.y_axis.abs() * along_v + edges.z_axis.abs() * across
    };
    let length = sides(within(reach, [0.0; 2])).length() / (1.0 - amplified.min(0.5));
    let reach = reach.max(centre.abs().max_element() + length);
    sides(within(reach, duals.map(|dual| 3.1 * U * dual.length() * length))) + SLABS * reach
}

fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

fn around(a: Bounds, b: Bounds) -> Bounds {
    (std::array::from_fn(|axis| a.0[axis].min(b.0[axis])), std::array::from_fn(|axis| a.1[axis].max(b.1[axis])))
}

fn leaf(first: u32, count: u32) -> u32 {
    count << LEAF_BITS | first
}

/// A node of the tree before it is flattened.
struct Node {
    bounds: Bounds,
    /// Both children, or none.
    children: Option<[usize; 2]>,
    /// [`BvhNode::leaf`].
    leaf: u32,
    /// Nodes of this subtree.
    size: u32,
}

/// Nodes, parents before children.
struct Tree(Vec<Node>);

impl Tree {
    fn new(boxes: &[Bounds], few: usize) -> Self {
        if boxes.len() <= few {
            let bounds = boxes.iter().fold(NOTHING, |all, one| around(all, *one));
            return Self(vec![Node { bounds, children: None, leaf: leaf(0, boxes.len() as u32), size: 1 }]);
        }
        let aabbs: Vec<Aabb> =
            boxes.iter().map(|&(low, high)| Aabb::new(Vec3A::from_array(low), Vec3A::from_array(high))).collect();
        // A primitive costs several times what a box costs, so that leaves of one are best.
        let params = BvhBuildParams { pre_split: false, max_prims_per_leaf: 1, ..BvhBuildParams::slow_build() };
        let bvh = build_bvh2(&aabbs, params, &mut Duration::default());
        let mut nodes: Vec<Node> = Vec::with_capacity(bvh.nodes.len());
        // The nodes of `bvh` that are still to be taken, with the place among their parent's children.
        let mut left = vec![(0, None)];
        while let Some((index, parent)) = left.pop() {
            let from = &bvh.nodes[index];
            let at = nodes.len();
            if let Some((parent, side)) = parent {
                let parent: &mut Node = &mut nodes[parent];
                parent.children.get_or_insert([0; 2])[side] = at;
            }
            let first = from.first_index as usize;
            if from.is_leaf() {
                let primitive = bvh.primitive_indices[first];
                let bounds = boxes[primitive as usize];
                nodes.push(Node { bounds, children: None, leaf: leaf(primitive, 1), size: 1 });
            } else {
                nodes.push(Node { bounds: NOTHING, children: None, leaf: INNER, size: 1 });
                left.extend([(first + 1, Some((at, 1))), (first, Some((at, 0)))]);
            }
        }
        // Children stand behind their parents.
        for at in (0..nodes.len()).rev() {
            for child in nodes[at].children.into_iter().flatten() {
                nodes[at].size += nodes[child].size;
                nodes[at].bounds = around(nodes[at].bounds, nodes[child].bounds);
            }
        }
        Self(nodes)
    }

    /// The list of one octant: depth first, the nearer child first.
    fn flattened(&self, octant: u32) -> Vec<BvhNode> {
        let count = self.0.len() as u32;
        let mut list = Vec::with_capacity(self.0.len());
        let mut left = vec![0];
        while let Some(index) = left.pop() {
            let node = &self.0[index];
            let (low, high) = node.bounds;
            let backwards = |axis: usize| octant >> axis & 1 != 0;
            let pick = |if_forwards: [f32; 3], if_backwards: [f32; 3]| {
                std::array::from_fn(|axis| if backwards(axis) { if_backwards[axis] } else { if_forwards[axis] })
            };
            let skip = octant * count + list.len() as u32 + node.size;
            list.push(BvhNode { near: pick(low, high), skip, far: pick(high, low), leaf: node.leaf });
            if let Some([a, b]) = node.children {
                // How far along the octant's diagonal the middle of a child lies.
                let depth = |child: usize| -> f64 {
                    let (low, high) = self.0[child].bounds;
                    let along = |axis: usize| f64::from(low[axis]) + f64::from(high[axis]);
                    (0..3).map(|axis| if backwards(axis) { -along(axis) } else { along(axis) }).sum()
                };
                left.extend(if depth(a) <= depth(b) { [b, a] } else { [a, b] });
            }
        }
        list
    }
}
