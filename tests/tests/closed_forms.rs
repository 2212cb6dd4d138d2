//! Direct light and photon maps against closed forms.
//!
//! Seeds are fixed, so no test fails by chance. Statistical bounds are 4 standard errors (SE) plus, where the photon map
//! has one, the bias that is worked out beside the test.

use caustic_device::Device;
use caustic_kernels::trace::Camera;
use caustic_renderer::output::Image;
use caustic_renderer::scene::Scene;
use caustic_renderer::{Settings, Show};
use caustic_tests::renders::*;
use std::f64::consts::PI;

/// Irradiance of the scene `plane`, I·h / (d² + h²)^(3/2) with I = 1 and h = 1.
fn under_point([x, z]: [f64; 2]) -> f64 {
    (x * x + z * z + 1.0).powf(-1.5)
}

/// Irradiance of [`LAMP`]: π·L times the form factor of a rectangle parallel to a small area, put together from four with a
/// corner above it (Siegel and Howell, "Thermal Radiation Heat Transfer", configuration 3).
fn under_lamp([x, z]: [f64; 2]) -> f64 {
    let corner = |a: f64, b: f64| {
        let (p, q) = (a.hypot(1.0), b.hypot(1.0));
        (a / p * (b / p).atan() + b / q * (a / q).atan()) / (2.0 * PI)
    };
    let [u0, u1, v0, v1] = [-0.5 - x, 0.5 - x, -0.5 - z, 0.5 - z];
    4.0 * PI * (corner(u1, v1) - corner(u0, v1) - corner(u1, v0) + corner(u0, v0))
}

/// The mean of `f` over the middles of `n` × `n` parts of the pixel whose top left corner is (x, y).
fn pixel_mean(camera: &Camera, x: u32, y: u32, n: u32, f: fn([f64; 2]) -> f64) -> f64 {
    let part = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
    let parts = (0..n * n).map(|i| f(on_floor(camera, f64::from(x) + part(i % n), f64::from(y) + part(i / n))));
    parts.sum::<f64>() / f64::from(n * n)
}

#[test]
fn the_form_factor_is_the_integral_it_stands_for() {
    let n = 400;
    for at in [[0.0, 0.0], [0.3, -0.9], [1.0, 1.0]] {
        let part = |i: i32| (f64::from(i) + 0.5) / f64::from(n) - 0.5;
        let kernel = |i: i32| {
            let (dx, dz) = (part(i % n) - at[0], part(i / n) - at[1]);
            // L·cos θ·cos θ' / d², both cosines being h / d.
            4.0 / (dx * dx + dz * dz + 1.0).powi(2)
        };
        let integral = (0..n * n).map(kernel).sum::<f64>() / f64::from(n * n);
        assert!((under_lamp(at) / integral - 1.0).abs() < 1e-5, "{at:?}: {} and {integral}", under_lamp(at));
    }
}

/// Checks a picture of `plane` made with 16 samples a pixel, `direct` light alone.
///
/// The samples are a (0, 2)-sequence: one in each of 4 × 4 parts of the pixel. So a pixel is at least the mean of the
/// parts' least values and at most that of their greatest, which are at their corners, since the foot of the light is one:
/// no statistics, only the rounding of f32.
fn check_plane(scene: &Scene, picture: &Image) -> Result<f64, String> {
    const ROUNDING: f64 = 2e-6;
    let camera = scene.camera(picture.width, picture.height);
    let mut widest: f64 = 0.0;
    for (i, pixel) in (0..).zip(&picture.rgb) {
        let (x, y) = (f64::from(i % picture.width), f64::from(i / picture.width));
        let (mut least, mut most) = (0.0, 0.0);
        for part in 0..16 {
            let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| {
                let at = |i: i32| f64::from(i) / 4.0;
                REFLECTANCE / PI * under_point(on_floor(&camera, x + at(part % 4 + dx), y + at(part / 4 + dy)))
            });
            least += corners.iter().copied().fold(f64::MAX, f64::min) / 16.0;
            most += corners.iter().copied().fold(f64::MIN, f64::max) / 16.0;
        }
        widest = widest.max(most / least - 1.0);
        let (least, most) = (least * (1.0 - ROUNDING), most * (1.0 + ROUNDING));
        if pixel.iter().any(|&value| !(least..=most).contains(&f64::from(value))) {
            return Err(format!("pixel {x}, {y} is {pixel:?}, not from {least} to {most}"));
        }
    }
    Ok(widest)
}

/// Checks that the mean of a picture is that of a closed form: the errors of the pixels are independent and have the
/// mean 0, so their scatter gives the standard error of their mean.
fn check_mean(scene: &Scene, picture: &Image, irradiance: fn([f64; 2]) -> f64) -> Result<String, String> {
    let camera = scene.camera(picture.width, picture.height);
    let pixels = (0..).zip(&picture.rgb);
    let errors: Vec<f64> = pixels
        .map(|(i, pixel)| {
            let exact = pixel_mean(&camera, i % picture.width, i / picture.width, 8, irradiance);
            f64::from(pixel[1]) / (REFLECTANCE / PI * exact) - 1.0
        })
        .collect();
    let (error, se) = mean_and_error(&errors);
    let text = format!("relative error of the mean {error:.2e}, SE {se:.2e}");
    if error.abs() < 4.0 * se && se < 1e-3 { Ok(text) } else { Err(text) }
}

#[test]
fn direct_light_of_a_point_light_is_the_closed_form() {
    let scene = load("plane");
    let settings = Settings { size: [64, 64], spp: 16, show: Show::Direct, ..small(&scene) };
    let picture = image(&scene, &settings, &Device::cpu());
    let widest = check_plane(&scene, &picture).unwrap();
    assert!(widest < 0.05, "the bounds are {widest} apart: they bind nothing");
    println!("point light: bounds at most {widest:.3} apart, {}", check_mean(&scene, &picture, under_point).unwrap());
    let doubled = Image { rgb: picture.rgb.iter().map(|rgb| rgb.map(|x| x * 1.05)).collect(), ..picture };
    assert!(check_plane(&scene, &doubled).is_err());
    assert!(check_mean(&scene, &doubled, under_point).is_err());
}

#[test]
fn direct_light_of_an_area_light_is_the_closed_form() {
    let scene = parse(LAMP);
    let settings = Settings { size: [64, 64], spp: 16, show: Show::Direct, ..small(&scene) };
    let picture = image(&scene, &settings, &Device::cpu());
    println!("area light: {}", check_mean(&scene, &picture, under_lamp).unwrap());
    let brighter = Image { rgb: picture.rgb.iter().map(|rgb| rgb.map(|x| x * 1.005)).collect(), ..picture };
    assert!(check_mean(&scene, &brighter, under_lamp).is_err());
}

/// Checks the density estimate from a whole photon map against a closed form, over the middle 48 × 48 of 64 × 64 pixels.
///
/// Estimates that share photons are correlated, so the error of their mean is not 1/√k over the root of their number. To
/// first order the mean of all estimates changes with the number of photons that land in the region, N: its relative
/// standard error is 1/√N. N follows from the closed form: the flux there over the power of a photon.
///
/// The bias of an estimate over a disc of radius r is r²/8·∇²E to second order; with r² = k·p/(π·E) it is below
/// `bias_bound`, which is the mean over the region, by finite differences.
///
/// Estimates themselves scatter by 1/√(k − 1): r² of the (k + 1)-th photon has a gamma distribution.
fn check_density(scene: &Scene, power: f64, irradiance: fn([f64; 2]) -> f64) -> Result<String, String> {
    const K: u32 = 100;
    const PHOTONS: u32 = 400_000;
    const SEEDS: u32 = 4;
    const MIDDLE: std::ops::Range<u32> = 8..56;
    let camera = scene.camera(64, 64);
    let photon = power / f64::from(PHOTONS);
    let at = |i: u32| on_floor(&camera, f64::from(i % 64) + 0.5, f64::from(i / 64) + 0.5);
    let middle: Vec<u32> = (0..64 * 64).filter(|i| MIDDLE.contains(&(i % 64)) && MIDDLE.contains(&(i / 64))).collect();
    let exact: Vec<f64> = middle.iter().map(|&i| pixel_mean(&camera, i % 64, i / 64, 4, irradiance)).collect();

    let pixel_side = at(1)[0] - at(0)[0];
    let landed = exact.iter().sum::<f64>() * pixel_side * pixel_side / photon;
    let se = 1.0 / (landed * f64::from(SEEDS)).sqrt();
    let bias_of = |&i: &u32| {
        let ([x, z], step) = (at(i), 1e-3);
        let sum: f64 = [[x + step, z], [x - step, z], [x, z + step], [x, z - step]].map(irradiance).iter().sum();
        let here = irradiance([x, z]);
        let laplacian = (sum - 4.0 * here) / (step * step);
        f64::from(K) * photon / (PI * here) / 8.0 * laplacian
    };
    let bias = middle.iter().map(bias_of).sum::<f64>() / exact.iter().sum::<f64>();
    let bias_bound = 1.5 * bias.abs();

    let mut ratios = Vec::new();
    let mut squares = Vec::new();
    for seed in 0..SEEDS {
        let settings = Settings {
            size: [64, 64],
            photons: PHOTONS,
            k: K,
            radius: 0.4,
            spp: 1,
            seed,
            show: Show::MapGlobal,
            ..small(scene)
        };
        let picture = image(scene, &settings, &Device::cpu());
        let found = |&i: &u32| f64::from(picture.rgb[i as usize][1]) * PI / REFLECTANCE;
        ratios.push(middle.iter().map(found).sum::<f64>() / exact.iter().sum::<f64>());
        squares.extend(middle.iter().zip(&exact).map(|(i, exact)| (found(i) / exact - 1.0).powi(2)));
    }
    let error = mean(&ratios) - 1.0;
    let scatter = mean(&squares).sqrt() * f64::from(K - 1).sqrt();
    let text = format!(
        "relative error of the mean {error:.2e}, SE {se:.2e} from {landed:.0} photons, bias {bias:.2e}; seeds {ratios:.4?}; \
         scatter of estimates {scatter:.3}/√(k − 1)"
    );
    // The bias adds to the scatter, and 4 · 2304 correlated pixels give it to a few percent.
    let fine = error.abs() < 4.0 * se + bias_bound && (0.9..1.1).contains(&scatter);
    if fine { Ok(text) } else { Err(text) }
}

#[test]
fn the_photon_map_of_a_point_light_is_the_closed_form() {
    let scene = load("plane");
    // 4π·I, half of which goes upwards and misses.
    println!("point light, map: {}", check_density(&scene, 4.0 * PI, under_point).unwrap());
    let bounced = check_density(&scene, 4.0 * PI, |at| under_point(at) * 1.02);
    println!("a fault of 2 %: {}", bounced.unwrap_err());
}

#[test]
fn the_photon_map_of_an_area_light_is_the_closed_form() {
    // π·L·A.
    println!("area light, map: {}", check_density(&parse(LAMP), 4.0 * PI, under_lamp).unwrap());
}
