//! The tree gives what a loop over all primitives gives, to the bit, and takes fewer steps.

use caustic_kernels::num::{pcg4d, u32_to_unit};
use caustic_kernels::trace::vector::{cross, normalize};
use caustic_kernels::trace::{
    BLOCKED, BvhNode, Hit, INNER, LEAF_BITS, MISS, NO_LIGHT, OCTANTS, PRIMITIVE_QUAD, Primitive, Slabs, closest_hit,
    intersect, occluded, octant,
};
use caustic_renderer::scene::{CompiledScene, Scene};
use caustic_tests::renders::parse;
use glam::Vec3;
use std::fmt::Write;

/// Random numbers from 0 to 1 in their order.
struct Random([u32; 2]);

impl Random {
    fn next(&mut self) -> f32 {
        self.0[1] += 1;
        u32_to_unit(pcg4d([self.0[0], self.0[1], 0xb7, 0])[0])
    }

    fn below(&mut self, n: u32) -> u32 {
        ((self.next() * n as f32) as u32).min(n - 1)
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next()) * 2.0 - Vec3::ONE
    }

    fn direction(&mut self) -> Vec3 {
        normalize(self.vector() + Vec3::new(0.0, 0.0, 1e-6))
    }
}

/// Where the primitives of a soup are.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Kind {
    /// All over the place.
    Spread,
    /// On a few planes, parallel to the axes, over and over each other; every fourth is there twice.
    Planes,
    /// Around three points that are far from each other: coordinates are large and primitives small.
    Clusters,
    /// Thin quads, quads of almost parallel edges, and balls that touch each other or hold each other.
    Degenerate,
}
const KINDS: [Kind; 4] = [Kind::Spread, Kind::Planes, Kind::Clusters, Kind::Degenerate];

/// A scene of `n` primitives of about `unit` m, in a room ten times as large for each factor of a thousand in their number.
fn soup(n: u32, unit: f64, kind: Kind, seed: u32) -> Scene {
    let mut random = Random([seed, 0]);
    let side = unit * f64::from(n).cbrt() * 0.6;
    let text = |v: [f64; 3]| format!("[{:?}, {:?}, {:?}]", v[0], v[1], v[2]);
    let vector = |random: &mut Random, length: f64| random.vector().to_array().map(|x| f64::from(x) * length);
    let mut quads = String::new();
    let mut spheres = String::new();
    let mut last = String::new();
    for i in 0..n {
        let mut at = vector(&mut random, side);
        let mut u = vector(&mut random, unit);
        let mut v = vector(&mut random, unit);
        let mut radius = unit * (0.2 + 0.5 * f64::from(random.next()));
        match kind {
            Kind::Spread => (),
            Kind::Planes => {
                let axis = i as usize % 3;
                at[axis] = side * f64::from(i % 2);
                (u, v) = ([0.0; 3], [0.0; 3]);
                u[(axis + 1) % 3] = unit * f64::from(1 + i % 4);
                v[(axis + 2) % 3] = -unit * f64::from(1 + i % 3);
                radius = unit / 2.0;
            }
            Kind::Clusters => {
                at = std::array::from_fn(|k| at[k] / 3.0 + [0.0, 300.0, -1000.0][(i as usize + k) % 3] * unit)
            }
            Kind::Degenerate => {
                let factor = 10f64.powi(-((i % 6) as i32)).max(2e-6 / unit);
                if i % 2 == 0 {
                    u = u.map(|x| x * factor);
                } else {
                    v = std::array::from_fn(|k| u[k] + v[k] * factor);
                }
                radius = unit * (1.0 + factor);
                at = at.map(|x| (x / unit / 2.0).round() * 2.0 * unit);
            }
        }
        // No shorter than a scene may have them.
        let longer = |v: [f64; 3]| {
            let length = v.map(|x| x * x).iter().sum::<f64>().sqrt();
            v.map(|x| x * (1.1e-6 / length).max(1.0))
        };
        if i % 3 == 2 {
            let radius = radius.max(1e-6);
            write!(spheres, "[[spheres]]\ncentre = {}\nradius = {radius:?}\nmaterial = 'm'\n", text(at)).unwrap();
            continue;
        }
        let quad = format!(
            "[[quads]]\ncorner = {}\nedge_u = {}\nedge_v = {}\nmaterial = 'm'\n",
            text(at),
            text(longer(u)),
            text(longer(v))
        );
        quads += if kind == Kind::Planes && i % 4 == 0 && !last.is_empty() { &last } else { &quad };
        last = quad;
    }
    parse(&format!(
        "[camera]\nposition = {}\ntarget = {}\nup = [0.1, 1, 0.2]\nvertical_fov_degrees = 60\n[materials.m]\nkind = 'mirror'\n\
         reflectance = [1, 1, 1]\n{quads}{spheres}[[lights]]\nkind = 'point'\nposition = {}\nintensity = [1, 1, 1]\n",
        text([side, side, side]),
        text([0.0, 0.1 * side, 0.0]),
        text([0.0, side, 0.0])
    ))
}

/// The loop over all primitives.
fn linear(origin: Vec3, direction: Vec3, primitives: &[Primitive]) -> Hit {
    let mut best = Hit { t: f32::MAX, primitive: MISS };
    for (i, primitive) in primitives.iter().enumerate() {
        let t = intersect(origin, direction, primitive);
        if t > 0.0 && t < best.t {
            best = Hit { t, primitive: i as u32 };
        }
    }
    best
}

/// A ray of the kinds that paths have, and of those that rounding is worst for. It starts where `last` met something.
fn ray(random: &mut Random, scene: &CompiledScene, side: f32, last: Vec3) -> (Vec3, Vec3) {
    let primitive = scene.primitives[random.below(scene.info.primitives) as usize];
    let centre = Vec3::from_array(primitive.position);
    let normal = Vec3::from_array(primitive.normal);
    let mut origin = match random.below(6) {
        0 => centre,
        1 | 2 => last,
        3 => centre + random.vector() * primitive.size.min(side),
        4 if primitive.kind != PRIMITIVE_QUAD => centre + random.direction() * primitive.size,
        _ => random.vector() * side,
    };
    let direction = match random.below(8) {
        0 => [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z][random.below(6) as usize],
        1 => {
            // In a plane of two axes, or almost.
            let mut d = random.direction();
            d[random.below(3) as usize] = [0.0, -0.0, 1e-38, -1e-20, 1e-9][random.below(5) as usize];
            normalize(d)
        }
        // Straight at something, and at an edge of its box.
        2 | 3 if origin != centre => normalize(centre - origin),
        4 => {
            let sphere = primitive.kind != PRIMITIVE_QUAD;
            let corner =
                if sphere { random.direction() * primitive.size } else { random.vector().signum() * side * 1e-3 };
            normalize(centre + corner - origin + Vec3::splat(side * 1e-7))
        }
        // Along a surface.
        5 if primitive.kind == PRIMITIVE_QUAD => {
            let along = normalize(cross(normal, random.direction()));
            origin = centre - along * (side * 0.1 * random.next());
            normalize(along + random.vector() * [0.0, 1e-8, 1e-6, 1e-3][random.below(4) as usize])
        }
        5 => {
            let outwards = random.direction();
            let along = normalize(cross(outwards, random.direction()));
            origin = centre + outwards * primitive.size;
            normalize(along + outwards * [0.0, 1e-9, -1e-9, 1e-4, -1e-4][random.below(5) as usize])
        }
        _ => random.direction(),
    };
    (origin, direction)
}

/// Rays of which the tree and the loop say something else, and rays that met something, out of `rays`.
fn compare(scene: &CompiledScene, nodes: &[BvhNode], rays: u32, seed: u32) -> (u32, u32) {
    let mut random = Random([seed, 0]);
    let side = scene.primitives.iter().flat_map(|p| p.position).fold(0.0, |all: f32, x| all.max(x.abs()));
    let (mut differ, mut met, mut last) = (0, 0, Vec3::ZERO);
    for _ in 0..rays {
        let (origin, direction) = ray(&mut random, scene, side, last);
        let expected = linear(origin, direction, &scene.primitives);
        let found = closest_hit(origin, direction, &scene.info, nodes, &scene.primitives);
        let mut same = (found.t.to_bits(), found.primitive) == (expected.t.to_bits(), expected.primitive);
        // Shadow rays that end before, at, and after something.
        let distance = expected.t.min(side) * [0.5, 1.0, 1.000_001, 3.0][random.below(4) as usize];
        let except = [NO_LIGHT, expected.primitive][random.below(2) as usize];
        let blocked = (0..).zip(&scene.primitives).any(|(i, primitive)| {
            let t = intersect(origin, direction, primitive);
            i != except && t > 0.0 && t < distance
        });
        let shadow = occluded(origin, direction, distance, except, &scene.info, nodes, &scene.primitives);
        same &= shadow == if blocked { BLOCKED } else { MISS };
        differ += u32::from(!same);
        met += u32::from(expected.primitive != MISS);
        if expected.primitive != MISS && expected.t < side {
            last = origin + direction * expected.t;
        }
    }
    (differ, met)
}

#[test]
fn the_tree_and_the_loop_agree_to_the_bit() {
    let (mut rays, mut all_met) = (0, 0);
    for (i, unit) in [1e-6, 1e-3, 1.0, 300.0, 3e5].into_iter().enumerate() {
        for kind in KINDS {
            // One leaf, a small tree, a larger one.
            for (n, part) in [(12, 2000), (40, 5000), (400, 10_000)] {
                let scene = soup(n, unit, kind, n + i as u32).compile();
                let (differ, met) = compare(&scene, &scene.nodes, part, n + i as u32);
                assert_eq!(differ, 0, "{kind:?}, {n} primitives of {unit} m: of {part} rays");
                rays += part;
                all_met += met;
            }
        }
    }
    assert!(rays >= 300_000 && all_met > rays / 4 && all_met < rays * 9 / 10, "{all_met} of {rays} met something");
}

/// The comparison above must be able to fail.
#[test]
fn a_box_that_is_a_little_too_small_is_seen() {
    for kind in KINDS {
        let scene = soup(400, 1.0, kind, 9).compile();
        let reach = scene.nodes[0].near.iter().chain(&scene.nodes[0].far).fold(0.0, |all: f32, x| all.max(x.abs()));
        // Smaller by a part of itself, and by as much as rounding can be, which makes flat boxes empty.
        for (part, length) in [(1e-2, 0.0), (0.0, 2e-5 * reach)] {
            let mut nodes = scene.nodes.clone();
            for node in nodes.iter_mut().filter(|node| node.leaf != INNER) {
                for axis in 0..3 {
                    let inwards = (node.far[axis] - node.near[axis]) * part
                        + length * (node.far[axis] - node.near[axis]).signum();
                    node.near[axis] += inwards;
                    node.far[axis] -= inwards;
                }
            }
            assert_eq!(compare(&scene, &scene.nodes, 5000, 4).0, 0);
            let (differ, _) = compare(&scene, &nodes, 5000, 4);
            println!("{kind:?}, boxes smaller by {part} and {length} m: {differ} of 5000 rays differ");
            assert!(differ > 0, "{kind:?}, {part}, {length}");
        }
    }
    // One list that skips a node too many.
    let scene = soup(400, 1.0, Kind::Spread, 9).compile();
    let mut nodes = scene.nodes.clone();
    for node in nodes.iter_mut().filter(|node| node.leaf == INNER).skip(3).step_by(50) {
        node.skip += 1;
    }
    assert!(compare(&scene, &nodes, 5000, 4).0 > 0);
}

/// Each octant's list has each primitive once, skips only to places behind itself and within the list, and a box holds those of
/// its subtree.
#[test]
fn the_lists_are_trees() {
    for (n, kind) in
        [(1, Kind::Spread), (16, Kind::Planes), (17, Kind::Spread), (1000, Kind::Clusters), (300, Kind::Degenerate)]
    {
        let scene = soup(n, 1.0, kind, 3).compile();
        let count = scene.info.nodes as usize;
        assert_eq!(scene.nodes.len(), count * OCTANTS as usize);
        assert_eq!(count, if n <= 16 { 1 } else { 2 * n as usize - 1 });
        for (list, nodes) in scene.nodes.chunks(count).enumerate() {
            let mut seen = vec![0; n as usize];
            for (i, node) in nodes.iter().enumerate() {
                let end = node.skip as usize - list * count;
                assert!(end > i && end <= count);
                assert_eq!(node.leaf != INNER, end == i + 1);
                let first = node.leaf & ((1 << LEAF_BITS) - 1);
                (0..node.leaf >> LEAF_BITS).for_each(|k| seen[(first + k) as usize] += 1);
                for axis in 0..3 {
                    let sign = if list >> axis & 1 == 0 { 1.0 } else { -1.0 };
                    let within = |inner: &BvhNode| {
                        sign * inner.near[axis] >= sign * node.near[axis]
                            && sign * inner.far[axis] <= sign * node.far[axis]
                    };
                    assert!(nodes[i..end].iter().all(within) && sign * node.near[axis] < sign * node.far[axis]);
                }
            }
            assert!(seen.iter().all(|&times| times == 1), "{seen:?}");
        }
    }
}

/// Ten times as many primitives cost a ray a few steps more.
#[test]
fn the_cost_of_a_ray_grows_like_a_tree() {
    let steps = |n: u32| {
        let scene = soup(n, 1.0, Kind::Spread, 5).compile();
        let side = scene.primitives.iter().flat_map(|p| p.position).fold(0.0, |all: f32, x| all.max(x.abs()));
        let mut random = Random([n, 0]);
        let (mut visited, mut tested) = (0, 0);
        const RAYS: u32 = 20_000;
        for _ in 0..RAYS {
            let (origin, direction) = (random.vector() * side, random.direction());
            let slabs = Slabs::new(origin, direction);
            let (mut at, mut best) = (octant(direction) * scene.info.nodes, f32::MAX);
            let end = at + scene.info.nodes;
            while at < end {
                let node = scene.nodes[at as usize];
                visited += 1;
                if !slabs.meet(&node, best) {
                    at = node.skip;
                    continue;
                }
                if node.leaf != INNER {
                    tested += 1;
                    let t =
                        intersect(origin, direction, &scene.primitives[(node.leaf & ((1 << LEAF_BITS) - 1)) as usize]);
                    best = if t > 0.0 && t < best { t } else { best };
                }
                at += 1;
            }
            assert_eq!(best, closest_hit(origin, direction, &scene.info, &scene.nodes, &scene.primitives).t);
        }
        [visited, tested].map(|sum| f64::from(sum) / f64::from(RAYS))
    };
    let [few, many] = [steps(1000), steps(10_000)];
    println!("boxes and primitives a ray: {few:?} of 1000, {many:?} of 10,000");
    assert!(many[0] < 120.0 && many[1] < 12.0 && many[0] < 2.0 * few[0], "{few:?}, {many:?}");
}
