//! The Cornell box against a reference made by other programs (`tests/reference`). Seeds are fixed.

use caustic_device::Device;
use caustic_renderer::scene::Scene;
use caustic_renderer::{Settings, Show};
use caustic_tests::assert_same_words;
use caustic_tests::renders::*;

/// A mean radiance and its standard error, from the reference.
struct Reference {
    mean: [f64; 3],
    se: [f64; 3],
}

fn reference(path: &[&str]) -> Reference {
    let text = include_str!("../reference/cornell_reference.json");
    let root: serde_json::Value = serde_json::from_str(text).expect("the reference is JSON");
    let value = path.iter().fold(&root, |value, key| &value[key]);
    let triple = |value: &serde_json::Value| -> [f64; 3] {
        std::array::from_fn(|channel| value[channel].as_f64().expect("three numbers"))
    };
    if path.is_empty() {
        return Reference { mean: triple(&root["mean_rgb"]), se: triple(&root["standard_error_rgb"]) };
    }
    Reference { mean: triple(&value["mean"]), se: triple(&value["se"]) }
}

/// Checks a mean radiance against the reference: within 3 % and 3 standard errors of the reference in each channel.
fn check_reference(name: &str, found: [f64; 3], reference: &Reference) -> Result<String, String> {
    let ratios: [f64; 3] = std::array::from_fn(|c| found[c] / reference.mean[c] - 1.0);
    let fine = (0..3).all(|c| (found[c] - reference.mean[c]).abs() <= 0.03 * reference.mean[c] + 3.0 * reference.se[c]);
    let percent = ratios.map(|ratio| format!("{:+.2} %", 100.0 * ratio)).join(", ");
    let text = format!("{name}: {found:.5?} against {:.5?}: {percent}", reference.mean);
    if fine { Ok(text) } else { Err(text) }
}

/// Settings at which the Cornell box is compared with the reference.
fn cornell_settings(scene: &Scene, show: Show) -> Settings {
    Settings {
        size: [64, 64],
        photons: 300_000,
        caustic_photons: 200_000,
        k: 100,
        radius: 0.05,
        spp: 16,
        show,
        ..Settings::of(scene)
    }
}

#[test]
fn the_cornell_box_is_as_bright_as_an_independent_path_tracer_says() {
    let scene = load("cornell");
    let picture = |show| image(&scene, &cornell_settings(&scene, show), &Device::cpu());
    let [beauty, direct, global, caustic] =
        [Show::Beauty, Show::Direct, Show::Global, Show::Caustic].map(|show| mean_rgb(&picture(show)));
    let mut failed = Vec::new();
    let whole = reference(&[]);
    for (name, found, reference) in [
        ("total", beauty, &whole),
        ("direct", direct, &reference(&["parts", "direct"])),
        ("global", global, &reference(&["parts", "global"])),
        ("caustic", caustic, &reference(&["parts", "caustic"])),
    ] {
        match check_reference(name, found, reference) {
            Ok(text) => println!("{text}"),
            Err(text) => failed.push(text),
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");

    // Faults that this is to find, made of the parts.
    let sum = |weights: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|c| weights[0] * direct[c] + weights[1] * global[c] + weights[2] * caustic[c])
    };
    check_reference("the sum of the parts", sum([1.0; 3]), &whole).unwrap();
    for (fault, weights) in [
        ("photons of half the power", [1.0, 0.5, 0.5]),
        ("photons of twice the power", [1.0, 2.0, 2.0]),
        ("direct light in the map, too", [2.0, 1.0, 1.0]),
        ("no indirect light", [1.0, 0.0, 1.0]),
        ("an eighth of the direct light lost", [0.875, 1.0, 1.0]),
    ] {
        assert!(check_reference(fault, sum(weights), &whole).is_err(), "{fault} was not found");
    }
    // A caustic is 3 % of all light: the total would not show its faults, but the part does.
    let part = reference(&["parts", "caustic"]);
    for factor in [0.0, 0.5, 2.0] {
        assert!(check_reference("caustic", caustic.map(|x| x * factor), &part).is_err(), "{factor}");
    }
}

#[test]
fn the_parts_add_up_to_the_picture() {
    let scene = load("cornell");
    let settings = Settings { spp: 4, ..small(&scene) };
    let picture = |show| image(&scene, &Settings { show, ..settings.clone() }, &Device::cpu());
    let [beauty, direct, global, caustic] = [Show::Beauty, Show::Direct, Show::Global, Show::Caustic].map(picture);
    // Sums of positive terms in another order: each of at most 2·spp + 6 additions and products is off by half an ulp.
    let rounding = f64::from(2 * settings.spp + 6) * f64::from(f32::EPSILON);
    for (i, &whole) in floats(&beauty).iter().enumerate() {
        let sum: f64 = [&direct, &global, &caustic].map(|part| f64::from(floats(part)[i])).iter().sum();
        let whole = f64::from(whole);
        assert!((sum - whole).abs() <= rounding * whole, "value {i}: {sum} and {whole}");
    }
    for part in [&direct, &global, &caustic] {
        assert!(floats(part).iter().any(|&x| x > 0.0) && floats(part).iter().all(|&x| x >= 0.0));
    }
    assert_same_words("the caustic map", floats(&caustic), floats(&picture(Show::MapCaustic)));
}
