//! Layers: they add up to the picture, have the same bits on every device, and tell the truth.

use caustic_device::{Device, LaneOrder};
use caustic_kernels::layout::Query;
use caustic_photon_map::{Gather, Hash};
use caustic_renderer::output::{Layer, LayerKind};
use caustic_renderer::scene::Scene;
use caustic_renderer::{RenderError, Rendered, Settings, Show, View};
use caustic_tests::renders::*;
use caustic_tests::{assert_same_words, gpu};

fn all(scene: &Scene) -> Settings {
    Settings { layers: LayerKind::OF_PHOTON_MAPS.to_vec(), ..small(scene) }
}

fn layer(rendered: &Rendered, kind: LayerKind) -> &[f32] {
    let found: Vec<&Layer> = rendered.layers.iter().filter(|layer| layer.kind == kind).collect();
    assert_eq!(found.len(), 1, "{kind:?}");
    &found[0].values
}

#[test]
fn the_layers_of_light_add_up_to_the_picture_bit_for_bit() {
    let scene = load("cornell");
    let rendered = run(&scene, &all(&scene), &Device::cpu());
    let [direct, global, caustic] =
        [LayerKind::Direct, LayerKind::Global, LayerKind::Caustic].map(|kind| layer(&rendered, kind));
    let sum: Vec<f32> = (0..direct.len()).map(|i| (direct[i] + global[i]) + caustic[i]).collect();
    assert_same_words("sum", floats(&rendered.image), &sum);
    assert!(direct.iter().any(|&x| x > 0.0) && global.iter().any(|&x| x > 0.0) && caustic.iter().any(|&x| x > 0.0));
    // And each is the picture that --show makes of it.
    for (show, part) in [(Show::Direct, direct), (Show::Global, global), (Show::Caustic, caustic)] {
        let shown = image(&scene, &Settings { show, ..small(&scene) }, &Device::cpu());
        assert_same_words(&format!("{show:?}"), floats(&shown), part);
    }
    // Layers change nothing about the picture.
    assert_same_words("plain", floats(&image(&scene, &small(&scene), &Device::cpu())), floats(&rendered.image));
}

#[test]
fn layers_have_the_same_bits_everywhere() {
    let scene = load("cornell");
    let expected = run(&scene, &all(&scene), &Device::cpu()).layers;
    let mut devices = vec![(Device::cpu_with_order(LaneOrder::Shuffled(5)), Hash::Linear, Gather::Histogram)];
    devices.push((Device::cpu(), Hash::Teschner, Gather::List));
    for (device, hash, gather) in &devices {
        let settings = Settings { hash: *hash, gather: *gather, ..all(&scene) };
        assert_eq!(run(&scene, &settings, device).layers, expected);
    }
    if let Some(gpu) = gpu() {
        for (found, expected) in run(&scene, &all(&scene), gpu).layers.iter().zip(&expected) {
            assert_same_words(expected.kind.name(), &expected.values, &found.values);
        }
    }
}

/// Of the plane under a lamp everything is known: where the camera's rays meet it, and what it is made of.
#[test]
fn depth_normal_and_albedo_of_a_plane_are_those_of_geometry() {
    let scene = parse(LAMP);
    let settings = Settings { size: [16, 16], spp: 64, show: Show::Direct, ..all(&scene) };
    let settings = Settings { layers: vec![LayerKind::Normal, LayerKind::Albedo, LayerKind::Depth], ..settings };
    let rendered = run(&scene, &settings, &Device::cpu());
    let camera = scene.camera(16, 16);
    let depth = layer(&rendered, LayerKind::Depth);
    for pixel in 0..256u32 {
        let (x, y) = (f64::from(pixel % 16) + 0.5, f64::from(pixel / 16) + 0.5);
        let [px, pz] = on_floor(&camera, x, y);
        let expected = (px * px + pz * pz + 0.75 * 0.75).sqrt();
        // Samples lie anywhere in the pixel, an eighth of a metre wide: their mean differs by far less than its half.
        let found = f64::from(depth[pixel as usize]);
        assert!((found - expected).abs() < 0.01, "pixel {pixel}: {found} and not {expected}");
    }
    for rgb in layer(&rendered, LayerKind::Albedo) {
        assert!((f64::from(*rgb) - REFLECTANCE).abs() < 1e-6, "{rgb}");
    }
    for normal in layer(&rendered, LayerKind::Normal).chunks(3) {
        assert_eq!(normal, [0.0, 1.0, 0.0]);
    }
}

/// The radius and the number of photons of one sample a pixel are those of its search, which is done again here photon by photon.
#[test]
fn the_radius_is_the_distance_of_the_last_photon() {
    let scene = load("cornell");
    let (k, size) = (14, [24, 16]);
    let settings = Settings { k, size, spp: 1, show: Show::MapGlobal, radius: 0.15, ..all(&scene) };
    let settings = Settings { layers: vec![LayerKind::Radius, LayerKind::Photons], ..settings };
    let rendered = run(&scene, &settings, &Device::cpu());
    let device = Device::cpu();
    let photons =
        caustic_renderer::trace_photons(&device, &scene, Show::MapGlobal, settings.photons, settings.seed).unwrap();
    let view = View::new(&device, &scene, size, 1, settings.seed).unwrap();
    let queries: Vec<Query> = device.read(&view.queries, u64::from(view.count())).unwrap();
    let (radius, counts) = (layer(&rendered, LayerKind::Radius), layer(&rendered, LayerKind::Photons));
    let (mut full, mut sparse) = (0, 0);
    for (pixel, query) in queries.iter().enumerate() {
        let found = [radius[2 * pixel], counts[2 * pixel]];
        if query.active == 0 {
            assert_eq!(found, [0.0, 0.0]);
            continue;
        }
        let distance = |p: [f32; 3]| {
            let square: f64 = (0..3).map(|axis| (f64::from(p[axis]) - f64::from(query.position[axis])).powi(2)).sum();
            square.sqrt()
        };
        let mut all: Vec<f64> = photons.iter().map(|photon| distance(photon.position)).collect();
        all.sort_by(f64::total_cmp);
        let within = all.iter().filter(|&&d| d <= 0.15).count();
        let expected = if within > k as usize { all[k as usize] } else { 0.15 };
        full += usize::from(within > k as usize);
        sparse += usize::from(within <= k as usize);
        // A few roundings of f32: of the distance and of its root.
        assert!((f64::from(found[0]) / expected - 1.0).abs() < 2e-6, "pixel {pixel}: {} and not {expected}", found[0]);
        assert_eq!(found[1], within.min(k as usize) as f32, "pixel {pixel}");
        // There is no caustic map to tell of.
        assert_eq!([radius[2 * pixel + 1], counts[2 * pixel + 1]], [0.0, 0.0]);
    }
    assert!(full > 50 && sparse > 20, "{full} queries with enough photons, {sparse} without");
}

#[test]
fn layers_that_a_picture_does_not_have_are_refused() {
    let scene = load("cornell");
    for (show, layer) in [
        (Show::Direct, LayerKind::Global),
        (Show::Direct, LayerKind::Radius),
        (Show::MapCaustic, LayerKind::Direct),
        (Show::Beauty, LayerKind::Variance),
        (Show::Direct, LayerKind::Bias),
    ] {
        let settings = Settings { show, layers: vec![layer], ..small(&scene) };
        assert!(matches!(settings.validate(), Err(RenderError::NoLayer { .. })), "{show:?} {layer:?}");
    }
}
