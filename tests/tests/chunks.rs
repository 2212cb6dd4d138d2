//! Renders whose photons come in chunks: the bits of whole maps, in the memory that was foreseen.

use caustic_device::{Device, LaneOrder, Plan};
use caustic_kernels::layout::{Irradiance, Photon, Query};
use caustic_photon_map::{
    DensitySums, Filter, Gather, Hash, LargestPower, MapOptions, NearestPower, PhotonMap, Points, Surface, plan_grid,
};
use caustic_renderer::output::LayerKind;
use caustic_renderer::scene::Scene;
use caustic_renderer::{
    Chunk, ExpectedMap, Given, Integrator, RenderError, Rendered, Settings, Stop, peak_bytes, render, render_across,
};
use caustic_tests::points::{photons_at, query, uniform};
use caustic_tests::renders::*;
use caustic_tests::{assert_same_words, compare_words, gpu};

const WAYS: [Integrator; 2] = [Integrator::Photon, Integrator::Progressive];

fn in_chunks(settings: &Settings, photons: u32, samples: u32) -> Settings {
    Settings { chunk: Some(Chunk { photons, samples }), ..settings.clone() }
}

fn two_passes(integrator: Integrator, radius: f32, scene: &Scene) -> Settings {
    Settings {
        integrator,
        radius,
        size: [24, 16],
        photons: 6000,
        caustic_photons: 2500,
        k: 20,
        stop: Stop { passes: Some(2), ..Stop::default() },
        layers: vec![LayerKind::Direct, LayerKind::Global, LayerKind::Caustic, LayerKind::Photons, LayerKind::Variance],
        ..small(scene)
    }
}

/// Chunks that divide the photons and such that do not, one that is larger, and batches of one row, of some pixels and of all.
const CUTS: [(u32, u32); 4] = [(1000, 48), (1777, 193), (977, u32::MAX), (100_000, 50)];

#[test]
fn chunks_give_the_picture_of_whole_maps() {
    for (name, radius) in [("cornell", 0.1), ("courtyard", 0.5), ("lamps", 0.1), ("plane", 0.2)] {
        let scene = load(name);
        for integrator in WAYS {
            let settings = two_passes(integrator, radius, &scene);
            let whole = run(&scene, &settings, &Device::cpu());
            let shuffled = Device::cpu_with_order(LaneOrder::Shuffled(7));
            // A GPU compiles the kernels of two kinds of scenes.
            let gpu = gpu().filter(|_| ["cornell", "courtyard"].contains(&name));
            for (device, cuts) in [(Some(&shuffled), &CUTS[..]), (gpu, &CUTS[1..2])] {
                let Some(device) = device else { continue };
                for &(photons, samples) in cuts {
                    let chunked = run(&scene, &in_chunks(&settings, photons, samples), device);
                    let what = format!("{name}, {integrator:?}, {photons} photons, {samples} samples");
                    same(&what, &whole, &chunked);
                    for map in &chunked.report.maps {
                        let expected = map.photons_emitted.div_ceil(photons);
                        assert_eq!(map.chunks, expected, "{what}, {} map", map.map);
                    }
                }
            }
        }
    }
}

/// Pictures, layers and what is said of the maps.
fn same(what: &str, whole: &Rendered, chunked: &Rendered) {
    assert_same_words(what, floats(&whole.image), floats(&chunked.image));
    assert_eq!(whole.layers, chunked.layers, "{what}");
    let numbers = |rendered: &Rendered| -> Vec<_> {
        let maps = rendered.report.maps.iter();
        maps.map(|map| (map.map, map.photons_emitted, map.photons_stored, map.segments, map.paths_cut)).collect()
    };
    assert_eq!(numbers(whole), numbers(chunked), "{what}");
    assert_eq!(whole.report.problems, chunked.report.problems, "{what}");
    assert_eq!(whole.report.notes, chunked.report.notes, "{what}");
    assert_eq!(whole.report.photons_emitted, chunked.report.photons_emitted, "{what}");
}

#[test]
fn k_may_be_one_or_more_than_there_are_photons_and_any_search_will_do() {
    let scene = load("cornell");
    for (k, gather) in [(1, Gather::Heap), (300, Gather::List), (1023, Gather::Histogram)] {
        let settings = Settings { k, gather, ..two_passes(Integrator::Photon, 0.3, &scene) };
        let whole = run(&scene, &settings, &Device::cpu());
        let chunked = run(&scene, &in_chunks(&settings, 1500, 500), &Device::cpu());
        same(&format!("k = {k}"), &whole, &chunked);
    }
}

#[test]
fn devices_that_share_a_render_may_each_have_chunks() {
    let scene = load("cornell");
    let settings = in_chunks(&two_passes(Integrator::Progressive, 0.1, &scene), 1777, 100);
    let (one, two) = (Device::cpu(), Device::cpu_with_order(LaneOrder::Reversed));
    let shared = render_across(&scene, &settings, &[&one, &two], Given::default(), &mut |_| true, &mut |_| Ok(()));
    let alone = run(&scene, &Settings { chunk: None, ..settings }, &one);
    assert_same_words("two devices", floats(&alone.image), floats(&shared.expect("a render").image));
}

/// A dim lamp whose photons come first, and one a thousand times as bright.
const TWO_LAMPS: &str = r#"[camera]
position = [0, 1, 4]
target = [0, 0.5, 0]
vertical_fov_degrees = 35
[materials.white]
kind = "lambertian"
reflectance = [0.8, 0.8, 0.8]
[[quads]]
corner = [-1, 0, -1]
edge_u = [0, 0, 2]
edge_v = [2, 0, 0]
material = "white"
[[quads]]
corner = [-1, 0, -1]
edge_u = [2, 0, 0]
edge_v = [0, 2, 0]
material = "white"
[[quads]]
corner = [-0.9, 1.9, -0.9]
edge_u = [0.5, 0, 0]
edge_v = [0, 0, 0.5]
radiance = [0.01, 0.01, 0.01]
[[quads]]
corner = [0.2, 1.9, 0.2]
edge_u = [0.5, 0, 0]
edge_v = [0, 0, 0.5]
radiance = [10, 10, 10]
"#;

/// Sums are aligned to the largest power: where it comes late, photons come by once more, and only then.
#[test]
fn the_largest_power_may_come_in_any_chunk() {
    for (name, scene, walks) in [("two lamps", parse(TWO_LAMPS), 2), ("cornell", load("cornell"), 1)] {
        let settings = Settings {
            stop: Stop::default(),
            show: caustic_renderer::Show::MapGlobal,
            ..two_passes(Integrator::Photon, 0.2, &scene)
        };
        let settings = Settings {
            integrator: Integrator::Progressive,
            stop: Stop { passes: Some(1), ..Stop::default() },
            layers: Vec::new(),
            ..settings
        };
        let whole = run(&scene, &settings, &Device::cpu());
        let device = Device::cpu();
        let chunked = run(&scene, &in_chunks(&settings, 300, u32::MAX), &device);
        assert_same_words(name, floats(&whole.image), floats(&chunked.image));
        let runs: u32 =
            chunked.report.stages.iter().filter(|row| row.stage.contains("store")).map(|row| row.runs).sum();
        assert_eq!(runs, 20 * walks, "{name}: {:?}", chunked.report.stages);
    }
}

/// The comparison can fail: a chunk that is left out or comes twice, powers that are aligned to a largest one below theirs, and
/// chunks in another order, which have other indices, show.
#[test]
fn planted_faults_show() {
    let cpu = Device::cpu();
    // Many at the same distance, so that indices matter.
    let mut positions = uniform(1, 2000, [0.0; 3], [1.0; 3]);
    positions.extend(std::iter::repeat_n([0.25; 3], 300));
    positions.extend(uniform(2, 500, [0.2; 3], [0.3; 3]));
    let photons = photons_at(1, &positions);
    let mut queries: Vec<Query> = uniform(3, 100, [0.0; 3], [1.0; 3]).into_iter().map(query).collect();
    queries.extend([query([0.25; 3]), query([9.0; 3])]);
    queries[5].active = 0;
    let options = MapOptions { radius: 0.3, hash: Hash::Linear, table: None, cell: None };
    let whole = PhotonMap::build(&cpu, &photons, &options).unwrap();
    let points = || {
        let parts = queries.chunks(40).map(|part| (cpu.upload("queries", part).unwrap(), part.len() as u32));
        parts.map(|(queries, count)| Points { queries, count }).collect::<Vec<_>>()
    };
    let mut largest = LargestPower::default();
    largest.see(&photons);

    let expected = whole.irradiance(&cpu, &queries, 50, Gather::Auto).unwrap();
    let nearest = |chunks: &[&[Photon]]| -> Vec<Irradiance> {
        let mut nearest = NearestPower::new(&cpu, points(), 50, Gather::Auto).unwrap();
        for chunk in chunks {
            let map = PhotonMap::build(&cpu, chunk, &options).unwrap();
            let powers: Vec<_> = chunk.iter().map(|photon| photon.power).collect();
            nearest.add(&map, &powers).unwrap();
        }
        nearest.irradiance(options.radius)
    };
    let differ = |found: &[Irradiance]| compare_words("estimates", &expected, found).is_err();
    let chunks: Vec<&[Photon]> = photons.chunks(700).collect();
    assert_same_words("estimates", &expected, &nearest(&chunks));
    assert!(differ(&nearest(&chunks[1..])), "without the first");
    assert!(differ(&nearest(&[&chunks[..], &chunks[..1]].concat())), "with the first twice");
    let turned: Vec<_> = chunks.iter().rev().copied().collect();
    assert!(differ(&nearest(&turned)), "in another order");

    let expected = whole.density(&cpu, &queries).unwrap();
    let density = |chunks: &[&[Photon]], below: LargestPower| -> Vec<Irradiance> {
        let sums = DensitySums::new(&cpu, points()).unwrap();
        for chunk in chunks {
            let unsorted = cpu.upload("photons", chunk).unwrap();
            let grid = plan_grid([0.0; 3], [1.0; 3], chunk.len() as u64, &[], &options).unwrap();
            let mut plan = Plan::new();
            let (map, own) = PhotonMap::plan_below(&cpu, &mut plan, &unsorted, grid, below).unwrap();
            cpu.run(&plan).unwrap();
            let own = LargestPower(cpu.read::<[f32; 3]>(&own, 1).unwrap()[0]);
            assert!(!largest.is_below(&own));
            sums.add(&map).unwrap();
        }
        sums.irradiance(options.radius, &below).unwrap()
    };
    let differ = |found: &[Irradiance]| compare_words("sums", &expected, found).is_err();
    assert_same_words("sums", &expected, &density(&chunks, largest));
    assert_same_words("sums", &expected, &density(&turned, largest));
    assert!(differ(&density(&chunks[1..], largest)), "without the first");
    assert!(differ(&density(&chunks, LargestPower(largest.0.map(|power| power / 4.0)))), "aligned too low");
}

/// What is foreseen is what is taken, of all sizes of chunks and batches, and less than whole maps take.
#[test]
fn memory_is_as_foreseen() {
    let scene = load("cornell");
    let device = Device::cpu();
    for integrator in WAYS {
        let settings = Settings {
            integrator,
            photons: 400_000,
            caustic_photons: 200_000,
            k: 30,
            radius: 0.05,
            size: [100, 80],
            spp: 4,
            stop: Stop { passes: Some(1), ..Stop::default() },
            ..Settings::of(&scene)
        };
        let compiled = scene.compile();
        let taken = |settings: &Settings| {
            device.trim();
            device.reset_peak_bytes();
            let report = run(&scene, settings, &device).report;
            let mut maps = [ExpectedMap::default(); 2];
            for (expected, map) in maps.iter_mut().zip(&report.maps) {
                let [emitted, stored] = [map.photons_emitted, map.photons_stored].map(f64::from);
                *expected = ExpectedMap { emitted, stored, table: map.table_entries.into() };
            }
            let ratio = peak_bytes(&compiled, settings, maps, &device) as f64 / report.peak_bytes as f64;
            println!("{integrator:?}, {:?}: {} bytes, {ratio:.3} of it foreseen", settings.chunk, report.peak_bytes);
            assert!((0.9..1.1).contains(&ratio), "{integrator:?}, {:?}: {ratio} was foreseen", settings.chunk);
            report.peak_bytes
        };
        let whole = taken(&settings);
        for (photons, samples) in [(40_000, 2000), (100_000, 8000), (20_000, 32_000), (300_000, 1000)] {
            let chunked = taken(&in_chunks(&settings, photons, samples));
            assert!(chunked < whole, "{chunked} bytes instead of {whole}");
        }
    }
}

#[test]
fn a_render_that_is_stopped_shows_the_batches_that_are_finished() {
    let scene = load("cornell");
    let settings = two_passes(Integrator::Photon, 0.1, &scene);
    let settings = Settings { stop: Stop::default(), layers: Vec::new(), ..settings };
    let chunked = in_chunks(&settings, 1000, 96);
    let whole = run(&scene, &settings, &Device::cpu());
    // Nothing before the first batch, and in the second what the first has come to.
    let mut batches = 0;
    let stopped = render(&scene, &chunked, &Device::cpu(), &mut |progress| {
        batches += u32::from(progress.phase == "look");
        batches < 2
    });
    let stopped = stopped.expect("some rows");
    assert!(!stopped.report.complete);
    let (seen, all) = (floats(&stopped.image), floats(&whole.image));
    assert_same_words("the first batch", &all[..48 * 3], &seen[..48 * 3]);
    assert!(seen[48 * 3..].iter().all(|&value| value == 0.0));
    let none = render(&scene, &chunked, &Device::cpu(), &mut |progress| progress.phase != "global photons");
    assert!(matches!(none, Err(RenderError::Interrupted)));
}

#[test]
fn what_chunks_cannot_give_is_refused() {
    let scene = load("cornell");
    let settings = in_chunks(&small(&scene), 1000, 1000);
    let refusals = [
        ("filter", Settings { filter: Filter::Cone, ..settings.clone() }),
        ("surface", Settings { surface: Surface::Own, ..settings.clone() }),
        ("compact", Settings { compact: true, ..settings.clone() }),
        ("k", Settings { k: 1024, ..settings.clone() }),
        ("radius", Settings { automatic_radius: true, ..settings.clone() }),
        ("final-gather", Settings { final_gather: 4, ..settings.clone() }),
        ("chunk", Settings { integrator: Integrator::Path, ..settings.clone() }),
        ("chunk", in_chunks(&settings, 0, 1)),
    ];
    for (flag, settings) in refusals {
        let refused = settings.validate();
        assert!(matches!(refused, Err(RenderError::Setting { name, .. }) if name == flag), "{flag}: {refused:?}");
    }
    let layers = Settings { layers: vec![LayerKind::Bias], ..settings.clone() };
    assert!(matches!(layers.validate(), Err(RenderError::NoLayer { .. })));
    assert!(settings.validate().is_ok());
}
