//! Any words on the command line.

use super::*;
use clap::CommandFactory;

const WORDS: [&str; 76] = [
    "render",
    "compare",
    "--metric",
    "flip",
    "yee,rmse",
    "--threshold",
    "yee=0",
    "--diff",
    "map",
    "info",
    "scene",
    "list",
    "verify",
    "bench",
    "--case",
    "--quick",
    "--list",
    "--table",
    "--into",
    "--budget",
    "cornell",
    "furnace",
    "no_such_scene",
    "-o",
    "--output",
    "a.png",
    "a.exr",
    "--size",
    "640x480",
    "0x0",
    "1x",
    "x",
    "99999999x9",
    "-1x-1",
    "--photons",
    "--caustic-photons",
    "--k",
    "--radius",
    "--hash",
    "linear",
    "teschner",
    "morton",
    "--gather",
    "heap",
    "list",
    "histogram",
    "auto",
    "--precision",
    "exact",
    "fast",
    "--spp",
    "--seed",
    "--show",
    "beauty",
    "map-caustic",
    "--device",
    "cpu",
    "gpu",
    "gpu:",
    "gpu:0",
    "--json",
    "--quiet",
    "--queries",
    "--repeat",
    "--gpu-from",
    "0",
    "-1",
    "1",
    "4294967296",
    "1e400",
    "nan",
    "-inf",
    "--",
    "",
    "\u{1b}[31m",
    "ü=",
];

#[test]
fn the_command_line_is_well_formed() {
    Arguments::command().debug_assert();
}

/// Any words give arguments or one sentence. `CAUSTIC_FUZZ` sets how many are tried.
#[test]
fn any_command_line_is_arguments_or_a_sentence() {
    let count = std::env::var("CAUSTIC_FUZZ").ok().map_or(5000, |count| count.parse().expect("a number"));
    let (mut good, mut bad) = (0, 0);
    for seed in 0..count {
        let random = |step: u32| caustic_kernels::num::pcg4d([seed, step, 0xc11, 0])[0] as usize;
        let mut words = vec!["caustic"];
        // A command and its scene first, more often than chance would have it.
        if random(0) % 4 > 0 {
            words.push(["render", "map", "compare", "verify", "bench"][random(1) % 5]);
        }
        if random(2) % 4 > 0 {
            words.extend([["cornell", "-o", "a.png"].as_slice(), &["--seed", "7"], &["--json"]][random(3) % 3]);
        }
        for step in 0..random(4) as u32 % 6 {
            words.push(WORDS[random(5 + step) % WORDS.len()]);
        }
        match Arguments::try_parse_from(&words) {
            Ok(_) => good += 1,
            Err(error) => {
                bad += 1;
                let sentence = crate::first_sentence(&error);
                assert!(!sentence.trim().is_empty() && !sentence.contains('\n'), "{words:?}: {sentence:?}");
            }
        }
    }
    assert!(good > count / 100 && bad > count / 10, "{good} good, {bad} bad");
}
