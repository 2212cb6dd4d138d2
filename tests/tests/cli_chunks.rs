//! `render --chunk` and `--memory`: the file of whole maps, byte for byte, in less memory.

use caustic_tests::program::*;
use std::fs;
use tempfile::TempDir;

/// The program with surveys kept in the test's folder.
fn surveyed(folder: &TempDir, arguments: &[&str]) -> Run {
    let mut command = command(folder, arguments);
    command.env("XDG_CACHE_HOME", folder.path().join("cache"));
    Run::from(command.output().expect("the program runs"))
}

fn bytes(folder: &TempDir, name: &str) -> Vec<u8> {
    fs::read(folder.path().join(name)).expect("a file")
}

#[test]
fn a_memory_that_whole_maps_do_not_fit_gives_the_same_file_in_chunks() {
    let folder = folder();
    let render = |output: &str, more: &[&str]| {
        let all = ["render", "cornell", "-o", output, "--device", "cpu", "--size", "64x48", "--spp", "2", "--json"];
        let photons = ["--photons", "300000", "--caustic-photons", "100000", "--k", "40", "--radius", "0.05"];
        let run = surveyed(&folder, &[&all[..], &photons, more].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        (json(&run.stdout), run.stderr)
    };
    for integrator in ["photon", "progressive"] {
        let way = ["--integrator", integrator, "--passes", "1"];
        let (whole, _) = render("whole.exr", &way);
        let (roomy, _) = render("roomy.exr", &[&way[..], &["--memory", "1GB"]].concat());
        let (chunked, said) = render("chunked.exr", &[&way[..], &["--memory", "16MB"]].concat());
        assert!(bytes(&folder, "whole.exr") == bytes(&folder, "chunked.exr"), "{integrator}: the files differ");
        assert!(bytes(&folder, "whole.exr") == bytes(&folder, "roomy.exr"), "{integrator}: the files differ");
        let number = |value: &serde_json::Value| value.as_f64().expect("a number");
        assert_eq!((&whole["maps"][0]["chunks"], &roomy["maps"][0]["chunks"]), (&1.into(), &1.into()));
        assert!(number(&chunked["maps"][0]["chunks"]) > 2.0 && said.contains(" --chunk "), "{chunked:#} {said}");
        let (taken, foreseen) = (number(&chunked["peak_bytes"]), number(&chunked["plan"]["prediction"]["bytes"]));
        println!("{integrator}: {taken} bytes, foreseen {foreseen}, whole {}", whole["peak_bytes"]);
        assert!(taken <= 1.1 * 16e6 && foreseen <= 16e6, "{taken} bytes, {foreseen} foreseen");
        assert!((0.9..1.1).contains(&(foreseen / taken)), "{foreseen} bytes foreseen, {taken} taken");
        assert!(taken < 0.5 * number(&whole["peak_bytes"]));
    }
}

/// How photons are cut is no part of a picture: checkpoints and parts go together whatever the chunks.
#[test]
fn checkpoints_and_parts_go_with_other_chunks() {
    let folder = folder();
    let render = |output: &str, more: &[&str]| {
        let way = ["--integrator", "progressive", "--passes", "4", "--quiet"];
        succeeds(&folder, &small(output, &[&way[..], more].concat()));
    };
    render("whole.exr", &[]);
    let two = ["--integrator", "progressive", "--passes", "2", "--quiet", "--checkpoint", "state", "--chunk", "700"];
    succeeds(&folder, &small("two.exr", &two));
    render("resumed.exr", &["--checkpoint", "state", "--resume", "--chunk", "333"]);
    render("a.caustic", &["--part", "1/2", "--chunk", "999"]);
    render("b.caustic", &["--part", "2/2"]);
    succeeds(&folder, &["merge", "a.caustic", "b.caustic", "-o", "merged.exr"]);
    for name in ["resumed.exr", "merged.exr"] {
        assert!(bytes(&folder, "whole.exr") == bytes(&folder, name), "{name} differs");
    }
}

#[test]
fn what_chunks_cannot_do_is_refused_with_the_flag_and_the_remedy() {
    let folder = folder();
    for (more, words) in [
        (&["--filter", "cone"][..], &["--filter is cone", "constant", "--chunk", "--memory"][..]),
        (&["--surface", "own"], &["--surface is own", "any", "--chunk"]),
        (&["--nearest", "approximate"], &["--nearest is approximate", "exact", "--chunk"]),
        (&["--keep", "visible"], &["--keep is visible", "all", "--chunk"]),
        (&["--compact"], &["--compact is given", "left out", "--chunk"]),
        (&["--radius", "auto"], &["--radius is auto", "metres", "--chunk"]),
        (&["--k", "1024"], &["--k is 1024", "1 to 1023", "--chunk"]),
        (&["--final-gather", "4"], &["--final-gather is 4", "must be 0", "--chunk"]),
        (&["--interpolate", "4"], &["--interpolate is 4", "must be 0", "--chunk"]),
        (&["--integrator", "path"], &["--chunk is 500", "left out", "no photon maps"]),
        (&["--aov", "radius"], &["layer `radius`", "--chunk"]),
        (&["--load-map", "photons.caustic"], &["--load-map", "--chunk"]),
    ] {
        let arguments = ["render", "cornell", "-o", "a.exr", "--device", "cpu", "--chunk", "500"];
        refused(&folder, &[&arguments[..], more].concat(), words);
    }
    for chunk in ["0", "-1", "many"] {
        refused(&folder, &small("a.exr", &["--chunk", chunk]), &["--chunk", "1 to 536870912"]);
    }
    let little = surveyed(&folder, &small("a.exr", &["--memory", "100KB", "--quiet"]));
    assert!(little.code == Some(2) && little.stderr.contains("is too little: give at least"), "{little:?}");
    let own = ["--surface", "own", "--memory", "4MB", "--photons", "100000", "--quiet"];
    let arguments = ["render", "cornell", "-o", "a.exr", "--device", "cpu", "--size", "24x16", "--spp", "2"];
    let own = surveyed(&folder, &[&arguments[..], &own].concat());
    assert!(own.code == Some(2) && own.stderr.contains("--surface is own"), "{own:?}");
}
