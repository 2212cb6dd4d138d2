//! What a render leaves out, and what is foreseen of it.

use caustic_device::Device;
use caustic_photon_map::{Nearest, Surface};
use caustic_planner::{Budget, Costs, Given, Scout, Survey, Surveyor, choose, settle};
use caustic_renderer::output::LayerKind;
use caustic_renderer::scene::{BUILT_IN, Scene};
use caustic_renderer::{Decision, ExpectedMap, Feature, Settings, Stop, decide, peak_bytes};
use caustic_tests::gpu;
use caustic_tests::renders::{LAMP, floats, image, load, parse, run, small};

fn decision(scene: &Scene, settings: &Settings, feature: Feature) -> Decision {
    let compiled = scene.compile_with(&settings.forced);
    decide(&compiled, settings).into_iter().find(|one| one.feature == feature).expect("all features are decided on")
}

fn bits(scene: &Scene, settings: &Settings, device: &Device) -> Vec<u32> {
    floats(&image(scene, settings, device)).iter().map(|x| x.to_bits()).collect()
}

/// What is left out of a built-in scene has no light to add: with it, the bits are the same, on the CPU and on a GPU.
#[test]
fn what_is_left_out_changes_nothing_when_it_is_forced() {
    let cpu = Device::cpu();
    let devices: Vec<&Device> = gpu().into_iter().chain([&cpu]).collect();
    let mut left_out = [0; Feature::ALL.len()];
    for scene in BUILT_IN.iter().map(|scene| load(scene.name)).chain([parse(LAMP)]) {
        let settings = Settings { size: [24, 16], caustic_photons: 1500, ..small(&scene) };
        for (feature, times) in Feature::ALL.into_iter().zip(&mut left_out) {
            let forced = Settings { forced: vec![feature], ..settings.clone() };
            let (plain, with) = (decision(&scene, &settings, feature), decision(&scene, &forced, feature));
            assert!(!plain.forced && !plain.why.is_empty(), "{}: {plain:?}", scene.name);
            if plain.modelled {
                assert_eq!(plain, with, "{}: what is modelled anyway cannot be forced", scene.name);
                continue;
            }
            assert!(with.modelled && with.forced && with.why == plain.why, "{}: {with:?}", scene.name);
            *times += 1;
            for &device in &devices {
                let (a, b) = (bits(&scene, &settings, device), bits(&scene, &forced, device));
                assert_eq!(a, b, "{feature:?} of {} on {}", scene.name, device.name());
            }
        }
    }
    assert!(left_out.iter().all(|&times| times > 0), "{left_out:?}: each is left out somewhere");
}

/// The test above can fail: where a feature has light to add, leaving it out shows.
#[test]
fn what_matters_is_modelled() {
    let cpu = Device::cpu();
    let cornell = load("cornell");
    let settings = small(&cornell);
    let whole = bits(&cornell, &settings, &cpu);
    let without = Settings { caustic_photons: 0, ..settings.clone() };
    assert_eq!(decision(&cornell, &without, Feature::CausticMap).why, "it is given no photons");
    assert_ne!(bits(&cornell, &without, &cpu), whole);
    // Two planes that see each other, or one that is not matt, reflect light twice.
    let plane = "[[quads]]\ncorner = [-50, 0, -50]\nedge_u = [0, 0, 100]\nedge_v = [100, 0, 0]\nmaterial = \"grey\"\n";
    assert!(LAMP.contains(plane));
    let feature = |text: &str| decision(&parse(text), &settings, Feature::GlobalMap).modelled;
    assert!(!feature(LAMP));
    assert!(!feature(&LAMP.replace(plane, &format!("{plane}\n{}", plane.replace("-50, 0, -50", "50, 0, -50")))));
    assert!(feature(&LAMP.replace(plane, &format!("{plane}\n{}", plane.replace("-50, 0, -50", "-50, -1, -50")))));
    assert!(feature(&LAMP.replace("kind = \"lambertian\"", "kind = \"plastic\"")));
    let ball = "[[spheres]]\ncentre = [0, 0.2, 0]\nradius = 0.1\nmaterial = \"grey\"\n";
    assert!(feature(&format!("{LAMP}\n{ball}")));
    let lit = parse(&format!("{LAMP}\n{ball}"));
    let rendered = run(&lit, &Settings { layers: vec![LayerKind::Global], ..small(&lit) }, &cpu);
    assert!(rendered.layers[0].values.iter().any(|&light| light > 0.0));
}

/// Memory is what the buffers are made of, for every built-in scene.
#[test]
fn memory_is_foreseen_within_a_tenth() {
    for scene in BUILT_IN.iter().map(|scene| load(scene.name)) {
        let size = [96, 64];
        let settings = Settings { photons: 60_000, caustic_photons: 30_000, size, spp: 4, ..Settings::of(&scene) };
        let (surface, nearest) = (Surface::Own, Nearest::Approximate);
        for settings in [
            Settings { layers: LayerKind::OF_PHOTON_MAPS.to_vec(), ..settings.clone() },
            Settings { surface, nearest, interpolate: 1, ..settings.clone() },
            Settings { compact: true, interpolate: 4, final_gather: 2, ..settings.clone() },
            settings,
        ] {
            let device = Device::cpu();
            let report = run(&scene, &settings, &device).report;
            let maps = ["global", "caustic"].map(|name| {
                report.maps.iter().find(|map| map.map == name).map_or_else(ExpectedMap::default, |map| ExpectedMap {
                    emitted: map.photons_emitted.into(),
                    stored: map.photons_stored.into(),
                    table: map.table_entries.into(),
                })
            });
            let foreseen = peak_bytes(&scene.compile(), &settings, maps, &device) as f64;
            let ratio = foreseen / report.peak_bytes as f64;
            assert!((0.9..1.1).contains(&ratio), "{}: {foreseen} bytes are {ratio} of what it took", scene.name);
        }
    }
}

/// With built-in costs, the same settings are chosen wherever a survey is made.
#[test]
fn a_budget_is_kept_and_its_choice_does_not_depend_on_the_machine() {
    let scene = load("cornell");
    let cpu = Device::cpu();
    let settings = Settings { size: [64, 48], ..Settings::of(&scene) };
    let near = Settings { automatic_radius: true, ..settings.clone() };
    let mut go_on = || true;
    let mut scout = Scout::new(&scene, &cpu, Costs::BuiltIn, &mut go_on);
    let mut take = || Survey::take(&mut scout, &near).unwrap();
    let survey = take();
    assert_eq!(survey, take());
    let compiled = scene.compile();
    let pick = |budget: Budget| choose(&survey, &compiled, &settings, Given::default(), &budget, &cpu);
    let (rough, fine) = (
        pick(Budget { error: Some(0.05), ..Budget::default() }),
        pick(Budget { error: Some(0.01), ..Budget::default() }),
    );
    assert!(rough.met && fine.met && rough.prediction.error() <= 0.05 && fine.prediction.error() <= 0.01);
    assert!(fine.prediction.seconds > rough.prediction.seconds, "{rough:?} {fine:?}");
    let soon = pick(Budget { seconds: Some(0.5), ..Budget::default() });
    let late = pick(Budget { seconds: Some(5.0), ..Budget::default() });
    assert!(soon.met && late.met && late.prediction.error() < soon.prediction.error(), "{soon:?} {late:?}");
    let little = pick(Budget { error: Some(0.01), bytes: Some(40_000_000), ..Budget::default() });
    assert!(little.met && little.prediction.bytes <= 40_000_000, "{little:?}");
    assert!(!pick(Budget { bytes: Some(1000), ..Budget::default() }).met);
    let given = Given { k: true, photons: true, ..Given::default() };
    let kept = choose(&survey, &compiled, &settings, given, &Budget { error: Some(0.05), ..Budget::default() }, &cpu);
    assert_eq!((kept.settings.k, kept.settings.photons), (settings.k, settings.photons));
}

/// What a budget chooses for a scene, with the survey that foresees it.
fn settled(scene: &Scene, cpu: &Device) -> (Survey, Settings) {
    let settings = Settings { size: [64, 48], ..Settings::of(scene) };
    let budget = Budget { error: Some(0.05), ..Budget::default() };
    let mut go_on = || true;
    let mut surveyor = Surveyor::new(Scout::new(scene, cpu, Costs::BuiltIn, &mut go_on), None);
    let (near, found) = settle(&mut surveyor, &scene.compile(), &settings, Given::default(), &budget, cpu).unwrap();
    assert!(found.met && near.knows(&found.settings));
    (near, found.settings)
}

/// The noise that is foreseen is that of passes, within the goal of a factor of 1.5: of a scene without rare bright samples, whose mean a test would have to wait
/// for.
#[test]
fn the_noise_of_a_choice_is_foreseen() {
    let (scene, cpu) = (load("ring"), Device::cpu());
    let (near, chosen) = settled(&scene, &cpu);
    // Eight times the noise of eight times as many passes, whose mean is known well.
    let many = Settings { seed: 99, stop: Stop { passes: Some(64), ..Stop::default() }, ..chosen.clone() };
    let noise = 8.0 * run(&scene, &many, &cpu).report.noise.unwrap();
    let foreseen = near.predict(&scene.compile(), &chosen, 8, &cpu);
    let ratio = foreseen.noise / noise;
    assert!((1.0 / 1.5..1.5).contains(&ratio), "{foreseen:?}, {ratio} of the noise that came");
}

#[test]
fn the_memory_of_a_choice_is_foreseen() {
    let (scene, cpu) = (load("cornell"), Device::cpu());
    let (near, chosen) = settled(&scene, &cpu);
    let passes = Settings { stop: Stop { passes: Some(8), ..Stop::default() }, ..chosen };
    cpu.reset_peak_bytes();
    let report = run(&scene, &passes, &cpu).report;
    let foreseen = near.predict(&scene.compile(), &passes, 8, &cpu);
    let ratio = foreseen.bytes as f64 / report.peak_bytes as f64;
    assert!((0.9..1.1).contains(&ratio), "{foreseen:?}, {ratio} of what it took");
}
