//! Case files: good, bad, and those that come with the program.

use super::*;

const GOOD: &str = r#"name = "mine"
description = "what it is"
kind = "gather"
distribution = "uniform"
sizes = [1000, 2000]
queries = 500
k = 10

[[targets]]
device = "h100"
n = 1000
ms = 2.5

[expected]
1000 = "0000000000000000000000000000000000000000000000000000000000000000"
"#;

#[test]
fn a_case_is_what_its_file_says() {
    let case = parse("mine.toml", GOOD).unwrap();
    assert_eq!((case.name.as_str(), &case.sizes[..]), ("mine", &[1000, 2000][..]));
    let map = Map { distribution: Distribution::Uniform, k: 10, radius: None, hash: Hash::Linear };
    let output = Output::Estimate;
    assert_eq!(case.kind, Kind::Gather { map, queries: 500, output, gather: Gather::Auto });
    assert_eq!((case.kind.queries(100), case.kind.queries(1000)), (Some(100), Some(500)));
    assert_eq!((case.targets[0].ms, case.targets[0].counts.as_str()), (Some(2.5), "all"));
    assert_eq!(case.expected.len(), 1);
}

#[test]
fn bad_cases_are_refused_with_place_field_and_remedy() {
    let hash = "0000000000000000000000000000000000000000000000000000000000000000";
    for (from, to, parts) in [
        ("k = 10", "k = 2000", &["mine.toml:7:1", "`k`", "2000", "1 to 1024"][..]),
        ("k = 10", "k = 0", &["`k`", "1 to 1024"]),
        ("k = 10", "k = \"ten\"", &["mine.toml:7:5", "whole number"]),
        ("k = 10\n", "", &["mine.toml:1:1", "`k` is missing", "gather"]),
        ("k = 10", "kk = 10", &["mine.toml:7:1", "unknown field `kk`"]),
        ("k = 10", "k = 10\nbits = 24", &["mine.toml:8:1", "`bits`", "not used", "gather", "remove"]),
        ("[1000, 2000]", "[1000, 999999999999]", &["mine.toml:5:1", "`sizes`", "999999999999", "268435456"]),
        ("[1000, 2000]", "[2000, 1000]", &["`sizes`", "ascend"]),
        ("[1000, 2000]", "[]", &["`sizes`", "empty"]),
        ("kind = \"gather\"", "kind = \"dance\"", &["mine.toml:3:8", "dance", "`sort`"]),
        ("\"uniform\"", "\"even\"", &["mine.toml:4:", "even", "`uniform`"]),
        ("\"mine\"", "\"a/b\"", &["mine.toml:1:1", "`name`"]),
        ("queries = 500", "queries = 500\nradius = -1.0", &["`radius`", "1e-9"]),
        ("n = 1000", "n = 3", &["`targets`", "N = 3", "sizes"]),
        ("ms = 2.5", "ms = -1", &["`targets`", "positive"]),
        ("ms = 2.5\n", "", &["`targets`", "faster_than"]),
        ("1000 = \"0", "7 = \"0", &["mine.toml:15:1", "`7`", "sizes"]),
        (hash, "abc", &["`1000`", "64 digits", "--bless"]),
        ("name = ", "name ", &["mine.toml:1:", "docs/benchmarks/README.md"]),
    ] {
        assert!(GOOD.contains(from), "{from}");
        let message = parse("mine.toml", &GOOD.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(!message.contains('\n'), "{message}");
        for part in parts {
            assert!(message.contains(part), "{to}: no `{part}` in: {message}");
        }
    }
}

#[test]
fn unknown_scenes_and_cases_are_refused_with_those_there_are() {
    let frame =
        "name = \"f\"\ndescription = \"d\"\nkind = \"frame\"\nsizes = [1]\nsize = [8, 8]\nk = 5\nscene = \"box\"\n";
    let message = parse("f.toml", frame).unwrap_err().to_string();
    assert!(message.contains("f.toml:7:1") && message.contains("\"cornell\""), "{message}");
    let message = built_in(Some("sort-pair-24")).unwrap_err().to_string();
    assert!(message.contains("did you mean `sort-pairs-24`"), "{message}");
    let message = built_in(Some("sort")).unwrap_err().to_string();
    assert!(message.contains("`sort`") && message.contains("sort-pairs-24"), "{message}");
}

#[test]
fn built_in_cases_parse_and_have_hashes_for_their_smallest_sizes() {
    let cases = built_in(None).unwrap();
    assert_eq!(cases.len(), BUILT_IN.len());
    for (case, (name, _)) in cases.iter().zip(BUILT_IN) {
        assert_eq!(case.name, *name, "a file has the name of its case");
        assert!(case.expected.contains_key(&case.sizes[0]), "{name}: no hash for N = {}", case.sizes[0]);
        assert!(case.sizes[0] <= crate::suite::QUICK_N, "{name}: nothing for --quick");
    }
    // Every file in the folder is built in.
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
    assert_eq!(load_folder(&folder).unwrap().len(), cases.len());
}
