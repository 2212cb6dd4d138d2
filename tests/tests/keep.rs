//! Photons that no query can use are left out, and nothing else: pictures keep their bits.

use caustic_device::{Device, LaneOrder, Plan};
use caustic_kernels::gather::distance2;
use caustic_kernels::layout::{Photon, Query};
use caustic_photon_map::{Filter, Hash, SeenCells, Surface};
use caustic_renderer::output::LayerKind;
use caustic_renderer::{Integrator, Keep, RenderError, Settings, Stop};
use caustic_tests::points::{photons_at, uniform};
use caustic_tests::renders::*;
use caustic_tests::{assert_same_words, gpu};

#[test]
fn pictures_have_the_same_bits_with_the_photons_near_what_is_seen_alone() {
    let ways = [
        Settings { ..small(&load("cornell")) },
        Settings { surface: Surface::Own, filter: Filter::Cone, hash: Hash::Morton, ..small(&load("cornell")) },
    ];
    for (name, radius) in [("cornell", 0.1), ("pool", 0.05), ("landscape", 60.0), ("hall", 0.5), ("lamps", 0.05)] {
        let scene = load(name);
        for way in &ways {
            for integrator in [Integrator::Photon, Integrator::Progressive] {
                let settings = Settings {
                    integrator,
                    radius,
                    photons: 6000,
                    caustic_photons: 6000,
                    size: [24, 16],
                    stop: Stop { passes: Some(2), ..Stop::default() },
                    layers: vec![LayerKind::Radius, LayerKind::Photons, LayerKind::Bias],
                    ..way.clone()
                };
                let all = run(&scene, &settings, &Device::cpu());
                let device = Device::cpu_with_order(LaneOrder::Shuffled(7));
                let kept = run(&scene, &Settings { keep: Keep::Visible, ..settings.clone() }, &device);
                let what = format!("{name}, {integrator:?}, {:?}", way.surface);
                assert_same_words(&what, floats(&all.image), floats(&kept.image));
                assert_eq!(all.layers, kept.layers, "{what}");
                for (all, kept) in all.report.maps.iter().zip(&kept.report.maps) {
                    assert_eq!(all.photons_stored, all.photons_kept);
                    assert_eq!(all.photons_stored, kept.photons_stored);
                    assert!(kept.photons_kept < all.photons_kept, "{what}, {} map: all are kept", all.map);
                    println!("{what}: {} of {} photons of the {} map", kept.photons_kept, kept.photons_stored, all.map);
                }
            }
        }
    }
}

/// The queries of two tiles and photons in a box, with the photons that are kept, on one device.
fn kept(device: &Device, tiles: &[Vec<Query>], photons: &[Photon], radius: f32) -> Vec<Photon> {
    let cells = SeenCells::new(device, [-1.0; 3], [1.0; 3], radius).unwrap();
    for tile in tiles {
        let queries = device.upload("queries", tile).unwrap();
        let mut plan = Plan::new();
        cells.plan_mark(device, &mut plan, &queries, tile.len() as u32).unwrap();
        device.run(&plan).unwrap();
    }
    let all = device.upload("photons", photons).unwrap();
    let (kept, count) = cells.keep(device, &all, photons.len() as u32).unwrap();
    device.read(&kept, u64::from(count)).unwrap()
}

#[test]
fn what_is_within_the_radius_of_a_query_is_kept_and_what_is_far_is_not() {
    let photons = photons_at(1, &uniform(1, 20_000, [-1.0; 3], [1.0; 3]));
    let tile = |seed: u32| -> Vec<Query> {
        let place = |(i, position): (usize, [f32; 3])| Query { position, active: u32::from(i % 5 != 0) };
        uniform(seed, 40, [-0.9, -0.5, -0.9], [0.3, 0.9, 0.2]).into_iter().enumerate().map(place).collect()
    };
    let tiles = [tile(2), tile(3)];
    for radius in [0.01f32, 0.07, 0.3, 5.0] {
        let found = kept(&Device::cpu(), &tiles, &photons, radius);
        let nearest2 = |photon: &Photon| {
            let active = tiles.iter().flatten().filter(|query| query.active != 0);
            active.map(|query| distance2(query.position, photon.position)).fold(f32::MAX, f32::min)
        };
        let mut next = 0;
        let (mut near, mut left_out) = (0, 0);
        // In their order, each once.
        for photon in &photons {
            let is_kept = found.get(next) == Some(photon);
            next += usize::from(is_kept);
            near += usize::from(nearest2(photon) <= radius * radius);
            left_out += usize::from(!is_kept);
            assert!(is_kept || nearest2(photon) > radius * radius, "{radius}: {photon:?} is missing");
            // A cell is as wide as the radius and a little: farther than its diagonal beyond the radius, none is kept but near the last cell, which
            // queries that seek nothing mark.
            let far = nearest2(photon).sqrt() > 2.8 * radius;
            let last = photon.position.iter().all(|x| *x > 1.0 - 2.1 * radius);
            assert!(!(is_kept && far && !last), "{radius}: {photon:?} is kept");
        }
        assert_eq!(next, found.len(), "{radius}: photons that were not there");
        println!("radius {radius}: {near} near, {} kept of {}", found.len(), photons.len());
        assert!(left_out > 0 || radius > 1.0);
        if let Some(gpu) = gpu() {
            assert_same_words("kept", &kept(gpu, &tiles, &photons, radius), &found);
        }
    }
    // Nobody looks: the last cell is all that is marked.
    let nobody = [vec![Query { position: [0.0; 3], active: 0 }; 3]];
    assert!(kept(&Device::cpu(), &nobody, &photons, 0.01).len() < 5);
    assert!(kept(&Device::cpu(), &[], &photons, 0.01).is_empty());
    assert!(kept(&Device::cpu(), &tiles, &[], 0.01).is_empty());
}

#[test]
fn a_final_gather_looks_everywhere_and_says_so() {
    let settings = Settings { keep: Keep::Visible, final_gather: 2, ..small(&load("cornell")) };
    let error = settings.validate().unwrap_err();
    assert!(matches!(error, RenderError::Setting { name: "keep", .. }), "{error}");
}

#[test]
fn a_gpu_keeps_the_same_photons_and_bits() {
    let Some(gpu) = gpu() else { return };
    let scene = load("pool");
    let settings = Settings { keep: Keep::Visible, radius: 0.05, ..small(&scene) };
    let (a, b) = (run(&scene, &settings, &Device::cpu()), run(&scene, &settings, gpu));
    assert_same_words("pool", floats(&a.image), floats(&b.image));
    let kept = |maps: &[caustic_renderer::MapReport]| maps.iter().map(|map| map.photons_kept).collect::<Vec<_>>();
    assert_eq!(kept(&a.report.maps), kept(&b.report.maps));
}
