//! The roofline of bytes: how fast the device copies, measured in the same run.

use caustic_device::{Device, Kernel, Plan};
use caustic_kernels::layout::Site;
use rayon::prelude::*;
use std::time::{Duration, Instant};

/// Bytes that a CPU copies: far more than its caches hold.
const CPU_BYTES: usize = 256 << 20;
/// Bytes of one task of a copy.
const TASK_BYTES: usize = 1 << 20;
/// Quads that a GPU copies: 128 MiB, the largest buffer that every adapter has.
const GPU_QUADS: u32 = 1 << 23;
/// Copies that are measured; the fastest counts.
const COPIES: usize = 9;
const ENOUGH: Duration = Duration::from_secs(2);

/// Bytes a second, read and written ones together, of a copy on this device; none if it cannot be told.
pub(crate) fn copy_roofline(device: &Device) -> Option<f64> {
    if device.is_gpu() { copy_on_gpu(device) } else { Some(copy_on_cpu()) }
}

/// A parallel copy of memory with all of rayon's threads.
fn copy_on_cpu() -> f64 {
    let from = vec![1u8; CPU_BYTES];
    // Written once before, so that no page is first touched while the clock runs.
    let mut to = vec![2u8; CPU_BYTES];
    let copy = || {
        to.par_chunks_mut(TASK_BYTES).zip(from.par_chunks(TASK_BYTES)).for_each(|(to, from)| to.copy_from_slice(from));
        std::hint::black_box(&mut to);
    };
    2.0 * CPU_BYTES as f64 / fastest(copy)
}

/// A kernel that copies.
fn copy_on_gpu(device: &Device) -> Option<f64> {
    let from = device.buffer::<Site>("copy: from", GPU_QUADS.into()).ok()?;
    let to = device.buffer::<Site>("copy: to", GPU_QUADS.into()).ok()?;
    let mut plan = Plan::new();
    plan.each(Kernel::CopyQuads, GPU_QUADS, &[&from, &to]);
    device.run(&plan).ok()?;
    let mut best = f64::INFINITY;
    for _ in 0..COPIES {
        device.reset_stage_times();
        device.run(&plan).ok()?;
        let ms: f64 = device.stage_times().iter().map(|stage| stage.ms).sum();
        // Without time stamps there is nothing to compare stages with.
        best = if ms > 0.0 { best.min(ms) } else { best };
    }
    let bytes = f64::from(GPU_QUADS) * (2 * size_of::<Site>()) as f64;
    best.is_finite().then(|| bytes / (best * 1e-3))
}

/// Seconds of the fastest of some runs.
fn fastest(mut run: impl FnMut()) -> f64 {
    run();
    let start = Instant::now();
    let mut best = f64::INFINITY;
    for _ in 0..COPIES {
        let before = Instant::now();
        run();
        best = best.min(before.elapsed().as_secs_f64());
        if start.elapsed() > ENOUGH {
            break;
        }
    }
    best
}
