//! Pictures that cut holes, bend normals and shine: against scenes without them, closed forms, and the bits of a GPU. Seeds are fixed; bounds are 4
//! standard errors.

use caustic_device::Device;
use caustic_photon_map::Surface;
use caustic_renderer::scene::Scene;
use caustic_renderer::{Integrator, Settings, Show};
use caustic_tests::renders::*;
use caustic_tests::{assert_same_words, gpu};
use std::f64::consts::PI;
use std::path::Path;
use tempfile::TempDir;

/// Writes a picture of `side` × `side` pixels.
fn picture(folder: &TempDir, name: &str, side: u32, pixel: impl Fn(u32, u32) -> [u8; 4]) {
    let image = image::RgbaImage::from_fn(side, side, |x, y| image::Rgba(pixel(x, y)));
    image.save(folder.path().join(name)).unwrap();
}

/// A scene beside the pictures.
fn scene(folder: &TempDir, text: &str) -> Scene {
    Scene::parse(&folder.path().join("scene.toml").to_string_lossy(), text).expect("a scene")
}

/// A floor in the light of a lamp, with a mirror ball, and what is `between`.
fn with(between: &str) -> String {
    format!(
        "{LAMP}\n[materials.mirror]\nkind = \"mirror\"\nreflectance = [0.9, 0.9, 0.9]\n\
         [[spheres]]\ncentre = [0.8, 0.2, 0.3]\nradius = 0.2\nmaterial = \"mirror\"\n{between}"
    )
}

/// A sheet below the lamp and above the camera's floor.
fn sheet(fields: &str) -> String {
    format!(
        "[materials.sheet]\nkind = \"lambertian\"\nreflectance = [0.5, 0.5, 0.5]\n{fields}\n\
         [[quads]]\ncorner = [-1, 0.5, -1]\nedge_u = [0, 0, 2]\nedge_v = [2, 0, 0]\nmaterial = \"sheet\"\n"
    )
}

fn integrators(scene: &Scene) -> [(&'static str, Settings); 3] {
    let base = Settings { size: [24, 18], ..small(scene) };
    [
        ("photon", base.clone()),
        ("path", Settings { integrator: Integrator::Path, ..base.clone() }),
        ("final gather", Settings { final_gather: 2, ..base }),
    ]
}

/// A sheet that is all hole is not there, and one that has no hole is as if it could have none: to the last bit.
#[test]
fn a_sheet_of_holes_is_not_there() {
    let folder = tempfile::tempdir().unwrap();
    picture(&folder, "clear.png", 4, |_, _| [255, 255, 255, 100]);
    picture(&folder, "solid.png", 4, |_, _| [255, 255, 255, 150]);
    let cut = |name: &str| with(&sheet(&format!("texture = \"{name}\"\nalpha_cutoff = 0.5")));
    let nothing = scene(&folder, &with("[materials.sheet]\nkind = \"lambertian\"\nreflectance = [0.5, 0.5, 0.5]"));
    let plain = scene(&folder, &with(&sheet("texture = \"solid.png\"")));
    let (clear, solid) = (scene(&folder, &cut("clear.png")), scene(&folder, &cut("solid.png")));
    for (name, settings) in integrators(&nothing) {
        let of = |scene: &Scene| image(scene, &settings, &Device::cpu());
        let (without, opaque) = (of(&nothing), of(&plain));
        assert_same_words(name, floats(&of(&clear)), floats(&without));
        assert_same_words(name, floats(&of(&solid)), floats(&opaque));
        assert_ne!(floats(&without), floats(&opaque), "{name}");
    }
}

/// Holes let half of a directional light through: to the floor below them, in the pattern of the picture.
#[test]
fn holes_let_light_through_where_they_are() {
    let folder = tempfile::tempdir().unwrap();
    picture(&folder, "half.png", 2, |x, _| [255, 255, 255, if x == 0 { 0 } else { 255 }]);
    let text = "[camera]\nposition = [0, 0.4, 0]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\nvertical_fov_degrees = 90\n\
        [materials.grey]\nkind = \"lambertian\"\nreflectance = [0.5, 0.5, 0.5]\n\
        [materials.sheet]\nkind = \"lambertian\"\nreflectance = [0, 0, 0]\ntexture = \"half.png\"\nalpha_cutoff = 0.5\n\
        [[quads]]\ncorner = [-4, 0, -4]\nedge_u = [0, 0, 8]\nedge_v = [8, 0, 0]\nmaterial = \"grey\"\n\
        [[quads]]\ncorner = [-4, 0.5, 4]\nedge_u = [8, 0, 0]\nedge_v = [0, 0, -8]\nmaterial = \"sheet\"\n\
        [[lights]]\nkind = \"directional\"\ndirection = [0, -1, 0]\nirradiance = [2, 2, 2]\n";
    let scene = scene(&folder, text);
    let base = Settings { size: [16, 16], ..small(&scene) };
    let lit = 2.0 * REFLECTANCE / PI;
    for (name, allowed, settings) in [
        ("direct", 1e-5, Settings { integrator: Integrator::Direct, ..base.clone() }),
        ("path", 1e-5, Settings { integrator: Integrator::Path, ..base.clone() }),
        // Of some 300 photons on either side that the picture sees.
        ("map", 0.2, Settings { show: Show::MapGlobal, photons: 200_000, radius: 0.1, surface: Surface::Own, ..base }),
    ] {
        let found = image(&scene, &settings, &Device::cpu());
        // u grows with x; bilinear alpha is ½ where x is 0: the pixels there are left out.
        for (what, columns, wanted) in [("lit", 0..6, lit), ("in shadow", 10..16, 0.0)] {
            let pixels = found.rgb.iter().enumerate().filter(|(i, _)| columns.contains(&(i % 16)));
            let mean = mean(&pixels.map(|(_, rgb)| f64::from(rgb[0])).collect::<Vec<_>>());
            println!("{name}, {what}: {mean:.5}, expected {wanted:.5}");
            assert!((mean - wanted).abs() < allowed * lit, "{name}, {what}: {mean}, not {wanted}");
        }
    }
}

/// A code of a normal map, from −1 to 1.
fn decoded(code: u8) -> f64 {
    2.0 * f64::from(code) / 255.0 - 1.0
}

/// Normals that a picture bends are met by directional light as their cosine says: on a quad, on triangles, and where texture coordinates are
/// mirrored or turned.
#[test]
fn bent_normals_shade_as_their_cosine_says() {
    let folder = tempfile::tempdir().unwrap();
    let code = [190u8, 160, 220];
    picture(&folder, "bent.png", 2, |_, _| [code[0], code[1], code[2], 255]);
    let light = [0.3f64, -1.0, 0.2];
    // Seen from straight above: a normal whose mirror image of the view is below the surface would be lifted.
    let mesh = |uv: &str| {
        format!(
            "[[meshes]]\nvertices = [[-2, 0, 2], [2, 0, 2], [2, 0, -2], [-2, 0, -2]]\n\
             triangles = [[0, 1, 2], [0, 2, 3]]\nuv = {uv}\nmaterial = \"bent\"\n"
        )
    };
    let quad =
        "[[quads]]\ncorner = [-2, 0, 2]\nedge_u = [4, 0, 0]\nedge_v = [0, 0, -4]\nmaterial = \"bent\"\n".to_string();
    // Where u grows, and where the picture's upper edge is, against which v grows.
    for (what, shape, right, up, scale) in [
        // Of a quad u × v is the normal, so that its pictures stand on their heads, and are mirrored.
        ("a quad", quad.clone(), [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], 1.0),
        ("a quad with less of it", quad, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.25),
        ("triangles", mesh("[[0, 1], [1, 1], [1, 0], [0, 0]]"), [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], 1.0),
        ("mirrored", mesh("[[1, 1], [0, 1], [0, 0], [1, 0]]"), [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0], 1.0),
        ("turned", mesh("[[0, 0], [0, 1], [1, 1], [1, 0]]"), [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], 1.0),
    ] {
        let text = format!(
            "[camera]\nposition = [0, 4, 0]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\nvertical_fov_degrees = 10\n\
             [materials.bent]\nkind = \"lambertian\"\nreflectance = [0.5, 0.5, 0.5]\nnormal_texture = \"bent.png\"\nnormal_scale = {scale}\n\
             {shape}[[lights]]\nkind = \"directional\"\ndirection = {light:?}\nirradiance = [2, 2, 2]\n"
        );
        let scene = scene(&folder, &text);
        let [x, y, z] = [decoded(code[0]) * scale, decoded(code[1]) * scale, decoded(code[2])];
        let normal: [f64; 3] = std::array::from_fn(|c| right[c] * x + up[c] * y + [0.0, 1.0, 0.0][c] * z);
        let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let cos = -(0..3).map(|c| normal[c] * light[c]).sum::<f64>() / length(normal) / length(light);
        let wanted = 2.0 * REFLECTANCE / PI * cos;
        for integrator in [Integrator::Direct, Integrator::Path] {
            let settings = Settings { size: [8, 8], integrator, ..small(&scene) };
            let found = image(&scene, &settings, &Device::cpu());
            for pixel in &found.rgb {
                // Halves have 11 bits.
                let off = (f64::from(pixel[1]) / wanted - 1.0).abs();
                assert!(off < 2e-3, "{what}, {integrator:?}: {} and not {wanted}", pixel[1]);
            }
        }
    }
}

/// A lamp of which a picture leaves half is a lamp of half the size: by shadow rays, by paths, and by photons.
#[test]
fn a_lamp_with_a_picture_shines_where_it_is_bright() {
    let folder = tempfile::tempdir().unwrap();
    picture(&folder, "half.png", 64, |x, _| if x < 32 { [255; 4] } else { [0, 0, 0, 255] });
    let lamp = |fields: &str, width: f64| {
        LAMP.replace("[[quads]]\nname = \"lamp\"", &format!("{fields}[[quads]]\nname = \"lamp\""))
            .replace("edge_u = [1, 0, 0]", &format!("edge_u = [{width}, 0, 0]"))
            + if fields.is_empty() { "" } else { "material = \"lamp\"\n" }
    };
    let black = "[materials.lamp]\nkind = \"lambertian\"\nreflectance = [0, 0, 0]\nemission_texture = \"half.png\"\n";
    let half = scene(&folder, &lamp("", 0.5));
    let textured = scene(&folder, &lamp(black, 1.0));
    // The same of two triangles.
    let mesh = "[[meshes]]\nvertices = [[-0.5, 1, -0.5], [0.5, 1, -0.5], [0.5, 1, 0.5], [-0.5, 1, 0.5]]\n\
        triangles = [[0, 1, 2], [0, 2, 3]]\nuv = [[0, 0], [1, 0], [1, 1], [0, 1]]\nmaterial = \"lamp\"\nradiance = [4, 4, 4]\n";
    let without = LAMP.split("[[quads]]\nname = \"lamp\"").next().unwrap();
    let triangles = scene(&folder, &format!("{without}{black}{mesh}"));
    let power = |scene: &Scene| scene.compile().emitted_power_w[1];
    for scene in [&textured, &triangles] {
        assert!((power(scene) / power(&half) - 1.0).abs() < 1e-2, "{} {}", power(scene), power(&half));
    }
    let base = Settings { size: [16, 16], spp: 64, ..small(&half) };
    let map = Settings { show: Show::MapGlobal, photons: 100_000, spp: 2, surface: Surface::Facing, ..base.clone() };
    for (name, settings) in [
        ("direct", Settings { integrator: Integrator::Direct, ..base.clone() }),
        ("path", Settings { integrator: Integrator::Path, ..base.clone() }),
        ("map", map),
    ] {
        let means = |scene: &Scene| {
            let of = |seed| image(scene, &Settings { seed, ..settings.clone() }, &Device::cpu());
            let pictures: Vec<_> = (0..6).map(of).collect();
            // The left and the right half of the picture.
            [0, 1].map(|side| {
                let of_side = |picture: &caustic_renderer::output::Image| {
                    let pixels = picture.rgb.iter().enumerate().filter(|(i, _)| i % 16 / 8 == side);
                    mean(&pixels.map(|(_, rgb)| f64::from(rgb[1])).collect::<Vec<_>>())
                };
                mean_and_error(&pictures.iter().map(of_side).collect::<Vec<_>>())
            })
        };
        let wanted = means(&half);
        for (what, scene) in [("quad", &textured), ("triangles", &triangles)] {
            for ((found, se), (wanted, other)) in means(scene).into_iter().zip(wanted) {
                println!("{name}, {what}: {found:.5} ± {se:.5}, expected {wanted:.5} ± {other:.5}");
                // The edge between bright and dark is blurred by a sixty-fourth.
                assert!((found - wanted).abs() < 4.0 * se.hypot(other) + 5e-3 * wanted, "{name}, {what}");
            }
        }
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    picture(&folder, "a.png", 2, |_, _| [255; 4]);
    let ball = "[[spheres]]\ncentre = [0, 0.5, 0]\nradius = 0.2\nradiance = [1, 1, 1]\nmaterial = \"sheet\"\n";
    for (fields, shape, words) in [
        ("alpha_cutoff = 0.5", "", "means nothing without a `texture`"),
        ("texture = \"a.png\"\nalpha_cutoff = 2", "", "must be from 0.001 to 1"),
        ("normal_scale = 1", "", "means nothing without a `normal_texture`"),
        ("normal_texture = \"b.png\"", "", "normal_texture` names a file that cannot be read"),
        ("texture = \"a.png\"\nalpha_cutoff = 0.5", ball, "has holes"),
        ("emission_texture = \"a.png\"", ball, "spheres have no texture coordinates"),
    ] {
        let text = with(&format!("{}{shape}", sheet(fields)));
        let path = folder.path().join("scene.toml");
        let error = Scene::parse(&path.to_string_lossy(), &text).unwrap_err().to_string();
        assert!(error.contains(words) && !error.contains('\n'), "{fields}: {error}");
    }
    assert!(Path::new(folder.path()).is_dir());
}

#[test]
fn a_gpu_computes_the_same_bits() {
    let Some(gpu) = gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let noise = |x: u32, y: u32| [x * 53 + y * 97, x * 31 + y * 11, x * 7 + y * 71, x * 89 + y * 29].map(|n| n as u8);
    picture(&folder, "noise.png", 16, noise);
    let pictures = "texture = \"noise.png\"\nalpha_cutoff = 0.5\nnormal_texture = \"noise.png\"";
    let glow = "[materials.glow]\nkind = \"plastic\"\nreflectance = [0.5, 0.4, 0.3]\nroughness = 0.4\nemission_texture = \"noise.png\"\n\
        [[meshes]]\nvertices = [[-1, 0.1, -1], [1, 0.1, -1], [0, 0.6, -1.2]]\ntriangles = [[0, 1, 2]]\n\
        normals = [[0, 1, 1], [0, 0, 1], [1, 1, 1]]\nuv = [[0, 0], [1, 0], [0.3, 1]]\nmaterial = \"glow\"\nradiance = [3, 2, 1]\n\
        [[discs]]\ncentre = [-0.6, 0.3, 0.6]\nnormal = [1, 2, 0]\nradius = 0.3\nmaterial = \"glow\"\nradiance = [1, 2, 3]\n";
    let sky = "[[lights]]\nkind = \"environment\"\nfile = \"built-in:sky\"\nrotation_degrees = 70\nradiance = [0.1, 0.2, 0.3]\n";
    let scene = scene(&folder, &with(&format!("{}{glow}{sky}", sheet(pictures))));
    // The final gather's kernel is the camera's, once more, and takes a software GPU as long to compile.
    for (name, settings) in integrators(&scene).into_iter().take(2) {
        let (a, b) = (image(&scene, &settings, &Device::cpu()), image(&scene, &settings, gpu));
        assert_same_words(name, floats(&a), floats(&b));
    }
}
