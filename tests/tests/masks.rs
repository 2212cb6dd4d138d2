//! What tracing kernels know, bit by bit.

use caustic_device::{Buffer, Device, Plan};
use caustic_kernels::layout::{Irradiance, Photon, Query};
use caustic_kernels::sort::SCAN_BLOCK;
use caustic_kernels::trace::known::{GLOSS, LAMPS, MEDIA, MESHES, SKY, TEXTURES};
use caustic_kernels::trace::{CameraTile, EVERYTHING, GatherTile, PhotonPass, RAY_CAUSTIC, RAY_GLOBAL, Tally, Vertex};
use caustic_renderer::scene::{BUILT_IN, Scene};
use caustic_renderer::{SceneBuffers, Tracers};
use caustic_tests::gpu;
use caustic_tests::program::folder;
use caustic_tests::renders::{load, parse};

const BITS: [u32; 6] = [TEXTURES, GLOSS, MEDIA, SKY, MESHES, LAMPS];

/// What kernels of a mask give for a scene: photons of both maps, then words of what the camera sees of surfaces, direct light, rays of a final
/// gather, and paths to the lights.
fn traced(device: &Device, scene: &Scene, mask: u32) -> (Vec<Photon>, Vec<u32>) {
    let kernels = Tracers::knowing(mask);
    let compiled = scene.compile();
    let buffers = SceneBuffers::new(device, &compiled).unwrap();
    let paths = 3000;
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
        let tallies = device.buffer::<Tally>("tallies", paths.into()).unwrap();
        let mut plan = Plan::new();
        let outputs = [&counts, &fates, &segments, &tallies];
        plan.each(kernels.count, paths, &[&[&pass], &buffers.for_photons(&lights)[..], &outputs].concat());
        let [offsets, block_offsets, totals] = caustic_photon_map::scan(device, &mut plan, &counts, paths).unwrap();
        device.run(&plan).unwrap();
        let blocks = u64::from(paths.div_ceil(SCAN_BLOCK));
        let stored: u32 = device.read::<u32>(&totals, blocks).unwrap().iter().sum();
        let unsorted = device.buffer::<Photon>("photons", stored.max(1).into()).unwrap();
        let mut plan = Plan::new();
        let places = [&counts, &offsets, &block_offsets, &unsorted];
        plan.each(kernels.store, paths, &[&[&pass], &buffers.for_photons(&lights)[..], &places].concat());
        device.run(&plan).unwrap();
        photons.extend(device.read::<Photon>(&unsorted, stored.into()).unwrap());
    }
    let (size, samples, seed) = ([40, 30], 2, 5);
    let (pixels, first_pixel) = (size[0] * size[1], 0);
    let count = pixels * samples;
    let tile = device.upload("tile", &[CameraTile { first_pixel, pixels, samples, seed }]).unwrap();
    let rays = device.upload("rays", &[GatherTile { first_pixel, pixels, samples, rays: 1, seed }]).unwrap();
    let camera = device.upload("camera", &[scene.camera(size[0], size[1])]).unwrap();
    let queries = |name| device.buffer::<Query>(name, count.into()).unwrap();
    let vertices = |name| device.buffer::<Vertex>(name, count.into()).unwrap();
    let (seen, at, far, beyond, ends) =
        (queries("queries"), vertices("vertices"), queries("far"), vertices("beyond"), vertices("ends"));
    let direct = device.buffer::<Irradiance>("direct", count.into()).unwrap();
    let mut plan = Plan::new();
    let mut each = |kernel, before: &[&Buffer], after: &[&Buffer]| {
        plan.each(kernel, count, &[before, &buffers.for_camera()[..], after].concat());
    };
    each(kernels.camera, &[&tile, &camera], &[&seen, &at]);
    each(kernels.direct, &[&tile], &[&seen, &at, &direct]);
    each(kernels.gather, &[&rays], &[&seen, &at, &far, &beyond]);
    each(kernels.paths, &[&tile, &camera], &[&ends]);
    device.run(&plan).unwrap();
    let vertices = [&at, &beyond, &ends].map(|buffer| device.read::<Vertex>(buffer, count.into()).unwrap());
    let lit = device.read::<Irradiance>(&direct, count.into()).unwrap();
    let words = vertices.iter().flat_map(|all| bytemuck::cast_slice::<_, u32>(all)).chain(bytemuck::cast_slice(&lit));
    (photons, words.copied().collect())
}

/// A picture on the ground.
fn pictured(folder: &std::path::Path) -> Scene {
    let texture = folder.join("t.png");
    image::RgbImage::from_fn(7, 5, |x, y| image::Rgb([x as u8 * 36, y as u8 * 50, 90])).save(&texture).unwrap();
    parse(&format!(
        "[camera]\nposition=[0,1,4]\ntarget=[0,0,0]\nvertical_fov_degrees=45\n\
         [materials.picture]\nkind='lambertian'\nreflectance=[0.9,0.9,0.9]\ntexture={:?}\n\
         [[quads]]\ncorner=[-2,0,2]\nedge_u=[4,0,0]\nedge_v=[0,0,-4]\nmaterial='picture'\n\
         [[lights]]\nkind='point'\nposition=[0,2,0]\nintensity=[9,9,9]\n",
        texture.to_str().unwrap()
    ))
}

/// Whatever a kernel knows beyond what a scene needs, it gives the same bits. Without a bit that the scene needs it gives others: the
/// comparison can fail, and no bit is asked for without a reason.
#[test]
fn knowing_more_changes_nothing_and_knowing_less_does() {
    let (cpu, folder) = (Device::cpu(), folder());
    let mut needed = 0;
    for scene in BUILT_IN.iter().map(|scene| load(scene.name)).chain([pictured(folder.path())]) {
        let needs = scene.compile().needs;
        let exact = traced(&cpu, &scene, needs);
        assert!(!exact.0.is_empty(), "{}", scene.name);
        assert!(traced(&cpu, &scene, EVERYTHING) == exact, "{} with everything", scene.name);
        for bit in BITS {
            let same = traced(&cpu, &scene, needs ^ bit) == exact;
            assert_eq!(same, needs & bit == 0, "{}: needs {needs:#b}, and {bit:#b} is turned over", scene.name);
        }
        needed |= needs;
    }
    assert_eq!(needed, EVERYTHING, "each is needed somewhere");
}

/// A GPU's kernels obey their masks as the CPU's do: what is missing is missing.
#[test]
fn a_gpu_knows_what_the_cpu_knows() {
    let Some(gpu) = gpu() else { return };
    let (cpu, folder) = (Device::cpu(), folder());
    for (scene, less) in [(load("cornell-coated"), GLOSS), (load("cornell-coated"), 0), (pictured(folder.path()), 0)] {
        let found = traced(gpu, &scene, less);
        assert!(found == traced(&cpu, &scene, less), "{} knowing {less:#b}", scene.name);
        assert!(found != traced(&cpu, &scene, scene.compile().needs), "{} knowing {less:#b}", scene.name);
    }
}
