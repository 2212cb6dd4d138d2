//! Settings that trade accuracy for speed: alike on all devices, independent of how the work is cut, and as far off as they should be.

use caustic_device::Device;
use caustic_kernels::gather::snap;
use caustic_kernels::layout::{Photon, Query};
use caustic_metrics::{Metric, compare};
use caustic_photon_map::{Estimate, Filter, Gather, Hash, MapOptions, Nearest, PhotonMap, Surface};
use caustic_renderer::output::Image;
use caustic_renderer::{Given, Keep, Settings, Show, render_across};
use caustic_tests::points::{photons_at, query, uniform};
use caustic_tests::renders::*;
use caustic_tests::{assert_same_words, gpu};

/// Each of the settings, and some together.
fn ways(base: &Settings) -> Vec<(&'static str, Settings)> {
    let (nearest, surface) = (Nearest::Approximate, Surface::Own);
    vec![
        ("thin", Settings { thin: 3, ..base.clone() }),
        ("approximate", Settings { nearest, ..base.clone() }),
        ("approximate, Teschner", Settings { nearest, hash: Hash::Teschner, surface, ..base.clone() }),
        ("compact", Settings { compact: true, ..base.clone() }),
        ("compact, approximate", Settings { compact: true, nearest, hash: Hash::Morton, ..base.clone() }),
        ("interpolated in a pixel", Settings { interpolate: 1, ..base.clone() }),
        ("interpolated", Settings { interpolate: 5, thin: 2, nearest, surface, ..base.clone() }),
        ("interpolated final gather", Settings { interpolate: 4, final_gather: 3, ..base.clone() }),
        ("interpolated map", Settings { interpolate: 4, show: Show::MapGlobal, ..base.clone() }),
    ]
}

#[test]
fn each_way_has_the_same_bits_on_both_devices() {
    let Some(gpu) = gpu() else { return };
    for name in ["cornell", "cornell-glossy", "landscape"] {
        let scene = load(name);
        let base = Settings { size: [31, 23], ..small(&scene) };
        // Larger than k photons need, so that it matters how far they reach.
        let base = Settings { radius: 20.0 * Settings::of(&scene).radius, k: 20, ..base };
        let exact = image(&scene, &base, &Device::cpu());
        for (way, settings) in ways(&base) {
            let cpu = image(&scene, &settings, &Device::cpu());
            assert_same_words(&format!("{name}, {way}"), floats(&cpu), floats(&image(&scene, &settings, gpu)));
            assert!(floats(&cpu) != floats(&exact), "{name}, {way}: it does nothing");
        }
    }
}

/// Keys that two tiles share are the same keys.
#[test]
fn tiles_do_not_show_between_keys() {
    let scene = load("cornell");
    let (one, two) = (Device::cpu(), Device::cpu());
    for (way, settings) in ways(&Settings { size: [61, 47], ..small(&scene) }) {
        let across = |devices: &[&Device]| {
            render_across(&scene, &settings, devices, Given::default(), &mut |_| true, &mut |_| Ok(())).unwrap().image
        };
        assert_same_words(way, floats(&across(&[&one])), floats(&across(&[&one, &two])));
    }
}

fn relmse(image: &Image, reference: &Image) -> f64 {
    let read = |image: &Image| {
        let [width, height] = [image.width, image.height].map(|side| side as usize);
        caustic_metrics::Image::from_linear(width, height, image.rgb.clone()).expect("an image")
    };
    compare(&read(image), &read(reference), Metric::RelMse).expect("a score").value
}

/// Of the cornell box's soft light: how far each way is from the exact estimate, beside how far another seed is, which is the noise of both.
#[test]
fn each_way_is_off_by_less_than_noise() {
    let scene = load("cornell");
    let base = Settings {
        size: [64, 64],
        show: Show::Global,
        spp: 4,
        photons: 60_000,
        k: 100,
        radius: 0.3,
        ..Settings::of(&scene)
    };
    let of = |settings: &Settings| image(&scene, settings, &Device::cpu());
    let exact = of(&base);
    let noise = relmse(&of(&Settings { seed: 1, ..base.clone() }), &exact);
    for (way, settings) in [
        ("approximate", Settings { nearest: Nearest::Approximate, ..base.clone() }),
        ("compact", Settings { compact: true, ..base.clone() }),
        ("every pixel", Settings { interpolate: 1, ..base.clone() }),
        ("every 4 pixels", Settings { interpolate: 4, ..base.clone() }),
    ] {
        let off = relmse(&of(&settings), &exact);
        println!("{way}: relMSE {off:.5} beside a noise of {noise:.5}");
        assert!(off > 0.0 && off < noise, "{way}: {off}, noise {noise}");
    }
    // Eight times fewer photons are noisier.
    let thin = relmse(&of(&Settings { thin: 8, ..base }), &exact);
    println!("thin: relMSE {thin:.5}");
    assert!(thin > noise, "{thin}, noise {noise}");
}

/// What is left out is made up for: light that was reflected once or more is a quarter of the furnace's, over many seeds.
#[test]
fn the_furnace_is_as_bright_with_each_way() {
    let scene = load("furnace");
    let base = Settings { size: [24, 24], spp: 8, surface: Surface::Own, show: Show::Global, ..Settings::of(&scene) };
    let base = Settings { photons: 100_000, radius: 0.3, ..base };
    for (way, settings) in [
        ("exact", base.clone()),
        ("thin", Settings { photons: 400_000, thin: 4, ..base.clone() }),
        ("approximate", Settings { nearest: Nearest::Approximate, ..base.clone() }),
        ("every 3 pixels", Settings { interpolate: 3, ..base.clone() }),
    ] {
        let of_seed = |seed| mean_rgb(&image(&scene, &Settings { seed, ..settings.clone() }, &Device::cpu()))[1] / 0.25;
        let (mean, se) = mean_and_error(&(0..20).map(of_seed).collect::<Vec<_>>());
        println!("{way}: {mean:.5}, SE {se:.5}");
        assert!((mean - 1.0).abs() < 4.0 * se && se < 3e-3, "{way}: {mean} ± {se}");
    }
}

/// Photons and queries on a square of 1 m.
fn square(photons: u32, queries: u32) -> (Vec<Photon>, Vec<Query>) {
    let on_it = |seed, n| uniform(seed, n, [0.0, 0.5, 0.0], [1.0, 0.5, 1.0]);
    (photons_at(5, &on_it(5, photons)), on_it(6, queries).into_iter().map(query).collect())
}

/// On surfaces the approximate radius is near that of the k-th, and finds most of the k nearest.
#[test]
fn the_likely_reach_is_near_the_exact_one() {
    let (photons, queries) = square(40_000, 500);
    for (hash, k) in [(Hash::Linear, 20), (Hash::Linear, 100), (Hash::Morton, 50)] {
        let options = MapOptions { radius: 0.1, hash, table: None, cell: None };
        let reaches = |device: &Device, nearest| {
            let map = PhotonMap::build(device, &photons, &options).unwrap();
            map.reaches(device, &queries, k, nearest).unwrap()
        };
        let cpu = Device::cpu();
        let (exact, likely) = (reaches(&cpu, Nearest::Exact), reaches(&cpu, Nearest::Approximate));
        let map = PhotonMap::build(&cpu, &photons, &options).unwrap();
        let nearest = map.k_nearest(&cpu, &queries, k, Gather::Auto).unwrap();
        let recall: Vec<_> = nearest
            .iter()
            .zip(&likely)
            .map(|(found, reach)| {
                let inside = found.iter().filter(|photon| photon.distance2 <= reach.radius2).count();
                inside as f64 / found.len() as f64
            })
            .collect();
        let off: Vec<_> = exact
            .iter()
            .zip(&likely)
            .map(|(exact, likely)| (f64::from(likely.radius2 / exact.radius2).sqrt() - 1.0).abs())
            .collect();
        println!("{hash:?}, k = {k}: recall {:.3}, radius off by {:.3}", mean(&recall), mean(&off));
        assert!(mean(&recall) > 0.75 && mean(&off) < 0.2, "{hash:?}, k = {k}");
        if let Some(gpu) = gpu() {
            assert_eq!(likely, reaches(gpu, Nearest::Approximate), "{hash:?}, k = {k}");
        }
    }
}

/// A compact map is a whole one of photons that were moved to its lattice, to the last bit, whatever the hash and the filter.
#[test]
fn a_compact_map_has_the_bits_of_a_whole_one_of_its_photons() {
    let (photons, queries) = square(20_000, 300);
    let cpu = Device::cpu();
    for hash in [Hash::Linear, Hash::Teschner] {
        let options = MapOptions { radius: 0.05, hash, table: None, cell: Some(0.02) };
        let compact = PhotonMap::build_compact(&cpu, &photons, &options).unwrap();
        let snapped: Vec<_> = photons.iter().map(|photon| snap(*photon, compact.grid())).collect();
        assert_ne!(snapped, photons);
        let whole = PhotonMap::build(&cpu, &snapped, &options).unwrap();
        assert!(whole.bytes() > 3 * compact.bytes(), "{} and {} bytes", whole.bytes(), compact.bytes());
        for filter in [Filter::Constant, Filter::Cone] {
            for k in [None, Some(1), Some(50), Some(500)] {
                let how = Estimate { filter, k, ..Estimate::default() };
                let [found, expected] = [&compact, &whole].map(|map| map.estimate(&cpu, &queries, &how).unwrap());
                assert_eq!(found, expected, "{hash:?}, {filter:?}, k = {k:?}");
            }
        }
        // The photons as they were given make other bits, so that this could have failed.
        let given = PhotonMap::build(&cpu, &photons, &options).unwrap();
        assert_ne!(given.density(&cpu, &queries).unwrap(), compact.density(&cpu, &queries).unwrap());
        // What it does not know it says.
        let refused = compact.k_nearest(&cpu, &queries, 5, Gather::Auto).expect_err("a refusal").to_string();
        assert!(refused.contains("compact map has no neighbours"), "{refused}");
    }
}

#[test]
fn what_looks_beyond_the_samples_needs_all_photons() {
    let base = Settings { keep: Keep::Visible, ..small(&load("cornell")) };
    for (settings, remedy) in [
        (Settings { interpolate: 2, ..base.clone() }, "all with --interpolate"),
        (Settings { nearest: Nearest::Approximate, ..base.clone() }, "all with --nearest approximate"),
    ] {
        let error = settings.validate().expect_err("a refusal").to_string();
        assert!(error.contains("keep") && error.contains(remedy), "{error}");
    }
    // An inactive query reaches nowhere.
    let cpu = Device::cpu();
    let (photons, _) = square(100, 1);
    let options = MapOptions { radius: 0.5, hash: Hash::Linear, table: None, cell: None };
    let map = PhotonMap::build(&cpu, &photons, &options).unwrap();
    let nowhere = [Query { position: [0.0; 3], active: 0 }];
    assert_eq!(map.reaches(&cpu, &nowhere, 5, Nearest::Approximate).unwrap()[0].photons, 0);
}
