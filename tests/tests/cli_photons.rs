//! Photon maps in files, layers, tone curves and what a new user begins with, as users run them.

use caustic_tests::program::*;
use std::fs;

const FEW: [&str; 6] = ["--photons", "2000", "--caustic-photons", "1000", "--device", "cpu"];

fn photons<'a>(input: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["photons", input][..], &FEW, more].concat()
}

/// A render of a few milliseconds from a file of photons.
fn from_map<'a>(output: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let fixed = ["render", "cornell", "-o", output, "--device", "cpu", "--size", "24x16", "--spp", "2", "--k", "40"];
    [&fixed[..], &["--radius", "0.2", "--load-map", "a.caustic"], more].concat()
}

#[test]
fn a_saved_map_gives_the_same_file() {
    let folder = folder();
    let run = succeeds(&folder, &photons("cornell", &["-o", "a.caustic", "--seed", "3"]));
    for part in ["global map", "caustic map", "photons stored of 2000 emitted", "wrote a.caustic"] {
        assert!(run.stderr.contains(part), "no `{part}` in {}", run.stderr);
    }
    let bytes = |name: &str| fs::read(folder.path().join(name)).expect("a file");
    let saved = bytes("a.caustic");
    succeeds(&folder, &photons("cornell", &["-o", "a.caustic", "--seed", "3", "--quiet"]));
    assert!(bytes("a.caustic") == saved, "the same photons are the same file");
    succeeds(&folder, &small("direct.exr", &["--seed", "3"]));
    succeeds(&folder, &from_map("loaded.exr", &[]));
    assert!(bytes("direct.exr") == bytes("loaded.exr"));
    // The map is used: another seed of the camera alone is neither picture.
    succeeds(&folder, &from_map("other.exr", &["--seed", "4"]));
    assert!(bytes("direct.exr") != bytes("other.exr"));
    succeeds(&folder, &from_map("hash.exr", &["--hash", "morton", "--gather", "list"]));
    assert!(bytes("direct.exr") == bytes("hash.exr"));
}

#[test]
fn dumps_tell_of_every_photon() {
    let folder = folder();
    succeeds(&folder, &photons("cornell", &["-o", "a.caustic", "--quiet"]));
    let stats =
        json(&succeeds(&folder, &["photons", "a.caustic", "--dump", "stats", "--json", "--device", "cpu"]).stdout);
    let maps = stats["maps"].as_array().expect("maps");
    assert_eq!(maps.len(), 2);
    let stored: Vec<u64> = maps.iter().map(|map| map["stored"].as_u64().expect("a number")).collect();
    for map in maps {
        let health = &map["hash"];
        assert!(health["load"].as_f64() > Some(0.0) && health["collisions"] == 0, "{map}");
        assert!(health["longest_cell"].as_u64() >= Some(1) && health["candidates_per_query"].as_f64() >= Some(1.0));
        assert!(map["power"][0].as_f64() > Some(0.0), "{map}");
    }
    let teschner = ["photons", "a.caustic", "--dump", "stats", "--json", "--device", "cpu", "--hash", "teschner"];
    let teschner = json(&succeeds(&folder, &teschner).stdout);
    assert_eq!(teschner["maps"][0]["hash"]["cells"], maps[0]["hash"]["cells"], "cells do not depend on the hash");

    let text = succeeds(&folder, &["photons", "a.caustic", "--dump", "stats", "--device", "cpu"]).stdout;
    for part in ["scene cornell, seed 0", "global map", "power", "extent", "collisions", "in the fullest", "candidates"]
    {
        assert!(text.contains(part), "no `{part}` in {text}");
    }

    let csv = succeeds(&folder, &["photons", "a.caustic", "--dump", "csv"]).stdout;
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len() as u64, 1 + stored.iter().sum::<u64>());
    assert!(rows.iter().all(|row| row.len() == 11) && rows[0][1] == "x");
    let of = |map: &str| rows.iter().filter(|row| row[0] == map).count() as u64;
    assert_eq!([of("global"), of("caustic")], [stored[0], stored[1]]);
    let power: f64 =
        rows[1..].iter().filter(|row| row[0] == "global").map(|row| f64::from(row[7].parse::<f32>().unwrap())).sum();
    let told = maps[0]["power"][0].as_f64().unwrap();
    // Sums of the same numbers in f64, printed to all their digits.
    assert!((power / told - 1.0).abs() < 1e-9, "{power} and {told}");

    succeeds(&folder, &["photons", "a.caustic", "--dump", "ply", "-o", "a.ply"]);
    let ply = fs::read(folder.path().join("a.ply")).expect("a file");
    let end = ply.windows(11).position(|bytes| bytes == b"end_header\n").expect("a header") + 11;
    let header = String::from_utf8(ply[..end].to_vec()).unwrap();
    assert!(header.contains(&format!("element vertex {}\n", stored.iter().sum::<u64>())), "{header}");
    // 3 doubles, 6 floats, 4 bytes and a word.
    assert_eq!((ply.len() - end) as u64, stored.iter().sum::<u64>() * (24 + 24 + 4 + 4));
    let x = f64::from_le_bytes(ply[end..end + 8].try_into().unwrap());
    assert_eq!(x, rows[1][1].parse::<f64>().unwrap(), "the first photon is the first");

    // Of a scene, without a file in between.
    let direct = succeeds(&folder, &photons("cornell", &["--dump", "csv"])).stdout;
    assert!(direct == csv);
}

#[test]
fn maps_that_do_not_fit_are_refused() {
    let folder = folder();
    succeeds(&folder, &photons("cornell", &["-o", "a.caustic", "--quiet"]));
    fs::copy(folder.path().join("a.caustic"), folder.path().join("cut.caustic")).expect("a copy");
    let cut = fs::read(folder.path().join("cut.caustic")).expect("a file");
    fs::write(folder.path().join("cut.caustic"), &cut[..cut.len() - 7]).expect("a file");
    fs::write(folder.path().join("text.caustic"), "a text").expect("a file");
    for (arguments, words) in [
        (
            &["render", "plane", "-o", "b.exr", "--load-map", "a.caustic"][..],
            &["a.caustic", "`cornell`", "`plane`"][..],
        ),
        (&["render", "cornell", "-o", "b.exr", "--load-map", "cut.caustic"], &["cut.caustic", "damaged"]),
        (&["render", "cornell", "-o", "b.exr", "--load-map", "text.caustic"], &["text.caustic", "not a photon map"]),
        (&["render", "cornell", "-o", "b.exr", "--load-map", "none.caustic"], &["none.caustic", "cannot read"]),
        (
            &["render", "cornell", "-o", "b.exr", "--load-map", "a.caustic", "--photons", "5"],
            &["--load-map", "--photons"],
        ),
        (
            &["render", "cornell", "-o", "b.exr", "--load-map", "a.caustic", "--show", "map-global", "--device", "cpu"],
            &["a.caustic", "global map", "--show"],
        ),
        (&["photons", "a.caustic", "-o", "b.caustic"], &["a.caustic", "--dump"]),
        (&["photons", "a.caustic", "--dump", "stats", "--seed", "4"], &["--seed", "a.caustic"]),
        (&["photons", "a.caustic", "--dump", "ply"], &["--output"]),
        (&["photons", "cornell"], &["--output", "--dump"]),
        (&["photons", "cornel", "-o", "b.caustic"], &["did you mean `cornell`"]),
        (&["photons", "cornell", "--dump", "stat"], &["stat", "stats"]),
        (&["photons", "cornell", "-o", "none/b.caustic"], &["none", "does not exist"]),
    ] {
        refused(&folder, arguments, words);
    }
}

#[test]
fn layers_are_in_the_file_and_in_exr_alone() {
    let folder = folder();
    succeeds(&folder, &small("plain.exr", &[]));
    succeeds(&folder, &small("a.exr", &["--aov", "all"]));
    let path = |name: &str| folder.path().join(name);
    assert_eq!(read(&path("plain.exr")), read(&path("a.exr")), "layers change nothing about the picture");
    let names = |name: &str| -> Vec<String> {
        let header = exr::meta::MetaData::read_from_file(path(name), true).expect("an EXR").headers[0].clone();
        header.channels.list.iter().map(|channel| channel.name.to_string()).collect()
    };
    assert_eq!(names("plain.exr"), ["B", "G", "R"]);
    let all = names("a.exr");
    for name in
        ["direct.R", "caustic.B", "global.G", "radius.global", "photons.caustic", "normal.X", "albedo.R", "depth.Z"]
    {
        assert!(all.iter().any(|channel| channel == name), "no {name} in {all:?}");
    }
    succeeds(&folder, &small("b.exr", &["--aov", "depth,direct", "--aov", "depth"]));
    assert_eq!(names("b.exr"), ["B", "G", "R", "depth.Z", "direct.B", "direct.G", "direct.R"]);
    refused(&folder, &small("c.png", &["--aov", "depth"]), &["c.png", "depth", ".exr"]);
    refused(&folder, &small("c.exr", &["--aov", "dept"]), &["dept", "depth"]);
    refused(&folder, &small("c.exr", &["--aov", "global", "--show", "direct"]), &["global", "--show"]);
}

#[test]
fn a_png_is_shown_as_asked_and_tonemap_does_the_same_to_an_exr() {
    let folder = folder();
    let bytes = |name: &str| fs::read(folder.path().join(name)).expect("a file");
    succeeds(&folder, &small("a.exr", &[]));
    let plain = {
        succeeds(&folder, &small("plain.png", &[]));
        bytes("plain.png")
    };
    for tone in ["none", "reinhard", "aces", "agx"] {
        let how = ["--tone-map", tone, "--exposure", "-0.5"];
        succeeds(&folder, &small("a.png", &how));
        succeeds(&folder, &[&["tonemap", "a.exr", "-o", "b.png"][..], &how].concat());
        assert!(bytes("a.png") == bytes("b.png"), "{tone}");
        assert!(bytes("a.png") != plain, "{tone}");
    }
    succeeds(&folder, &["tonemap", "a.exr", "-o", "b.png"]);
    assert!(bytes("b.png") == plain);
    succeeds(&folder, &small("a.hdr", &[]));
    succeeds(&folder, &["tonemap", "a.exr", "-o", "b.hdr"]);
    assert!(bytes("a.hdr") == bytes("b.hdr"));
    succeeds(&folder, &["compare", "a.hdr", "a.exr", "--metric", "relmse", "--threshold", "0.001"]);
    for (arguments, words) in [
        (&["tonemap", "a.exr", "-o", "c.hdr", "--exposure", "1"][..], &["--exposure", "c.hdr", ".png"][..]),
        (&["tonemap", "none.exr", "-o", "c.png"], &["none.exr"]),
        (&["tonemap", "a.exr", "-o", "c.png", "--tone-map", "ages"], &["ages", "agx"]),
        (&["tonemap", "a.exr", "-o", "c.png", "--exposure", "nan"], &["--exposure", "-64 to 64"]),
        (&["tonemap", "a.exr", "-o", "c.jpg"], &["c.jpg", ".png, .exr or .hdr"]),
    ] {
        refused(&folder, arguments, words);
    }
    refused(&folder, &small("c.exr", &["--tone-map", "aces"]), &["--tone-map", "c.exr", ".png"]);
}

#[test]
fn render_tells_of_the_hash() {
    let folder = folder();
    let report = json(&succeeds(&folder, &small("a.png", &["--json", "--hash", "teschner"])).stdout);
    let health = &report["maps"][0]["health"];
    for field in ["load", "longest_cell", "collisions", "candidates_per_query"] {
        assert!(health[field].is_number(), "no {field} in {report}");
    }
}

#[test]
fn a_new_user_gets_a_scene_that_renders() {
    let folder = folder();
    let run = succeeds(&folder, &["init"]);
    assert!(run.stderr.contains("caustic render scene.toml -o scene.png"), "{run:?}");
    let render = ["render", "scene.toml", "-o", "scene.png", "--size", "32x24", "--spp", "1", "--photons", "3000"];
    succeeds(&folder, &[&render[..], &["--caustic-photons", "1000", "--device", "cpu"]].concat());
    refused(&folder, &["init"], &["scene.toml", "there already"]);
    refused(&folder, &["init", "scene"], &["scene.toml"]);
    assert_eq!(files(&folder), ["scene.png", "scene.toml"]);
}

#[test]
fn completions_and_manual_name_every_command() {
    let folder = folder();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let text = succeeds(&folder, &["completions", shell]).stdout;
        for word in ["render", "photons", "load-map", "tone-map"] {
            assert!(text.contains(word), "no {word} for {shell}");
        }
    }
    refused(&folder, &["completions", "bsh"], &["bsh", "bash"]);
    let text = succeeds(&folder, &["man"]).stdout;
    assert!(text.contains(".TH") && text.contains("photons"), "{text}");
    succeeds(&folder, &["man", "--output", "."]);
    let pages = files(&folder);
    for page in ["caustic.1", "caustic-render.1", "caustic-photons.1"] {
        assert!(pages.iter().any(|name| name == page), "{pages:?}");
    }
}
