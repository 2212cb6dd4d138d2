//! Whole renders: closed forms, a furnace, a reference made by other programs, and the same bits every time.
//!
//! Seeds are fixed, so no test fails by chance. Statistical bounds are 4 standard errors (SE) plus, where the photon map
//! has one, the bias that is worked out beside the test.

use caustic_device::{Device, LaneOrder};
use caustic_kernels::trace::Camera;
use caustic_photon_map::{Gather, Hash};
use caustic_renderer::output::{self, Image, Metadata};
use caustic_renderer::scene::Scene;
use caustic_renderer::{RenderError, Rendered, Settings, Show, render};
use caustic_tests::{assert_same_words, compare_words, gpu};
use std::f64::consts::PI;
use std::path::Path;

/// A square lamp of side 1 and radiance 4, 1 m above a plane of reflectance 0.5, with the camera between them: it sees
/// x and z from −1 to 1.
const LAMP: &str = r#"
[camera]
position = [0, 0.75, 0]
target = [0, 0, 0]
up = [0, 0, -1]
vertical_fov_degrees = 106.26020470831196

[materials.grey]
kind = "lambertian"
reflectance = [0.5, 0.5, 0.5]

[[quads]]
corner = [-50, 0, -50]
edge_u = [0, 0, 100]
edge_v = [100, 0, 0]
material = "grey"

[[quads]]
name = "lamp"
corner = [-0.5, 1, -0.5]
edge_u = [1, 0, 0]
edge_v = [0, 0, 1]
radiance = [4, 4, 4]
"#;

/// Reflectance of the planes.
const REFLECTANCE: f64 = 0.5;

fn load(name: &str) -> Scene {
    Scene::load(name).expect("a built-in scene")
}

fn parse(text: &str) -> Scene {
    Scene::parse("test.toml", text).expect("a scene")
}

/// Cheap settings for a scene, to be changed where a test needs more.
fn small(scene: &Scene) -> Settings {
    Settings { size: [48, 32], photons: 3000, caustic_photons: 1500, k: 50, radius: 0.2, spp: 2, ..Settings::of(scene) }
}

fn run(scene: &Scene, settings: &Settings, device: &Device) -> Rendered {
    render(scene, settings, device, &mut |_| true).expect("a render")
}

fn image(scene: &Scene, settings: &Settings, device: &Device) -> Image {
    let rendered = run(scene, settings, device);
    assert!(rendered.report.complete);
    rendered.image
}

/// The picture's floats, three a pixel.
fn floats(image: &Image) -> &[f32] {
    image.rgb.as_flattened()
}

fn mean_rgb(image: &Image) -> [f64; 3] {
    let n = image.rgb.len() as f64;
    std::array::from_fn(|c| image.rgb.iter().map(|rgb| f64::from(rgb[c])).sum::<f64>() / n)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The mean of independent values and its standard error, from their scatter.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let mean = mean(values);
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    let n = values.len() as f64;
    (mean, (squares / (n - 1.0) / n).sqrt())
}

/// Origin and direction of the camera's ray through a point of the film, in pixels.
fn ray(camera: &Camera, x: f64, y: f64) -> ([f64; 3], [f64; 3]) {
    let at = |axis| {
        let [corner, right, down] = [camera.corner, camera.right, camera.down].map(|v: [f32; 3]| f64::from(v[axis]));
        corner + right * x + down * y
    };
    (camera.origin.map(f64::from), [at(0), at(1), at(2)])
}

/// Where the ray through a point of the film meets the plane y = 0.
fn on_floor(camera: &Camera, x: f64, y: f64) -> [f64; 2] {
    let (origin, direction) = ray(camera, x, y);
    let t = -origin[1] / direction[1];
    [origin[0] + t * direction[0], origin[2] + t * direction[2]]
}

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

/// The wall of the furnace, the box from −1 to 1, that the camera sees through a point of the film, and where.
fn on_wall(camera: &Camera, x: f64, y: f64) -> [f64; 3] {
    let (origin, direction) = ray(camera, x, y);
    let reach = |axis: usize| (direction[axis].signum() - origin[axis]) / direction[axis];
    let t = (0..3).map(reach).fold(f64::MAX, f64::min);
    std::array::from_fn(|axis| origin[axis] + t * direction[axis])
}

/// Area of the walls of the furnace within `radius` of a point on one of them.
fn wall_area(at: [f64; 3], radius: f64) -> f64 {
    let clipped_disc = |radius2: f64, u: f64, v: f64| {
        const STEPS: u32 = 48;
        let radius = radius2.sqrt();
        let step = 2.0 * radius / f64::from(STEPS);
        let strip = |i: u32| {
            let du = -radius + (f64::from(i) + 0.5) * step;
            let chord = (radius2 - du * du).sqrt();
            if (u + du).abs() > 1.0 { 0.0 } else { (v + chord).min(1.0) - (v - chord).max(-1.0) }
        };
        step * (0..STEPS).map(strip).sum::<f64>()
    };
    let mut area = 0.0;
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let height = at[axis] - side;
            let radius2 = radius * radius - height * height;
            if radius2 > 0.0 {
                area += clipped_disc(radius2, at[(axis + 1) % 3], at[(axis + 2) % 3]);
            }
        }
    }
    area
}

/// What the estimate at a point of the furnace is expected to be, as a multiple of the truth: photons are spread evenly over
/// the walls, and the estimate takes the walls within its radius for a disc. At an edge there are two half discs, as much
/// as a disc, half a radius from it 18 % more, and in a corner three quarters.
fn boundary_bias(at: [f64; 3], radius: f64) -> f64 {
    let (mut low, mut high) = (0.5 * radius, 2.0 * radius);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if wall_area(at, middle) < PI * radius * radius {
            low = middle;
        } else {
            high = middle;
        }
    }
    (radius / low).powi(2)
}

#[test]
fn a_closed_furnace_is_evenly_bright() {
    const SIDE: u32 = 48;
    const SEEDS: u32 = 10;
    let scene = load("furnace");
    let camera = scene.camera(SIDE, SIDE);
    let pixels: Vec<[f64; 3]> =
        (0..SIDE * SIDE).map(|i| on_wall(&camera, f64::from(i % SIDE) + 0.5, f64::from(i / SIDE) + 0.5)).collect();
    // Distance from the nearest edge, and from the nearest of the two walls that do not make it.
    let from_edge = |at: &[f64; 3]| {
        let mut distances = at.map(|x| 1.0 - x.abs());
        distances.sort_by(f64::total_cmp);
        [distances[1], distances[2]]
    };
    // Expected radius of an estimate: each photon is stored 0.5 + 0.25 + … = 1 times on 24 m².
    let settings = Settings { size: [SIDE; 2], spp: 16, ..Settings::of(&scene) };
    let radius = (f64::from(settings.k) * 24.0 / f64::from(settings.photons) / PI).sqrt();
    let inner = |i: &usize| from_edge(&pixels[*i])[0] > 3.0 * radius;
    let corner = |i: &usize| from_edge(&pixels[*i])[1] < radius;
    let band = |i: &usize| from_edge(&pixels[*i])[0] < radius && !corner(i);

    let part = |show: Show, seed: u32| image(&scene, &Settings { show, seed, ..settings.clone() }, &Device::cpu());
    let average = |picture: &Image, wanted: &dyn Fn(&usize) -> bool| {
        let values: Vec<f64> = (0..pixels.len()).filter(wanted).map(|i| f64::from(picture.rgb[i][1])).collect();
        assert!(values.len() > 3, "only {} pixels", values.len());
        mean(&values)
    };
    let mut beauty = Vec::new();
    let mut global = Vec::new();
    for seed in 0..SEEDS {
        beauty.push(part(Show::Beauty, seed));
        if seed < 4 {
            global.push(part(Show::Global, seed));
        }
    }
    let over = |pictures: &[Image], wanted: &dyn Fn(&usize) -> bool| {
        mean_and_error(&pictures.iter().map(|picture| average(picture, wanted)).collect::<Vec<_>>())
    };

    // Away from edges nothing but noise is left.
    let (value, se) = over(&beauty, &inner);
    println!("furnace, away from edges: {value:.5}, SE {se:.5}");
    assert!((value - 1.0).abs() < 4.0 * se && se < 2e-3, "{value} ± {se}");

    // All pixels: the boundary bias of the part that comes from the map, which is a quarter, is known.
    let expected: Vec<f64> = (0..pixels.len())
        .map(|i| {
            let parts = (0..9).map(|part| {
                let at = |i: u32, part: usize| f64::from(i) + (part as f64 + 0.5) / 3.0;
                boundary_bias(on_wall(&camera, at(i as u32 % SIDE, part % 3), at(i as u32 / SIDE, part / 3)), radius)
            });
            parts.sum::<f64>() / 9.0
        })
        .collect();
    let bias = |wanted: &dyn Fn(&usize) -> bool| {
        mean(&(0..pixels.len()).filter(wanted).map(|i| expected[i]).collect::<Vec<_>>())
    };
    let (value, se) = over(&beauty, &|_| true);
    let wanted = 1.0 + 0.25 * (bias(&|_| true) - 1.0);
    println!("furnace, all pixels: {value:.5}, SE {se:.5}, expected with the boundary bias {wanted:.5}");
    assert!((value - wanted).abs() < 4.0 * se + 1e-3, "{value} ± {se}, not {wanted}");
    for (name, wanted) in [("edges", &band as &dyn Fn(&usize) -> bool), ("corners", &corner)] {
        let (value, se) = over(&global, wanted);
        let (ratio, se, bias) = (4.0 * value, 4.0 * se, bias(wanted));
        println!("furnace, {name}, from the map: {ratio:.4} of the truth, SE {se:.4}, expected {bias:.4}");
        assert!((ratio - bias).abs() < 4.0 * se + 0.03, "{name}: {ratio} ± {se}, not {bias}");
    }
}

#[test]
fn direct_light_of_many_lights_converges_in_each_pixel() {
    let scene = load("furnace");
    // The root mean square error of the pixels, the truth being 0.75, away from edges, where 1 / d² has no bound.
    let error = |spp: u32| {
        let settings = Settings { size: [16, 16], spp, show: Show::Direct, ..small(&scene) };
        let picture = image(&scene, &settings, &Device::cpu());
        let camera = scene.camera(16, 16);
        let inner = (0..256u32).filter(|&i| {
            let mut at = on_wall(&camera, f64::from(i % 16) + 0.5, f64::from(i / 16) + 0.5).map(f64::abs);
            at.sort_by(f64::total_cmp);
            at[1] < 0.7
        });
        mean(&inner.map(|i| (f64::from(picture.rgb[i as usize][1]) - 0.75).powi(2)).collect::<Vec<_>>()).sqrt()
    };
    let errors = [16, 256, 4096].map(error);
    println!("root mean square errors at 16, 256 and 4096 samples a pixel: {errors:.5?}");
    // Random numbers would make it 4 times less each time, a sequence more.
    assert!(errors[1] < errors[0] / 3.0 && errors[2] < errors[1] / 3.0, "{errors:?}");
}

/// A mean radiance and its standard error, from the reference.
struct Reference {
    mean: [f64; 3],
    se: [f64; 3],
}

fn reference(path: &[&str]) -> Reference {
    let text = include_str!("../reference/cornell_reference.json");
    let root: serde_json::Value = serde_json::from_str(text).expect("the reference is JSON");
    let value = path.iter().fold(&root, |value, key| &value[key]);
    let triple = |value: &serde_json::Value| -> [f64; 3] {
        std::array::from_fn(|channel| value[channel].as_f64().expect("three numbers"))
    };
    if path.is_empty() {
        return Reference { mean: triple(&root["mean_rgb"]), se: triple(&root["standard_error_rgb"]) };
    }
    Reference { mean: triple(&value["mean"]), se: triple(&value["se"]) }
}

/// Checks a mean radiance against the reference: within 3 % and 3 standard errors of the reference in each channel.
fn check_reference(name: &str, found: [f64; 3], reference: &Reference) -> Result<String, String> {
    let ratios: [f64; 3] = std::array::from_fn(|c| found[c] / reference.mean[c] - 1.0);
    let fine = (0..3).all(|c| (found[c] - reference.mean[c]).abs() <= 0.03 * reference.mean[c] + 3.0 * reference.se[c]);
    let percent = ratios.map(|ratio| format!("{:+.2} %", 100.0 * ratio)).join(", ");
    let text = format!("{name}: {found:.5?} against {:.5?}: {percent}", reference.mean);
    if fine { Ok(text) } else { Err(text) }
}

/// Settings at which the Cornell box is compared with the reference.
fn cornell_settings(scene: &Scene, show: Show) -> Settings {
    Settings {
        size: [64, 64],
        photons: 300_000,
        caustic_photons: 200_000,
        k: 100,
        radius: 0.05,
        spp: 16,
        show,
        ..Settings::of(scene)
    }
}

#[test]
fn the_cornell_box_is_as_bright_as_an_independent_path_tracer_says() {
    let scene = load("cornell");
    let picture = |show| image(&scene, &cornell_settings(&scene, show), &Device::cpu());
    let [beauty, direct, global, caustic] =
        [Show::Beauty, Show::Direct, Show::Global, Show::Caustic].map(|show| mean_rgb(&picture(show)));
    let mut failed = Vec::new();
    let whole = reference(&[]);
    for (name, found, reference) in [
        ("total", beauty, &whole),
        ("direct", direct, &reference(&["parts", "direct"])),
        ("global", global, &reference(&["parts", "global"])),
        ("caustic", caustic, &reference(&["parts", "caustic"])),
    ] {
        match check_reference(name, found, reference) {
            Ok(text) => println!("{text}"),
            Err(text) => failed.push(text),
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");

    // Faults that this is to find, made of the parts.
    let sum = |weights: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|c| weights[0] * direct[c] + weights[1] * global[c] + weights[2] * caustic[c])
    };
    check_reference("the sum of the parts", sum([1.0; 3]), &whole).unwrap();
    for (fault, weights) in [
        ("photons of half the power", [1.0, 0.5, 0.5]),
        ("photons of twice the power", [1.0, 2.0, 2.0]),
        ("direct light in the map, too", [2.0, 1.0, 1.0]),
        ("no indirect light", [1.0, 0.0, 1.0]),
        ("an eighth of the direct light lost", [0.875, 1.0, 1.0]),
    ] {
        assert!(check_reference(fault, sum(weights), &whole).is_err(), "{fault} was not found");
    }
    // A caustic is 3 % of all light: the total would not show its faults, but the part does.
    let part = reference(&["parts", "caustic"]);
    for factor in [0.0, 0.5, 2.0] {
        assert!(check_reference("caustic", caustic.map(|x| x * factor), &part).is_err(), "{factor}");
    }
}

#[test]
fn the_parts_add_up_to_the_picture() {
    let scene = load("cornell");
    let settings = Settings { spp: 4, ..small(&scene) };
    let picture = |show| image(&scene, &Settings { show, ..settings.clone() }, &Device::cpu());
    let [beauty, direct, global, caustic] = [Show::Beauty, Show::Direct, Show::Global, Show::Caustic].map(picture);
    // Sums of positive terms in another order: each of at most 2·spp + 6 additions and products is off by half an ulp.
    let rounding = f64::from(2 * settings.spp + 6) * f64::from(f32::EPSILON);
    for (i, &whole) in floats(&beauty).iter().enumerate() {
        let sum: f64 = [&direct, &global, &caustic].map(|part| f64::from(floats(part)[i])).iter().sum();
        let whole = f64::from(whole);
        assert!((sum - whole).abs() <= rounding * whole, "value {i}: {sum} and {whole}");
    }
    for part in [&direct, &global, &caustic] {
        assert!(floats(part).iter().any(|&x| x > 0.0) && floats(part).iter().all(|&x| x >= 0.0));
    }
    assert_same_words("the caustic map", floats(&caustic), floats(&picture(Show::MapCaustic)));
}

#[test]
fn the_picture_depends_on_the_seed_alone() {
    let scene = load("cornell");
    let settings = small(&scene);
    let first = image(&scene, &settings, &Device::cpu());
    for hash in [Hash::Linear, Hash::Teschner, Hash::Morton] {
        for gather in [Gather::Heap, Gather::List] {
            let again = image(&scene, &Settings { hash, gather, ..settings.clone() }, &Device::cpu());
            assert_same_words(&format!("{hash:?}, {gather:?}"), floats(&first), floats(&again));
        }
    }
    for order in [LaneOrder::Forward, LaneOrder::Reversed, LaneOrder::Shuffled(1), LaneOrder::Shuffled(2)] {
        let again = image(&scene, &settings, &Device::cpu_with_order(order));
        assert_same_words(&format!("lanes {order:?}"), floats(&first), floats(&again));
    }
    // A device that has rendered before has no memory of it.
    let device = Device::cpu();
    image(&load("furnace"), &small(&scene), &device);
    assert_same_words("again", floats(&first), floats(&image(&scene, &settings, &device)));
    for seed in [1, u32::MAX] {
        let other = image(&scene, &Settings { seed, ..settings.clone() }, &Device::cpu());
        let difference = compare_words("another seed", floats(&first), floats(&other)).unwrap_err();
        println!("{difference}");
    }
}

#[test]
fn cpu_and_gpu_make_the_same_picture() {
    let Some(gpu) = gpu() else { return };
    let (cpu, cornell) = (Device::cpu(), load("cornell"));
    let settings = small(&cornell);
    // The first has 2 tiles on the CPU and 1 on a GPU.
    let plane = Settings { size: [40, 40], spp: 128, show: Show::Direct, ..settings.clone() };
    let map = Settings { size: [32, 32], spp: 1, show: Show::MapGlobal, ..settings.clone() };
    let lists = Settings { size: [32, 32], spp: 1, hash: Hash::Teschner, gather: Gather::List, ..settings.clone() };
    for (name, scene, settings) in [
        ("plane, in tiles", &load("plane"), plane),
        ("lamp, map", &parse(LAMP), map.clone()),
        ("furnace, Teschner and list", &load("furnace"), lists),
        ("cornell, caustic map", &cornell, Settings { show: Show::MapCaustic, ..map }),
        ("cornell", &cornell, settings),
    ] {
        let (a, b) = (run(scene, &settings, &cpu), run(scene, &settings, gpu));
        assert_same_words(name, floats(&a.image), floats(&b.image));
        let counts = |rendered: &Rendered| -> Vec<_> {
            let maps = rendered.report.maps.iter();
            maps.map(|map| (map.map, map.photons_emitted, map.photons_stored, map.table_entries)).collect()
        };
        assert_eq!(counts(&a), counts(&b), "{name}");
        println!("{name}: {} floats are the same", floats(&a.image).len());
    }
}

#[test]
fn the_golden_picture_has_not_changed() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/cornell_48.exr");
    let scene = load("cornell");
    let settings = Settings {
        size: [48, 48],
        photons: 20_000,
        caustic_photons: 10_000,
        k: 60,
        radius: 0.15,
        spp: 4,
        seed: 7,
        ..Settings::of(&scene)
    };
    let picture = image(&scene, &settings, &Device::cpu());
    let bless = "if the change is meant, look at the picture and run `CAUSTIC_BLESS=1 cargo test --release -p \
                 caustic-tests --test render golden`, then commit tests/golden/cornell_48.exr";
    if std::env::var("CAUSTIC_BLESS").is_ok_and(|value| value == "1") {
        let metadata = Metadata {
            version: env!("CARGO_PKG_VERSION").to_string(),
            scene: scene.name.clone(),
            seed: settings.seed,
            settings: vec![("test".to_string(), format!("{settings:?}"))],
        };
        output::write(&path, &picture, &metadata).expect("the golden picture is written");
        println!("wrote {}", path.display());
    }
    let golden = output::read(&path).unwrap_or_else(|error| panic!("{error}; {bless}"));
    assert_eq!([golden.width, golden.height], settings.size);
    if let Err(difference) = compare_words("golden picture", floats(&golden), floats(&picture)) {
        panic!("{difference}; {bless}");
    }
    let planted = floats(&golden).iter().enumerate().map(|(i, &x)| if i == 5000 { x.next_up() } else { x });
    let planted: Vec<f32> = planted.collect();
    assert!(compare_words("a bit that was flipped", &planted, floats(&picture)).is_err());
}

/// [`LAMP`] turned over: it shines into the void.
fn lamp_upside_down() -> Scene {
    let turned = LAMP.replace("edge_u = [1, 0, 0]\nedge_v = [0, 0, 1]", "edge_u = [0, 0, 1]\nedge_v = [1, 0, 0]");
    assert_ne!(turned, LAMP);
    parse(&turned)
}

#[test]
fn a_light_that_faces_the_void_is_an_error() {
    let scene = lamp_upside_down();
    for device in [Some(&Device::cpu()), gpu()].into_iter().flatten() {
        for show in [Show::Beauty, Show::Global, Show::MapGlobal] {
            let settings = Settings { show, ..small(&scene) };
            let error = render(&scene, &settings, device, &mut |_| true).err().expect("there is no light");
            assert!(matches!(error, RenderError::NoPhotons { map: "global", emitted: 3000, .. }), "{error:?}");
            let text = error.to_string();
            assert!(text.contains("3000 emitted") && text.contains("--"), "{text}");
        }
    }
    // Shadow rays need no photons: the plane is just dark.
    let dark = image(&scene, &Settings { show: Show::Direct, ..small(&scene) }, &Device::cpu());
    assert_eq!(mean_rgb(&dark), [0.0; 3]);
}

#[test]
fn a_scene_without_mirror_or_glass_has_no_caustic_map() {
    let scene = load("furnace");
    let settings = Settings { caustic_photons: 1000, ..small(&scene) };
    for show in [Show::Beauty, Show::Caustic, Show::MapCaustic] {
        let report = run(&scene, &Settings { show, ..settings.clone() }, &Device::cpu()).report;
        assert!(report.maps.iter().all(|map| map.map != "caustic"), "{:?}", report.maps);
        assert!(report.notes.iter().any(|note| note.contains("no caustic map")), "{:?}", report.notes);
    }
    let report = run(&load("cornell"), &settings, &Device::cpu()).report;
    let maps: Vec<_> = report.maps.iter().map(|map| map.map).collect();
    assert_eq!(maps, ["global", "caustic"]);
    assert!(report.maps.iter().all(|map| map.photons_stored > 0 && map.bytes > 0));
    assert!(report.notes.is_empty(), "{:?}", report.notes);
}

#[test]
fn settings_out_of_range_are_errors() {
    let scene = load("plane");
    let good = small(&scene);
    for (name, wrong) in [
        ("size", Settings { size: [0, 1], ..good.clone() }),
        ("size", Settings { size: [1_000_000; 2], ..good.clone() }),
        ("size", Settings { size: [65_536; 2], ..good.clone() }),
        ("photons", Settings { photons: 0, ..good.clone() }),
        ("photons", Settings { photons: u32::MAX, ..good.clone() }),
        ("caustic-photons", Settings { caustic_photons: u32::MAX, ..good.clone() }),
        ("k", Settings { k: 0, ..good.clone() }),
        ("k", Settings { k: 100_000_000, ..good.clone() }),
        ("spp", Settings { spp: 0, ..good.clone() }),
        ("radius", Settings { radius: 0.0, ..good.clone() }),
        ("radius", Settings { radius: -1.0, ..good.clone() }),
        ("radius", Settings { radius: f32::INFINITY, ..good.clone() }),
        ("radius", Settings { radius: f32::NAN, ..good.clone() }),
    ] {
        match render(&scene, &wrong, &Device::cpu(), &mut |_| true).err() {
            Some(RenderError::Setting { name: found, range, .. }) => {
                assert_eq!(found, name);
                assert!(range.contains(char::is_numeric), "{name}: {range}");
            }
            other => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn a_render_stops_when_it_is_told_to() {
    let scene = load("cornell");
    // Two tiles on the CPU.
    let settings = Settings { size: [64, 64], spp: 64, k: 5, show: Show::Direct, ..small(&scene) };
    let whole = image(&scene, &settings, &Device::cpu());
    let stopped = render(&scene, &settings, &Device::cpu(), &mut |progress| progress.done == 0).expect("a tile");
    assert!(!stopped.report.complete);
    let half = floats(&whole).len() / 2;
    assert_same_words("finished rows", &floats(&whole)[..half], &floats(&stopped.image)[..half]);
    assert!(floats(&stopped.image)[half..].iter().all(|&x| x == 0.0));
    let settings = Settings { show: Show::Beauty, ..settings };
    let error = render(&scene, &settings, &Device::cpu(), &mut |_| false).err();
    assert!(matches!(error, Some(RenderError::Interrupted)), "{error:?}");
}
