//! Meshes: triangles in scenes, on the CPU and on a GPU, through the tree and without it.

use caustic_device::Device;
use caustic_kernels::layout::{Irradiance, Photon, Query};
use caustic_kernels::trace::{CameraTile, PhotonPass, RAY_CAUSTIC, RAY_GLOBAL, Vertex, corners_of};
use caustic_renderer::scene::{BUILT_IN, CompiledScene, Scene};
use caustic_renderer::{SceneBuffers, Tracers};
use caustic_tests::gpu;
use caustic_tests::rays::{closest, shadow};
use caustic_tests::renders::{floats, image, load, parse, small};
use caustic_tests::soups::{Random, linear};
use glam::Vec3;
use std::fmt::Write;

/// A soup of triangles: large, small, needles, some twice, and some that lie in one plane.
fn triangles(n: u32, unit: f32, seed: u32) -> CompiledScene {
    let mut random = Random([seed, 1]);
    let side = unit * (n as f32).cbrt();
    let (mut vertices, mut indices) = (String::new(), String::new());
    for i in 0..n {
        let at = random.vector() * side;
        let thin = [1.0, 0.1, 1e-3, 1e-5][(i % 4) as usize];
        let (u, v) = (random.vector() * unit, random.vector() * unit);
        let mut corners = [at, at + u, at + u * 0.4 + v * thin];
        if i % 5 == 0 {
            corners.iter_mut().for_each(|corner| corner.y = 0.5 * side);
        }
        for corner in corners {
            let _ = write!(vertices, "[{:?},{:?},{:?}],", corner.x, corner.y, corner.z);
        }
        let _ = write!(indices, "[{},{},{}],", 3 * i, 3 * i + 1, 3 * i + 2);
        if i % 7 == 0 {
            let _ = write!(indices, "[{},{},{}],", 3 * i + 1, 3 * i, 3 * i + 2);
        }
    }
    parse(&format!(
        "[camera]\nposition=[{side:?},{side:?},{side:?}]\ntarget=[0,0,0]\nvertical_fov_degrees=60\n\
         [materials.m]\nkind='lambertian'\nreflectance=[0.5,0.5,0.5]\n\
         [[lights]]\nkind='point'\nposition=[0,0,{side:?}]\nintensity=[1,1,1]\n\
         [[meshes]]\nmaterial='m'\nvertices=[{vertices}]\ntriangles=[{indices}]\n"
    ))
    .compile()
}

/// Rays of which the tree and the loop say something else, and rays that met something.
fn compare(scene: &CompiledScene, rays: u32, seed: u32) -> (u32, u32) {
    let mut random = Random([seed, 2]);
    let side = scene.primitives.iter().flat_map(|p| p.position).fold(0.0, |all: f32, x| all.max(x.abs()));
    let (mut differ, mut met) = (0, 0);
    for i in 0..rays {
        let [a, b, c] = corners_of(&scene.primitives[random.below(scene.info.primitives) as usize]);
        let aim = [a, b, (a + b) * 0.5, (a + b + c) * (1.0 / 3.0)][random.below(4) as usize];
        let mut origin = random.vector() * side;
        let mut direction = (aim - origin).normalize();
        if i % 3 == 0 {
            // Along a triangle.
            let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
            direction = (b - a + (c - a) * random.next_unit()).normalize();
            direction = (direction + normal * [0.0, 1e-7, 1e-5][random.below(3) as usize]).normalize();
            origin = aim - direction * (side * random.next_unit());
        }
        if !direction.is_finite() {
            continue;
        }
        let expected = linear(origin, direction, &scene.primitives);
        let found = closest::<true>(scene, &scene.nodes, origin, direction);
        differ += u32::from((found.t.to_bits(), found.primitive) != (expected.t.to_bits(), expected.primitive));
        let distance = expected.t.min(side) * 0.999;
        let in_shadow = shadow::<true>(scene, &scene.nodes, [origin, direction], distance, u32::MAX);
        let blocked = scene.primitives.iter().any(|primitive| {
            let t = caustic_kernels::trace::intersect(origin, direction, primitive);
            t > 0.0 && t < distance
        });
        differ += u32::from(blocked != (in_shadow == 0));
        met += u32::from(expected.t < f32::MAX);
    }
    (differ, met)
}

#[test]
fn the_tree_over_triangles_and_the_loop_agree_to_the_bit() {
    for unit in [1e-5, 1.0, 3e4] {
        for n in [10, 60, 500] {
            let scene = triangles(n, unit, n);
            let (differ, met) = compare(&scene, 8000, n);
            assert_eq!(differ, 0, "{n} triangles of {unit} m");
            assert!(met > 2000, "{met}");
        }
    }
}

/// Boxes that are a little too small are seen by the comparison above.
#[test]
fn a_box_of_a_triangle_that_is_too_small_is_seen() {
    let mut scene = triangles(500, 1.0, 3);
    assert_eq!(compare(&scene, 8000, 1).0, 0);
    for node in &mut scene.nodes {
        for axis in 0..3 {
            let inwards = (node.far[axis] - node.near[axis]) * 0.01;
            node.near[axis] += inwards;
            node.far[axis] -= inwards;
        }
    }
    assert!(compare(&scene, 8000, 1).0 > 0);
}

/// What a scene's kernels give: photons of both maps, what the camera sees, and direct light.
fn traced(device: &Device, scene: &Scene, kernels: Tracers) -> (Vec<Photon>, Vec<Vertex>, Vec<Irradiance>) {
    use caustic_device::Plan;
    let compiled = scene.compile();
    let buffers = SceneBuffers::new(device, &compiled).unwrap();
    let (paths, size, samples) = (3000, [40, 30], 2);
    let mut photons = Vec::new();
    for rays in [RAY_GLOBAL, RAY_CAUSTIC] {
        if compiled.fewest_photons(rays) == 0 {
            continue;
        }
        let pass = PhotonPass { emitted: paths, first: 0, paths, rays, seed: 5, stored_from: 0, thin: 1, chunk: 0 };
        let lights = device.upload("lights", &compiled.lights_for(paths, rays)).unwrap();
        let pass = device.upload("pass", &[pass]).unwrap();
        let words = |name| device.buffer::<u32>(name, paths.into()).unwrap();
        let (counts, fates, segments) = (words("counts"), words("fates"), words("segments"));
        let tallies = device.buffer::<caustic_kernels::trace::Tally>("tallies", paths.into()).unwrap();
        let mut plan = Plan::new();
        let outputs = [&counts, &fates, &segments, &tallies];
        plan.each(kernels.count, paths, &[&[&pass], &buffers.for_photons(&lights)[..], &outputs].concat());
        let [offsets, block_offsets, totals] = caustic_photon_map::scan(device, &mut plan, &counts, paths).unwrap();
        device.run(&plan).unwrap();
        let blocks = u64::from(paths.div_ceil(caustic_kernels::sort::SCAN_BLOCK));
        let stored: u32 = device.read::<u32>(&totals, blocks).unwrap().iter().sum();
        let unsorted = device.buffer::<Photon>("photons", stored.max(1).into()).unwrap();
        let mut plan = Plan::new();
        let places = [&counts, &offsets, &block_offsets, &unsorted];
        plan.each(kernels.store, paths, &[&[&pass], &buffers.for_photons(&lights)[..], &places].concat());
        device.run(&plan).unwrap();
        photons.extend(device.read::<Photon>(&unsorted, stored.into()).unwrap());
    }
    let [width, height] = size;
    let count = width * height * samples;
    let tile = CameraTile { first_pixel: 0, pixels: width * height, samples, seed: 5 };
    let tile = device.upload("tile", &[tile]).unwrap();
    let camera = device.upload("camera", &[scene.camera(width, height)]).unwrap();
    let queries = device.buffer::<Query>("queries", count.into()).unwrap();
    let vertices = device.buffer::<Vertex>("vertices", count.into()).unwrap();
    let direct = device.buffer::<Irradiance>("direct", count.into()).unwrap();
    let mut plan = Plan::new();
    let seen = [&queries, &vertices];
    plan.each(kernels.camera, count, &[&[&tile, &camera], &buffers.for_camera()[..], &seen].concat());
    let shaded = [&queries, &vertices, &direct];
    plan.each(kernels.direct, count, &[&[&tile], &buffers.for_camera()[..], &shaded].concat());
    device.run(&plan).unwrap();
    (photons, device.read(&vertices, count.into()).unwrap(), device.read(&direct, count.into()).unwrap())
}

/// The two kinds of kernels are one body: what the basic ones can trace, the full ones trace to the same bits.
#[test]
fn basic_and_full_kernels_give_a_basic_scene_the_same_bits() {
    let mut compared = 0;
    for built_in in BUILT_IN {
        let scene = load(built_in.name);
        if scene.compile().full {
            continue;
        }
        for device in [Some(&Device::cpu()), gpu()].into_iter().flatten() {
            let (basic, full) = (traced(device, &scene, Tracers::BASIC), traced(device, &scene, Tracers::FULL));
            assert!(!basic.0.is_empty() && basic == full, "{} on {}", built_in.name, device.name());
            compared += 1;
        }
    }
    assert!(compared >= 3);
}

/// A box of triangles with a lamp outside: inside it is black, whatever the grid of its walls; with a triangle less it is not.
#[test]
fn no_light_leaks_into_a_closed_box_of_triangles() {
    let sides = |without: usize| {
        let n = 5;
        let (mut vertices, mut indices) = (String::new(), String::new());
        let mut points = 0;
        for axis in 0..3usize {
            for end in [-1.0f64, 1.0] {
                for k in 0..=n {
                    for i in 0..=n {
                        let mut p = [end; 3];
                        p[(axis + 1) % 3] = f64::from(i) * 2.0 / f64::from(n) - 1.0;
                        p[(axis + 2) % 3] = f64::from(k) * 2.0 / f64::from(n) - 1.0;
                        // Turned, so that no wall is parallel to an axis.
                        let (x, y, z) = (p[0], p[1], p[2]);
                        let (x, y) = (0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y);
                        let (y, z) = (0.28 * y - 0.96 * z, 0.96 * y + 0.28 * z);
                        let _ = write!(vertices, "[{x:?},{y:?},{z:?}],");
                    }
                }
                for k in 0..n {
                    for i in 0..n {
                        let a = points + k * (n + 1) + i;
                        for t in [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]] {
                            let _ = write!(indices, "[{},{},{}],", t[0], t[1], t[2]);
                        }
                    }
                }
                points += (n + 1) * (n + 1);
            }
        }
        let kept: Vec<&str> = indices.trim_end_matches(',').split_inclusive("],").skip(without).collect();
        parse(&format!(
            "[camera]\nposition=[0,0,0]\ntarget=[0.3,0.2,1]\nvertical_fov_degrees=150\n\
             [materials.m]\nkind='lambertian'\nreflectance=[0.8,0.8,0.8]\n\
             [[spheres]]\nname='lamp'\ncentre=[0,0,9]\nradius=3\nradiance=[50,50,50]\n\
             [[lights]]\nkind='point'\nposition=[0.5,-4,-3]\nintensity=[90,90,90]\n\
             [[lights]]\nkind='point'\nposition=[-3,2.5,1]\nintensity=[90,90,90]\n\
             [[meshes]]\nmaterial='m'\nvertices=[{vertices}]\ntriangles=[{}]\n",
            kept.concat()
        ))
    };
    let bright = |scene: &Scene, device: &Device| {
        let settings = caustic_renderer::Settings { photons: 40_000, spp: 8, ..small(scene) };
        floats(&image(scene, &settings, device)).iter().filter(|&&value| value > 0.0).count()
    };
    let closed = sides(0);
    for device in [Some(&Device::cpu()), gpu()].into_iter().flatten() {
        assert_eq!(bright(&closed, device), 0, "{}", device.name());
    }
    let open: usize = [1, 30, 60].iter().map(|&without| bright(&sides(without), &Device::cpu())).sum();
    assert!(open > 0, "a hole must be seen");
}

/// Scenes of meshes have the same bits on a GPU: smooth normals, textures, glass, metals and lights of triangles.
#[test]
fn pictures_of_meshes_have_the_same_bits_on_a_gpu() {
    let Some(gpu) = gpu() else { return };
    let folder = caustic_tests::program::folder();
    let texture = folder.path().join("t.png");
    ::image::RgbImage::from_fn(7, 5, |x, y| ::image::Rgb([x as u8 * 36, y as u8 * 50, 90])).save(&texture).unwrap();
    let text = format!(
        "[camera]\nposition=[0,0.6,4]\ntarget=[0,0.4,0]\nvertical_fov_degrees=45\n\
         [materials.picture]\nkind='lambertian'\nreflectance=[0.9,0.9,0.9]\ntexture={:?}\n\
         [materials.glass]\nkind='dielectric'\nior=1.5\n[materials.metal]\nkind='mirror'\nreflectance=[0.8,0.7,0.6]\n\
         [[meshes]]\nmaterial='picture'\nvertices=[[-3,0,3],[3,0,3],[3,0,-3],[-3,0,-3]]\nuv=[[0,3],[3,3],[3,0],[0,0]]\n\
         triangles=[[0,1,2],[0,2,3]]\n\
         [[meshes]]\nname='gem'\nmaterial='glass'\nvertices=[[0,1,0],[0.5,0.4,0],[0,0.4,-0.5],[-0.5,0.4,0],[0,0.4,0.5],[0,0.1,0]]\n\
         normals=[[0,1,0],[1,0,0],[0,0,-1],[-1,0,0],[0,0,1],[0,-1,0]]\n\
         triangles=[[0,1,2],[0,2,3],[0,3,4],[0,4,1],[5,2,1],[5,3,2],[5,4,3],[5,1,4]]\n\
         [[instances]]\nmesh='gem'\nmaterial='metal'\nplace={{translate=[1.1,0,-0.4],rotate_degrees=[0,20,0],scale=0.8}}\n\
         [[discs]]\ncentre=[-1.2,0.7,-0.3]\nnormal=[0.4,0.3,1]\nradius=0.5\nmaterial='picture'\n\
         [[meshes]]\nname='lamp'\nvertices=[[-0.5,2.5,0.5],[0.5,2.5,-0.5],[0.5,2.5,0.5]]\ntriangles=[[0,1,2]]\nradiance=[20,18,15]\n",
        texture.to_str().unwrap()
    );
    let scenes = [parse(&text), load("hall")];
    for scene in scenes {
        assert!(scene.compile().full);
        let settings = caustic_renderer::Settings { photons: 2000, caustic_photons: 1000, ..small(&scene) };
        let [cpu, other] = [&Device::cpu(), gpu].map(|device| image(&scene, &settings, device));
        assert!(floats(&cpu).iter().any(|&value| value > 0.0), "{}", scene.name);
        assert_eq!(cpu.sha256(), other.sha256(), "{}", scene.name);
    }
}

#[test]
fn a_large_mesh_has_fewer_lists_and_the_same_hits() {
    // 2 × 270² triangles: more than eight lists of nodes have room for.
    let n = 270;
    let mut vertices = String::new();
    for k in 0..=n {
        for i in 0..=n {
            let (x, z) = (f64::from(i) / 10.0, f64::from(k) / 10.0);
            let _ = write!(vertices, "[{x:?},{:?},{z:?}],", (x * 1.7).sin() * (z * 1.3).cos());
        }
    }
    let mut indices = String::new();
    for k in 0..n {
        for i in 0..n {
            let a = k * (n + 1) + i;
            let _ = write!(indices, "[{},{},{}],[{},{},{}],", a, a + n + 1, a + n + 2, a, a + n + 2, a + 1);
        }
    }
    let scene = parse(&format!(
        "[camera]\nposition=[0,9,0]\ntarget=[9,0,9]\nvertical_fov_degrees=60\n\
         [materials.m]\nkind='lambertian'\nreflectance=[0.5,0.5,0.5]\n\
         [[lights]]\nkind='point'\nposition=[5,9,5]\nintensity=[1,1,1]\n\
         [[meshes]]\nmaterial='m'\nvertices=[{vertices}]\ntriangles=[{indices}]\n"
    ))
    .compile();
    assert_eq!((scene.info.primitives, scene.info.lists), (145_800, 4));
    let (differ, met) = compare(&scene, 60, 7);
    assert_eq!(differ, 0);
    assert!(met > 30, "{met}");
}
