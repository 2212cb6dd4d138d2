//! Photon maps against the path tracer, scene by scene: they share rays and materials and nothing else.
//!
//! Of each built-in scene a small picture is made by paths and by progressive passes of a small and of a large radius, several seeds each. Blocks of
//! pixels give Welch's z = (mean of one − mean of the other) / √(SE² + SE²). Whole pictures have to agree within their noise and a
//! percent, and what is left in the pixels is bias that shrinks with the radius. `CAUSTIC_LONG=1` takes sixteen times the samples and photons.

use caustic_device::Device;
use caustic_photon_map::Surface;
use caustic_renderer::output::Image;
use caustic_renderer::scene::{BUILT_IN, Scene};
use caustic_renderer::{Integrator, Settings, Show, Stop};
use caustic_tests::renders::*;

/// Seeds of each way.
const SEEDS: u32 = 8;
/// The picture, and the sides of a block.
const SIZE: [u32; 2] = [16, 12];
const BLOCK: u32 = 4;

/// Scenes that the path tracer cannot do, with the reason: it finds light that comes from a point or from the sun through smooth mirrors or glass
/// with no chance at all, and through nearly smooth ones with nearly none.
const NOT_BY_PATHS: [(&str, &str); 6] = [
    (
        "courtyard",
        "paths find the sun of its environment in mirror and glass so seldom that means are 3 % off; tests/sky.rs has an environment without",
    ),
    ("lamps", "point lights shine through a glass ball and off a mirror ball"),
    ("landscape", "the lake mirrors the sun"),
    ("ring", "paths find the sun in polished brass so seldom that the mean of a million is 9 % off"),
    ("pool", "the sun shines through smooth water"),
    ("water", "a spot shines through smooth water"),
];

/// A scene that it can do, the smaller and the larger radius, m.
const SCENES: [(&str, [f32; 2]); 7] = [
    ("cornell", [0.06, 0.5]),
    ("cornell-coated", [0.06, 0.5]),
    ("cornell-glossy", [0.06, 0.5]),
    ("furnace", [0.1, 0.6]),
    ("hall", [0.15, 2.0]),
    ("micro", [6e-7, 5e-6]),
    ("plane", [0.1, 1.0]),
];

fn many() -> u32 {
    if std::env::var("CAUSTIC_LONG").is_ok_and(|value| value == "1") { 16 } else { 1 }
}

fn pictures(scene: &Scene, settings: &Settings, first: u32) -> Vec<Image> {
    (first..first + SEEDS).map(|seed| image(scene, &Settings { seed, ..settings.clone() }, &Device::cpu())).collect()
}

/// Mean and standard error of a number that each picture has.
fn over(pictures: &[Image], of: impl Fn(&Image) -> f64) -> (f64, f64) {
    mean_and_error(&pictures.iter().map(of).collect::<Vec<_>>())
}

/// Mean of the channel `c` of a block.
fn block(picture: &Image, [x, y]: [u32; 2], c: usize) -> f64 {
    let pixels = (0..BLOCK * BLOCK).map(|i| (y * BLOCK + i / BLOCK) * SIZE[0] + x * BLOCK + i % BLOCK);
    mean(&pixels.map(|at| f64::from(picture.rgb[at as usize][c])).collect::<Vec<_>>())
}

/// What the blocks of the means of pictures say of each other.
struct Blocks {
    /// Root of the mean of z².
    rms: f64,
    /// The largest.
    most: f64,
    /// Mean of the squared bias over the truth: (difference of the means)² less the variances of both, so that noise does not make it. And its standard
    /// error, from its scatter over blocks.
    bias2: (f64, f64),
}

fn compare(truth: &[Image], found: &[Image]) -> Blocks {
    let blocks = (0..SIZE[1] / BLOCK).flat_map(|y| (0..SIZE[0] / BLOCK).map(move |x| [x, y]));
    // Blocks without any light are as good as equal.
    let dark = 0.01 * over(truth, |one| mean_rgb(one)[1]).0;
    let (mut z, mut bias2) = (Vec::new(), Vec::new());
    for (at, c) in blocks.flat_map(|at| (0..3).map(move |c| (at, c))) {
        let ((a, a_error), (b, b_error)) = (over(truth, |one| block(one, at, c)), over(found, |one| block(one, at, c)));
        let variance = a_error * a_error + b_error * b_error;
        z.push(if a == b { 0.0 } else { (a - b).abs() / variance.sqrt() });
        bias2.push(((a - b).powi(2) - variance) / (a * a + dark * dark));
    }
    let rms = mean(&z.iter().map(|z| z * z).collect::<Vec<_>>()).sqrt();
    Blocks { rms, most: z.into_iter().fold(0.0, f64::max), bias2: mean_and_error(&bias2) }
}

#[test]
fn every_scene_is_tested_or_says_why_not() {
    for built_in in BUILT_IN {
        let listed = SCENES.iter().filter(|(name, _)| *name == built_in.name).count();
        let left_out = NOT_BY_PATHS.iter().filter(|(name, _)| *name == built_in.name).count();
        assert_eq!(listed + left_out, 1, "{}", built_in.name);
    }
}

#[test]
fn photon_maps_converge_to_what_paths_see() {
    for (name, radii) in SCENES {
        let scene = load(name);
        let base = Settings { size: SIZE, surface: Surface::Own, ..Settings::of(&scene) };
        let paths = Settings { integrator: Integrator::Path, spp: 96 * many(), ..base.clone() };
        let truth = pictures(&scene, &paths, 0);
        let [small, large] = radii.map(|radius| {
            let settings = Settings {
                integrator: Integrator::Progressive,
                photons: 20_000 * many(),
                caustic_photons: 20_000 * many(),
                spp: 16,
                radius,
                // All of its light is direct, which would come from shadow rays.
                show: if name == "plane" { Show::MapGlobal } else { Show::Beauty },
                stop: Stop { passes: Some(2), ..Stop::default() },
                ..base.clone()
            };
            pictures(&scene, &settings, 100)
        });
        for c in 0..3 {
            let mean_of = |one: &Image| mean_rgb(one)[c];
            let ((paths, paths_se), (maps, maps_se)) = (over(&truth, mean_of), over(&small, mean_of));
            let (ratio, se) = (maps / paths, paths_se.hypot(maps_se) / paths);
            println!("{name}, channel {c}: maps over paths {ratio:.4} ± {se:.4}");
            assert!((ratio - 1.0).abs() < 4.0 * se + 0.01 && se < 0.02, "{name}, channel {c}: {ratio} ± {se}");
        }
        let (near, far) = (compare(&truth, &small), compare(&truth, &large));
        for (radius, Blocks { rms, most, bias2: (bias2, se) }) in [(radii[0], &near), (radii[1], &far)] {
            println!(
                "{name}, {radius} m: z of blocks rms {rms:.2}, at most {most:.2}; squared relative bias {bias2:.2e} ± {se:.2e}"
            );
        }
        assert!(near.rms < 2.5, "{name}: z {}", near.rms);
        // 10⁻³ is 3 % of a block.
        assert!(near.bias2.0 < 0.5 * far.bias2.0 + 1e-3, "{name}: the bias does not shrink");
        // The walls' own photons over the walls' own area have no bias, whatever the radius.
        assert!(name == "furnace" || far.rms > 2.5, "{name}: no bias is seen, so that none can shrink");
    }
}
