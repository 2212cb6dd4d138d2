//! The program as users run it: what it prints and what it leaves behind.

use caustic_renderer::output::{self, Image};
use caustic_tests::program::*;
use std::fs;

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
