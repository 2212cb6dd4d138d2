//! Environments: furnaces, a picture against quadrature, the energy of their photons and bad files. Seeds are fixed; bounds are 4 standard
//! errors. That a GPU has the same bits, `tests/pictures.rs` sees, and `tests/verify.rs` of the scene courtyard.

use caustic_device::Device;
use caustic_photon_map::{Filter, Surface};
use caustic_renderer::scene::Scene;
use caustic_renderer::{Integrator, Settings, Show};
use caustic_tests::renders::*;
use std::f64::consts::PI;
use std::path::Path;

/// A ball of radius 1, seen from 3 m, in the light of `sky`.
fn ball(fields: &str, fov: f64, sky: &str) -> Scene {
    parse(&format!(
        "[camera]\nposition = [0, 0, 3]\ntarget = [0, 0, 0]\nvertical_fov_degrees = {fov}\n\
         [materials.ball]\n{fields}\n[[spheres]]\ncentre = [0, 0, 0]\nradius = 1\nmaterial = \"ball\"\n\
         [[lights]]\nkind = \"environment\"\n{sky}\n"
    ))
}

const EVEN: &str = "radiance = [1, 1, 1]";

/// A diffuse ball of reflectance a in an environment of radiance 1 has the radiance a everywhere: by paths, by shadow rays, and by photons alone.
#[test]
fn a_diffuse_ball_reflects_its_share_of_an_even_sky() {
    for reflectance in [0.25, 1.0] {
        let scene = ball(
            &format!("kind = \"lambertian\"\nreflectance = [{reflectance}, {reflectance}, {reflectance}]"),
            20.0,
            EVEN,
        );
        let base = Settings { size: [16, 16], spp: 32, ..Settings::of(&scene) };
        let map = Settings { show: Show::MapGlobal, photons: 200_000, k: 60, radius: 0.5, spp: 1, ..base.clone() };
        for (name, settings) in [
            ("path", Settings { integrator: Integrator::Path, ..base.clone() }),
            ("direct", Settings { integrator: Integrator::Direct, ..base.clone() }),
            ("map", map.clone()),
            ("map, cone", Settings { filter: Filter::Cone, surface: Surface::Own, ..map }),
        ] {
            let ratio = |seed| {
                let rendered = run(&scene, &Settings { seed, ..settings.clone() }, &Device::cpu());
                assert_eq!(rendered.report.problems, [""; 0]);
                mean_rgb(&rendered.image)[1] / reflectance
            };
            let (mean, se) = mean_and_error(&(0..4).map(ratio).collect::<Vec<_>>());
            println!("{name}, {reflectance}: {mean:.5}, SE {se:.5}");
            assert!((mean - 1.0).abs() < 4.0 * se + 1e-5 && se < 1.5e-2, "{name}, {reflectance}: {mean} ± {se}");
        }
    }
}

/// What loses no light cannot be seen in an even sky: of delta lobes to the last bits.
#[test]
fn what_loses_no_light_is_invisible() {
    for (fields, exact) in [
        ("kind = \"mirror\"\nreflectance = [1, 1, 1]", true),
        ("kind = \"dielectric\"\nior = 1.5", true),
        ("kind = \"conductor\"\nreflectance = [1, 1, 1]\nroughness = 0.2", false),
        ("kind = \"plastic\"\nreflectance = [1, 1, 1]", false),
        ("kind = \"lambertian\"\nreflectance = [1, 1, 1]", false),
    ] {
        let scene = ball(fields, 60.0, EVEN);
        // The ball does not light itself, so that direct light is all that is diffuse.
        for integrator in [Integrator::Path, Integrator::Direct] {
            let settings = Settings { integrator, size: [24, 24], spp: 64, ..small(&scene) };
            let picture = image(&scene, &settings, &Device::cpu());
            let worst = floats(&picture).iter().map(|&x| (x - 1.0).abs()).fold(0f32, f32::max);
            let mean = mean_rgb(&picture)[1];
            println!("{fields:?}, {integrator:?}: mean {mean:.5}, worst pixel off by {worst:.1e}");
            // GGX loses a thousandth at this roughness to facets' mutual reflections.
            let (of_mean, of_pixels) = if exact { (1e-6, 1e-5) } else { (4e-3, 0.2) };
            assert!((mean - 1.0).abs() < of_mean && worst < of_pixels, "{fields}: {mean}, {worst}");
        }
    }
}

/// Many bounces: two balls and a disc that are white, close together, are as bright as the sky, and so is what is between them.
#[test]
fn white_things_are_invisible_together() {
    let scene = parse(
        "[camera]\nposition = [0, 0.4, 4]\ntarget = [0, 0, 0]\nvertical_fov_degrees = 40\n\
         [materials.white]\nkind = \"lambertian\"\nreflectance = [1, 1, 1]\n\
         [[spheres]]\ncentre = [-0.8, 0, 0]\nradius = 0.78\nmaterial = \"white\"\n\
         [[spheres]]\ncentre = [0.8, 0, 0]\nradius = 0.78\nmaterial = \"white\"\n\
         [[discs]]\ncentre = [0, -0.8, 0]\nnormal = [0, 1, 0]\nradius = 2\nmaterial = \"white\"\n\
         [[lights]]\nkind = \"environment\"\nradiance = [1, 1, 1]\n",
    );
    // Within the radius the disc is flat and both sides are told apart; what an edge or a contact makes of it is the bias that is left.
    let photon = Settings { photons: 200_000, k: 80, radius: 0.1, surface: Surface::Own, spp: 16, ..small(&scene) };
    for (name, bias, settings) in
        [("path", 0.0, Settings { integrator: Integrator::Path, spp: 64, ..small(&scene) }), ("photon", 0.01, photon)]
    {
        let of_seed = |seed| {
            let settings = Settings { seed, size: [24, 24], ..settings.clone() };
            mean_rgb(&image(&scene, &settings, &Device::cpu()))[1]
        };
        let (mean, se) = mean_and_error(&(0..6).map(of_seed).collect::<Vec<_>>());
        println!("{name}: {mean:.5}, SE {se:.5}");
        assert!((mean - 1.0).abs() < 4.0 * se + bias && se < 5e-3, "{name}: {mean} ± {se}");
    }
}

/// Emitted is ∫ L dω · π·R², by every photon the same share of it, and what is not absorbed escapes.
#[test]
fn an_even_sky_emits_what_comes_to_the_sphere_around_the_scene() {
    let scene = ball("kind = \"lambertian\"\nreflectance = [0.5, 0.25, 0]", 60.0, "radiance = [1, 2, 4]");
    let settings = Settings { photons: 50_000, show: Show::MapGlobal, ..small(&scene) };
    let report = run(&scene, &settings, &Device::cpu()).report;
    let ledger = &report.maps[0].ledger[0];
    // The sphere around the box of the ball.
    let all = 4.0 * PI * PI * 3.0;
    for (c, radiance) in [1.0, 2.0, 4.0].into_iter().enumerate() {
        assert!((ledger.emitted_w[c] / (all * radiance) - 1.0).abs() < 1e-4, "{:?}", ledger.emitted_w);
    }
    // A third of the disc is the ball's: half of that red light is absorbed, within four standard errors of 50,000 photons.
    let absorbed = ledger.absorbed_w[0] / ledger.emitted_w[0];
    assert!((absorbed - 1.0 / 6.0).abs() < 4.0 * 0.5 * (2.0 / 9.0 / 50_000f64).sqrt(), "{absorbed}");
    assert!(report.problems.is_empty() && ledger.closes());
}

const WIDTH: usize = 32;
const HEIGHT: usize = 16;

/// A picture with a bright spot to the right of its middle, above the horizon, and a gradient.
fn picture() -> Vec<[f32; 3]> {
    (0..WIDTH * HEIGHT)
        .map(|i| {
            let (x, y) = (i % WIDTH, i / WIDTH);
            let spot = if (20..22).contains(&x) && (4..6).contains(&y) { 60.0 } else { 0.0 };
            [0.25 + spot, 0.5 * y as f32 / HEIGHT as f32 + spot, if x < WIDTH / 2 { 1.0 } else { 0.0 }]
        })
        .collect()
}

fn write_exr(path: &Path, rgb: &[[f32; 3]]) {
    use exr::prelude::{Image, SpecificChannels, WritableImage};
    let channels = SpecificChannels::rgb(|at: exr::math::Vec2<usize>| {
        let [r, g, b] = rgb[at.y() * WIDTH + at.x()];
        (r, g, b)
    });
    Image::from_channels((WIDTH, HEIGHT), channels).write().to_file(path).unwrap();
}

/// Radiance of the picture from a direction, bilinear, in f64.
fn radiance(rgb: &[[f32; 3]], d: [f64; 3]) -> [f64; 3] {
    let u = 0.5 + d[0].atan2(-d[2]) / (2.0 * PI);
    let v = d[1].clamp(-1.0, 1.0).acos() / PI;
    let (x, y) = (u * WIDTH as f64 - 0.5, v * HEIGHT as f64 - 0.5);
    let at = |dx: i64, dy: i64| {
        let column = (x.floor() as i64 + dx).rem_euclid(WIDTH as i64) as usize;
        let row = (y.floor() as i64 + dy).clamp(0, HEIGHT as i64 - 1) as usize;
        rgb[row * WIDTH + column].map(f64::from)
    };
    let (s, t) = (x - x.floor(), y - y.floor());
    let corners = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
    let shares = [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t];
    std::array::from_fn(|c| (0..4).map(|k| shares[k] * corners[k][c]).sum())
}

/// Irradiance of a surface of this normal: a Riemann sum.
fn irradiance(rgb: &[[f32; 3]], normal: [f64; 3]) -> [f64; 3] {
    const FINE: usize = 40;
    let mut sum = [0.0; 3];
    for row in 0..HEIGHT * FINE {
        let theta = PI * (row as f64 + 0.5) / (HEIGHT * FINE) as f64;
        for column in 0..WIDTH * FINE {
            let phi = 2.0 * PI * ((column as f64 + 0.5) / (WIDTH * FINE) as f64 - 0.5);
            let d = [theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos()];
            let cos: f64 = (0..3).map(|axis| d[axis] * normal[axis]).sum();
            let area = 2.0 * PI * PI * theta.sin() / (HEIGHT * WIDTH * FINE * FINE) as f64;
            let l = radiance(rgb, d);
            (0..3).for_each(|c| sum[c] += l[c] * cos.max(0.0) * area);
        }
    }
    sum
}

/// A square that faces `normal` in the light of the file, seen from where it faces.
fn facing(normal: [f64; 3], folder: &Path, turned: f64) -> Scene {
    let [x, y, z] = normal;
    // Two edges across the normal, in this order: u × v = normal.
    let (u, v) = if y.abs() > 0.5 { ([0.0, 0.0, 1.0], [y, 0.0, 0.0]) } else { ([z, 0.0, -x], [0.0, 1.0, 0.0]) };
    let corner: [f64; 3] = std::array::from_fn(|c| -0.5 * (u[c] + v[c]));
    let text = format!(
        "[camera]\nposition = {:?}\ntarget = [0, 0, 0]\nup = {v:?}\nvertical_fov_degrees = 20\n\
         [materials.grey]\nkind = \"lambertian\"\nreflectance = [0.5, 0.5, 0.5]\n\
         [[quads]]\ncorner = {corner:?}\nedge_u = {u:?}\nedge_v = {v:?}\nmaterial = \"grey\"\n\
         [[lights]]\nkind = \"environment\"\nfile = \"sky.exr\"\nradiance = [2, 2, 2]\nrotation_degrees = {turned}\n",
        [2.0 * x, 2.0 * y, 2.0 * z]
    );
    Scene::parse(&folder.join("scene.toml").to_string_lossy(), &text).expect("a scene")
}

/// Flat surfaces that face six ways have the irradiance that quadrature gives, by paths, shadow rays and photons; turned by a quarter, what faced
/// ahead faces left.
#[test]
fn a_picture_lights_as_quadrature_says() {
    let folder = tempfile::tempdir().unwrap();
    let rgb = picture();
    write_exr(&folder.path().join("sky.exr"), &rgb);
    for (normal, turned, original) in [
        ([0.0, 1.0, 0.0], 0.0, [0.0, 1.0, 0.0]),
        ([0.0, -1.0, 0.0], 0.0, [0.0, -1.0, 0.0]),
        ([0.0, 0.0, -1.0], 0.0, [0.0, 0.0, -1.0]),
        ([1.0, 0.0, 0.0], 0.0, [1.0, 0.0, 0.0]),
        ([-1.0, 0.0, 0.0], 90.0, [0.0, 0.0, -1.0]),
        ([0.0, 0.0, -1.0], -30.0, [-0.5, 0.0, -0.75f64.sqrt()]),
    ] {
        let scene = facing(normal, folder.path(), turned);
        // L = 2·E / 2π, of a picture that is multiplied with 2.
        let wanted = irradiance(&rgb, original).map(|e| e / PI);
        let base = Settings { size: [8, 8], ..small(&scene) };
        // Of the photons a third misses or comes to the back, and has no place in this.
        let map = Settings { show: Show::MapGlobal, photons: 200_000, k: 100, surface: Surface::Own, ..base.clone() };
        for (name, settings) in [
            ("path", Settings { integrator: Integrator::Path, spp: 128, ..base.clone() }),
            ("direct", Settings { integrator: Integrator::Direct, spp: 128, ..base.clone() }),
            ("map", Settings { spp: 4, ..map }),
        ] {
            let of_seed = |seed| mean_rgb(&image(&scene, &Settings { seed, ..settings.clone() }, &Device::cpu()));
            let means: Vec<[f64; 3]> = (0..6).map(of_seed).collect();
            for c in 0..3 {
                let (mean, se) = mean_and_error(&means.iter().map(|mean| mean[c]).collect::<Vec<_>>());
                let allowed = 4.0 * se + 2e-3 * wanted[c];
                assert!(
                    (mean - wanted[c]).abs() < allowed && se < 0.02 * wanted[c] + 1e-3,
                    "{name}, {normal:?} turned by {turned}, channel {c}: {mean} ± {se}, not {}",
                    wanted[c]
                );
                if c == 0 {
                    println!("{name}, {normal:?}, {turned}: {mean:.5} ± {se:.5}, expected {:.5}", wanted[c]);
                }
            }
        }
    }
}

/// What cameras and mirrors see is the picture.
#[test]
fn the_sky_is_seen_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let rgb = picture();
    write_exr(&folder.path().join("sky.exr"), &rgb);
    let text = "[camera]\nposition = [0, 0, 0]\ntarget = [1, 0.6, 0.8]\nvertical_fov_degrees = 100\n\
         [materials.black]\nkind = \"lambertian\"\nreflectance = [0, 0, 0]\n\
         [[spheres]]\ncentre = [0, 0, -50]\nradius = 1\nmaterial = \"black\"\n\
         [[lights]]\nkind = \"environment\"\nfile = \"sky.exr\"\n";
    let scene = Scene::parse(&folder.path().join("scene.toml").to_string_lossy(), text).unwrap();
    let camera = scene.camera(64, 64);
    let settings = Settings { size: [64, 64], spp: 256, integrator: Integrator::Direct, ..small(&scene) };
    let found = image(&scene, &settings, &Device::cpu());
    for (i, pixel) in found.rgb.iter().enumerate() {
        let mut wanted = [0.0; 3];
        for part in 0..64 {
            let at = |i: usize, part: usize| i as f64 + (part as f64 + 0.5) / 8.0;
            let (_, d) = ray(&camera, at(i % 64, part % 8), at(i / 64, part / 8));
            let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
            let l = radiance(&rgb, d.map(|x| x / length));
            (0..3).for_each(|c| wanted[c] += l[c] / 64.0);
        }
        for c in 0..3 {
            let off = (f64::from(pixel[c]) - wanted[c]).abs();
            // Halves have 11 bits; the rest is that both means are of some points of the pixel.
            assert!(off < 5e-3 + 0.02 * wanted[c], "pixel {i}, channel {c}: {} and not {}", pixel[c], wanted[c]);
        }
    }
}

/// `caustic scene check` says what is around a scene, and that its light comes from below as well.
#[test]
fn an_inspection_tells_of_the_environment() {
    let courtyard = load("courtyard").inspect();
    assert!(courtyard.environment.is_some_and(|line| line.contains("512 × 256 pixels")));
    assert_eq!(courtyard.warnings, [""; 0]);
    let folder = tempfile::tempdir().unwrap();
    write_exr(&folder.path().join("sky.exr"), &picture());
    let warnings = facing([0.0, 1.0, 0.0], folder.path(), 0.0).inspect().warnings;
    assert!(warnings.iter().any(|warning| warning.contains("--surface facing")), "{warnings:?}");
}

#[test]
fn bad_environments_are_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let mut rgb = picture();
    rgb[7][1] = -1.0;
    write_exr(&folder.path().join("negative.exr"), &rgb);
    rgb[7][1] = f32::NAN;
    write_exr(&folder.path().join("nan.exr"), &rgb);
    write_exr(&folder.path().join("black.exr"), &[[0.0; 3]; WIDTH * HEIGHT]);
    std::fs::write(folder.path().join("text.hdr"), "no picture").unwrap();
    let light = |fields: &str| format!("[[lights]]\nkind = \"environment\"\n{fields}\n");
    for (lights, words) in [
        (light("file = \"missing.exr\""), "missing.exr"),
        (light("file = \"negative.exr\""), "pixel (7, 0) is negative"),
        (light("file = \"nan.exr\""), "NaN"),
        (light("file = \"black.exr\""), "is a picture that is black"),
        (light("file = \"text.hdr\""), "text.hdr"),
        (light("file = \"sky.tga\""), "sky.tga"),
        (light("file = \"built-in:moon\""), "built-in:sky"),
        (light(""), "lacks the field `radiance`"),
        (light("radiance = [0, 0, 0]"), "is dark"),
        (light("radiance = [1, 1, 1]\nintensity = [1, 1, 1]"), "means nothing for an environment"),
        (light("radiance = [1, 1, 1]").repeat(2), "second environment"),
        (light("file = \"built-in:sky\"\nradiance = [1e9, 1, 1]"), "make it darker"),
        ("[[lights]]\nkind = \"point\"\nrotation_degrees = 1".to_string(), "means nothing for a point"),
    ] {
        let text = format!(
            "[camera]\nposition = [0, 0, 3]\ntarget = [0, 0, 0]\nvertical_fov_degrees = 60\n\
             [materials.m]\nkind = \"mirror\"\nreflectance = [1, 1, 1]\n\
             [[spheres]]\ncentre = [0, 0, 0]\nradius = 1\nmaterial = \"m\"\n{lights}"
        );
        let error = Scene::parse(&folder.path().join("scene.toml").to_string_lossy(), &text).unwrap_err().to_string();
        assert!(error.contains(words) && !error.contains('\n'), "{lights}: {error}");
    }
}
