//! Renders at the extremes: any unit of length and of power, far from the origin, closed boxes, grazing light.

use caustic_device::Device;
use caustic_kernels::trace::Camera;
use caustic_photon_map::{Gather, Hash};
use caustic_renderer::output::Image;
use caustic_renderer::scene::Scene;
use caustic_renderer::{Settings, Show, render};
use caustic_tests::{assert_same_words, gpu};

const HASHES: [Hash; 3] = [Hash::Linear, Hash::Teschner, Hash::Morton];
const GATHERS: [Gather; 3] = [Gather::Histogram, Gather::Heap, Gather::List];

/// A room of sides 2, 1 and 2 with a lamp, a mirror ball and a glass ball: lengths times `unit`, moved by `at` (in units), and
/// radiance times `light`. Every number times a power of two is exact.
fn room(unit: f64, at: [f64; 3], light: f64) -> Scene {
    let p = |x: f64, y: f64, z: f64| {
        format!("[{:?}, {:?}, {:?}]", (x + at[0]) * unit, (y + at[1]) * unit, (z + at[2]) * unit)
    };
    let v = |x: f64, y: f64, z: f64| format!("[{:?}, {:?}, {:?}]", x * unit, y * unit, z * unit);
    let quad = |corner: String, u: String, v: String, rest: String| {
        format!("[[quads]]\ncorner = {corner}\nedge_u = {u}\nedge_v = {v}\n{rest}\n")
    };
    let white = || "material = \"white\"".to_string();
    let text = [
        format!(
            "[camera]\nposition = {}\ntarget = {}\nvertical_fov_degrees = 60\n",
            p(1.0, 0.5, 1.875),
            p(1.0, 0.375, 0.0)
        ),
        "[materials.white]\nkind = \"lambertian\"\nreflectance = [0.75, 0.5, 0.25]\n".to_string(),
        "[materials.mirror]\nkind = \"mirror\"\nreflectance = [1, 1, 1]\n".to_string(),
        "[materials.glass]\nkind = \"dielectric\"\nior = 1.5\n".to_string(),
        quad(p(0.0, 0.0, 0.0), v(0.0, 0.0, 2.0), v(2.0, 0.0, 0.0), white()),
        quad(p(0.0, 1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 0.0, 2.0), white()),
        quad(p(0.0, 0.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 1.0, 0.0), white()),
        quad(p(0.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(0.0, 0.0, 2.0), white()),
        quad(p(2.0, 0.0, 0.0), v(0.0, 0.0, 2.0), v(0.0, 1.0, 0.0), white()),
        quad(p(0.0, 0.0, 2.0), v(0.0, 1.0, 0.0), v(2.0, 0.0, 0.0), white()),
        quad(
            p(0.75, 0.96875, 0.75),
            v(0.5, 0.0, 0.0),
            v(0.0, 0.0, 0.5),
            format!("radiance = [{:?}, {:?}, {:?}]", 4.0 * light, 2.0 * light, light),
        ),
        format!("[[spheres]]\ncentre = {}\nradius = {:?}\nmaterial = \"mirror\"\n", p(0.5, 0.25, 0.5), 0.25 * unit),
        format!("[[spheres]]\ncentre = {}\nradius = {:?}\nmaterial = \"glass\"\n", p(1.5, 0.25, 1.0), 0.25 * unit),
    ];
    Scene::parse("room.toml", &text.join("\n")).unwrap()
}

fn settings(scene: &Scene, unit: f64) -> Settings {
    Settings {
        size: [40, 30],
        photons: 4000,
        caustic_photons: 2000,
        k: 40,
        radius: 0.25 * unit as f32,
        spp: 2,
        ..Settings::of(scene)
    }
}

fn picture(scene: &Scene, settings: &Settings, device: &Device) -> Image {
    let rendered = render(scene, settings, device, &mut |_| true).unwrap();
    assert_eq!(rendered.report.notes, [""; 0], "nothing is given up, empty or not finite");
    rendered.image
}

fn floats(image: &Image) -> &[f32] {
    image.rgb.as_flattened()
}

fn devices() -> Vec<(&'static str, Device)> {
    let mut devices = vec![("CPU", Device::cpu())];
    if gpu().is_some() {
        let named = std::env::var("CAUSTIC_TEST_GPU");
        devices.push(("GPU", Device::open(&named.as_deref().unwrap_or("gpu").parse().unwrap()).unwrap().0));
    }
    devices
}

/// Lengths times 2ⁿ change no significand and radiance does not depend on them: from a room of two thousandths of a
/// millimetre to one of two thousand kilometres, the picture has the same bits.
#[test]
fn the_unit_of_length_does_not_show() {
    for (name, device) in devices() {
        let scene = room(1.0, [0.0; 3], 1.0);
        let expected = picture(&scene, &settings(&scene, 1.0), &device);
        assert!(floats(&expected).iter().sum::<f32>() > 100.0);
        for (i, power) in [-14, -9, 5, 20].into_iter().enumerate() {
            let unit = 2f64.powi(power);
            let scene = room(unit, [0.0; 3], 1.0);
            let settings = Settings { hash: HASHES[i % 3], gather: GATHERS[(i + 1) % 3], ..settings(&scene, unit) };
            let found = picture(&scene, &settings, &device);
            assert_same_words(&format!("{name}, 1 unit = 2^{power} m"), floats(&expected), floats(&found));
        }
    }
}

/// Radiance times 2ⁿ does the same to every pixel, as long as powers stay away from the ends of the range.
#[test]
fn the_unit_of_power_does_not_show() {
    for (name, device) in devices() {
        let scene = room(1.0, [0.0; 3], 1.0);
        let expected = picture(&scene, &settings(&scene, 1.0), &device);
        for (i, power) in [-28, 27].into_iter().enumerate() {
            let light = 2f64.powi(power);
            let scene = room(1.0, [0.0; 3], light);
            let settings = Settings { gather: GATHERS[i + 1], hash: HASHES[i + 1], ..settings(&scene, 1.0) };
            let found = picture(&scene, &settings, &device);
            let scaled: Vec<f32> = floats(&expected).iter().map(|x| x * light as f32).collect();
            assert_same_words(&format!("{name}, radiance times 2^{power}"), &scaled, floats(&found));
        }
    }
}

/// A scene far from the origin is moved there before it is rounded to f32, so it has the bits of the one that stands there.
#[test]
fn far_from_the_origin_nothing_changes() {
    for (name, device) in devices() {
        let scene = room(1.0, [0.0; 3], 1.0);
        let expected = picture(&scene, &settings(&scene, 1.0), &device);
        let far = [1_048_576.0, -1e6, 3e8];
        for (i, hash) in HASHES.into_iter().enumerate() {
            let scene = room(1.0, far, 1.0);
            let settings = Settings { hash, gather: GATHERS[i], ..settings(&scene, 1.0) };
            assert_same_words(
                &format!("{name}, {hash:?}"),
                floats(&expected),
                floats(&picture(&scene, &settings, &device)),
            );
        }
    }
}

/// With a detail of a hundredth, 10⁶ away, in numbers that are no sums of powers of two: f64 rounds them by 10⁻¹⁰, so the same
/// photons fall in the same cells but for a few whose path that rounding changes.
#[test]
fn small_detail_far_away_is_seen() {
    let unit = 0.01;
    let near = room(unit, [0.0; 3], 1.0);
    let far = room(unit, [1e8; 3], 1.0);
    for hash in HASHES {
        let settings = Settings { hash, ..settings(&near, unit) };
        let cpu = Device::cpu();
        let (a, b) = (picture(&near, &settings, &cpu), picture(&far, &settings, &cpu));
        let off = floats(&a).iter().zip(floats(&b)).filter(|(x, y)| (*x - *y).abs() > 1e-3 * x.abs());
        // A photon that lands elsewhere moves some estimates by 1/k each.
        let off = off.count();
        assert!(off < floats(&a).len() / 50, "{off} of {} floats are off by a thousandth", floats(&a).len());
    }
    // The same numbers rounded before they are moved would be all one point: f32 has steps of 0.0625 there.
    assert_eq!(1e6f32 + 0.01, 1e6);
}

/// A closed box with black walls in the light of four lamps outside, a white ball within; `gap` opens one of its edges.
fn closed_box(unit: f64, gap: f64) -> Scene {
    let p = |x: f64, y: f64, z: f64| format!("[{:?}, {:?}, {:?}]", x * unit, y * unit, z * unit);
    let quad = |corner: String, u: String, v: String| {
        format!("[[quads]]\ncorner = {corner}\nedge_u = {u}\nedge_v = {v}\nmaterial = \"black\"\n")
    };
    // Corners that no float has exactly.
    let (a, b) = (-0.3, 0.7);
    let s = b - a;
    let mut text = vec![
        format!("[camera]\nposition = {}\ntarget = {}\nvertical_fov_degrees = 100\n", p(0.6, 0.6, 0.6), p(a, a, a)),
        "[materials.black]\nkind = \"lambertian\"\nreflectance = [0, 0, 0]\n".to_string(),
        "[materials.white]\nkind = \"lambertian\"\nreflectance = [0.9, 0.9, 0.9]\n".to_string(),
        quad(p(a, a, a), p(s, 0.0, 0.0), p(0.0, s, 0.0)),
        quad(p(a, a, b), p(0.0, s, 0.0), p(s, 0.0, 0.0)),
        quad(p(a, a, a), p(0.0, s, 0.0), p(0.0, 0.0, s)),
        quad(p(b, a, a), p(0.0, 0.0, s), p(0.0, s, 0.0)),
        quad(p(a, a, a), p(0.0, 0.0, s), p(s, 0.0, 0.0)),
        quad(p(a, b, a), p(s - gap, 0.0, 0.0), p(0.0, 0.0, s)),
        format!("[[spheres]]\ncentre = {}\nradius = {:?}\nmaterial = \"white\"\n", p(0.2, 0.2, 0.2), 0.25 * unit),
    ];
    for lamp in [p(5.0, 5.0, 5.0), p(-5.0, -4.0, -6.0), p(0.71, 3.0, 0.2), p(0.2, 0.2, 9.0)] {
        text.push(format!("[[lights]]\nkind = \"point\"\nposition = {lamp}\nintensity = [100, 100, 100]\n"));
    }
    Scene::parse("box.toml", &text.join("\n")).unwrap()
}

/// How bright the inside of the box is: direct light alone, and the photons that got in.
fn inside(unit: f64, gap: f64, device: &Device) -> f64 {
    let scene = closed_box(unit, gap);
    let mut sum = 0.0;
    for (show, photons, spp) in [(Show::Direct, 1, 24), (Show::MapGlobal, 300_000, 1)] {
        let settings = Settings {
            size: [96, 64],
            photons,
            caustic_photons: 0,
            k: 8,
            radius: 0.1 * unit as f32,
            spp,
            show,
            ..Settings::of(&scene)
        };
        match render(&scene, &settings, device, &mut |_| true) {
            Ok(rendered) => sum += rendered.image.rgb.as_flattened().iter().map(|&x| f64::from(x)).sum::<f64>(),
            // Not one photon on the ball.
            Err(error) => assert!(error.to_string().contains("stored no photons"), "{error}"),
        }
    }
    sum
}

#[test]
fn no_light_leaks_into_a_closed_box() {
    for (name, device) in devices() {
        for unit in [1.0, 1e-4, 3e5] {
            assert_eq!(inside(unit, 0.0, &device), 0.0, "{name}, a unit of {unit} m");
        }
        // The same box with a crack of two hundredths is not dark: the test can fail.
        assert!(inside(1.0, 0.02, &device) > 0.0, "{name}");
    }
}

/// Numbers at their ends give a picture or one clear sentence, never a panic or something that is not finite.
#[test]
fn settings_at_their_ends_give_a_picture_or_a_sentence() {
    let scene = room(1.0, [0.0; 3], 1.0);
    let base = Settings { size: [8, 6], ..settings(&scene, 1.0) };
    for (name, device) in devices() {
        for (i, hash) in HASHES.into_iter().enumerate() {
            for radius in [1e-18, 1e-9, 1e-5, 1e-3, 5.0, 1e6, 1e18] {
                let settings = Settings { radius, hash, gather: GATHERS[i], ..base.clone() };
                match render(&scene, &settings, &device, &mut |_| true) {
                    Ok(rendered) => assert!(floats(&rendered.image).iter().all(|x| x.is_finite() && *x >= 0.0)),
                    Err(error) => {
                        let text = error.to_string();
                        assert!(text.contains("radius") && !text.contains('\n'), "{name}: {text}");
                    }
                }
            }
            for (photons, caustic_photons, k, spp) in
                [(1, 0, 1, 1), (1, 1, 1024, 1), (5000, 1, 1, 70), (300, 300, 1024, 3)]
            {
                let settings = Settings { photons, caustic_photons, k, spp, hash, gather: GATHERS[i], ..base.clone() };
                match render(&scene, &settings, &device, &mut |_| true) {
                    Ok(rendered) => assert!(floats(&rendered.image).iter().all(|x| x.is_finite() && *x >= 0.0)),
                    Err(error) => assert!(error.to_string().contains("stored no photons"), "{name}: {error}"),
                }
            }
        }
    }
}

#[test]
fn the_camera_sees_what_it_saw_when_the_scene_moves() {
    let camera = |at| -> Camera { room(1.0, at, 1.0).camera(64, 48) };
    assert_eq!(camera([0.0; 3]), camera([1_048_576.0, 0.0, -2e6]));
    // Close to the origin nothing is moved: the file's numbers are the kernels'.
    assert_eq!(camera([0.5, 0.0, 0.0]).origin, [1.5, 0.5, 1.875]);
}
