//! The layer that estimates the bias of a picture: against closed forms, and against what it is for.

use caustic_device::Device;
use caustic_photon_map::{Filter, Surface};
use caustic_renderer::output::LayerKind;
use caustic_renderer::{Integrator, Rendered, Settings, Show, Stop};
use caustic_tests::renders::*;
use caustic_tests::{assert_same_words, gpu};
use std::f64::consts::{PI, SQRT_2};

const SIDE: u32 = 24;
const SEEDS: u32 = 16;

/// Irradiance at the squared distance `s2` from the point below a light of intensity 1 at height 1.
fn irradiance(s2: f64) -> f64 {
    (s2 + 1.0).powf(-1.5)
}

/// Its Laplacian.
fn laplacian(s2: f64) -> f64 {
    (9.0 * s2 - 6.0) * (s2 + 1.0).powf(-3.5)
}

/// What a filter of radius `r` makes of the irradiance at the distance `s`, by midpoints: ∫ w·E dA / ∫ w dA.
fn blurred(s: f64, r: f64, weight: fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 40;
    let (mut sum, mut area) = (0.0, 0.0);
    for i in 0..STEPS {
        // Rings of equal area.
        let x = (f64::from(i) + 0.5) / f64::from(STEPS);
        for j in 0..STEPS {
            let (sin, cos) = ((f64::from(j) + 0.5) / f64::from(STEPS) * 2.0 * PI).sin_cos();
            let d = r * x.sqrt();
            sum += weight(x) * irradiance((s + d * cos).powi(2) + (d * sin).powi(2));
            area += weight(x);
        }
    }
    sum / area
}

/// Each pixel's distance from the middle of the plane.
fn distances(size: u32) -> Vec<f64> {
    let camera = load("plane").camera(size, size);
    let at = |i: u32| on_floor(&camera, f64::from(i % size) + 0.5, f64::from(i / size) + 0.5);
    (0..size * size).map(|i| at(i)[0].hypot(at(i)[1])).collect()
}

/// Pictures of the plane's photons with the layer, of as many seeds.
fn pictures(settings: &Settings) -> Vec<Rendered> {
    let scene = load("plane");
    let of = |seed| run(&scene, &Settings { seed, ..settings.clone() }, &Device::cpu());
    (0..SEEDS).map(of).collect()
}

/// Green of the layer.
fn bias(rendered: &Rendered) -> Vec<f64> {
    let layer = rendered.layers.iter().find(|layer| layer.kind == LayerKind::Bias).expect("the layer");
    layer.values.iter().skip(1).step_by(3).map(|&value| f64::from(value)).collect()
}

/// Green of the picture.
fn green(rendered: &Rendered) -> Vec<f64> {
    rendered.image.rgb.iter().map(|rgb| f64::from(rgb[1])).collect()
}

/// Σ a·b over Σ b²: how many times `b` is in `a`.
fn share(a: &[f64], b: &[f64]) -> f64 {
    let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    product / b.iter().map(|b| b * b).sum::<f64>()
}

fn plane(radius: f32) -> Settings {
    Settings {
        size: [SIDE; 2],
        photons: 100_000,
        spp: 1,
        radius,
        show: Show::MapGlobal,
        integrator: Integrator::Progressive,
        stop: Stop { passes: Some(1), ..Stop::default() },
        layers: vec![LayerKind::Bias],
        ..Settings::of(&load("plane"))
    }
}

/// The layer is what it is by its definition, and that is the bias, and both are the Laplacian's: of each filter.
#[test]
fn below_a_point_light_the_layer_is_the_bias_that_the_laplacian_makes() {
    let radius = 0.35;
    let scale = REFLECTANCE / PI;
    let distances = distances(SIDE);
    let all = |of: &dyn Fn(f64) -> f64| distances.iter().map(|&s| scale * of(s)).collect::<Vec<f64>>();
    // c of c·r²·ΔE: a quarter of the weighted mean of x = d²/r².
    for (filter, weight, c) in [
        (Filter::Constant, (|_| 1.0) as fn(f64) -> f64, 1.0 / 8.0),
        (Filter::Epanechnikov, |x| 1.0 - x, 1.0 / 12.0),
        (Filter::Cone, |x: f64| 1.0 - x.sqrt(), 3.0 / 40.0),
    ] {
        let defined = all(&|s| 2.0 * (blurred(s, radius, weight) - blurred(s, radius / SQRT_2, weight)));
        let truth = all(&|s| blurred(s, radius, weight) - irradiance(s * s));
        let by_laplacian = all(&|s| c * radius * radius * laplacian(s * s));
        let settings = Settings { filter, ..plane(radius as f32) };
        let shares: Vec<f64> = pictures(&settings).iter().map(|one| share(&bias(one), &defined)).collect();
        let (found, se) = mean_and_error(&shares);
        let (method, order) = (share(&defined, &truth), share(&by_laplacian, &truth));
        println!(
            "{filter:?}: the layer is {found:.3} ± {se:.3} of its definition, that {method:.3} of the bias, c·r²·ΔE {order:.3}"
        );
        assert!((found - 1.0).abs() < 4.0 * se && se < 0.08, "{filter:?}: {found} ± {se}");
        // What is left are terms of r⁴: by quadrature, without noise.
        assert!((method - 1.0).abs() < 0.08 && (order - 1.0).abs() < 0.12, "{filter:?}: {method}, {order}");
    }
}

/// From the k nearest photons, whose discs are as large as photons are sparse: of N photons that leave the light, k + 1 fall into a disc of the mean
/// irradiance Ē if π·r²·Ē·N/Φ is that, with Φ = 4π.
#[test]
fn estimates_from_the_k_nearest_know_their_bias_too() {
    let settings = Settings { k: 1023, radius: 1.0, photons: 50_000, integrator: Integrator::Photon, ..plane(1.0) };
    let reach = |s: f64| {
        let mut r: f64 = 0.3;
        for _ in 0..30 {
            r = (1024.0 * 4.0 / (f64::from(settings.photons) * blurred(s, r, |_| 1.0))).sqrt();
        }
        r
    };
    // Farther out photons are so sparse that the radius is too large to be told of by a Laplacian.
    let inner: Vec<usize> = (0..(SIDE * SIDE) as usize).filter(|&i| distances(SIDE)[i] < 1.0).collect();
    let at = |of: &dyn Fn(f64) -> f64| inner.iter().map(|&i| of(distances(SIDE)[i])).collect::<Vec<f64>>();
    let expected = at(&|s| {
        let r = reach(s);
        REFLECTANCE / PI * 2.0 * (blurred(s, r, |_| 1.0) - blurred(s, r / SQRT_2, |_| 1.0))
    });
    let one = |rendered: &Rendered| {
        let all = bias(rendered);
        share(&inner.iter().map(|&i| all[i]).collect::<Vec<_>>(), &expected)
    };
    let (found, se) = mean_and_error(&pictures(&settings).iter().map(one).collect::<Vec<_>>());
    println!("k nearest: the layer is {found:.3} ± {se:.3} of what discs of their mean radius make");
    // The half's disc of 512 photons is not half of that of 1024 each time, only in the mean: 1/√512 of the radius.
    assert!((found - 1.0).abs() < 4.0 * se + 0.05 && se < 0.1, "{found} ± {se}");
}

/// Taken off, the layer makes the picture better in the mean.
#[test]
fn a_picture_without_its_bias_is_nearer_to_the_truth() {
    let truth: Vec<f64> = distances(SIDE).iter().map(|s| REFLECTANCE / PI * irradiance(s * s)).collect();
    let pictures = pictures(&plane(0.35));
    // Squared bias without its own noise.
    let squares = |of: &dyn Fn(&Rendered) -> Vec<f64>| {
        let all: Vec<Vec<f64>> = pictures.iter().map(of).collect();
        let square = |i: usize| {
            let (mean, se) = mean_and_error(&all.iter().map(|one| one[i]).collect::<Vec<_>>());
            (mean - truth[i]).powi(2) - se * se
        };
        mean(&(0..truth.len()).map(square).collect::<Vec<_>>())
    };
    let better = |one: &Rendered| green(one).iter().zip(bias(one)).map(|(value, bias)| value - bias).collect();
    let (before, after) = (squares(&green), squares(&better));
    println!("squared bias {before:.3e}, without the layer {after:.3e}");
    assert!(after.abs() < 0.15 * before, "{before}, {after}");
}

/// The halves of a disc are independent, so 2·(A + B)/2a − 2·A/a has four times the variance of (A + B)/2a: the layer is twice as noisy as the
/// picture. Pixels are so small that the places of samples within them do not show.
#[test]
fn the_layer_is_twice_as_noisy_as_the_picture() {
    let settings = Settings { size: [96; 2], photons: 20_000, ..plane(0.35) };
    let pictures = pictures(&settings);
    let noise = |of: &dyn Fn(&Rendered) -> Vec<f64>| {
        let all: Vec<Vec<f64>> = pictures.iter().map(of).collect();
        let square = |i: usize| mean_and_error(&all.iter().map(|one| one[i]).collect::<Vec<_>>()).1.powi(2);
        (0..96 * 96).map(square).sum::<f64>().sqrt()
    };
    let ratio = noise(&bias) / noise(&green);
    println!("the layer is {ratio:.3} times as noisy as the picture");
    assert!((ratio - 2.0).abs() < 0.15, "{ratio}");
}

/// Where light is even there is no bias, at edges and in corners as well if the surface is known; if it is not, the layer sees that edges are too bright.
#[test]
fn a_furnace_has_bias_at_its_edges_alone_and_none_with_its_own_surfaces() {
    let scene = load("furnace");
    let base = Settings { size: [SIDE; 2], spp: 4, show: Show::MapGlobal, ..plane(0.2) };
    let of = |surface: Surface| {
        let mean_of = |seed: u32| {
            let settings = Settings { seed, surface, ..base.clone() };
            mean(&bias(&run(&scene, &settings, &Device::cpu())))
        };
        mean_and_error(&(0..8).map(mean_of).collect::<Vec<_>>())
    };
    let ((own, own_se), (any, any_se)) = (of(Surface::Own), of(Surface::Any));
    println!(
        "furnace, mean of the layer: {own:.5} ± {own_se:.5} with its own surfaces, {any:.5} ± {any_se:.5} with any"
    );
    assert!(own.abs() < 4.0 * own_se && own_se < 2e-3, "{own} ± {own_se}");
    assert!(any > 4.0 * any_se, "{any} ± {any_se}");
}

#[test]
fn passes_add_up_and_a_gpu_has_the_same_bits() {
    let scene = load("cornell");
    let settings = Settings {
        integrator: Integrator::Progressive,
        surface: Surface::Own,
        stop: Stop { passes: Some(2), ..Stop::default() },
        layers: vec![LayerKind::Variance, LayerKind::Bias],
        size: [20, 15],
        ..small(&scene)
    };
    let ours = run(&scene, &settings, &Device::cpu());
    let variance = &ours.layers[0].values;
    assert!(variance.iter().any(|&value| value > 0.0) && bias(&ours).iter().any(|&value| value != 0.0));
    // One pass is its own layer, and the second has another radius and seed.
    let one = run(
        &scene,
        &Settings {
            stop: Stop { passes: Some(1), ..Stop::default() },
            layers: vec![LayerKind::Bias],
            ..settings.clone()
        },
        &Device::cpu(),
    );
    assert!(bias(&one) != bias(&ours));
    let Some(gpu) = gpu() else { return };
    let theirs = run(&scene, &settings, gpu);
    for (a, b) in ours.layers.iter().zip(&theirs.layers) {
        assert_same_words(a.kind.name(), &a.values, &b.values);
    }
}
