//! A render from code: a scene as text, settings, a picture with layers.
//!
//! `cargo run --release --example render_from_code [-- FOLDER]` writes ball.exr and ball.png.

use caustic_device::Device;
use caustic_renderer::output::{Display, Extras, LayerKind, Metadata, ToneMap, write_with};
use caustic_renderer::scene::Scene;
use caustic_renderer::{Settings, render};
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or(".".to_string()));

    // A scene is text, so code can write it. `Scene::load("cornell")` has one of the built-in scenes.
    let balls: String = (0..5)
        .map(|i| {
            let (x, radius) = (f64::from(i) * 0.7 - 1.4, 0.15 + 0.04 * f64::from(i));
            format!("[[spheres]]\ncentre = [{x}, {radius}, 0]\nradius = {radius}\nmaterial = 'glass'\n")
        })
        .collect();
    let scene = Scene::parse("balls", &format!("{TABLE}{balls}"))?;

    let settings = Settings {
        size: [320, 180],
        photons: 200_000,
        caustic_photons: 400_000,
        layers: vec![LayerKind::Direct, LayerKind::Global, LayerKind::Caustic, LayerKind::Depth],
        ..Settings::of(&scene)
    };
    let (device, line) = Device::open(&"auto".parse()?)?;
    println!("{line}");
    // The closure hears of progress, and stops the render by returning false.
    let rendered = render(&scene, &settings, &device, &mut |_| true)?;
    for map in &rendered.report.maps {
        println!("{} map: {} photons", map.map, map.photons_stored);
    }

    // (direct + global) + caustic is the picture, bit for bit.
    let [direct, global, caustic] = [0, 1, 2].map(|layer| &rendered.layers[layer].values);
    let same = rendered.image.rgb.as_flattened().iter().enumerate().all(|(i, value)| {
        let sum = (direct[i] + global[i]) + caustic[i];
        sum.to_bits() == value.to_bits()
    });
    println!("the layers add up to the picture: {same}");

    let metadata = Metadata { scene: scene.name.clone(), seed: settings.seed, ..Metadata::default() };
    let layers = Extras { layers: &rendered.layers, ..Extras::default() };
    write_with(&folder.join("ball.exr"), &rendered.image, &metadata, &layers)?;
    let shown = Extras { display: Display { exposure: 0.5, tone: ToneMap::Agx }, ..Extras::default() };
    write_with(&folder.join("ball.png"), &rendered.image, &metadata, &shown)?;
    println!("wrote ball.exr and ball.png in {}; mean {:.4?}", folder.display(), rendered.report.mean_radiance);
    Ok(())
}

const TABLE: &str = "
[camera]
position = [0, 1.2, 4]
target = [0, 0.3, 0]
vertical_fov_degrees = 30

[materials.white]
kind = 'lambertian'
reflectance = [0.8, 0.8, 0.8]

[materials.glass]
kind = 'dielectric'
ior = 1.5

[[quads]]
name = 'table'
corner = [-3, 0, -3]
edge_u = [0, 0, 6]
edge_v = [6, 0, 0]
material = 'white'

[[quads]]
name = 'lamp'
corner = [-0.3, 2.5, -1]
edge_u = [0.6, 0, 0]
edge_v = [0, 0, 0.6]
radiance = [30, 28, 24]
";
