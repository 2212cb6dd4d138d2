//! The program as users run it, for tests of the command line.
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
pub fn program() -> PathBuf {
    let test = std::env::current_exe().expect("a test knows where it is");
    let folder = test.parent().and_then(Path::parent).expect("tests are in target/PROFILE/deps");
    let program = folder.join(format!("caustic{}", std::env::consts::EXE_SUFFIX));
    assert!(program.is_file(), "{} is missing: run `cargo build --release` first", program.display());
    program
}

/// The program with arguments, in a folder.
pub fn command(folder: &TempDir, arguments: &[&str]) -> Command {
    let mut command = Command::new(program());
    command.args(arguments).current_dir(folder.path());
    // Mesa's layer that sorts devices looks for a Wayland display and writes to stderr where there is none.
    command.env("NODEVICE_SELECT", "1");
    command
}

/// An empty folder that goes when it is dropped.
pub fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder for a test")
}

/// What a run of the program came to.
#[derive(Debug)]
pub struct Run {
    /// Its exit code.
    pub code: Option<i32>,
    /// What it printed.
    pub stdout: String,
    /// What it told the user.
    pub stderr: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("the program prints UTF-8");
        Self { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}

/// Runs the program.
pub fn run(folder: &TempDir, arguments: &[&str]) -> Run {
    command(folder, arguments).output().expect("the program starts").into()
}

/// Runs the program, which must succeed.
#[track_caller]
pub fn succeeds(folder: &TempDir, arguments: &[&str]) -> Run {
    let run = run(folder, arguments);
    assert_eq!(run.code, Some(0), "{arguments:?}: {}{}", run.stderr, run.stdout);
    run
}

/// Runs the program, which must refuse its input: exit code 2, one line on stderr that has all of `words`, nothing on
/// stdout, and no file that was not there before.
#[track_caller]
pub fn refused(folder: &TempDir, arguments: &[&str], words: &[&str]) {
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
pub fn files(folder: &TempDir) -> Vec<String> {
    let entries = fs::read_dir(folder.path()).expect("the folder can be read");
    let mut names: Vec<_> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A render of a few milliseconds, with more arguments.
pub fn small<'a>(output: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut arguments = vec!["render", "cornell", "-o", output, "--device", "cpu", "--size", "24x16", "--spp", "2"];
    arguments.extend(["--photons", "2000", "--caustic-photons", "1000", "--k", "40", "--radius", "0.2"]);
    arguments.extend(more);
    arguments
}

/// What the program printed as JSON.
pub fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error} in {text}"))
}

/// A picture that the program wrote.
pub fn read(path: &Path) -> Image {
    output::read(path).expect("a picture that can be read")
}

/// The GPU as arguments of the program, or none.
pub fn gpu_arguments() -> Option<Vec<String>> {
    crate::gpu()?;
    let named = std::env::var("CAUSTIC_TEST_GPU").unwrap_or("gpu".to_string());
    Some(vec!["--device".to_string(), named])
}
