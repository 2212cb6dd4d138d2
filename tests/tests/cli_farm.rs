//! Parts of a render as users have them: computed in any order, merged into the bytes of one process; and whatever can be wrong with them.

use caustic_kernels::num::pcg4d;
use caustic_tests::program::*;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const PROGRESSIVE: [&str; 7] = ["--integrator", "progressive", "--passes", "21", "--aov", "all", "--quiet"];

/// Renders the parts of a picture in an order that is not theirs, with more arguments.
fn parts(folder: &TempDir, of: u32, more: &[&str]) -> Vec<String> {
    let mut numbers: Vec<u32> = (1..=of).collect();
    numbers.sort_by_key(|&i| pcg4d([i, of, 5, 0])[0]);
    let name = |number: u32| format!("part{number}of{of}.caustic");
    for &number in &numbers {
        let part = format!("{number}/{of}");
        succeeds(folder, &small(&name(number), &[more, &["--part", &part]].concat()));
    }
    numbers.into_iter().map(name).collect()
}

fn merge<'a>(parts: &'a [String], output: &'a str) -> Vec<&'a str> {
    [&["merge"][..], &parts.iter().map(String::as_str).collect::<Vec<_>>(), &["-o", output]].concat()
}

fn assert_same_files(folder: &TempDir, a: &str, b: &str) {
    let read = |name: &str| fs::read(folder.path().join(name)).expect("a picture");
    assert!(read(a) == read(b), "{a} and {b} differ");
}

#[test]
fn eight_parts_in_any_order_are_the_picture_of_one_process() {
    let folder = folder();
    succeeds(&folder, &small("one.exr", &PROGRESSIVE));
    for of in [8, 1] {
        let parts = parts(&folder, of, &PROGRESSIVE);
        let run = succeeds(&folder, &merge(&parts, "merged.exr"));
        assert!(run.stderr.contains(&format!("parts: {of}, passes: 21, photons emitted: 63000")), "{run:?}");
        assert_same_files(&folder, "one.exr", "merged.exr");
        fs::remove_file(folder.path().join("merged.exr")).expect("it was there");
    }
    // Another format, with a tone curve.
    let flags = ["--tone-map", "agx", "--exposure", "1"];
    let plain = [&PROGRESSIVE[..4], &["--quiet"], &flags].concat();
    succeeds(&folder, &small("one.png", &plain));
    let parts = parts(&folder, 8, &[&PROGRESSIVE[..4], &["--quiet"]].concat());
    succeeds(&folder, &[&merge(&parts, "merged.png")[..], &flags].concat());
    assert_same_files(&folder, "one.png", "merged.png");
}

#[test]
fn parts_of_parts_are_the_picture_of_one_process() {
    let folder = folder();
    succeeds(&folder, &small("one.exr", &PROGRESSIVE));
    let parts = parts(&folder, 7, &PROGRESSIVE);
    let of = |parts: &[String], output: &str| {
        let run = succeeds(&folder, &merge(parts, output));
        assert!(run.stderr.contains("is a part itself"), "{run:?}");
        output.to_string()
    };
    // A tree of three levels over parts that are in no order.
    let (a, b) = (of(&parts[..2], "a.caustic"), of(&parts[2..5], "b.caustic"));
    let ab = of(&[b.clone(), a.clone()], "ab.caustic");
    assert_same_files(&folder, "ab.caustic", &of(&parts[..5], "five.caustic"));
    let all = [parts[6].clone(), ab.clone(), parts[5].clone()];
    succeeds(&folder, &merge(&all, "merged.exr"));
    assert_same_files(&folder, "one.exr", "merged.exr");
    // What a part was merged of counts: twice is refused, and what is missing is named.
    refused(&folder, &merge(&[ab.clone(), parts[0].clone()], "a.exr"), &["holds already", "give each part once"]);
    let missing: Vec<u32> = (1..=7).filter(|n| parts[5..].contains(&format!("part{n}of7.caustic"))).collect();
    let named = format!("parts {}/7, {}/7 are not among the files", missing[0], missing[1]);
    refused(&folder, &merge(std::slice::from_ref(&ab), "a.exr"), &["missing", &named]);
    refused(&folder, &[&merge(&all, "all.caustic")[..], &["--aov", "normal"]].concat(), &["all.caustic", "--aov"]);
}

#[test]
fn one_pass_is_split_into_tiles() {
    let folder = folder();
    succeeds(&folder, &small("one.exr", &["--quiet"]));
    let parts = parts(&folder, 5, &["--quiet"]);
    succeeds(&folder, &merge(&parts, "merged.exr"));
    assert_same_files(&folder, "one.exr", "merged.exr");
    refused(
        &folder,
        &merge(&parts[..4], "less.exr"),
        &["pixels ", " of pass 0", "missing", "is not among the files; render it"],
    );
}

#[test]
fn a_part_that_is_killed_goes_on() {
    let folder = folder();
    let part = |passes: &'static str, more: &[&'static str]| {
        let all =
            ["--integrator", "progressive", "--passes", passes, "--part", "2/2", "--quiet", "--checkpoint", "state"];
        small("b.caustic", &[&all[..], more].concat())
    };
    succeeds(&folder, &small("one.exr", &["--integrator", "progressive", "--passes", "30", "--quiet"]));
    // Half of twenty passes are some of the half of thirty, and others, which are kept for nothing.
    succeeds(&folder, &part("20", &[]));
    fs::remove_file(folder.path().join("b.caustic")).expect("it was there");
    refused(&folder, &part("30", &[]), &["exists already", "--resume"]);
    let mut killed = command(&folder, &part("1000000", &["--resume"])).spawn().expect("it starts");
    std::thread::sleep(std::time::Duration::from_millis(200));
    killed.kill().expect("it can be killed");
    killed.wait().expect("it ends");
    assert!(!files(&folder).contains(&"b.caustic".to_string()), "a part is written whole or not at all");
    // What it had of passes that this part has not is in it too, so that it cannot be merged with the other half: a new file can.
    fs::remove_file(folder.path().join("state")).expect("it was there");
    succeeds(&folder, &part("30", &[]));
    let first = ["--integrator", "progressive", "--passes", "30", "--part", "1/2", "--quiet"];
    succeeds(&folder, &small("a.caustic", &first));
    succeeds(&folder, &["merge", "b.caustic", "a.caustic", "-o", "two.exr"]);
    assert_same_files(&folder, "one.exr", "two.exr");
}

/// Changes a file and says what it was.
fn change(folder: &TempDir, name: &str, change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let path = folder.path().join(Path::new(name));
    let bytes = fs::read(&path).expect("a part");
    let mut changed = bytes.clone();
    change(&mut changed);
    fs::write(&path, &changed).expect("a part");
    bytes
}

#[test]
fn parts_that_cannot_be_merged_are_refused_and_say_why() {
    let folder = folder();
    let arguments = ["--integrator", "progressive", "--passes", "7", "--quiet"];
    let mut parts = parts(&folder, 3, &arguments);
    parts.sort();
    let refuse = |parts: &[String], words: &[&str]| refused(&folder, &merge(parts, "a.exr"), words);
    refuse(&parts[..2], &["passes 4 to 6 are missing: part 3/3 is not among the files"]);
    refuse(&parts[1..2], &["passes 0 to 1, passes 4 to 6 are missing: parts 1/3, 3/3"]);
    let twice = [&parts[..], &parts[1..2]].concat();
    refuse(&twice, &["part2of3.caustic (part 2/3) holds what another", "pass 2", "each part once"]);
    refuse(&["nothing.caustic".to_string()][..0], &["required"]);

    // Bits that were flipped, files that were cut off, files of others.
    for at in [30, 300, 3000] {
        let whole = change(&folder, &parts[1], |bytes| {
            let length = bytes.len();
            bytes[at % length] ^= 16;
        });
        refuse(&parts, &["part2of3.caustic", "damaged"]);
        fs::write(folder.path().join(&parts[1]), whole).expect("a part");
    }
    let whole = change(&folder, &parts[1], |bytes| bytes.truncate(bytes.len() / 2));
    refuse(&parts, &["part2of3.caustic", "damaged"]);
    fs::write(folder.path().join(&parts[1]), "a shopping list").expect("a part");
    refuse(&parts, &["part2of3.caustic is no part"]);
    fs::write(folder.path().join(&parts[1]), whole).expect("a part");
    succeeds(&folder, &small("c.exr", &[&arguments[..], &["--checkpoint", "state.caustic"]].concat()));
    refuse(&[parts[0].clone(), "state.caustic".to_string()], &["state.caustic is no part"]);

    // Parts of other pictures.
    for (more, words) in [
        (["--seed", "7"], ["made with seed 7", "with 0"]),
        (["--passes", "8"], ["made with passes 8", "with 7"]),
        (["--photons", "2001"], ["made with photons 2001", "with 2000"]),
        (["--radius", "0.21"], ["made with radius 0.21", "with 0.2"]),
        (["--size", "24x17"], ["made with", "merge parts of one picture"]),
    ] {
        let one_pass = [&arguments[..2], &["--quiet", "--part", "3/3"]].concat();
        let passes: &[&str] = if more[0] == "--passes" { &[] } else { &["--passes", "7"] };
        // A flag that is given twice is refused, so that the last one of `small` is replaced.
        let mut line: Vec<&str> = small("other.caustic", &[]).into_iter().collect();
        if let Some(at) = line.iter().position(|word| *word == more[0]) {
            line.drain(at..at + 2);
        }
        line.extend(one_pass.iter().chain(passes).chain(&more));
        succeeds(&folder, &line);
        let other = [&parts[..2], &["other.caustic".to_string()]].concat();
        refuse(&other, &[&["other.caustic"], &words[..]].concat());
    }
    succeeds(&folder, &merge(&parts, "a.exr"));
}

#[test]
fn parts_are_refused_where_they_cannot_be() {
    let folder = folder();
    let render = |more: &[&'static str]| [&["render", "cornell", "-o", "a.caustic"][..], more].concat();
    refused(&folder, &render(&["--part", "0/8"]), &["--part", "I/N"]);
    refused(&folder, &render(&["--part", "9/8"]), &["--part", "I/N"]);
    refused(&folder, &render(&["--part", "1/2", "--time", "3"]), &["--part", "--passes"]);
    refused(&folder, &render(&["--part", "1/2", "--tone-map", "agx"]), &["--part", "--tone-map"]);
    refused(&folder, &["render", "cornell", "-o", "a.png", "--part", "1/2"], &["a.png", ".caustic", "caustic merge"]);
    refused(&folder, &["render", "cornell", "-o", "a.caustic"], &[".png, .exr or .hdr"]);
    refused(&folder, &["render", "cornell", "-o", "a.png", "--device", "gpu:0,tpu"], &["--device", "gpu:all"]);
    refused(&folder, &["merge", "none.caustic", "-o", "a.gif"], &[".png, .exr or .hdr"]);
}
