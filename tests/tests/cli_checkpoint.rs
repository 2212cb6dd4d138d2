//! Checkpoints as users have them: a render that is killed goes on, and nothing is lost but the pass in flight.

use caustic_tests::program::*;
use std::fs;
use std::time::{Duration, Instant};

/// A progressive render of some milliseconds a pass.
fn arguments<'a>(output: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut all = small(output, &["--integrator", "progressive", "--quiet"]);
    all.extend(more);
    all
}

#[test]
fn a_render_that_is_killed_goes_on_to_the_same_bits() {
    let folder = folder();
    succeeds(&folder, &arguments("whole.exr", &["--passes", "40"]));
    // So many passes that it cannot be done before it is killed.
    let endless = arguments("killed.exr", &["--passes", "1000000", "--checkpoint", "state"]);
    let mut child = command(&folder, &endless).spawn().expect("the program starts");
    let state = folder.path().join("state");
    let begun = Instant::now();
    let passes = || fs::read(&state).ok().map(|bytes| passes_of(&bytes));
    while passes().is_none_or(|passes| passes < 3) {
        assert!(begun.elapsed() < Duration::from_secs(120), "no checkpoint after two minutes");
        std::thread::sleep(Duration::from_millis(5));
    }
    // SIGKILL on Unix: nothing is flushed, nothing is tidied up.
    child.kill().expect("it can be killed");
    child.wait().expect("it ends");
    let kept = passes().expect("a whole file");
    println!("killed after {kept} passes");
    assert!((3..40).contains(&kept), "{kept} passes before it was killed: too many for this test");
    let more = ["--passes", "40", "--checkpoint", "state", "--resume"];
    succeeds(&folder, &arguments("killed.exr", &more));
    let read = |name: &str| fs::read(folder.path().join(name)).expect("a picture");
    assert!(read("whole.exr") == read("killed.exr"), "the pictures differ");
    // And further on, from where it was finished.
    succeeds(&folder, &arguments("more.exr", &["--passes", "41", "--checkpoint", "state", "--resume"]));
    assert!(read("whole.exr") != read("more.exr"));
}

/// The number of passes in a checkpoint: what the nodes in its header add up.
fn passes_of(bytes: &[u8]) -> u32 {
    let line = bytes.iter().position(|&byte| byte == b'\n').expect("a line") + 1;
    let length = u32::from_le_bytes(bytes[line..line + 4].try_into().expect("four bytes")) as usize;
    let header = json(std::str::from_utf8(&bytes[line + 4..line + 4 + length]).expect("a header"));
    let nodes = header["nodes"].as_array().expect("nodes").iter();
    nodes.map(|node| 1 << node[1].as_u64().expect("a level")).sum()
}

#[test]
fn checkpoints_that_cannot_be_used_are_refused() {
    let folder = folder();
    let with = |more: &[&'static str]| {
        let mut all = arguments("a.exr", &["--checkpoint", "state"]);
        all.extend(more.iter().copied());
        all
    };
    refused(&folder, &with(&["--passes", "2", "--resume"]), &["no checkpoint state", "leave out --resume"]);
    refused(&folder, &arguments("a.exr", &["--resume"]), &["--checkpoint"]);
    succeeds(&folder, &with(&["--passes", "2"]));
    refused(&folder, &with(&["--passes", "2"]), &["exists already", "--resume"]);
    refused(&folder, &with(&["--resume", "--seed", "3"]), &["made with seed 0", "this render has 3"]);
    fs::write(folder.path().join("state"), "a shopping list").expect("a file");
    refused(&folder, &with(&["--resume"]), &["state is no checkpoint"]);
}

#[test]
fn flags_of_integrators_are_refused_with_their_ranges() {
    let folder = folder();
    for (flag, value, words) in [
        ("--alpha", "1", &["--alpha", "between 0 and 1"][..]),
        ("--alpha", "0", &["--alpha", "between 0 and 1"]),
        ("--time", "-1", &["--time", "above 0"]),
        ("--error", "nan", &["--error", "above 0"]),
        ("--passes", "0", &["--passes", "1 to"]),
        ("--final-gather", "99999", &["--final-gather", "0 to 4096"]),
        ("--integrator", "magic", &["--integrator", "photon, progressive, path, direct"]),
        ("--filter", "box", &["--filter", "constant, cone, gaussian, epanechnikov"]),
        ("--surface", "all", &["--surface", "any, facing, own"]),
    ] {
        refused(&folder, &["render", "cornell", "-o", "a.png", flag, value], words);
    }
    let path = ["render", "cornell", "-o", "a.png", "--integrator", "path"];
    refused(&folder, &[&path[..], &["--show", "caustic"]].concat(), &["--show is caustic", "beauty"]);
    refused(&folder, &[&path[..], &["--total-photons", "5"]].concat(), &["--total-photons", "--passes"]);
}
