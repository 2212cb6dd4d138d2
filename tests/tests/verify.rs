//! `verify`: the GPU against the CPU, stage by stage, and that it finds a device that computes otherwise.

use caustic_device::{Device, DeviceChoice, Kernel, Precision};
use caustic_renderer::scene::BUILT_IN;
use caustic_renderer::verify;
use caustic_tests::gpu;
use std::collections::BTreeSet;

fn fast_gpu() -> Device {
    let named = std::env::var("CAUSTIC_TEST_GPU");
    let choice: DeviceChoice = named.as_deref().unwrap_or("gpu").parse().unwrap();
    Device::open_with(&choice, Precision::Fast).unwrap().0
}

#[test]
fn every_kernel_and_every_scene_gives_the_same_bits() {
    let Some(gpu) = gpu() else { return };
    let found = verify(gpu, None, 7, &mut |_| true).unwrap();
    assert!(found.exact && found.same(), "{:?}", found.first());
    assert!(found.layouts_wrong.is_empty(), "{:?}", found.layouts_wrong);
    let stages: BTreeSet<_> = found.stages.iter().map(|row| row.stage).collect();
    let mut kernels: BTreeSet<_> = Kernel::ALL.iter().map(|kernel| kernel.entry_point()).collect();
    // Those for subgroups of another size.
    let others = if stages.contains("radix_count") {
        ["radix_count_narrow", "radix_scatter_narrow"]
    } else {
        ["radix_count", "radix_scatter"]
    };
    assert!(others.iter().all(|other| kernels.remove(other)));
    assert_eq!(stages, kernels, "a kernel was not run");
    assert!(found.stages.iter().all(|row| row.difference.words > 0), "a kernel wrote nothing that was compared");
    // And one of many surfaces.
    assert_eq!(found.images.len(), BUILT_IN.len() + 1);
    for image in &found.images {
        assert_eq!(image.cpu_sha256, image.gpu_sha256, "{}", image.scene);
        assert!(image.difference.words > 1000, "{}", image.scene);
    }
}

/// Fast kernels are a device that computes otherwise: a fault in every stage that divides or takes a sine.
#[test]
fn a_device_that_computes_otherwise_is_found() {
    if gpu().is_none() {
        return;
    }
    let gpu = fast_gpu();
    let found = verify(&gpu, None, 7, &mut |_| true).unwrap();
    assert!(!found.exact && !found.same());
    let differ = |stage: &str| found.stages.iter().find(|row| row.stage == stage).unwrap().difference.differ;
    assert!(differ("probe_arithmetic") > 1000);
    assert_eq!(differ("radix_scatter_plain") + differ("layout_scene"), 0, "integers are no faster");
    let (stage, first) = found.first().unwrap();
    assert_eq!(stage, "probe_arithmetic");
    assert_ne!(first.expected, first.found);
}

#[test]
fn the_gpu_can_go_on_alone_from_any_stage() {
    let Some(gpu) = gpu() else { return };
    let found = verify(gpu, Some(Kernel::HashPhotons), 8, &mut |_| true).unwrap();
    assert!(found.same(), "{:?}", found.first());
    assert!(found.images.is_empty(), "the film's stage is the picture");
    assert!(found.stages.iter().any(|row| row.stage == "develop_film"));
}

#[test]
fn verify_can_be_stopped() {
    let Some(gpu) = gpu() else { return };
    let mut left = 3;
    let result = verify(gpu, None, 1, &mut |_| {
        left -= 1;
        left > 0
    });
    assert!(result.is_err());
}
