//! The program as users run it: what it prints, how it fails, what it leaves behind.
//!
//! Cargo builds the program for the integration tests of its own package (`runner/tests`), so `cargo test --workspace` has
//! it. Tests of this package alone run the one that was built last.

use caustic_renderer::output::{self, Image};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// The program, which is beside the folder of this test.
fn program() -> PathBuf {
    let test = std::env::current_exe().expect("a test knows where it is");
    let folder = test.parent().and_then(Path::parent).expect("tests are in target/PROFILE/deps");
    let program = folder.join(format!("caustic{}", std::env::consts::EXE_SUFFIX));
    assert!(program.is_file(), "{} is missing: run `cargo build --release` first", program.display());
    program
}

/// The program with arguments, in a folder.
fn command(folder: &TempDir, arguments: &[&str]) -> Command {
    let mut command = Command::new(program());
    command.args(arguments).current_dir(folder.path());
    // Mesa's layer that sorts devices looks for a Wayland display and writes to stderr where there is none.
    command.env("NODEVICE_SELECT", "1");
    command
}

/// An empty folder that goes when it is dropped.
fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder for a test")
}

/// What a run of the program came to.
#[derive(Debug)]
struct Run {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("the program prints UTF-8");
        Self { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}

fn run(folder: &TempDir, arguments: &[&str]) -> Run {
    command(folder, arguments).output().expect("the program starts").into()
}

/// Runs the program, which must succeed.
#[track_caller]
fn succeeds(folder: &TempDir, arguments: &[&str]) -> Run {
    let run = run(folder, arguments);
    assert_eq!(run.code, Some(0), "{arguments:?}: {run:?}");
    run
}

/// Runs the program, which must refuse its input: exit code 2, one line on stderr that has all of `words`, nothing on
/// stdout, and no file that was not there before.
#[track_caller]
fn refused(folder: &TempDir, arguments: &[&str], words: &[&str]) {
    let before = files(folder);
    let run = run(folder, arguments);
    println!("{}", run.stderr.trim_end());
    assert_eq!(run.code, Some(2), "{arguments:?}: {run:?}");
    assert_eq!(run.stdout, "", "{arguments:?}");
    // Of errors that show only when the device has been opened: its line comes first.
    let lines: Vec<_> = run.stderr.lines().filter(|line| !line.starts_with("device: ")).collect();
    assert_eq!(lines.len(), 1, "{arguments:?}: {run:?}");
    let line = lines[0];
    assert!(line.starts_with("error: ") && run.stderr.ends_with('\n'), "{arguments:?}: {line}");
    assert!(!line.contains(":;") && !line.chars().any(char::is_control), "{arguments:?}: {line:?}");
    for word in words {
        assert!(line.contains(word), "{arguments:?}: no `{word}` in: {line}");
    }
    assert_eq!(files(folder), before, "{arguments:?}: files came or went");
}

/// Names of what a folder holds, in order.
fn files(folder: &TempDir) -> Vec<String> {
    let entries = fs::read_dir(folder.path()).expect("the folder can be read");
    let mut names: Vec<_> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A render of a few milliseconds, with more arguments.
fn small<'a>(output: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut arguments = vec!["render", "cornell", "-o", output, "--device", "cpu", "--size", "24x16", "--spp", "2"];
    arguments.extend(["--photons", "2000", "--caustic-photons", "1000", "--k", "40", "--radius", "0.2"]);
    arguments.extend(more);
    arguments
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error} in {text}"))
}

fn read(path: &Path) -> Image {
    output::read(path).expect("a picture that can be read")
}

#[test]
fn help_teaches() {
    let folder = folder();
    let help = succeeds(&folder, &["--help"]).stdout;
    let parts = [
        "Usage",
        "Examples:",
        "caustic render cornell -o cornell.png",
        "render",
        "map",
        "info",
        "scene",
        "Exit codes",
        "130",
        "caustic map --photons uniform:1000000",
    ];
    for part in parts {
        assert!(help.contains(part), "no `{part}` in {help}");
    }
    let help = succeeds(&folder, &["render", "--help"]).stdout;
    let flags = [
        "--output",
        "--size",
        "--photons",
        "--caustic-photons",
        "--k",
        "--radius",
        "--hash",
        "--gather",
        "--spp",
        "--device",
        "--seed",
        "--show",
        "--quiet",
        "--json",
    ];
    let values = [
        "WxH",
        "linear",
        "teschner",
        "morton",
        "heap",
        "list",
        "beauty",
        "direct",
        "global",
        "caustic",
        "map-global",
        "map-caustic",
        "auto, cpu, gpu",
        "gpu:NAME_OR_INDEX",
        ".png",
        ".exr",
        "metres",
        "scene list",
    ];
    for part in flags.iter().chain(&values) {
        assert!(help.contains(part), "no `{part}` in {help}");
    }
    for command in ["map", "info", "scene"] {
        assert!(succeeds(&folder, &[command, "--help"]).stdout.contains("Usage"));
    }
    let version = succeeds(&folder, &["--version"]).stdout;
    assert_eq!(version, format!("caustic {}\n", env!("CARGO_PKG_VERSION")));
    assert_eq!(files(&folder), [""; 0]);
}

#[test]
fn info_lists_the_devices() {
    let folder = folder();
    let text = succeeds(&folder, &["info"]).stdout;
    assert!(text.contains("cpu") && text.contains("exact: yes") && text.contains("threads"), "{text}");
    let info = json(&succeeds(&folder, &["info", "--json"]).stdout);
    assert!(info["cpu"]["threads"].as_u64() >= Some(1), "{info}");
    assert_eq!(info["cpu"]["exact"], true);
    for adapter in info["adapters"].as_array().expect("a list of adapters") {
        assert!(text.contains(adapter["name"].as_str().expect("a name")), "{adapter}");
        assert!(adapter["exact"].is_boolean() && adapter["subgroup"][0].is_u64(), "{adapter}");
        assert!(adapter["max_buffer_bytes"].is_u64() && adapter["max_workgroup_lanes"].is_u64(), "{adapter}");
    }
}

#[test]
fn scene_list_has_a_line_each() {
    let folder = folder();
    let text = succeeds(&folder, &["scene", "list"]).stdout;
    let names: Vec<_> = text.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(names[0], "cornell", "{text}");
    for line in text.lines() {
        assert!(line.split_whitespace().count() > 3, "a name alone: {line}");
    }
    let list = json(&succeeds(&folder, &["scene", "list", "--json"]).stdout);
    let listed: Vec<_> = list.as_array().expect("a list").iter().map(|scene| scene["name"].as_str()).collect();
    assert_eq!(listed, names.iter().copied().map(Some).collect::<Vec<_>>());
}

#[test]
fn a_render_writes_the_same_picture_to_png_and_exr() {
    let folder = folder();
    let run = succeeds(&folder, &small("a.png", &[]));
    assert_eq!(run.stdout, "");
    for part in ["device: CPU", "global map", "caustic map", "photons stored", "time:", "memory:", "wrote a.png"] {
        assert!(run.stderr.contains(part), "no `{part}` in {}", run.stderr);
    }
    succeeds(&folder, &small("a.exr", &[]));
    assert_eq!(files(&folder), ["a.exr", "a.png"]);
    let [png, exr] = ["a.png", "a.exr"].map(|name| read(&folder.path().join(name)));
    assert_eq!([png.width, png.height, exr.width, exr.height], [24, 16, 24, 16]);
    let codes = |image: &Image| -> Vec<_> { image.rgb.iter().map(|rgb| rgb.map(output::to_srgb8)).collect() };
    assert_eq!(codes(&png), codes(&exr));
    assert!(exr.rgb.iter().flatten().any(|&value| value > 1.0), "the light is in the picture");

    // The same command gives the same file, another seed another one; hash and gather change nothing.
    let bytes = |name: &str| fs::read(folder.path().join(name)).expect("a file");
    succeeds(&folder, &small("b.exr", &["--hash", "teschner", "--gather", "list", "--seed", "0"]));
    assert!(bytes("a.exr") == bytes("b.exr"));
    succeeds(&folder, &small("c.exr", &["--seed", "1"]));
    assert!(bytes("a.exr") != bytes("c.exr"));
    // A file that is there is replaced.
    succeeds(&folder, &small("c.exr", &[]));
    assert!(bytes("a.exr") == bytes("c.exr"));
}

#[test]
fn an_exr_says_how_it_was_made() {
    let folder = folder();
    succeeds(&folder, &small("a.exr", &["--seed", "77", "--show", "map-global"]));
    let data = exr::meta::MetaData::read_from_file(folder.path().join("a.exr"), true).expect("an EXR");
    let header = &data.headers[0];
    let attribute = |name: &str| {
        let name = exr::prelude::Text::from(name);
        let own = header.own_attributes.other.get(&name);
        match own.or(header.shared_attributes.other.get(&name)) {
            Some(exr::prelude::attribute::AttributeValue::Text(text)) => text.to_string(),
            other => panic!("{name}: {other:?}"),
        }
    };
    assert_eq!(attribute("caustic.version"), env!("CARGO_PKG_VERSION"));
    assert_eq!(attribute("caustic.scene"), "cornell");
    assert_eq!(attribute("caustic.seed"), "77");
    let settings = attribute("caustic.settings");
    let settings: Vec<_> = settings.lines().collect();
    for setting in ["photons=2000", "caustic_photons=1000", "k=40", "radius=0.2", "spp=2"] {
        assert!(settings.contains(&setting), "no `{setting}` in {settings:?}");
    }
    assert!(settings.iter().any(|setting| setting.starts_with("show=")), "{settings:?}");
}

#[test]
fn json_tells_what_a_render_did() {
    let folder = folder();
    let run = succeeds(&folder, &small("a.png", &["--json", "--quiet", "--seed", "3"]));
    assert_eq!(run.stderr, "");
    let report = json(&run.stdout);
    assert!(report["device"].as_str().is_some_and(|name| name.contains("CPU")), "{report}");
    assert_eq!(report["complete"], true);
    assert_eq!((&report["scene"], &report["seed"]), (&"cornell".into(), &3.into()));
    assert_eq!((&report["output"], &report["settings"]["k"]), (&"a.png".into(), &"40".into()));
    assert!(report["seconds"].as_f64() > Some(0.0));
    let maps = report["maps"].as_array().expect("a list of maps");
    assert_eq!(maps.len(), 2);
    for (map, (name, emitted)) in maps.iter().zip([("global", 2000), ("caustic", 1000)]) {
        assert_eq!((&map["map"], &map["photons_emitted"]), (&name.into(), &emitted.into()));
        let stored = map["photons_stored"].as_u64().expect("a number");
        assert!(stored > 0 && map["bytes"].as_u64() >= Some(32 * stored), "{map}");
    }
    let stages = report["stages"].as_array().expect("a list of stages");
    for name in ["global/store_photons", "caustic/store_photons", "image/trace_camera", "image/develop_film"] {
        let stage =
            stages.iter().find(|stage| stage["stage"] == name).unwrap_or_else(|| panic!("no {name}: {stages:?}"));
        assert!(stage["ms"].as_f64() >= Some(0.0), "{stage}");
    }
    let buffers = report["buffers"].as_array().expect("a list of buffers");
    let peaks = buffers.iter().map(|buffer| buffer["peak_bytes"].as_u64().expect("bytes"));
    let (most, sum) = peaks.fold((0, 0), |(most, sum), peak| (most.max(peak), sum + peak));
    let peak = report["peak_bytes"].as_u64().expect("bytes");
    assert!(most > 0 && most <= peak && peak <= sum, "{most} {peak} {sum}");
}

#[test]
fn quiet_prints_nothing() {
    let folder = folder();
    let run = succeeds(&folder, &small("a.png", &["--quiet"]));
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    assert_eq!(files(&folder), ["a.png"]);
}

#[test]
fn bad_flags_are_refused() {
    let folder = folder();
    let metres = ["--radius", "metres", "1e-18", "1e18"];
    let k = ["--k", "whole number", "1 to 1024"];
    let sides = ["--size", "WIDTHxHEIGHT", "1 to 65536", "640x480"];
    let photons = ["photons", "1 to 536870912"];
    let device = ["--device", "auto, cpu, gpu or gpu:NAME_OR_INDEX", "caustic info"];
    for (flag, values, words) in [
        ("--k", &["0", "100000000", "-1", "1.5", ""][..], &k[..]),
        ("--radius", &["0", "-1", "-0", "inf", "-inf", "nan", "1e-40", "1e39", "wide"], &metres),
        ("--size", &["0x0", "0x10", "1000000x1000000", "abc", "64", "64x", "64x64x64", "-4x4"], &sides),
        ("--size", &["65536x65536"], &["--size", "65536x65536", "at most 268435456 pixels"]),
        ("--photons", &["99999999999999", "0", "-5", "many"], &photons),
        ("--caustic-photons", &["99999999999999", "-5"], &["--caustic-photons", "0 to 536870912"]),
        ("--spp", &["0", "99999999", "-1"], &["--spp", "1 to 65536"]),
        ("--seed", &["abc", "-1", "4294967296"], &["--seed", "0 to 4294967295"]),
        ("--hash", &["md5"], &["--hash", "md5", "linear, teschner, morton"]),
        ("--gather", &["tree"], &["--gather", "tree", "heap, list"]),
        ("--show", &["ugly"], &["--show", "ugly", "beauty, direct, global, caustic, map-global, map-caustic"]),
        ("--device", &["foo", "gpu:", ""], &device),
        ("--device", &["gpu:nonexistent"], &["nonexistent", "this machine has", "--device cpu"]),
    ] {
        for value in values {
            refused(&folder, &["render", "cornell", "-o", "a.png", flag, value], words);
        }
    }
    refused(&folder, &["render", "cornell", "-o", "a.png", "--photon", "5"], &["--photon", "tip", "--photons"]);
    refused(&folder, &["render", "cornell"], &["--output"]);
    refused(&folder, &["render"], &["--output", "SCENE"]);
    refused(&folder, &["rendr", "cornell"], &["rendr", "render"]);
    refused(&folder, &["scene"], &["caustic scene", "list"]);
}

#[test]
fn a_refusal_leaves_the_picture_that_was_there() {
    let folder = folder();
    fs::write(folder.path().join("a.png"), "old").expect("a file");
    refused(&folder, &["render", "cornell", "-o", "a.png", "--k", "0"], &[]);
    refused(&folder, &["render", "void", "-o", "a.png", "--device", "cpu"], &[]);
    fs::write(folder.path().join("void.toml"), VOID).expect("a file");
    refused(&folder, &["render", "void.toml", "-o", "a.png", "--device", "cpu"], &["no photons"]);
    assert_eq!(fs::read(folder.path().join("a.png")).expect("the file"), b"old");
}

/// A lamp that faces away from the only surface.
const VOID: &str = r#"[camera]
position = [0, 1, 4]
target = [0, 0, 0]
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
name = "lamp"
corner = [-1, 1, -1]
edge_u = [0, 0, 2]
edge_v = [2, 0, 0]
radiance = [1, 1, 1]
"#;

#[test]
fn bad_scenes_are_refused() {
    let folder = folder();
    let good = VOID;
    let replaced = |from: &str, to: &str| {
        assert!(good.contains(from));
        good.replace(from, to).into_bytes()
    };
    let garbage: Vec<u8> = (0..5000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    let cases: [(&str, Vec<u8>, &[&str]); 17] = [
        ("empty.toml", Vec::new(), &["empty.toml", "is empty", "[camera]"]),
        ("blank.toml", b"\n \n".to_vec(), &["is empty"]),
        ("comment.toml", b"# nothing\n".to_vec(), &["lacks the field `camera`", "position"]),
        ("garbage.toml", garbage, &["not a text file", "UTF-8"]),
        ("nul.toml", vec![0; 64], &["nul.toml:1:", "not valid TOML"]),
        ("picture.png", b"\x89PNG\r\n\x1a\n".to_vec(), &["not a text file"]),
        ("broken.toml", replaced("[0.8, 0.8, 0.8]", "[0.8, 0.8"), &["broken.toml:10:", "not valid TOML"]),
        (
            "misspelt.toml",
            replaced("reflectance", "reflectence"),
            &["misspelt.toml:8:1", "did you mean `reflectance`?"],
        ),
        ("kind.toml", replaced("lambertian", "lambert"), &["kind.toml:7:", "one of `lambertian`"]),
        ("bright.toml", replaced("[0.8, 0.8, 0.8]", "[0.8, 1.2, 0.8]"), &["bright.toml:8:", "1.2", "from 0 to 1"]),
        ("type.toml", replaced("= 35", "= \"wide\""), &["type.toml:4:", "vertical_fov_degrees", "number"]),
        ("angle.toml", replaced("= 35", "= 180"), &["angle.toml:4:", "0.01", "179"]),
        ("nan.toml", replaced("[0, 1, 4]", "[0, nan, 4]"), &["nan.toml:2:", "camera.position", "NaN"]),
        ("flat.toml", replaced("edge_v = [2, 0, 0]", "edge_v = [0, 0, 1]"), &["flat.toml:1", "parallel"]),
        (
            "unknown.toml",
            replaced("material = \"white\"", "material = \"whyte\""),
            &["unknown.toml:14:12", "did you mean \"white\"?"],
        ),
        ("dark.toml", replaced("radiance = [1, 1, 1]", "radiance = [0, 0, 0]"), &["dark.toml:2", "radiance", "1e-9"]),
        ("void.toml", good.as_bytes().to_vec(), &["stored no photons", "lights face the scene", "--photons"]),
    ];
    for (name, bytes, words) in cases {
        fs::write(folder.path().join(name), bytes).expect("a file");
        refused(&folder, &["render", name, "-o", "a.png", "--device", "cpu", "--size", "8x8"], words);
    }
    refused(&folder, &["render", "none.toml", "-o", "a.png"], &["none.toml", "cannot read", "`cornell`"]);
    refused(&folder, &["render", "cornel", "-o", "a.png"], &["did you mean `cornell`?", "`furnace`", ".toml"]);
    refused(&folder, &["render", ".", "-o", "a.png"], &["folder"]);
    refused(&folder, &["render", "", "-o", "a.png"], &["`cornell`"]);

    // The scene is right if the lamp is turned round.
    let lamp = "edge_u = [0, 0, 2]\nedge_v = [2, 0, 0]\nradiance";
    fs::write(folder.path().join("good.toml"), replaced(lamp, "edge_u = [2, 0, 0]\nedge_v = [0, 0, 2]\nradiance"))
        .expect("a file");
    let arguments = ["render", "good.toml", "-o", "a.png", "--device", "cpu", "--size", "8x8", "--photons", "1000"];
    let run = succeeds(&folder, &arguments);
    assert!(run.stderr.contains("note: no caustic map"), "{}", run.stderr);
}

#[test]
fn bad_outputs_are_refused() {
    let folder = folder();
    fs::create_dir(folder.path().join("folder.png")).expect("a folder");
    fs::write(folder.path().join("file"), "").expect("a file");
    for (name, words) in [
        ("a.jpg", &["a.jpg", ".png or .exr"][..]),
        ("a", &["`a`", ".png or .exr"]),
        (".png", &[".png or .exr"]),
        (".", &[".png or .exr"]),
        ("none/a.png", &["`none` does not exist", "create it"]),
        ("file/a.png", &["`file` is not a folder"]),
        ("folder.png", &["folder.png", "is a folder"]),
    ] {
        refused(&folder, &["render", "cornell", "-o", name], words);
    }
    assert_eq!(fs::read_dir(folder.path().join("folder.png")).expect("the folder").count(), 0);
}

#[test]
fn map_builds_and_checks_a_photon_map() {
    let folder = folder();
    let more = ["--queries", "200", "--k", "10", "--device", "cpu", "--repeat", "1"];
    let map = |photons: &str, last: &[&str]| {
        let arguments: Vec<&str> = ["map", "--photons", photons].iter().chain(&more).chain(last).copied().collect();
        succeeds(&folder, &arguments).stdout
    };
    let text = map("uniform:5000", &[]);
    assert!(text.contains("0 of 64 checked queries differ"), "{text}");
    assert!(text.contains("5000 photons") && text.contains("200 queries, k = 10"), "{text}");
    for (photons, hash, gather) in [("surface:3000", "teschner", "list"), ("clustered:3000", "morton", "heap")] {
        let report = json(&map(photons, &["--json", "--hash", hash, "--gather", gather]));
        assert_eq!(report["queries_that_differ_from_brute_force"], 0, "{report}");
        assert_eq!((&report["photons"], &report["checked_queries"]), (&3000.into(), &64.into()));
        assert!(report["build_ms"].as_f64() > Some(0.0) && report["query_ms"].as_f64() > Some(0.0), "{report}");
        assert!(report["stages"].as_array().is_some_and(|stages| stages.len() > 5), "{report}");
    }
    fs::write(folder.path().join("points.txt"), "# x y z\n0 0 0\n\n1 2 3\n0.5 0.5 0.5\n").expect("a file");
    let text = map("points.txt", &["--radius", "1"]);
    assert!(text.contains("3 photons") && text.contains("0 of 64"), "{text}");
    assert_eq!(files(&folder), ["points.txt"]);
}

#[test]
fn bad_input_of_map_is_refused() {
    let folder = folder();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).expect("a file");
    write("empty.txt", b"");
    write("short.txt", b"0 0 0\n1 2\n");
    write("words.txt", b"a b c\n");
    write("nan.txt", b"0 nan 0\n");
    write("far.txt", b"0 0 0\n1e38 0 0\n-3e38 0 0\n");
    write("garbage.bin", &[0xff, 0xfe, 0x00, 0x80]);
    for (photons, words) in [
        ("none.txt", &["none.txt", "x y z", "uniform:N"][..]),
        ("empty.txt", &["empty.txt", "no photons", "x y z"]),
        ("short.txt", &["short.txt", "line 2", "x y z"]),
        ("words.txt", &["words.txt", "line 1", "x y z"]),
        ("garbage.bin", &["garbage.bin", "UTF-8", "x y z"]),
        ("nan.txt", &["photon", "finite"]),
        ("far.txt", &["cells along an axis", "--radius of at least"]),
        (".", &["x y z"]),
        ("uniform:0", &["uniform:0", "1 to 268435456"]),
        ("uniform:many", &["uniform:many", "1 to 268435456"]),
        ("clustered:-1", &["clustered:-1", "1 to 268435456"]),
        ("cube:5", &["cube:5", "uniform:N"]),
    ] {
        refused(&folder, &["map", "--photons", photons, "--device", "cpu", "--radius", "1e-3"], words);
    }
    for (flag, value, words) in [
        ("--k", "0", &["--k", "1 to 1024"][..]),
        ("--k", "100000000", &["--k", "1 to 1024"]),
        ("--queries", "0", &["--queries", "1 to"]),
        ("--repeat", "-1", &["--repeat", "1 to 1000"]),
        ("--radius", "nan", &["--radius", "1e-18 to 1e18"]),
        ("--hash", "md5", &["linear, teschner, morton"]),
    ] {
        refused(&folder, &["map", "--photons", "uniform:100", "--device", "cpu", flag, value], words);
    }
}

/// Ctrl-C.
#[cfg(unix)]
mod interrupt {
    use super::{Run, command, files, folder, read};
    use std::io::{BufRead, BufReader, Read};
    use std::process::{Command, Stdio};
    use std::thread::sleep;
    use std::time::{Duration, Instant};
    use tempfile::TempDir;

    /// Runs the program, interrupts it `after` it has said which device it runs on, and waits for its end.
    fn interrupted(folder: &TempDir, arguments: &[&str], after: Duration) -> (Run, Duration) {
        let mut child = command(folder, arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let mut stderr = BufReader::new(child.stderr.take().expect("a pipe"));
        let mut first = String::new();
        stderr.read_line(&mut first).expect("a line");
        assert!(first.starts_with("device: "), "{first}");
        sleep(after);
        let kill = Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status();
        assert!(kill.expect("a shell").success(), "the program had ended before");
        let start = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().expect("a child") {
                break status;
            }
            if start.elapsed() > Duration::from_secs(60) {
                child.kill().expect("a child that can be killed");
                panic!("the program did not stop within 60 s");
            }
            sleep(Duration::from_millis(20));
        };
        let took = start.elapsed();
        let mut rest = String::new();
        stderr.read_to_string(&mut rest).expect("text");
        (Run { code: status.code(), stdout: String::new(), stderr: rest }, took)
    }

    #[test]
    fn an_interrupt_among_the_photons_leaves_nothing() {
        let folder = folder();
        let arguments =
            ["render", "cornell", "-o", "a.png", "--device", "cpu", "--size", "32x32", "--photons", "60000000"];
        let (run, took) = interrupted(&folder, &arguments, Duration::from_millis(700));
        println!("stopped after {took:.1?}");
        assert_eq!(run.code, Some(130), "{run:?}");
        assert!(run.stderr.ends_with("error: interrupted; nothing was written\n"), "{run:?}");
        assert_eq!(files(&folder), [""; 0]);
    }

    #[test]
    fn an_interrupt_in_the_picture_leaves_all_of_it_or_nothing() {
        for name in ["a.png", "a.exr"] {
            let folder = folder();
            let arguments = [
                "render",
                "cornell",
                "-o",
                name,
                "--device",
                "cpu",
                "--size",
                "300x200",
                "--photons",
                "2000",
                "--caustic-photons",
                "1000",
                "--spp",
                "4096",
            ];
            let (run, took) = interrupted(&folder, &arguments, Duration::from_millis(1500));
            println!("stopped after {took:.1?}: {}", run.stderr);
            assert_eq!(run.code, Some(130), "{run:?}");
            let last = run.stderr.lines().last().unwrap_or_default();
            assert!(last.starts_with("error: interrupted"), "{run:?}");
            if files(&folder).is_empty() {
                assert!(last.contains("nothing was written"), "{run:?}");
            } else {
                assert_eq!(files(&folder), [name]);
                let picture = read(&folder.path().join(name));
                assert_eq!([picture.width, picture.height], [300, 200]);
                assert!(last.contains(name) && last.contains("black"), "{run:?}");
            }
        }
    }
}

/// The GPU as arguments of the program, or none.
fn gpu_arguments() -> Option<Vec<String>> {
    caustic_tests::gpu()?;
    let named = std::env::var("CAUSTIC_TEST_GPU").unwrap_or("gpu".to_string());
    Some(vec!["--device".to_string(), named])
}

#[test]
fn verify_compares_every_stage_and_prints_a_table() {
    let folder = folder();
    let Some(gpu) = gpu_arguments() else {
        if caustic_device::adapters().is_empty() {
            refused(&folder, &["verify"], &["no GPU matches `gpu`", "--device cpu"]);
        }
        return;
    };
    let gpu: Vec<&str> = gpu.iter().map(String::as_str).collect();
    let text = succeeds(&folder, &[&["verify", "--seed", "5"], &gpu[..]].concat()).stdout;
    for part in ["stage", "radix_scatter", "irradiance_histogram", "picture of cornell", "SHA-256 of furnace", "seed 5"]
    {
        assert!(text.contains(part), "no `{part}` in {text}");
    }
    let all = text.lines().find(|line| line.starts_with("all ")).expect("a sum");
    let numbers: Vec<u64> = all.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect();
    assert!(numbers[0] > 5_000_000 && numbers[1..] == [0, 0], "{all}");

    let found = json(&succeeds(&folder, &[&["verify", "--json"], &gpu[..]].concat()).stdout);
    assert_eq!((&found["same"], &found["exact"]), (&true.into(), &true.into()));
    assert!(
        found["stages"].as_array().unwrap().iter().all(|row| row["differ"] == 0 && row["words"].as_u64() > Some(0))
    );
    assert_eq!(found["images"][0]["cpu_sha256"], found["images"][0]["gpu_sha256"]);
}

#[test]
fn verify_refuses_what_it_cannot_compare() {
    let folder = folder();
    refused(&folder, &["verify", "--device", "cpu"], &["compares a GPU with the CPU", "gpu:NAME_OR_INDEX"]);
    refused(
        &folder,
        &["verify", "--gpu-from", "gathering"],
        &["--gpu-from gathering", "no such stage", "develop_film"],
    );
}

/// Where words cannot be passed through, exact kernels are refused and fast ones translated; here by an environment variable.
#[test]
fn without_passthrough_only_fast_kernels_run_and_say_so() {
    let Some(gpu) = gpu_arguments() else { return };
    let folder = folder();
    let portable = |more: &[&str]| -> Run {
        let mut arguments =
            vec!["render", "plane", "-o", "a.exr", "--size", "16x12", "--spp", "2", "--photons", "500", "--k", "10"];
        arguments.extend(gpu.iter().map(String::as_str).chain(more.iter().copied()));
        command(&folder, &arguments).env("CAUSTIC_PORTABLE", "1").output().expect("the program starts").into()
    };
    let exact = portable(&[]);
    assert_eq!(exact.code, Some(2), "{exact:?}");
    assert!(exact.stderr.contains("--precision fast") && files(&folder).is_empty(), "{exact:?}");
    let fast = portable(&["--precision", "fast"]);
    assert_eq!(fast.code, Some(0), "{fast:?}");
    assert!(fast.stderr.contains("not exact here"), "{}", fast.stderr);
    let found = read(&folder.path().join("a.exr"));
    let cpu = [
        "render",
        "plane",
        "-o",
        "b.exr",
        "--size",
        "16x12",
        "--spp",
        "2",
        "--photons",
        "500",
        "--k",
        "10",
        "--device",
        "cpu",
    ];
    succeeds(&folder, &cpu);
    let expected = read(&folder.path().join("b.exr"));
    // No photon of this scene is reflected again, and 2.5 ulp a division do not add up to more than this.
    for (a, b) in expected.rgb.as_flattened().iter().zip(found.rgb.as_flattened()) {
        assert!((a - b).abs() <= 1e-4 * a, "{a} and {b}");
    }
}
