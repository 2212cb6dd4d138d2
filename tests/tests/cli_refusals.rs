//! Bad input of the program: one sentence, exit code 2, and nothing lost or half-written.

use caustic_tests::program::*;
use std::fs;

#[test]
fn bad_flags_are_refused() {
    let folder = folder();
    let metres = ["--radius", "metres", "1e-9", "1e18"];
    let k = ["--k", "whole number", "1 to 1024"];
    let sides = ["--size", "WIDTHxHEIGHT", "1 to 65536", "640x480"];
    let photons = ["photons", "1 to 536870912"];
    let device = ["--device", "auto, cpu, gpu, gpu:NAME_OR_INDEX", "caustic info"];
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
        ("a.jpg", &["a.jpg", ".png, .exr or .hdr"][..]),
        ("a", &["`a`", ".png, .exr or .hdr"]),
        (".png", &[".png, .exr or .hdr"]),
        (".", &[".png, .exr or .hdr"]),
        ("none/a.png", &["`none` does not exist", "create it"]),
        ("file/a.png", &["`file` is not a folder"]),
        ("folder.png", &["folder.png", "is a folder"]),
    ] {
        refused(&folder, &["render", "cornell", "-o", name], words);
    }
    assert_eq!(fs::read_dir(folder.path().join("folder.png")).expect("the folder").count(), 0);
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
        ("far.txt", &["photons span", "remove those far away"]),
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
        ("--radius", "nan", &["--radius", "1e-9 to 1e18"]),
        ("--hash", "md5", &["linear, teschner, morton"]),
    ] {
        refused(&folder, &["map", "--photons", "uniform:100", "--device", "cpu", flag, value], words);
    }
}
