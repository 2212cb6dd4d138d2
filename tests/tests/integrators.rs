//! Integrators against closed forms, each other and themselves on another device. Seeds are fixed; bounds are 4 standard errors.

use caustic_device::Device;
use caustic_photon_map::{Filter, Hash, Surface};
use caustic_renderer::output::Image;
use caustic_renderer::scene::Scene;
use caustic_renderer::{Given, Integrator, ProgressState, Rendered, Settings, Show, Stop, render_on};
use caustic_tests::renders::*;
use caustic_tests::{assert_same_words, gpu};
use std::f64::consts::PI;

fn passes(passes: u32) -> Stop {
    Stop { passes: Some(passes), ..Stop::default() }
}

/// Radiance of the scene `plane`: ρ/π·I·h / (d² + h²)^(3/2) with I = 1 and h = 1.
fn plane([x, z]: [f64; 2]) -> f64 {
    REFLECTANCE / PI * (x * x + z * z + 1.0).powf(-1.5)
}

/// The means of pictures of several seeds, over what they should be.
fn ratios(scene: &Scene, settings: &Settings, seeds: u32, expected: f64) -> (f64, f64) {
    let of_seed = |seed| mean_rgb(&image(scene, &Settings { seed, ..settings.clone() }, &Device::cpu()))[1] / expected;
    mean_and_error(&(0..seeds).map(of_seed).collect::<Vec<_>>())
}

/// The furnace is 1 everywhere, and what an integrator leaves out is known: paths leave out nothing, direct light has the
/// walls' own ½ and the ¼ that they light each other with.
#[test]
fn the_furnace_is_as_bright_as_each_integrator_should_see_it() {
    let scene = load("furnace");
    let base = Settings { size: [24, 24], spp: 8, surface: Surface::Own, ..Settings::of(&scene) };
    let progressive = Settings { photons: 20_000, radius: 0.2, stop: passes(4), spp: 2, ..base.clone() };
    for (name, expected, settings) in [
        ("path", 1.0, Settings { integrator: Integrator::Path, ..base.clone() }),
        ("direct", 0.75, Settings { integrator: Integrator::Direct, spp: 256, ..base.clone() }),
        ("photon", 1.0, Settings { photons: 100_000, spp: 32, ..base.clone() }),
        ("progressive", 1.0, Settings { integrator: Integrator::Progressive, ..progressive.clone() }),
        ("final gather", 1.0, Settings { photons: 50_000, final_gather: 4, spp: 16, ..base.clone() }),
    ] {
        let (mean, se) = ratios(&scene, &settings, 6, expected);
        println!("{name}: {mean:.5}, SE {se:.5}");
        // Where pictures are exact but for rounding, the scatter says nothing of the rounding.
        assert!((mean - 1.0).abs() < 4.0 * se + 1e-5 && se < 5e-3, "{name}: {mean} ± {se}");
    }
}

#[test]
fn paths_below_a_point_light_are_the_closed_form() {
    let scene = load("plane");
    let settings = Settings { size: [32, 32], spp: 16, integrator: Integrator::Path, ..small(&scene) };
    let camera = scene.camera(32, 32);
    let picture = image(&scene, &settings, &Device::cpu());
    let errors: Vec<f64> = (0..32 * 32)
        .map(|i| {
            let parts = (0..16).map(|part| {
                let at = |i: u32, part: u32| f64::from(i) + (f64::from(part) + 0.5) / 4.0;
                plane(on_floor(&camera, at(i % 32, part % 4), at(i / 32, part / 4)))
            });
            f64::from(picture.rgb[i as usize][1]) / (parts.sum::<f64>() / 16.0) - 1.0
        })
        .collect();
    let (error, se) = mean_and_error(&errors);
    println!("path, point light: {error:.2e}, SE {se:.2e}");
    assert!(error.abs() < 4.0 * se + 1e-4, "{error} ± {se}");
}

/// Mean squared error of progressive renders of the point light's plane after some passes, against the closed form.
fn mse(alpha: f32, passes_wanted: [u32; 2]) -> [f64; 2] {
    const SIDE: u32 = 24;
    const SEEDS: u32 = 3;
    let scene = load("plane");
    let camera = scene.camera(SIDE, SIDE);
    let exact: Vec<f64> = (0..SIDE * SIDE)
        .map(|i| {
            let parts = (0..16).map(|part| {
                let at = |i: u32, part: u32| f64::from(i) + (f64::from(part) + 0.5) / 4.0;
                plane(on_floor(&camera, at(i % SIDE, part % 4), at(i / SIDE, part / 4)))
            });
            parts.sum::<f64>() / 16.0
        })
        .collect();
    let error = |picture: &Image| {
        let squares = picture.rgb.iter().zip(&exact).map(|(rgb, exact)| (f64::from(rgb[1]) / exact - 1.0).powi(2));
        squares.sum::<f64>() / exact.len() as f64
    };
    let mut sums = [0.0; 2];
    for seed in 0..SEEDS {
        let settings = Settings {
            size: [SIDE; 2],
            photons: 4000,
            spp: 1,
            radius: 0.35,
            seed,
            alpha,
            show: Show::MapGlobal,
            integrator: Integrator::Progressive,
            stop: passes(passes_wanted[1]),
            ..small(&scene)
        };
        let mut first = 0.0;
        let last = render_on(&scene, &settings, &Device::cpu(), Given::default(), &mut |_| true, &mut |state| {
            if state.passes() == passes_wanted[0] {
                first = error(&state.image());
            }
            Ok(())
        });
        sums[0] += first / f64::from(SEEDS);
        sums[1] += error(&last.unwrap().image) / f64::from(SEEDS);
    }
    sums
}

/// MSE ~ N^(−2/3) at α = 2/3: the variance falls as N^−α and the squared bias as N^(−2(1 − α)), here both with the power 2/3 (Knaus and
/// Zwicker 2011, section 4). From 8 to 128 passes; the MSE of 576 pixels whose discs overlap, over three seeds, is known to
/// about 15 %, which is ln 1.15 / ln 16 = 0.05 a power: two of them for both ends. The first passes' radii, not yet a power of their number, are 0.02
/// of it. At α = 0.95 nearly every pass counts alike, and the variance, here most of the error, falls as N^−0.95.
#[test]
fn progressive_renders_converge_as_fast_as_theory_says() {
    let slope = |alpha| {
        let [first, last] = mse(alpha, [8, 128]);
        let slope = (last / first).ln() / 16f64.ln();
        println!("alpha {alpha}: MSE {first:.3e} after 8 passes, {last:.3e} after 128: slope {slope:.3}");
        slope
    };
    let published = slope(2.0 / 3.0);
    assert!((published + 2.0 / 3.0).abs() < 0.12, "{published}");
    assert!(slope(0.95) < -0.79, "another schedule has the same slope");
}

#[test]
fn a_render_that_goes_on_has_the_bits_of_one_that_never_stopped() {
    let scene = load("cornell");
    for integrator in [Integrator::Progressive, Integrator::Path, Integrator::Photon] {
        let settings = |n| Settings { integrator, stop: passes(n), ..small(&scene) };
        let whole = run(&scene, &settings(5), &Device::cpu());
        let mut kept: Option<ProgressState> = None;
        let mut keep = |state: &ProgressState| {
            kept = Some(state.clone());
            Ok(())
        };
        render_on(&scene, &settings(2), &Device::cpu(), Given::default(), &mut |_| true, &mut keep).unwrap();
        let start = kept.take();
        assert_eq!(start.as_ref().map(ProgressState::passes), Some(2));
        let went_on = render_on(
            &scene,
            &settings(5),
            &Device::cpu(),
            Given { passes: start, ..Given::default() },
            &mut |_| true,
            &mut |_| Ok(()),
        )
        .unwrap();
        assert_same_words("went on", floats(&whole.image), floats(&went_on.image));
        assert_eq!((whole.report.passes, went_on.report.passes), (5, 5));
        assert_eq!(whole.report.photons_emitted, went_on.report.photons_emitted);
    }
}

#[test]
fn an_interrupted_render_keeps_the_passes_that_are_finished() {
    let scene = load("cornell");
    let settings = Settings { integrator: Integrator::Progressive, stop: passes(1000), ..small(&scene) };
    let done = std::cell::Cell::new(0);
    let stopped =
        render_on(&scene, &settings, &Device::cpu(), Given::default(), &mut |_| done.get() < 3, &mut |state| {
            done.set(state.passes());
            Ok(())
        });
    let Rendered { image: stopped, report, .. } = stopped.unwrap();
    assert_eq!((report.passes, report.complete, report.stopped_by), (3, false, "interrupted"));
    let three = image(&scene, &Settings { stop: passes(3), ..settings }, &Device::cpu());
    assert_same_words("three passes", floats(&stopped), floats(&three));
}

#[test]
fn renders_stop_where_they_are_told_to() {
    let scene = load("furnace");
    let base = Settings { integrator: Integrator::Progressive, size: [8, 8], ..small(&scene) };
    let stopped = |stop: Stop| {
        let report = run(&scene, &Settings { stop, ..base.clone() }, &Device::cpu()).report;
        (report.stopped_by, report.passes, report.noise)
    };
    let none = Stop::default();
    assert_eq!(stopped(Stop { photons: Some(7000), ..none }).1, 3, "3000 photons a pass");
    assert_eq!(stopped(Stop { seconds: Some(1e-9), ..none }).0, "time");
    let (why, passes, noise) = stopped(Stop { error: Some(1e-2), passes: Some(5000), ..none });
    println!("{passes} passes for a noise of {noise:?}");
    assert!(why == "error" && noise.is_some_and(|noise| noise <= 1e-2) && passes > 2);
}

/// The radius that is found holds k photons at half of the points, or at nearly all.
#[test]
fn an_automatic_radius_says_where_it_comes_from() {
    let scene = load("cornell");
    for (integrator, share) in [(Integrator::Progressive, "50 %"), (Integrator::Photon, "95 %")] {
        let settings =
            Settings { integrator, automatic_radius: true, photons: 20_000, k: 50, stop: passes(1), ..small(&scene) };
        let report = run(&scene, &settings, &Device::cpu()).report;
        println!("{}", report.notes[0]);
        assert!(report.notes[0].starts_with("radius ") && report.notes[0].contains(share), "{:?}", report.notes);
        // 50 of some 40,000 stored photons on 24 m² or so would, evenly spread, fill discs of 0.1 m.
        assert!((0.03..0.5).contains(&report.radius_m), "{}", report.radius_m);
    }
}

#[test]
fn every_integrator_makes_the_same_picture_on_a_gpu() {
    let Some(gpu) = gpu() else { return };
    let scene = load("cornell");
    let base = Settings { size: [20, 16], stop: passes(2), ..small(&scene) };
    let progressive = Settings { integrator: Integrator::Progressive, ..base.clone() };
    for (name, settings) in [
        ("path", Settings { integrator: Integrator::Path, ..base.clone() }),
        ("progressive", progressive.clone()),
        ("progressive, cone, own", Settings { filter: Filter::Cone, surface: Surface::Own, ..progressive.clone() }),
        (
            "photon, Gaussian, facing, Morton",
            Settings { filter: Filter::Gaussian, surface: Surface::Facing, hash: Hash::Morton, ..base.clone() },
        ),
        (
            "final gather, Epanechnikov",
            Settings { final_gather: 4, filter: Filter::Epanechnikov, surface: Surface::Own, ..base.clone() },
        ),
        ("automatic radius", Settings { automatic_radius: true, k: 20, ..progressive }),
    ] {
        let (a, b) = (run(&scene, &settings, &Device::cpu()), run(&scene, &settings, gpu));
        assert_same_words(name, floats(&a.image), floats(&b.image));
        println!("{name}: {} floats are the same", floats(&a.image).len());
    }
}
