//! The smallest pieces on one core of the CPU: exact arithmetic, a search, sorts small enough to see a pass's fixed cost.
//! `cargo bench -p caustic-bench`, with a name to run only some.

use caustic_bench::points::{Distribution, Points, keys};
use caustic_device::{Device, Plan};
use caustic_kernels::layout::{Irradiance, Query};
use caustic_kernels::num::{Limbs, div, sqrt};
use caustic_photon_map::{Gather, Hash, MapOptions, PhotonMap, RadixSort};
use divan::Bencher;
use divan::counter::ItemsCount;

/// Operands of an operation: enough to stay in a first-level cache.
const OPERANDS: u32 = 1024;
/// Photons of the map that is searched.
const PHOTONS: u32 = 100_000;

fn main() {
    divan::main();
}

/// Numbers from 0.5 to 1.5 and in pairs.
fn operands() -> Vec<[f32; 2]> {
    let points = Points::new(Distribution::Uniform, OPERANDS, 1);
    (0..OPERANDS).map(|i| points.photon(i)).map(|[a, b, _]| [0.5 + a, 0.5 + b]).collect()
}

fn each(bencher: Bencher<'_, '_>, operation: impl Fn(f32, f32) -> f32 + Sync) {
    let operands = operands();
    bencher.counter(ItemsCount::new(operands.len())).bench(|| {
        let mut bits = 0;
        for &[a, b] in divan::black_box(&operands) {
            bits ^= operation(a, b).to_bits();
        }
        bits
    });
}

#[divan::bench]
fn divide_exact(bencher: Bencher<'_, '_>) {
    each(bencher, div);
}

#[divan::bench]
fn divide_native(bencher: Bencher<'_, '_>) {
    each(bencher, |a, b| a / b);
}

#[divan::bench]
fn root_exact(bencher: Bencher<'_, '_>) {
    each(bencher, |a, _| sqrt(a));
}

#[divan::bench]
fn root_native(bencher: Bencher<'_, '_>) {
    each(bencher, |a, _| a.sqrt());
}

#[divan::bench]
fn sum_exact(bencher: Bencher<'_, '_>) {
    let operands = operands();
    bencher.counter(ItemsCount::new(operands.len())).bench(|| {
        let mut sum = Limbs::ZERO;
        for [a, _] in divan::black_box(&operands) {
            sum.add(Limbs::of(*a, 1.5).0);
        }
        sum.value(1.5)
    });
}

#[divan::bench]
fn sum_native(bencher: Bencher<'_, '_>) {
    let operands = operands();
    bencher
        .counter(ItemsCount::new(operands.len()))
        .bench(|| divan::black_box(&operands).iter().map(|[a, _]| *a).sum::<f32>());
}

/// 64 queries, which is one workgroup and so one thread.
#[divan::bench(args = [10, 50, 100])]
fn gather_query(bencher: Bencher<'_, '_>, k: u32) {
    let device = Device::cpu();
    let points = Points::new(Distribution::Uniform, PHOTONS, k);
    let options =
        MapOptions { radius: Distribution::Uniform.radius(PHOTONS, k), hash: Hash::Linear, table: None, cell: None };
    let map = PhotonMap::build(&device, &points.photons(PHOTONS), &options).expect("a map");
    let queries: Vec<Query> = points.queries(64);
    let buffer = device.upload("queries", &queries).expect("a buffer");
    let out = device.buffer::<Irradiance>("irradiance", 64).expect("a buffer");
    let mut plan = Plan::new();
    map.plan_irradiance(&device, &mut plan, &buffer, 64, k, Gather::Heap, &out).expect("a plan");
    bencher.counter(ItemsCount::new(64usize)).bench(|| device.run(&plan));
}

/// One pass of one digit over one workgroup's keys, over many, and all passes of whole keys.
#[divan::bench(args = [(4096, 4), (1_000_000, 4), (1_000_000, 8), (1_000_000, 32)])]
fn sort(bencher: Bencher<'_, '_>, (n, bits): (u32, u32)) {
    let device = Device::cpu();
    let input = keys(n, bits);
    let buffer = device.upload("sort: keys", &input).expect("a buffer");
    let mut plan = Plan::new();
    RadixSort::plan(&device, &mut plan, &buffer, n, bits).expect("a plan");
    // A sort of several passes overwrites its keys; the next finds them half sorted, which its time does not depend on.
    bencher.counter(ItemsCount::new(n)).bench(|| device.run(&plan));
}
