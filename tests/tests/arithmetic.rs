//! The exact arithmetic: the CPU's results against IEEE 754, and a GPU's against the CPU's, over millions of operands.

use caustic_device::{Device, Difference, Kernel, Plan};
use caustic_kernels::num::{from_total_order_key, is_nan};
use caustic_kernels::probe::{Arithmetic, ArithmeticParams};
use caustic_tests::{gpu, sum_rounded_once};

/// Pairs of operands of one plan.
const BATCH: u32 = 1 << 20;

fn results(device: &Device, first: u32, count: u32) -> Vec<Arithmetic> {
    let params = device.upload("params", &[ArithmeticParams { first, count, seed: 99 }]).unwrap();
    let results = device.buffer::<Arithmetic>("results", u64::from(count)).unwrap();
    let mut plan = Plan::new();
    plan.each(Kernel::ProbeArithmetic, count, &[&params, &results]);
    device.run(&plan).unwrap();
    device.read(&results, u64::from(count)).unwrap()
}

/// Subnormals count as zeros and there is one NaN.
fn policy(x: f32) -> f32 {
    if x.is_nan() {
        f32::from_bits(0x7fc0_0000)
    } else if x.is_subnormal() {
        0f32.copysign(x)
    } else {
        x
    }
}

fn bits(x: f32) -> u32 {
    x.to_bits()
}

/// The words of a result that are not what IEEE 754 and the standard library say.
fn wrong(result: &Arithmetic) -> Vec<&'static str> {
    let [a, b] = result.operands.map(f32::from_bits);
    let tame = |x: f32| f32::from_bits((bits(x) & 0x807f_ffff) | (((bits(x) >> 23 & 0x3f) + 96) << 23));
    let (x, y) = (tame(a), tame(b));
    let scale = x.abs().max(y.abs());
    let sum = sum_rounded_once([x, y, x, y, y].into_iter().map(f32::abs), scale);
    let floor = if is_nan(a) { -(1 << 30) } else { policy(a).floor().clamp(-1_073_741_824.0, 1_073_741_824.0) as i32 };
    let checks = [
        ("quotient", result.quotient == bits(policy(policy(a) / policy(b)))),
        ("root", result.root == bits(policy(policy(a).sqrt()))),
        // Two roundings, each to the nearest.
        ("product and sum", result.product_sum == bits(x * y + x)),
        ("difference", result.difference == bits((x + y) - x)),
        ("floor", result.conversions[0] == floor as u32),
        ("clamped", result.conversions[1] == if a.is_nan() { 0 } else { (a as u32).min(0xffff_ff00) }),
        ("order", bits(from_total_order_key(result.conversions[2])) == bits(a)),
        ("sum", result.sum == bits(sum)),
    ];
    checks.iter().filter(|(_, right)| !right).map(|&(name, _)| name).collect()
}

#[test]
fn twenty_million_pairs_give_the_ieee_result() {
    let cpu = Device::cpu();
    let mut finite = 0u32;
    for batch in 0..20 {
        for result in results(&cpu, batch * BATCH, BATCH) {
            let wrong = wrong(&result);
            assert!(wrong.is_empty(), "{wrong:?}: {result:x?}");
            finite += u32::from(f32::from_bits(result.quotient).is_normal());
        }
    }
    assert!(finite > 10 << 20, "only {finite} quotients are ordinary numbers");
}

#[test]
fn a_gpu_gives_the_bits_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    // A software GPU takes a second for a million.
    let batches = if gpu.name().contains("llvmpipe") { 4 } else { 32 };
    let cpu = Device::cpu();
    for batch in 0..batches {
        let first = batch * BATCH;
        let found = Difference::of("results", &results(&cpu, first, BATCH), &results(gpu, first, BATCH));
        assert!(found.is_none(), "{found:?}");
    }
}

/// Each word, one unit off.
#[test]
fn planted_faults_are_found() {
    let all = results(&Device::cpu(), 1, 40_000);
    let ordinary = all.iter().filter(|result| f32::from_bits(result.quotient).is_normal());
    for result in ordinary.take(100) {
        let with = |fault: fn(&mut Arithmetic)| {
            let mut faulty = *result;
            fault(&mut faulty);
            wrong(&faulty)
        };
        assert!(with(|_| ()).is_empty());
        assert_eq!(with(|r| r.quotient ^= 1), ["quotient"]);
        assert_eq!(with(|r| r.root ^= 1), ["root"]);
        assert_eq!(with(|r| r.product_sum ^= 1), ["product and sum"]);
        assert_eq!(with(|r| r.difference ^= 1), ["difference"]);
        assert_eq!(with(|r| r.conversions[0] ^= 1), ["floor"]);
        assert_eq!(with(|r| r.conversions[1] ^= 1), ["clamped"]);
        assert_eq!(with(|r| r.conversions[2] ^= 1), ["order"]);
        assert_eq!(with(|r| r.sum ^= 1), ["sum"]);
    }
    // What contraction and reassociation would give is another number often enough to be found.
    let tame = |bits: u32| f32::from_bits((bits & 0x807f_ffff) | (((bits >> 23 & 0x3f) + 96) << 23));
    let contracted = all.iter().filter(|r| {
        let [a, b] = r.operands.map(tame);
        a.mul_add(b, a).to_bits() != r.product_sum
    });
    let reassociated = all.iter().filter(|r| tame(r.operands[1]).to_bits() != r.difference);
    let (contracted, reassociated) = (contracted.count(), reassociated.count());
    assert!(contracted > 500 && reassociated > 500, "{contracted}, {reassociated}");
}
