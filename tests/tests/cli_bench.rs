//! `caustic bench`: a benchmark that is also a test.

use caustic_bench::record::{BEGIN, END, Record, into_text, table};
use caustic_tests::program::*;
use std::fs;
use std::path::{Path, PathBuf};

/// A case of a few milliseconds.
const TINY: &str = r#"# A comment that stays.
name = "tiny"
description = "a tiny gather"
kind = "gather"
distribution = "uniform"
sizes = [500, 3000]
queries = 200
k = 10
"#;

const FAST: [&str; 7] = ["bench", "--device", "cpu", "--repeat", "2", "--budget", "0"];

fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    FAST.iter().chain(more).copied().collect()
}

#[test]
fn a_quick_run_measures_checks_and_writes_everything() {
    let folder = folder();
    let more = ["--quick", "--case", "sort-pairs-24", "--json", "a.json", "--csv", "a.csv", "--markdown", "a.md"];
    let run = succeeds(&folder, &[&with(&more)[..], &["--svg", "plots", "--record", "records"]].concat());
    for part in
        ["sort-pairs-24", "64 Ki", "right", "0 of 65536 differ", "M pairs/s", "copy: ", "1 of them with the recorded"]
    {
        assert!(run.stdout.contains(part), "no `{part}` in {}", run.stdout);
    }
    assert_eq!(files(&folder), ["a.csv", "a.json", "a.md", "plots", "records"]);
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).expect("a file");
    let record = json(&read("a.json"));
    let row = &record["rows"][0];
    assert_eq!((&row["case"], &row["n"], &row["counts"]), (&"sort-pairs-24".into(), &65536.into(), &"pairs".into()));
    let measured = &row["measured"];
    assert_eq!((&measured["as_expected"], &measured["differ"]), (&true.into(), &0.into()), "{measured}");
    assert_eq!(measured["bytes"], 48 * 65536, "the model of a sort of three bytes");
    assert!(
        measured["wall_ms"]["median"].as_f64() > Some(0.0) && measured["of_copy"].as_f64() > Some(0.0),
        "{measured}"
    );
    assert!(measured["stages"].as_array().is_some_and(|stages| !stages.is_empty()), "{measured}");
    assert!(record["machine"]["rustc"].as_str().is_some_and(|rustc| rustc.starts_with("rustc ")), "{record}");
    assert!(record["command"].as_str().is_some_and(|line| line.starts_with("caustic bench --device cpu")), "{record}");
    assert!(read("a.csv").lines().count() >= 2 && read("a.md").contains("| sort-pairs-24 | 64 Ki |"));
    assert!(read("plots/sort-pairs-24.svg").contains("</svg>"));
    let records: Vec<_> = fs::read_dir(folder.path().join("records")).expect("a folder").collect();
    assert_eq!(records.len(), 1);
}

#[test]
fn what_is_blessed_is_right_and_a_planted_hash_is_noticed() {
    let folder = folder();
    let path = folder.path().join("cases/tiny.toml");
    fs::create_dir(folder.path().join("cases")).expect("a folder");
    fs::write(&path, TINY).expect("a file");
    let unknown = succeeds(&folder, &with(&["--cases", "cases"])).stdout;
    assert!(unknown.contains("no hash yet") && unknown.contains("0 of 64 differ"), "{unknown}");
    succeeds(&folder, &with(&["--cases", "cases", "--bless"]));
    let blessed = fs::read_to_string(&path).expect("a file");
    assert!(blessed.starts_with(TINY) && blessed.contains("\n[expected]\n500 = \"") && blessed.contains("\n3000 = \""));
    let right = succeeds(&folder, &with(&["--case", "cases/tiny.toml"])).stdout;
    assert!(right.contains("2 of them with the recorded result"), "{right}");

    let planted = "0123456789abcdef".repeat(4);
    let at = blessed.find("3000 = \"").expect("a hash") + 8;
    let hash = &blessed[at..at + 64];
    fs::write(&path, blessed.replace(hash, &planted)).expect("a file");
    let wrong = run(&folder, &with(&["--cases", "cases", "--json", "a.json"]));
    assert_eq!(wrong.code, Some(1), "{wrong:?}");
    let line = wrong.stderr.lines().last().unwrap_or_default();
    for part in ["error: tiny at N = 3000", hash, planted.as_str()] {
        assert!(line.contains(part), "no {part} in {line}");
    }
    assert!(wrong.stdout.contains("WRONG"), "{wrong:?}");
    // What was measured is written all the same.
    let record = json(&fs::read_to_string(folder.path().join("a.json")).expect("a file"));
    assert_eq!(record["rows"][1]["measured"]["as_expected"], false);
}

#[test]
fn what_does_not_fit_is_skipped_with_the_reason() {
    let folder = folder();
    fs::write(folder.path().join("tiny.toml"), TINY).expect("a file");
    let bounded = succeeds(&folder, &with(&["--case", "tiny.toml", "--max-n", "1000"])).stdout;
    assert!(bounded.contains("skipped: N is above --max-n 1000") && bounded.contains("1 rows"), "{bounded}");
}

#[test]
fn bad_cases_and_flags_are_refused() {
    let folder = folder();
    let case = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    case("k.toml", &TINY.replace("k = 10", "k = 5000"));
    case("field.toml", &TINY.replace("queries", "querys"));
    case("large.toml", &TINY.replace("3000", "3000000000"));
    case("broken.toml", &TINY.replace("[500, 3000]", "[500, 3000"));
    case("tiny.toml", TINY);
    fs::write(folder.path().join("record.json"), "{}").expect("a file");
    for (arguments, words) in [
        (&["--case", "k.toml"][..], &["k.toml:8:1", "`k`", "5000", "1 to 1024"][..]),
        (&["--case", "field.toml"], &["field.toml:7:1", "unknown field `querys`", "docs/benchmarks/README.md"]),
        (&["--case", "large.toml"], &["large.toml:6:1", "`sizes`", "3000000000", "1 to 268435456"]),
        (&["--case", "broken.toml"], &["broken.toml:"]),
        (&["--case", "none.toml"], &["none.toml", "cannot read", "built-in"]),
        (&["--case", "no-such-case"], &["no-such-case", "sort-pairs-24", ".toml"]),
        (&["--cases", "."], &["broken.toml"]),
        (&["--cases", "none"], &["cannot read", "none"]),
        (&["--filter", "zebra"], &["--filter", "zebra", "gather-U-k50"]),
        (&["--max-n", "0"], &["--max-n", "1 to 268435456"]),
        (&["--repeat", "0"], &["--repeat", "1 to 10000"]),
        (&["--budget", "never"], &["--budget", "seconds"]),
        (&["--case", "tiny.toml", "--json", "none/a.json"], &["--json", "none/a.json", "folder"]),
        (&["--case", "tiny.toml", "--svg", "tiny.toml"], &["--svg", "tiny.toml"]),
        (&["--case", "sort-pairs-24", "--bless"], &["--bless", "built in", "--cases"]),
        (&["--device", "gpu:nonexistent", "--case", "tiny.toml"], &["nonexistent"]),
        (&["--table", "record.json"], &["record.json", "no record", "--record"]),
        (&["--table", "none.json"], &["none.json", "cannot read"]),
        (&["--into", "tiny.toml"], &["--table"]),
    ] {
        refused(&folder, &[&["bench"], arguments].concat(), words);
    }
}

#[test]
fn the_list_names_every_case() {
    let text = succeeds(&folder(), &["bench", "--list"]).stdout;
    for (name, _) in caustic_bench::case::BUILT_IN {
        assert!(text.lines().any(|line| line.starts_with(&format!("{name} "))), "no {name} in {text}");
    }
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The records that are kept, in the order of their names.
fn records() -> Vec<PathBuf> {
    let entries = fs::read_dir(repository().join("docs/benchmarks")).expect("the folder of records");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let mut paths: Vec<_> = paths.filter(|path| path.extension().is_some_and(|ending| ending == "json")).collect();
    paths.sort();
    paths
}

#[test]
fn the_readme_has_the_table_of_the_records_that_are_kept() {
    let read: Result<Vec<_>, _> = records().iter().map(|path| Record::read(path)).collect();
    let read = read.expect("records");
    assert!(!read.is_empty(), "docs/benchmarks has records");
    let wrong = read.iter().flat_map(|record| &record.rows).filter_map(|row| row.measured());
    assert!(wrong.clone().count() > 0 && wrong.clone().all(|m| m.differ == 0 && m.as_expected != Some(false)));
    let readme = fs::read_to_string(repository().join("README.md")).expect("the README");
    let expected = into_text("README.md", &readme, &table(&read)).expect("a README with markers");
    let remedy = "run: caustic bench --table docs/benchmarks/*.json --into README.md";
    assert!(readme == expected, "the README's table is not the one of the records; {remedy}");
}

#[test]
fn the_table_goes_to_the_terminal_or_between_the_markers() {
    let folder = folder();
    let paths = records();
    let paths: Vec<&str> = paths.iter().map(|path| path.to_str().expect("a path of UTF-8")).collect();
    let printed = succeeds(&folder, &[&["bench", "--table"][..], &paths].concat()).stdout;
    assert!(printed.contains("| case | N |"), "{printed}");
    let file = folder.path().join("a.md");
    fs::write(&file, format!("before\n{BEGIN}\nold\n{END}\nafter\n")).expect("a file");
    succeeds(&folder, &[&["bench", "--into", "a.md", "--table"][..], &paths].concat());
    let text = fs::read_to_string(&file).expect("a file");
    assert_eq!(text, format!("before\n{BEGIN}\n\n{}\n\n{END}\nafter\n", printed.trim_end()));
    fs::write(&file, "no markers\n").expect("a file");
    refused(&folder, &[&["bench", "--into", "a.md", "--table"][..], &paths].concat(), &["a.md", BEGIN, END]);
    assert_eq!(fs::read_to_string(&file).expect("a file"), "no markers\n");
}

/// Ctrl-C.
#[cfg(unix)]
#[test]
fn an_interrupt_keeps_the_rows_that_are_finished() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};
    let folder = folder();
    // A first row that is soon done, and a second that takes a minute.
    let long = TINY.replace("[500, 3000]", "[500, 60000]").replace("queries = 200", "queries = 60000");
    fs::write(folder.path().join("long.toml"), long).expect("a file");
    let arguments = ["bench", "--device", "cpu", "--case", "long.toml", "--repeat", "1000", "--budget", "3600"];
    let mut child = command(&folder, &[&arguments[..], &["--json", "a.json"]].concat())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut lines = std::io::BufRead::lines(std::io::BufReader::new(child.stdout.take().expect("a pipe")));
    let first = lines.by_ref().map(|line| line.expect("text")).find(|line| line.starts_with("tiny "));
    assert!(first.is_some_and(|line| line.contains(" 500 ")), "a row");
    let kill = Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status();
    assert!(kill.expect("a shell").success(), "the program had ended before");
    let start = Instant::now();
    // Emptied, so that the program is not held up.
    let rest: Vec<_> = lines.map_while(Result::ok).collect();
    let output = child.wait_with_output().expect("an end");
    assert!(start.elapsed() < Duration::from_secs(60), "it stopped after {:?}", start.elapsed());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{stderr} {rest:?}");
    let last = stderr.lines().last().unwrap_or_default();
    assert!(last.starts_with("error: interrupted") && last.contains("rows were finished and written"), "{stderr}");
    let record = json(&fs::read_to_string(folder.path().join("a.json")).expect("a file"));
    assert_eq!(record["complete"], false);
    assert_eq!(record["rows"][0]["n"], 500);
}
