//! `caustic compare`, as users run it: what it prints, its exit codes and its heat maps.

use caustic_metrics::{Metric, compare};
use caustic_renderer::output::{self, Image, Metadata};
use caustic_tests::program::*;
use serde_json::Value;
use std::fs;
use tempfile::TempDir;

const WIDTH: u32 = 24;
const HEIGHT: u32 = 16;

/// A picture in the folder: a gradient with `offset` on all of it and `planted` on one pixel, row 5, column 7.
fn write(folder: &TempDir, name: &str, offset: f32, planted: f32) {
    let value = |i: u32| 0.1 + 0.01 * (i % WIDTH) as f32 + offset;
    let mut rgb: Vec<[f32; 3]> = (0..WIDTH * HEIGHT).map(|i| [value(i), 0.9 * value(i), 0.8 * value(i)]).collect();
    rgb[(5 * WIDTH + 7) as usize].iter_mut().for_each(|channel| *channel += planted);
    output::write(&folder.path().join(name), &Image { width: WIDTH, height: HEIGHT, rgb }, &Metadata::default())
        .expect("a picture");
}

/// Runs the program, which must end with a code.
#[track_caller]
fn ends(folder: &TempDir, arguments: &[&str], code: i32) -> Run {
    let run = run(folder, arguments);
    assert_eq!(run.code, Some(code), "{arguments:?}: {run:?}");
    run
}

#[track_caller]
fn compared(folder: &TempDir, arguments: &[&str]) -> Value {
    json(&succeeds(folder, &[&["compare"], arguments, &["--json"]].concat()).stdout)
}

#[test]
fn pictures_that_are_the_same_differ_by_nothing() {
    let folder = folder();
    for name in ["a.png", "b.png", "a.exr", "b.exr"] {
        write(&folder, name, 0.0, 0.0);
    }
    for (a, b, range) in [("a.png", "b.png", "display"), ("a.exr", "b.exr", "scene")] {
        let found = compared(&folder, &[a, b]);
        assert_eq!(found["range"], range);
        for metric in ["flip", "yee", "relmse", "rmse"] {
            assert_eq!(found["metrics"][metric]["value"], 0.0, "{found}");
        }
        assert_eq!((&found["width"], &found["height"]), (&WIDTH.into(), &HEIGHT.into()));
        assert!(found["within"].is_null() && found["diff"].is_null(), "{found}");
    }
    // A PNG is its EXR as a display shows it, but for the rounding to codes.
    let found = compared(&folder, &["a.png", "a.exr"]);
    assert_eq!((&found["range"], &found["metrics"]["yee"]["value"]), (&"display".into(), &0.0.into()));
    assert!(found["metrics"]["rmse"]["value"].as_f64().expect("a number") < 2e-3, "{found}");
    let text = succeeds(&folder, &["compare", "a.png", "a.exr"]).stdout;
    assert!(text.contains("note: `a.exr` is compared as a display shows it"), "{text}");
}

#[test]
fn an_offset_has_the_error_of_its_closed_form() {
    let folder = folder();
    write(&folder, "a.exr", 0.25, 0.0);
    write(&folder, "b.exr", 0.0, 0.0);
    let found = compared(&folder, &["a.exr", "b.exr", "--metric", "rmse,relmse"]);
    assert_eq!(found["metrics"].as_object().expect("metrics").len(), 2);
    // Offsets of 0.25, 0.225 and 0.2 in red, green and blue.
    let rmse = ((0.25f64.powi(2) + 0.225f64.powi(2) + 0.2f64.powi(2)) / 3.0).sqrt();
    let rel = |i: u32, share: f64| {
        let right = share * (0.1 + 0.01 * f64::from(i));
        (0.25 * share).powi(2) / (right * right + 0.01)
    };
    let relmse: f64 = (0..WIDTH).map(|i| rel(i, 1.0) + rel(i, 0.9) + rel(i, 0.8)).sum::<f64>() / f64::from(3 * WIDTH);
    for (metric, expected) in [("rmse", rmse), ("relmse", relmse)] {
        let value = found["metrics"][metric]["value"].as_f64().expect("a number");
        assert!((value / expected - 1.0).abs() < 1e-6, "{metric}: {value} instead of {expected}");
    }
    let text = succeeds(&folder, &["compare", "a.exr", "b.exr"]).stdout;
    for part in ["`a.exr` against `b.exr`, 24 × 16 pixels", "HDR-FLIP", "pixels (", "differ visibly", "rmse    0.22592"]
    {
        assert!(text.contains(part), "no `{part}` in {text}");
    }
}

#[test]
fn one_planted_pixel_is_found_by_each_metric_and_shown_in_its_place() {
    let folder = folder();
    write(&folder, "a.exr", 0.0, 0.6);
    write(&folder, "b.exr", 0.0, 0.0);
    for metric in ["flip", "yee", "relmse", "rmse"] {
        let diff = format!("{metric}.png");
        let arguments =
            ["compare", "a.exr", "b.exr", "--metric", metric, "--threshold", "0", "--diff", &diff, "--json"];
        let run = ends(&folder, &arguments, 3);
        let found = json(&run.stdout);
        assert!(found["metrics"][metric]["value"].as_f64() > Some(0.0), "{found}");
        assert_eq!((&found["within"], &found["diff"]["metric"]), (&false.into(), &metric.into()));
        assert!(run.stderr.starts_with(&format!("error: the pictures differ: {metric} is ")), "{}", run.stderr);
        // The heat map is brightest there, and dark in the corner.
        let map = read(&folder.path().join(&diff));
        let light = |i: usize| map.rgb[i].iter().sum::<f32>();
        let most = (0..map.rgb.len()).max_by(|&a, &b| light(a).total_cmp(&light(b))).expect("pixels");
        assert_eq!((map.width, map.height, most), (WIDTH, HEIGHT, (5 * WIDTH + 7) as usize), "{metric}");
        assert!(light(0) < 0.01 && light(most) > 0.05, "{metric}: {} {}", light(0), light(most));
    }
    // The number of pixels is Yee's value, and the library says what the program says.
    let found = compared(&folder, &["a.exr", "b.exr"]);
    let [a, b] =
        ["a.exr", "b.exr"].map(|name| caustic_metrics::Image::read(&folder.path().join(name)).expect("a picture"));
    for metric in Metric::all() {
        let value = compare(&a, &b, metric).expect("a score").value;
        assert_eq!(found["metrics"][metric.name()]["value"], value, "{}", metric.name());
    }
    assert_eq!(found["metrics"]["yee"]["value"], 1.0);
}

#[test]
fn the_exit_code_is_the_thresholds() {
    let folder = folder();
    write(&folder, "a.exr", 0.25, 0.0);
    write(&folder, "b.exr", 0.0, 0.0);
    let compare = |more: &[&'static str]| [&["compare", "a.exr", "b.exr"], more].concat();
    for (more, code) in [
        (&["--metric", "rmse", "--threshold", "0.23"][..], 0),
        (&["--metric", "rmse", "--threshold", "0.22"], 3),
        (&["--threshold", "rmse=0.23"], 0),
        (&["--threshold", "rmse=0.23", "--threshold", "relmse=100"], 0),
        (&["--threshold", "rmse=0.23", "--threshold", "yee=0"], 3),
        (&["--metric", "yee", "--threshold", "384"], 0),
        (&["--metric", "yee", "--threshold", "383"], 3),
        (&["--metric", "flip", "--threshold", "1"], 0),
    ] {
        let run = ends(&folder, &compare(more), code);
        let word = if code == 0 { ", within " } else { ", MORE THAN " };
        assert!(run.stdout.contains(word), "{more:?}: {}", run.stdout);
        assert_eq!(run.stderr.lines().count(), usize::from(code == 3), "{more:?}: {}", run.stderr);
    }
    let run = ends(&folder, &compare(&["--threshold", "rmse=0.1", "--threshold", "yee=3"]), 3);
    assert!(run.stderr.contains("yee is 384, more than the threshold of 3; rmse is 0.22592"), "{}", run.stderr);
    assert_eq!(compared(&folder, &["a.exr", "a.exr", "--threshold", "yee=0"])["within"], true);
}

#[test]
fn parameters_change_the_result() {
    let folder = folder();
    write(&folder, "a.exr", 0.0, 0.1);
    write(&folder, "b.exr", 0.0, 0.0);
    let value = |metric: &str, more: &[&str]| {
        let found = compared(&folder, &[&["a.exr", "b.exr", "--metric", metric], more].concat());
        found["metrics"][metric]["value"].as_f64().expect("a number")
    };
    let [far, near] = ["200", "20"].map(|pixels| value("flip", &["--pixels-per-degree", pixels]));
    // Its filters span an angle: from afar, the error of one pixel is spread over more of them.
    assert!(far > 1.2 * near, "{far} {near}");
    assert_eq!(value("flip", &["--pixels-per-degree", "67.02064514160156"]), value("flip", &[]));
    // Seen from so far that the whole picture is a fifth of a degree, and in the dark, a pixel does not show.
    assert_eq!(value("yee", &[]), 1.0);
    assert_eq!(value("yee", &["--field-of-view", "0.2"]), 0.0);
    assert_eq!(value("yee", &["--white", "0.01"]), 0.0);
}

#[test]
fn bad_pictures_and_flags_are_refused() {
    let folder = folder();
    write(&folder, "a.png", 0.0, 0.0);
    write(&folder, "a.exr", 0.0, 0.0);
    write(&folder, "nan.exr", 0.0, f32::NAN);
    write(&folder, "inf.exr", 0.0, f32::INFINITY);
    let png = fs::read(folder.path().join("a.png")).expect("the file");
    let small = Image { width: 3, height: 2, rgb: vec![[0.5; 3]; 6] };
    output::write(&folder.path().join("small.png"), &small, &Metadata::default()).expect("a picture");
    for (name, bytes) in
        [("empty.png", &[][..]), ("half.png", &png[..png.len() / 2]), ("fake.exr", &png), ("text.hdr", b"hello")]
    {
        fs::write(folder.path().join(name), bytes).expect("a file");
    }
    for (picture, words) in [
        ("small.png", &["`small.png` has 3 × 2 pixels", "`a.exr` has 24 × 16", "--size"][..]),
        ("nan.exr", &["`nan.exr` holds NaN in the red channel of pixel (7, 5)"]),
        ("inf.exr", &["`inf.exr` holds inf in the red channel of pixel (7, 5)"]),
        ("empty.png", &["`empty.png` is empty"]),
        ("half.png", &["cannot read the picture `half.png`"]),
        ("fake.exr", &["`fake.exr` does not begin as an EXR file does"]),
        ("text.hdr", &["`text.hdr` does not begin as a Radiance HDR file does"]),
        ("none.png", &["cannot read the picture `none.png`", "check the path"]),
        ("a.jpg", &["`a.jpg`", ".png, .exr or .hdr"]),
        (".", &[".png, .exr or .hdr"]),
    ] {
        refused(&folder, &["compare", picture, "a.exr"], words);
        refused(&folder, &["compare", "a.exr", picture, "--diff", "d.png", "--json"], &[]);
    }
    for (flags, words) in [
        (&["--metric", "psnr"][..], &["--metric", "psnr", "all, flip, yee, relmse, rmse"][..]),
        (&["--threshold", "1"], &["--threshold 1", "of which metric", "flip=1"]),
        (&["--metric", "flip", "--threshold", "yee=1"], &["--metric leaves yee out"]),
        (&["--threshold", "yee=1", "--threshold", "yee=2"], &["given twice for yee"]),
        (&["--threshold", "-1"], &["--threshold", "a number from 0"]),
        (&["--threshold", "nan"], &["--threshold", "a number from 0"]),
        (&["--threshold", "all=1"], &["--threshold", "flip=0.05"]),
        (&["--threshold", "psnr=1"], &["--threshold", "flip=0.05"]),
        (&["--pixels-per-degree", "0"], &["--pixels-per-degree", "from 1 to 1000"]),
        (&["--field-of-view", "180"], &["--field-of-view", "from 0.1 to 170"]),
        (&["--white", "-5"], &["--white", "from 0.01 to 1000000"]),
        (&["--diff", "d.exr"], &["--diff", "d.exr", ".png"]),
        (&["--diff", "none/d.png"], &["`none` does not exist"]),
        (&["--diff", "a.png"], &["--diff", "would replace"]),
    ] {
        refused(&folder, &[&["compare", "a.png", "a.exr"], flags].concat(), words);
    }
    refused(&folder, &["compare", "a.png"], &["<B>"]);
    assert!(succeeds(&folder, &["compare", "--help"]).stdout.contains("exit code is 3"));
}

/// Renders of one scene with two seeds differ by their noise, and a render against itself does not.
#[test]
fn renders_are_compared() {
    let folder = folder();
    succeeds(&folder, &small("a.exr", &[]));
    succeeds(&folder, &small("b.exr", &["--seed", "1"]));
    succeeds(&folder, &small("c.exr", &[]));
    ends(&folder, &["compare", "a.exr", "c.exr", "--threshold", "yee=0", "--threshold", "rmse=0"], 0);
    ends(&folder, &["compare", "a.exr", "b.exr", "--metric", "relmse", "--threshold", "0.0001"], 3);
}
