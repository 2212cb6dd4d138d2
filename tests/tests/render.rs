//! Whole renders: the same bits every time and everywhere, the golden picture, and what is refused.

use caustic_device::{Device, LaneOrder};
use caustic_photon_map::{Gather, Hash};
use caustic_renderer::output::{self, Metadata};
use caustic_renderer::scene::Scene;
use caustic_renderer::{RenderError, Rendered, Settings, Show, render};
use caustic_tests::renders::*;
use caustic_tests::{assert_same_words, compare_words, gpu};
use std::path::Path;

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
