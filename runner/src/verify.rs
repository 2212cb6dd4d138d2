//! `caustic verify`.

use crate::Failure;
use crate::args::VerifyArguments;
use crate::progress::Monitor;
use crate::render::failure;
use caustic_device::{Device, DeviceChoice, Difference, Error, Kernel, Precision};
use caustic_renderer::scene::suggestion;
use caustic_renderer::{Verification, verify};
use std::time::{SystemTime, UNIX_EPOCH};

/// Compares a GPU with the CPU and prints a table.
pub fn run(arguments: &VerifyArguments) -> Result<(), Failure> {
    if arguments.device == DeviceChoice::Cpu {
        return Err(Failure::input("verify compares a GPU with the CPU: --device must be gpu or gpu:NAME_OR_INDEX"));
    }
    let choice = if arguments.device == DeviceChoice::Auto { &DeviceChoice::Gpu(None) } else { &arguments.device };
    let gpu_from = arguments.gpu_from.as_deref().map(stage).transpose()?;
    let opened = match Device::open_with(choice, arguments.precision.into()) {
        // Nothing exact can be had: the portable path, and how far off it is.
        Err(Error::NotExact { .. }) => Device::open_with(choice, Precision::Fast),
        opened => opened,
    };
    let (gpu, line) = opened.map_err(|error| match error {
        // Its usual remedy, the CPU, is none here.
        Error::NoSuchDevice { wanted, available } => Failure::input(format!(
            "verify compares a GPU with the CPU, but this machine has no `{wanted}` (it has {available}); on Debian, mesa-vulkan-drivers adds a software GPU"
        )),
        error => Failure::input(error),
    })?;
    eprintln!("{line}");
    // Fresh inputs every time; the seed that is printed brings them back.
    let now =
        SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.subsec_nanos() ^ time.as_secs() as u32);
    let seed = arguments.seed.unwrap_or(now);
    let mut monitor = Monitor::new(arguments.json);
    let found = verify(&gpu, gpu_from, seed, &mut |progress| monitor.show(progress));
    monitor.finish();
    let found = found.map_err(|error| failure(&error).with_remark(&again(seed)))?;
    if arguments.json {
        let mut value = serde_json::to_value(&found).map_err(Failure::machine)?;
        value["same"] = found.same().into();
        println!("{value:#}");
    } else {
        print(&found);
    }
    outcome(&found)
}

/// Whether what was found is an error: any difference on a device that is meant to be exact.
fn outcome(found: &Verification) -> Result<(), Failure> {
    if found.same() || !found.exact {
        return Ok(());
    }
    Err(Failure::machine(match found.first() {
        Some((stage, first)) => format!(
            "{} computes otherwise than the CPU; first in {stage}: {first}. Update its driver, or use --device cpu; {}",
            found.device,
            again(found.seed)
        ),
        None => format!("{} lays records out otherwise than the CPU; use --device cpu", found.device),
    }))
}

/// How to have the same random inputs once more.
fn again(seed: u32) -> String {
    format!("--seed {seed} brings these inputs back")
}

fn stage(name: &str) -> Result<Kernel, Failure> {
    Kernel::named(name).ok_or_else(|| {
        let names: Vec<_> = Kernel::ALL.iter().map(|kernel| kernel.entry_point()).collect();
        let meant = suggestion(name, names.iter().copied());
        Failure::input(format!("--gpu-from {name}: there is no such stage{meant}; the stages are {}", names.join(", ")))
    })
}

fn print(found: &Verification) {
    println!("{:<24} {:>12} {:>10} {:>6}  first difference", "stage", "words", "differ", "NaN");
    let row = |name: &str, difference: &Difference| {
        let Difference { words, differ, nans, .. } = difference;
        let first = difference.first.as_ref().map_or(String::new(), ToString::to_string);
        println!("{name:<24} {words:>12} {differ:>10} {nans:>6}  {first}");
    };
    let mut all = Difference::default();
    for stage in &found.stages {
        row(stage.stage, &stage.difference);
        all.add(stage.difference.clone());
    }
    for image in &found.images {
        row(&format!("picture of {}", image.scene), &image.difference);
        all.add(image.difference.clone());
    }
    println!("{:<24} {:>12} {:>10} {:>6}", "all", all.words, all.differ, all.nans);
    for image in &found.images {
        let same = if image.cpu_sha256 == image.gpu_sha256 { "the same" } else { &image.gpu_sha256 };
        println!("SHA-256 of {}: CPU {}, GPU {same}", image.scene, image.cpu_sha256);
    }
    if !found.layouts_wrong.is_empty() {
        println!("records laid out otherwise: {}", found.layouts_wrong.join(", "));
    }
    println!("seed {}: {}", found.seed, again(found.seed));
    if !found.exact {
        println!("not exact here: words differ by up to {} ulp", all.most_ulps);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustic_device::StageComparison;

    fn with(expected: f32, found: f32, exact: bool) -> Verification {
        let difference = Difference::of("sums", &[1.0, expected], &[1.0, found]);
        let stages = vec![StageComparison { stage: "scan_rows", runs: 1, difference }];
        let device = "a device".to_string();
        Verification { device, exact, seed: 1, stages, images: Vec::new(), layouts_wrong: Vec::new() }
    }

    #[test]
    fn any_difference_ends_an_exact_verification_with_code_1() {
        assert!(outcome(&with(2.0, 2.0, true)).is_ok());
        let failure = outcome(&with(2.0, 2f32.next_up(), true)).err().unwrap();
        assert_eq!(failure.code(), 1);
        let parts = ["scan_rows", "record 1", "0x40000000", "0x40000001", "1 ulp", "--device cpu"];
        assert!(parts.iter().all(|part| failure.message().contains(part)), "{}", failure.message());
        // A NaN is never right, and neither is a record that is laid out otherwise.
        assert_eq!(outcome(&with(f32::NAN, f32::NAN, true)).err().map(|failure| failure.code()), Some(1));
        let moved = Verification { layouts_wrong: vec!["Photon".to_string()], ..with(2.0, 2.0, true) };
        assert_eq!(outcome(&moved).err().map(|failure| failure.code()), Some(1));
        assert!(outcome(&with(2.0, 3.0, false)).is_ok(), "what is not exact is reported and no error");
    }
}
