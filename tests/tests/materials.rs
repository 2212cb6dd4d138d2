//! Materials in a closed furnace, lights against closed forms and against their own photons, and the bits of both on a GPU.

use caustic_device::Device;
use caustic_photon_map::Surface;
use caustic_renderer::{Integrator, LightLedger, Settings, Show};
use caustic_tests::gpu;
use caustic_tests::renders::*;
use std::f64::consts::PI;

/// The furnace, whose radiance is 1 everywhere, with a ball of radius 0.2 in its middle, of a material `fields`.
fn furnace_with_ball(fields: &str) -> String {
    let furnace = caustic_renderer::scene::BUILT_IN.iter().find(|scene| scene.name == "furnace").unwrap().text;
    format!(
        "{furnace}\n[materials.ball]\n{fields}\n[[spheres]]\ncentre = [0, 0, 0]\nradius = 0.2\nmaterial = \"ball\"\n"
    )
}

/// Seeds of a mean.
const SEEDS: u32 = 6;
/// Pixels that are brighter count as this bright: see [`photon_maps`].
const MOST: f64 = 2.0;
/// What that takes from a mean, at most.
const TAKEN: f64 = 0.006;

/// Cosine of the angle at which a pixel's middle sees the ball; 0 next to it, where a pixel may see both, and −1 where it sees the walls alone.
fn cosines(side: u32) -> Vec<f64> {
    let camera = parse(&furnace_with_ball("kind = \"mirror\"\nreflectance = [1, 1, 1]")).camera(side, side);
    let of = |i: u32| {
        let (origin, direction) = ray(&camera, f64::from(i % side) + 0.5, f64::from(i / side) + 0.5);
        let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        let along = -(0..3).map(|axis| origin[axis] * direction[axis]).sum::<f64>() / length;
        let off2 = origin.iter().map(|x| x * x).sum::<f64>() - along * along;
        // A pixel is up to 0.03 m wide there.
        if off2 < 0.16 * 0.16 {
            (1.0 - off2 / 0.04).sqrt()
        } else if off2 > 0.24 * 0.24 {
            -1.0
        } else {
            0.0
        }
    };
    (0..side * side).map(of).collect()
}

/// Means over the pixels that see the ball and over those that see the walls, and their standard errors from the scatter of seeds.
fn ball_and_walls(fields: &str, change: impl Fn(Settings) -> Settings) -> [(f64, f64); 2] {
    of_scene(&furnace_with_ball(fields), change)
}

fn of_scene(text: &str, change: impl Fn(Settings) -> Settings) -> [(f64, f64); 2] {
    const SIDE: u32 = 32;
    let scene = parse(text);
    let settings = change(Settings { size: [SIDE; 2], ..Settings::of(&scene) });
    let cosines = cosines(SIDE);
    let mut means = [Vec::new(), Vec::new()];
    for seed in 0..SEEDS {
        let rendered = run(&scene, &Settings { seed, ..settings.clone() }, &Device::cpu());
        // Rough glass that absorbs nothing holds some light by total reflection for longer than paths are followed: 0.06 % of caustic photons.
        let catches = text.contains("dielectric") && text.contains("roughness");
        let expected = |problem: &String| catches && problem.contains("given up");
        assert!(rendered.report.problems.iter().all(expected), "{text}: {:?}", rendered.report.problems);
        let pixels = || rendered.image.rgb.iter().zip(&cosines).map(|(rgb, cos)| (f64::from(rgb[1]).min(MOST), *cos));
        means[0].push(mean(&pixels().filter(|(_, cos)| *cos > 0.0).map(|(value, _)| value).collect::<Vec<_>>()));
        means[1].push(mean(&pixels().filter(|(_, cos)| *cos < 0.0).map(|(value, _)| value).collect::<Vec<_>>()));
    }
    means.map(|means| mean_and_error(&means))
}

/// Photon maps without their bias at edges (`Surface::Own`).
///
/// Direct light next to an edge has no variance: a lamp drawn by its area is seen from a point at the distance h of it with a weight of up to
/// 1/h², in a part h² of the draws, so that P(x) ~ x^(−3/2) for single samples. 2.4 million of the furnace have it: 3.1·10⁻³ are above 4, 2.6·10⁻⁴
/// above 16, 2.9·10⁻⁵ above 64, the brightest is 955, and the mean 0.7491 of 0.75 is right. The mean of a picture then follows its few brightest
/// pixels, and no standard error tells how far. So pixels are cut off at [`MOST`], and what that takes is known: 0.5 % of the mean, the part of
/// single samples beyond 32, since pixels have 32 samples. Paths, which also meet lamps by chance and weigh both, have variance 0.07 at a
/// sample and none above 11.
fn photon_maps(settings: Settings) -> Settings {
    Settings { spp: 32, photons: 60_000, caustic_photons: 30_000, k: 60, surface: Surface::Own, ..settings }
}

/// Those, with more photons on a ball that is lit by them.
fn more_photons(settings: Settings) -> Settings {
    Settings { photons: 200_000, ..photon_maps(settings) }
}

fn paths(settings: Settings) -> Settings {
    Settings { integrator: Integrator::Path, spp: 64, ..settings }
}

/// Share of the light from the angle `cos` that microfacets of roughness α reflect once: the mean of G₂·(o·h) / (cos·cos_h) over normals h drawn by
/// D·cos_h, with Smith's height-correlated G₂ (Heitz, "Understanding the Masking-Shadowing Function", 2014, equation 99). By midpoints, in f64,
/// and by other draws than the kernels'.
fn single_scattering(alpha: f64, cos: f64) -> f64 {
    const STEPS: u32 = 200;
    let out = [(1.0 - cos * cos).sqrt(), 0.0, cos];
    let lambda = |z: f64| 0.5 * ((1.0 + alpha * alpha * (1.0 / (z * z) - 1.0)).sqrt() - 1.0);
    let mut sum = 0.0;
    for i in 0..STEPS {
        let u = (f64::from(i) + 0.5) / f64::from(STEPS);
        let tan2 = alpha * alpha * u / (1.0 - u);
        let cos_h = 1.0 / (1.0 + tan2).sqrt();
        for j in 0..STEPS {
            let (sin, cos_phi) = (2.0 * PI * (f64::from(j) + 0.5) / f64::from(STEPS)).sin_cos();
            let sin_h = (1.0 - cos_h * cos_h).sqrt();
            let h = [sin_h * cos_phi, sin_h * sin, cos_h];
            let out_h: f64 = (0..3).map(|axis| out[axis] * h[axis]).sum();
            let into_z = 2.0 * out_h * h[2] - out[2];
            if out_h > 0.0 && into_z > 0.0 {
                sum += out_h / (cos * cos_h * (1.0 + lambda(cos) + lambda(into_z)));
            }
        }
    }
    sum / f64::from(STEPS * STEPS)
}

/// [`single_scattering`] of all that the picture shows of the ball.
fn ball_of_microfacets(alpha: f64) -> f64 {
    let seen: Vec<f64> = cosines(32).into_iter().filter(|cos| *cos > 0.0).collect();
    mean(&seen.iter().map(|cos| single_scattering(alpha, *cos)).collect::<Vec<_>>())
}

/// What loses no light cannot be seen in a furnace, nor does it change how bright the walls are: direct light, both maps, the paths of the eye and the
/// path tracer agree about it. Of a diffuse ball half comes from the map's few photons on it. Rough materials lose what is scattered more
/// than once: at α = 0.0225 that is 0.04 %, by [`single_scattering`]; of refraction and light caught in glass
/// together 0.2 % are allowed.
#[test]
fn what_loses_no_light_is_invisible_in_a_furnace() {
    let loss = 1.0 - ball_of_microfacets(0.15 * 0.15);
    println!("microfacets of α = 0.0225 lose {loss:.5} of what they reflect");
    assert!(loss > 1e-4 && loss < 1e-3, "{loss}");
    for (fields, rough) in [
        ("kind = \"mirror\"\nreflectance = [1, 1, 1]", false),
        ("kind = \"dielectric\"\nior = 1.5", false),
        ("kind = \"dielectric\"\nior = 1.5\nroughness = 0.1", true),
        ("kind = \"conductor\"\nreflectance = [1, 1, 1]", false),
        ("kind = \"conductor\"\nreflectance = [1, 1, 1]\nroughness = 0.15", true),
        ("kind = \"plastic\"\nreflectance = [1, 1, 1]", false),
        ("kind = \"metallic-roughness\"\nreflectance = [1, 1, 1]\nmetallic = 0.5\nroughness = 0.1", true),
        ("kind = \"lambertian\"\nreflectance = [1, 1, 1]", false),
    ] {
        let lost = if rough { 2e-3 } else { 0.0 };
        let is_diffuse = ["plastic", "metallic", "lambertian"].iter().any(|kind| fields.contains(kind));
        let maps = if is_diffuse { more_photons } else { photon_maps };
        for (name, taken, most_se, means) in [
            ("paths", 0.0, 2e-3, ball_and_walls(fields, paths)),
            ("maps", TAKEN, if is_diffuse { 0.025 } else { 0.012 }, ball_and_walls(fields, maps)),
        ] {
            let [(ball, ball_se), (walls, walls_se)] = means;
            println!("{fields:?}, {name}: ball {ball:.4} ± {ball_se:.4}, walls {walls:.4} ± {walls_se:.4}");
            for (what, value, se, lost) in [("ball", ball, ball_se, lost), ("walls", walls, walls_se, 0.0)] {
                let (least, most) = (1.0 - lost - taken - 4.0 * se, 1.0 + 4.0 * se);
                assert!(value > least && value < most && se < most_se, "{fields}, {name}, {what}: {value} ± {se}");
            }
        }
    }
}

/// Lamps of other shapes that reflect half and shine with half, as the walls do, cannot be seen either: a sphere, which is drawn by its solid angle,
/// and triangles. (Maps darken the edges of small triangles, whose discs hang over.)
#[test]
fn lamps_of_every_shape_are_invisible_in_a_furnace() {
    let half = "radiance = [0.5, 0.5, 0.5]";
    let grey = "kind = \"lambertian\"\nreflectance = [0.5, 0.5, 0.5]";
    // An octahedron, which covers all that the sphere's pixels see.
    let octahedron = format!(
        "[[meshes]]\nmaterial = \"ball\"\n{half}\nvertices = [[0.3, 0, 0], [-0.3, 0, 0], [0, 0.3, 0], [0, -0.3, 0], [0, 0, 0.3], [0, 0, -0.3]]\n\
         triangles = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]\n"
    );
    let sphere = furnace_with_ball(grey) + half;
    let triangles = format!("{}\n{octahedron}", furnace_with_ball(grey).split("[[spheres]]").next().unwrap());
    for (name, taken, means) in [
        ("sphere, paths", 0.0, of_scene(&sphere, paths)),
        ("sphere, maps", TAKEN, of_scene(&sphere, photon_maps)),
        ("triangles, paths", 0.0, of_scene(&triangles, paths)),
    ] {
        let [(lamp, lamp_se), (walls, walls_se)] = means;
        println!("{name}: lamp {lamp:.4} ± {lamp_se:.4}, walls {walls:.4} ± {walls_se:.4}");
        for (value, se) in [(lamp, lamp_se), (walls, walls_se)] {
            let (least, most) = (1.0 - taken - 4.0 * se, 1.0 + 4.0 * se);
            assert!(value > least && value < most && se < 0.012, "{name}: {value} ± {se}");
        }
    }
}

/// What does lose light is seen, and as dark as its albedo says. The walls lose some of what it does not send back, at most a hundredth of that.
#[test]
fn what_loses_light_is_as_dark_as_its_albedo() {
    let rough = ball_of_microfacets(0.25);
    println!("microfacets of α = 0.25 reflect {rough:.4}");
    for (fields, least, most) in [
        ("kind = \"conductor\"\nreflectance = [1, 1, 1]\nroughness = 0.5", rough - 0.002, rough),
        ("kind = \"dielectric\"\nior = 1.5\nroughness = 0.4", 0.8, 1.0),
        // F + (1 − F)·½ of a furnace that is nearly 1, F between 0.04 and 1 over the ball, but what the ball reflects is darker too.
        ("kind = \"plastic\"\nreflectance = [0.5, 0.5, 0.5]", 0.48, 0.62),
        ("kind = \"conductor\"\nreflectance = [0.5, 0.5, 0.5]", 0.48, 0.6),
        // Chords of the ball that are seen are 0.24 to 0.4 m long: e^(−2·0.4) is 0.45, e^(−2·0.24) is 0.62.
        ("kind = \"dielectric\"\nior = 1.001\nabsorption = [2, 2, 2]", 0.45, 0.62),
    ] {
        for (name, taken, means) in
            [("paths", 0.0, ball_and_walls(fields, paths)), ("maps", TAKEN, ball_and_walls(fields, photon_maps))]
        {
            let [(ball, se), (walls, walls_se)] = means;
            println!("{fields:?}, {name}: ball {ball:.4} ± {se:.4}, walls {walls:.4} ± {walls_se:.4}");
            assert!(ball > least - taken - 4.0 * se && ball < most + 4.0 * se, "{fields}, {name}: {ball} ± {se}");
            assert!(walls < 1.0 + 4.0 * walls_se && walls > 0.97, "{fields}, {name}: {walls} ± {walls_se}");
        }
    }
}

/// A grey plane of 8 m with the lights `lights`, seen from above: x and z from −1 to 1.
fn plane_with(lights: &str) -> String {
    format!(
        "[camera]\nposition = [0, 2.5, 0]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\nvertical_fov_degrees = 43.6\n\
         [materials.grey]\nkind = \"lambertian\"\nreflectance = [0.5, 0.5, 0.5]\n\
         [[quads]]\ncorner = [-4, 0, -4]\nedge_u = [0, 0, 8]\nedge_v = [8, 0, 0]\nmaterial = \"grey\"\n{lights}\n"
    )
}

const LIGHTS: [&str; 7] = [
    "[[lights]]\nkind = \"spot\"\nposition = [0, 3, 0]\ndirection = [0, -1, 0]\nintensity = [9, 9, 9]\ninner_degrees = 15\nouter_degrees = 25",
    "[[lights]]\nkind = \"directional\"\ndirection = [1, -2, 0]\nirradiance = [2, 2, 2]",
    "[[spheres]]\ncentre = [0, 3, 0]\nradius = 0.4\nradiance = [5, 5, 5]",
    "[[quads]]\ncorner = [-0.5, 3, -0.5]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [4, 4, 4]",
    "[[lights]]\nkind = \"point\"\nposition = [0, 3, 0]\nintensity = [9, 9, 9]",
    "[[discs]]\ncentre = [0, 3, 0]\nnormal = [0, -2, 0]\nradius = 0.6\nradiance = [4, 4, 4]",
    "[[lights]]\nkind = \"environment\"\nradiance = [0.5, 0.5, 0.5]",
];

/// Irradiance below the middle of each of [`LIGHTS`].
fn expected(light: usize) -> f64 {
    match light {
        0 | 4 => 1.0,                           // I / h², 9 / 3²
        1 => 2.0 * 2.0 / 5f64.sqrt(),           // E·cos θ
        2 => PI * 5.0 * (0.4f64 / 3.0).powi(2), // π·L·sin² of the half angle
        5 => PI * 4.0 * 0.36 / (0.36 + 9.0),    // π·L·sin² of the half angle
        6 => PI * 0.5,                          // π·L
        _ => {
            // Four corners of a quarter each: E = L/2·Σ of the edges' view factors of a rectangle above a parallel patch.
            let x: f64 = 0.5 / 3.0;
            let root = (1.0 + x * x).sqrt();
            4.0 * 4.0 * 0.5 * 2.0 * (x / root) * (x / root).atan()
        }
    }
}

#[test]
fn lights_shine_as_closed_forms_say_and_so_do_their_photons() {
    for (i, light) in LIGHTS.iter().enumerate() {
        let scene = parse(&plane_with(light));
        // Of an environment's photons a fourth as many come to the picture; and those from below are not to be seen.
        let (photons, surface) = (if i == 6 { 1_600_000 } else { 400_000 }, Surface::Facing);
        let of = |show: Show, size: u32, spp: u32| {
            let base = Settings { photons, surface, k: 100, radius: 0.3, ..Settings::of(&scene) };
            let settings = Settings { size: [size; 2], spp, show, ..base };
            image(&scene, &settings, &Device::cpu())
        };
        // The middle 2 × 2 of 64 × 64 pixels: within 3 cm, where the light is even to a ten-thousandth.
        // Of an environment half of the shadow rays go below the horizon, and the others are as many from everywhere.
        let picture = of(Show::Direct, 64, if i == 6 { 1024 } else { 64 });
        let middle: Vec<f64> =
            [(31, 31), (32, 31), (31, 32), (32, 32)].map(|(x, y)| f64::from(picture.rgb[y * 64 + x][1])).to_vec();
        let (found, wanted) = (mean(&middle) * PI / REFLECTANCE, expected(i));
        println!("{}: {found:.5} below it, expected {wanted:.5}", light.lines().nth(1).unwrap());
        assert!((found / wanted - 1.0).abs() < 5e-3, "light {i}: {found}, not {wanted}");
        // The same light by its photons: of the point's and the directional light's, 1.3·10⁴ are in the picture, so their number is
        // good to 0.9 %; three times that.
        let [direct] = [mean_rgb(&of(Show::Direct, 32, 16))[1]];
        let mapped = mean_rgb(&of(Show::MapGlobal, 32, 4))[1];
        println!("    mean radiance {direct:.5} by shadow rays, {mapped:.5} by photons");
        assert!((mapped / direct - 1.0).abs() < 0.027, "light {i}: {mapped} by photons, {direct} by shadow rays");
    }
}

/// A pass's ledger, one light.
fn caustic_ledger(text: &str) -> LightLedger {
    let scene = parse(text);
    let settings = Settings { caustic_photons: 200_000, show: Show::MapCaustic, size: [4, 4], ..Settings::of(&scene) };
    let report = run(&scene, &settings, &Device::cpu()).report;
    assert_eq!(report.problems, [""; 0]);
    report.maps[0].ledger[0].clone()
}

/// Aimed photons carry the power that the light sends into the union of all cones or shadows, however these overlap.
#[test]
fn aimed_photons_carry_the_power_of_what_they_are_aimed_at() {
    let ball =
        |x: f64, radius: f64| format!("[[spheres]]\ncentre = [{x}, 1, 0]\nradius = {radius}\nmaterial = \"mirror\"\n");
    let mirror = "[materials.mirror]\nkind = \"mirror\"\nreflectance = [1, 1, 1]\n";
    let point = plane_with(&format!("{mirror}{}", LIGHTS[4]));
    let sun = plane_with(&format!("{mirror}{}", LIGHTS[1]));
    // 2 m below the light, 0.5 m in radius: Ω = 2π(1 − cos), sin = 1/4.
    let cone = 9.0 * 2.0 * PI * (1.0 - (1.0f64 - 1.0 / 16.0).sqrt());
    let shadow = 2.0 * PI * 0.25;
    let sky = plane_with(&format!("{mirror}{}", LIGHTS[6]));
    for (name, text, wanted) in [
        // From each direction a shadow as large as the ball: 4π·L·π·r².
        ("all around", format!("{sky}{}", ball(0.0, 0.5)), 4.0 * PI * 0.5 * PI * 0.25),
        ("a cone", format!("{point}{}", ball(0.0, 0.5)), cone),
        ("a cone in a cone", format!("{point}{}{}", ball(0.0, 0.5), ball(0.05, 0.3)), cone),
        ("a shadow", format!("{sun}{}", ball(0.0, 0.5)), shadow),
        ("a shadow in a shadow", format!("{sun}{}{}", ball(0.0, 0.5), ball(0.1, 0.3)), shadow),
        ("two shadows", format!("{sun}{}{}", ball(-1.0, 0.5), ball(1.5, 0.5)), 2.0 * shadow),
    ] {
        let ledger = caustic_ledger(&text);
        println!("{name}: {:.4} W, expected {wanted:.4} W", ledger.emitted_w[1]);
        // One cone has no noise; with a second, powers differ by a factor of 2 or less among 200,000 photons.
        assert!((ledger.emitted_w[1] / wanted - 1.0).abs() < 5e-3, "{name}: {:?}, not {wanted}", ledger.emitted_w);
    }
}

#[test]
fn ledgers_of_all_built_in_scenes_close() {
    for built_in in caustic_renderer::scene::BUILT_IN {
        let scene = load(built_in.name);
        let settings =
            Settings { photons: 20_000, caustic_photons: 20_000, size: [16, 12], spp: 1, ..Settings::of(&scene) };
        let report = run(&scene, &settings, &Device::cpu()).report;
        assert_eq!(report.problems, [""; 0], "{}", built_in.name);
        for map in &report.maps {
            let paths: u64 = map.ledger.iter().map(|light| light.paths).sum();
            assert!(paths > 10_000, "{}: {paths} paths in the {} map", built_in.name, map.map);
        }
    }
}

#[test]
fn a_gpu_computes_the_same_bits() {
    let Some(device) = gpu() else { return };
    let kinds = [
        "kind = \"dielectric\"\nior = 1.4\nroughness = 0.5\nabsorption = [0.5, 1, 2]",
        "kind = \"conductor\"\nreflectance = [0.9, 0.6, 0.3]\nroughness = 0.4",
        "kind = \"plastic\"\nreflectance = [0.2, 0.6, 0.3]\nroughness = 0.3",
        "kind = \"metallic-roughness\"\nreflectance = [0.8, 0.6, 0.3]\nmetallic = 0.5\nroughness = 0.03",
    ];
    let balls = kinds.map(furnace_with_ball);
    let lights = LIGHTS[..3].iter().chain(&LIGHTS[5..]).map(|light| plane_with(light));
    for text in balls.into_iter().chain(lights) {
        let scene = parse(&text);
        let settings = Settings { size: [24, 18], ..small(&scene) };
        let ours = image(&scene, &settings, &Device::cpu());
        let theirs = image(&scene, &settings, device);
        assert_eq!(ours.sha256(), theirs.sha256(), "{text}");
    }
}
