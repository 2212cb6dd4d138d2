//! `caustic plan`, budgets and `caustic tradeoff`.

use caustic_tests::program::*;
use std::fs;

/// The program with surveys kept in the test's folder.
fn plan(folder: &tempfile::TempDir, arguments: &[&str]) -> Run {
    let mut command = command(folder, arguments);
    command.env("XDG_CACHE_HOME", folder.path().join("cache"));
    Run::from(command.output().expect("the program runs"))
}

#[test]
fn a_plan_explains_each_decision_and_foresees_what_it_takes() {
    let folder = folder();
    // A pass so short that it is rehearsed on a busy machine as well.
    let few = ["--photons", "5000", "--caustic-photons", "2000", "--spp", "2"];
    let arguments = [&["plan", "cornell", "--device", "cpu", "--size", "32x32"][..], &few].concat();
    let shown = plan(&folder, &arguments);
    assert_eq!(shown.code, Some(0), "{shown:?}");
    for part in [
        "caustic map      yes",
        "textures         no",
        "tree             list",
        "asked for",
        "foreseen: ",
        "MiB at the most",
    ] {
        assert!(shown.stdout.contains(part), "no {part} in {}", shown.stdout);
    }
    // Survey and rehearsal are kept: the second plan is the first, to the last digit of its times.
    assert_eq!(fs::read_dir(folder.path().join("cache/caustic/surveys")).unwrap().count(), 2);
    assert_eq!(plan(&folder, &arguments).stdout, shown.stdout);
    let value = json(&plan(&folder, &[&arguments[..], &["--json", "--quiet"]].concat()).stdout);
    assert_eq!(value["settings"]["photons"], 5000);
    assert!(value["prediction"]["seconds"].as_f64().unwrap() > 0.0 && value["decisions"].as_array().unwrap().len() > 8);
}

#[test]
fn a_budget_chooses_what_is_not_given_and_the_same_everywhere() {
    let folder = folder();
    let arguments =
        ["render", "cornell", "-o", "a.exr", "--size", "32x24", "--quality", "draft", "--costs", "built-in"];
    let run = |more: &[&str]| plan(&folder, &[&arguments[..], &["--device", "cpu"], more].concat());
    let chosen = run(&[]);
    assert!(chosen.code == Some(0) && chosen.stderr.contains("plan: --photons "), "{chosen:?}");
    assert!(chosen.stderr.contains("foreseen for ") && chosen.stderr.contains("quality: "), "{chosen:?}");
    let value = json(&run(&["--json", "--quiet", "--k", "17", "--strict"]).stdout);
    assert_eq!((&value["settings"]["k"], &value["plan"]["within_budget"]), (&"17".into(), &true.into()));
    let actual = value["peak_bytes"].as_f64().unwrap();
    let ratio = value["plan"]["prediction"]["bytes"].as_f64().unwrap() / actual;
    assert!((0.5..2.0).contains(&ratio), "{ratio} of {actual} bytes");
    let forced = run(&["--explain", "--force", "tree,gloss,lamps"]);
    assert!(
        forced.stderr.contains("tree             yes, forced") && forced.stderr.contains("chosen for the budget"),
        "{forced:?}"
    );
    for (wrong, part) in [
        (["--memory", "512"], "512MB or 2GiB"),
        (["--force", "wings"], "caustic-map"),
        (["--error", "0.1"], "cannot be used with"),
    ] {
        let refused = run(&wrong);
        assert!(refused.code == Some(2) && refused.stderr.contains(part), "{refused:?}");
    }
}

/// A radius that f32 cannot measure is refused with the remedy; one that is coarse is warned of.
#[test]
fn a_plan_refuses_what_f32_cannot_hold() {
    let folder = folder();
    for (radius, code) in [("3e-7", 2), ("2e-6", 0), ("0.05", 0)] {
        let shown = plan(
            &folder,
            &[
                "plan",
                "cornell",
                "--device",
                "cpu",
                "--size",
                "8x8",
                "--photons",
                "1000",
                "--spp",
                "1",
                "--radius",
                radius,
            ],
        );
        assert_eq!(shown.code, Some(code), "{shown:?}");
        let warned = shown.stdout.contains("steps of f32") && shown.stdout.contains("use --radius");
        assert_eq!(warned, radius != "0.05", "{shown:?}");
    }
}

#[test]
fn a_sweep_is_measured_once_and_tells_what_is_worth_having() {
    let folder = folder();
    // A scene without maps has few knobs.
    let sweep = ["tradeoff", "plane", "--quick", "--device", "cpu", "-o", "out"];
    succeeds(&folder, &sweep);
    let read = |name: &str| fs::read_to_string(folder.path().join("out").join(name)).unwrap();
    let (results, page) = (read("results.jsonl"), read("report.html"));
    for part in ["<svg", "knee", "worth having (Pareto)", "caustic render plane -o point.exr --device cpu", "paths"] {
        assert!(page.contains(part), "no {part}");
    }
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http"), "something comes from elsewhere");
    let points = json(&read("points.json"));
    let points = points["points"].as_array().unwrap();
    assert!(points.len() > 4 && read("points.csv").lines().count() == points.len() + 1);
    let worth = points.iter().filter(|point| point["worth_its_time"] == true);
    assert!(worth.count() > 1 && points.iter().filter(|point| point["knee"] == true).count() <= 1);
    // More paths are less wrong.
    let error = |i: usize| points[i]["numbers"]["relmse"].as_f64().unwrap();
    let paths: Vec<_> = (0..points.len()).filter(|&i| points[i]["knob"] == "paths").collect();
    assert!(error(paths[1]) < error(paths[0]));
    // What is there is not measured again, and what is cut off is.
    succeeds(&folder, &sweep);
    assert_eq!(read("results.jsonl"), results);
    fs::write(folder.path().join("out/results.jsonl"), &results[..results.len() - 20]).unwrap();
    succeeds(&folder, &sweep);
    assert_eq!(read("results.jsonl").lines().count(), results.lines().count());
    // Parts, measured anywhere, are the same sweep: only times differ.
    let part = |part: &str, into: &str| {
        let more = ["--part", part, "-o", into, "--reference", "out/reference.exr"];
        succeeds(&folder, &[&sweep[..5], &more].concat());
    };
    part("2/2", "b");
    refused(&folder, &["tradeoff", "plane", "--merge", "b", "-o", "all"], &["cases are missing", "part 1/2"]);
    part("1/2", "a");
    refused(&folder, &["tradeoff", "plane", "--merge", "a", "b", "a", "-o", "all"], &["each part once"]);
    refused(&folder, &[&sweep[..5], &["-o", "a"]].concat(), &["part 1/2", "another folder"]);
    succeeds(&folder, &["tradeoff", "plane", "--device", "cpu", "--merge", "b", "a", "-o", "all"]);
    let errors = |name: &str| -> Vec<_> {
        let sweep = json(&fs::read_to_string(folder.path().join(name)).unwrap());
        let of_point = |point: &serde_json::Value| (point["command"].clone(), point["numbers"]["relmse"].clone());
        sweep["points"].as_array().unwrap().iter().map(of_point).collect()
    };
    assert_eq!(errors("all/points.json"), errors("out/points.json"));
    // The command of a point renders it.
    let command = points[0]["command"].as_str().unwrap().to_string();
    let words: Vec<_> = command.split(' ').skip(1).collect();
    succeeds(&folder, &words);
    refused(
        &folder,
        &["tradeoff", "plane", "--quick", "--device", "cpu", "-o", "b", "--reference", "point.png"],
        &["point.png"],
    );
    refused(&folder, &["tradeoff", "plane", "--report-only", "-o", "nowhere"], &["nowhere", "no results"]);
}
