//! `caustic verify` and `--precision`, as users run them.

use caustic_tests::program::*;

#[test]
fn verify_compares_every_stage_and_prints_a_table() {
    let folder = folder();
    let Some(gpu) = gpu_arguments() else {
        if caustic_device::adapters().is_empty() {
            refused(&folder, &["verify"], &["this machine has no `gpu`", "mesa-vulkan-drivers"]);
        }
        return;
    };
    let gpu: Vec<&str> = gpu.iter().map(String::as_str).collect();
    let text = succeeds(&folder, &[&["verify", "--seed", "5"], &gpu[..]].concat()).stdout;
    for part in [
        "stage",
        "radix_scatter",
        "irradiance_histogram",
        "picture of cornell",
        "SHA-256 of furnace",
        "SHA-256 of crowd",
        "seed 5",
    ] {
        assert!(text.contains(part), "no `{part}` in {text}");
    }
    let all = text.lines().find(|line| line.starts_with("all ")).expect("a sum");
    let numbers: Vec<u64> = all.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect();
    assert!(numbers[0] > 5_000_000 && numbers[1..] == [0, 0], "{all}");

    let found = json(&succeeds(&folder, &[&["verify", "--json", "--seed", "6"], &gpu[..]].concat()).stdout);
    assert_eq!((&found["same"], &found["exact"]), (&true.into(), &true.into()));
    assert!(
        found["stages"].as_array().unwrap().iter().all(|row| row["differ"] == 0 && row["words"].as_u64() > Some(0))
    );
    assert_eq!(found["images"][0]["cpu_sha256"], found["images"][0]["gpu_sha256"]);
}

#[test]
fn verify_refuses_what_it_cannot_compare() {
    let folder = folder();
    refused(&folder, &["verify", "--device", "cpu"], &["compares a GPU with the CPU", "gpu:NAME_OR_INDEX"]);
    refused(
        &folder,
        &["verify", "--gpu-from", "gathering"],
        &["--gpu-from gathering", "no such stage", "develop_film"],
    );
}

/// Where words cannot be passed through, exact kernels are refused and fast ones translated; here by an environment variable.
#[test]
fn without_passthrough_only_fast_kernels_run_and_say_so() {
    let Some(gpu) = gpu_arguments() else { return };
    let folder = folder();
    let portable = |more: &[&str]| -> Run {
        let mut arguments =
            vec!["render", "plane", "-o", "a.exr", "--size", "16x12", "--spp", "2", "--photons", "500", "--k", "10"];
        arguments.extend(gpu.iter().map(String::as_str).chain(more.iter().copied()));
        command(&folder, &arguments).env("CAUSTIC_PORTABLE", "1").output().expect("the program starts").into()
    };
    let exact = portable(&[]);
    assert_eq!(exact.code, Some(2), "{exact:?}");
    assert!(exact.stderr.contains("--precision fast") && files(&folder).is_empty(), "{exact:?}");
    let fast = portable(&["--precision", "fast"]);
    assert_eq!(fast.code, Some(0), "{fast:?}");
    assert!(fast.stderr.contains("not exact here"), "{}", fast.stderr);
    let found = read(&folder.path().join("a.exr"));
    let cpu = [
        "render",
        "plane",
        "-o",
        "b.exr",
        "--size",
        "16x12",
        "--spp",
        "2",
        "--photons",
        "500",
        "--k",
        "10",
        "--device",
        "cpu",
    ];
    succeeds(&folder, &cpu);
    let expected = read(&folder.path().join("b.exr"));
    // No photon of this scene is reflected again, and 2.5 ulp a division do not add up to more than this.
    for (a, b) in expected.rgb.as_flattened().iter().zip(found.rgb.as_flattened()) {
        assert!((a - b).abs() <= 1e-4 * a, "{a} and {b}");
    }
}
