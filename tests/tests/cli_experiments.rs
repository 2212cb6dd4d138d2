//! `caustic experiments`: results that are kept, a report made of them, and claims judged by them.

use caustic_tests::program::*;
use std::fs;

const FAST: [&str; 7] = ["experiments", "--device", "cpu", "--quick", "--only", "fig24,fig30", "-o"];

fn read(folder: &tempfile::TempDir, name: &str) -> String {
    fs::read_to_string(folder.path().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn figures_are_measured_once_and_judged_by_what_was_measured() {
    let folder = folder();
    let first = succeeds(&folder, &[&FAST[..], &["out"]].concat());
    assert!(
        first.stdout.contains("claims of the thesis: ") && first.stdout.contains("wrote out/report.html"),
        "{first:?}"
    );
    let page = read(&folder, "out/report.html");
    for part in ["id=\"fig24\"", "id=\"fig30\"", "<svg", "data:image/png;base64,", "Memory over query radius", "holds"]
    {
        assert!(page.contains(part), "no {part}");
    }
    assert!(!page.contains("id=\"fig16\""), "a figure that was not asked for");
    // Nothing comes from elsewhere.
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http") && !page.contains("url("));
    // All techniques make one picture.
    let pictures: Vec<_> =
        fs::read_dir(folder.path().join("out/pictures")).unwrap().map(|file| file.unwrap().path()).collect();
    assert!(pictures.len() > 3, "{pictures:?}");
    for photons in ["-10000-", "-50000-"] {
        let of_so_many = |path: &&std::path::PathBuf| path.to_string_lossy().contains(photons);
        let bytes: Vec<_> = pictures.iter().filter(of_so_many).map(|path| output(path)).collect();
        assert!(bytes.len() > 3 && bytes.iter().all(|picture| *picture == bytes[0]), "pictures of {photons} differ");
    }

    // What is there is not measured again.
    let results = read(&folder, "out/results.jsonl");
    succeeds(&folder, &[&FAST[..], &["out"]].concat());
    assert_eq!(read(&folder, "out/results.jsonl"), results);
    // What is missing is: a run that was cut off in the middle of a line goes on.
    let cut = results.len() - 40;
    fs::write(folder.path().join("out/results.jsonl"), &results[..cut]).unwrap();
    succeeds(&folder, &[&FAST[..], &["out"]].concat());
    assert_eq!(read(&folder, "out/results.jsonl").lines().count(), results.lines().count());
    // Parts are the same experiments: only times differ.
    for (part, into) in [("1/2", "a"), ("2/2", "b")] {
        succeeds(&folder, &[&FAST[..], &[into, "--part", part]].concat());
    }
    let missing = ["experiments", "--only", "fig24,fig30", "-o", "all", "--merge", "b"];
    refused(&folder, &missing, &["cases are missing", "part 1/2"]);
    succeeds(&folder, &["experiments", "--only", "fig24,fig30", "-o", "all", "--merge", "b", "a"]);
    let found = |name: &str| -> Vec<_> {
        read(&folder, name)
            .lines()
            .skip(1)
            .map(json)
            .map(|line| (line["case"].clone(), line["found"].clone()))
            .collect()
    };
    assert_eq!(found("all/results.jsonl"), found("out/results.jsonl"));
    assert_eq!(fs::read_dir(folder.path().join("all/pictures")).unwrap().count(), pictures.len());

    // Other numbers, another verdict.
    let claims = read(&folder, "out/claims.md");
    let line = |text: &str| text.lines().find(|line| line.contains("more than 4 times")).unwrap().to_string();
    assert!(!line(&claims).contains("1000.0 times"), "{claims}");
    let planted: String = read(&folder, "out/results.jsonl")
        .lines()
        .map(|line| {
            let is_smallest = line.contains("\"linear\"")
                && line.contains("\"photons\":10000,")
                && line.contains("\"radius_mm\":37,");
            let line = if is_smallest { with_memory(line, 1e12) } else { line.to_string() };
            line + "\n"
        })
        .collect();
    fs::write(folder.path().join("out/results.jsonl"), planted).unwrap();
    succeeds(&folder, &["experiments", "--report-only", "--only", "fig24", "-o", "out"]);
    let judged = line(&read(&folder, "out/claims.md"));
    assert!(judged.contains("**holds**") && judged != line(&claims), "{judged}");
}

/// A picture's floats.
fn output(path: &std::path::Path) -> Vec<[f32; 3]> {
    caustic_renderer::output::read(path).unwrap().rgb
}

/// A line of results with another memory.
fn with_memory(line: &str, bytes: f64) -> String {
    let mut value = json(line);
    value["outcome"]["values"]["memory_bytes"] = bytes.into();
    value.to_string()
}

#[test]
fn what_cannot_be_is_refused_in_one_line() {
    let folder = folder();
    refused(&folder, &["experiments", "--only", "fig99"], &["--only", "fig99", "fig16", "table3"]);
    refused(&folder, &["experiments", "--report-only", "-o", "nowhere"], &["nowhere", "no results"]);
    refused(&folder, &["experiments", "--patience", "-1", "--device", "cpu"], &["--patience", "-1"]);
    fs::write(folder.path().join("file"), "").unwrap();
    refused(&folder, &["experiments", "--device", "cpu", "-o", "file"], &["-o file", "folder"]);
    fs::create_dir(folder.path().join("bad")).unwrap();
    fs::write(folder.path().join("bad/results.jsonl"), "rubbish\n").unwrap();
    refused(&folder, &["experiments", "--device", "cpu", "-o", "bad"], &["line 1", "bad/results.jsonl", "delete"]);
    let listed = succeeds(&folder, &["experiments", "--list"]).stdout;
    assert!(listed.lines().count() > 15 && listed.contains("fig12") && listed.contains("table3"), "{listed}");
}
