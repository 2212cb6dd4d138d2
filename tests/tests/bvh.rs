//! The tree gives what a loop over all primitives gives, to the bit, and takes fewer steps.

use caustic_device::{Device, Kernel, Plan};
use caustic_kernels::layout::Query;
use caustic_kernels::trace::{
    ALL, BLOCKED, BvhNode, Camera, CameraTile, Corners, INNER, LEAF_BITS, LOST, Light, MISS, Material, NO_LIGHT,
    OCTANTS, Only, Primitive, SceneInfo, Slabs, Texel, Texture, Vertex, intersect, octant,
};
use caustic_renderer::scene::CompiledScene;
use caustic_tests::gpu;
use caustic_tests::maps::limits_loops;
use caustic_tests::rays::{closest, shadow};
use caustic_tests::renders::{load, run, small};
use caustic_tests::soups::{KINDS, Kind, Random, linear, ray, soup};
use glam::Vec3;

/// Rays of which the tree and the loop say something else, and rays that met something, out of `rays`.
fn compare(scene: &CompiledScene, nodes: &[BvhNode], rays: u32, seed: u32) -> (u32, u32) {
    let mut random = Random([seed, 0]);
    let side = scene.primitives.iter().flat_map(|p| p.position).fold(0.0, |all: f32, x| all.max(x.abs()));
    let (mut differ, mut met, mut last) = (0, 0, Vec3::ZERO);
    for _ in 0..rays {
        let (origin, direction) = ray(&mut random, scene, side, last);
        let expected = linear(origin, direction, &scene.primitives);
        let found = closest(Only::<0>, scene, nodes, origin, direction);
        let mut same = (found.t.to_bits(), found.primitive) == (expected.t.to_bits(), expected.primitive);
        // Shadow rays that end before, at, and after something.
        let distance = expected.t.min(side) * [0.5, 1.0, 1.000_001, 3.0][random.below(4) as usize];
        let except = [NO_LIGHT, expected.primitive][random.below(2) as usize];
        let blocked = (0..).zip(&scene.primitives).any(|(i, primitive)| {
            let t = intersect(origin, direction, primitive);
            i != except && t > 0.0 && t < distance
        });
        let shadow = shadow(Only::<0>, scene, nodes, [origin, direction], distance, except);
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
                for k in 0..node.leaf >> LEAF_BITS {
                    seen[(first + k) as usize] += 1;
                }
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
                if !slabs.meet(ALL, &node, best) {
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
            assert_eq!(best, closest(ALL, &scene, &scene.nodes, origin, direction).t);
        }
        [visited, tested].map(|sum| f64::from(sum) / f64::from(RAYS))
    };
    let [few, many] = [steps(1000), steps(10_000)];
    println!("boxes and primitives a ray: {few:?} of 1000, {many:?} of 10,000");
    assert!(many[0] < 120.0 && many[1] < 12.0 && many[0] < 2.0 * few[0], "{few:?}, {many:?}");
}

/// A tree that is a chain of more nodes than 16 bits count, its one primitive last: llvmpipe does not come to its end, and says so.
#[test]
fn a_ray_that_does_not_come_to_its_end_is_lost() {
    const NODES: u32 = 70_000;
    let node = |i: u32| {
        let (list, at) = (i / NODES, i % NODES);
        let z = if list >> 2 == 0 { -9.0 } else { 9.0 };
        let leaf = if at + 1 < NODES { INNER } else { 1 << LEAF_BITS };
        BvhNode {
            near: [-9.0, -9.0, z],
            skip: list * NODES + if leaf == INNER { NODES } else { at + 1 },
            far: [9.0, 9.0, -z],
            leaf,
        }
    };
    let nodes: Vec<BvhNode> = (0..OCTANTS * NODES).map(node).collect();
    let info = SceneInfo { primitives: 1, nodes: NODES, ..SceneInfo::default() };
    let wall =
        Primitive { light: NO_LIGHT, position: [0.0, 0.0, -2.0], normal: [0.0, 0.0, 1.0], ..Primitive::default() };
    for device in [Some(&Device::cpu()), gpu()].into_iter().flatten() {
        let tile = device.upload("tile", &[CameraTile { pixels: 1, samples: 1, ..CameraTile::default() }]).unwrap();
        let camera = Camera { width: 1, height: 1, corner: [0.0, 0.0, -1.0], ..Camera::default() };
        let camera = device.upload("camera", &[camera]).unwrap();
        let info = device.upload("info", &[info]).unwrap();
        let nodes = device.upload("nodes", &nodes).unwrap();
        let primitives = device.upload("primitives", &[wall]).unwrap();
        let materials = device.upload("materials", &[Material::default()]).unwrap();
        let lights = device.buffer::<Light>("lights", 0).unwrap();
        let corners = device.buffer::<Corners>("corners", 0).unwrap();
        let textures = device.buffer::<Texture>("textures", 0).unwrap();
        let texels = device.buffer::<Texel>("texels", 0).unwrap();
        let queries = device.buffer::<Query>("queries", 1).unwrap();
        let vertices = device.buffer::<Vertex>("vertices", 1).unwrap();
        let mut plan = Plan::new();
        let scene = [&info, &nodes, &primitives, &materials, &lights, &corners, &textures, &texels];
        let buffers = [&[&tile, &camera], &scene[..], &[&queries, &vertices]].concat();
        plan.each(Kernel::TraceCamera.knowing(0), 1, &buffers);
        device.run(&plan).unwrap();
        let found: Vec<Vertex> = device.read(&vertices, 1).unwrap();
        assert_eq!(found[0].primitive, if limits_loops(device) { LOST } else { 0 }, "{}", device.name());
    }
}

/// A path has a segment more than it has bounces, and a sample at most one ray to a light.
#[test]
fn rays_are_counted() {
    let scene = load("cornell");
    let settings = small(&scene);
    let report = run(&scene, &settings, &Device::cpu()).report;
    for map in &report.maps {
        // Photons are stored at the ends of segments, at one each at the most.
        assert!(
            map.segments > u64::from(map.photons_stored) && map.segments >= u64::from(map.photons_emitted),
            "{map:?}"
        );
        assert!(map.segments < 10 * u64::from(map.photons_emitted), "{map:?}");
    }
    let samples = u64::from(settings.size[0] * settings.size[1] * settings.spp);
    assert!(report.camera_rays > samples && report.camera_rays < 4 * samples, "{}", report.camera_rays);
    // In a furnace that a photon never leaves, every segment ends on the wall, where all but the first photon are stored.
    let scene = load("furnace");
    let report = run(&scene, &small(&scene), &Device::cpu()).report;
    let map = &report.maps[0];
    assert_eq!(map.segments, u64::from(map.photons_stored + map.photons_emitted));
    if let Some(gpu) = gpu() {
        let of_gpu = run(&scene, &small(&scene), gpu).report;
        assert_eq!((map.segments, report.camera_rays), (of_gpu.maps[0].segments, of_gpu.camera_rays));
    }
}
