//! The radix sort and the scan, against the standard library and CPU against GPU.

use caustic_device::{Device, Kernel, LaneOrder, Plan};
use caustic_kernels::num::pcg4d;
use caustic_kernels::sort::{SCAN_BLOCK, ScanParams};
use caustic_photon_map::{RadixSort, scan};
use caustic_tests::{assert_same_words, compare_sorted, gpu};

/// Around the items of a lane (16), of a block (4096) and of a lane's run of blocks.
const SIZES: [u32; 11] = [0, 1, 2, 15, 16, 17, 4095, 4096, 4097, 65_537, 100_000];
/// Below, at and above whole digits, and all bits.
const BITS: [u32; 6] = [1, 4, 5, 13, 24, 32];
const KINDS: [&str; 5] = ["random", "all equal", "sorted", "reversed", "two values"];

/// `count` keys of at most `bits` bits.
fn keys(kind: &str, count: u32, bits: u32) -> Vec<u32> {
    let mask = u32::MAX >> (32 - bits);
    let mut keys: Vec<u32> = (0..count).map(|i| pcg4d([i, bits, 1, 2])[0] & mask).collect();
    match kind {
        "random" => {}
        "all equal" => keys.fill(0x5555_5555 & mask),
        "sorted" => keys.sort_unstable(),
        "reversed" => keys.sort_unstable_by(|a, b| b.cmp(a)),
        // The smallest and the largest.
        "two values" => keys.iter_mut().for_each(|key| *key = if *key & 1 == 0 { 0 } else { mask }),
        _ => unreachable!("{kind}"),
    }
    keys
}

fn sort(device: &Device, keys: &[u32], bits: u32) -> (Vec<u32>, Vec<u32>) {
    let count = keys.len() as u32;
    let buffer = device.upload("keys", keys).unwrap();
    let mut plan = Plan::new();
    let sorted = RadixSort::plan(device, &mut plan, &buffer, count, bits).unwrap();
    device.run(&plan).unwrap();
    let read = |buffer| device.read(buffer, u64::from(count)).unwrap();
    (read(&sorted.keys), read(&sorted.order))
}

fn check(stage: &str, device: &Device, keys: &[u32], bits: u32) {
    let (sorted, order) = sort(device, keys, bits);
    let what = format!("{stage}, {} keys of {bits} bits", keys.len());
    assert_eq!(compare_sorted(&what, keys, &sorted, &order), Ok(2 * keys.len()));
}

#[test]
fn the_cpu_sorts_like_the_standard_librarys_stable_sort() {
    let cpu = Device::cpu();
    for bits in BITS {
        for kind in KINDS {
            for size in SIZES {
                check(kind, &cpu, &keys(kind, size, bits), bits);
            }
        }
    }
    check("random", &cpu, &keys("random", 1_000_003, 27), 27);
}

#[test]
fn the_gpu_sorts_like_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let cpu = Device::cpu();
    for bits in BITS {
        for kind in KINDS {
            // A kind shows in one size or another; every kind in every size would take lavapipe a minute.
            let sizes = if kind == "random" { &SIZES[..] } else { &SIZES[7..9] };
            for &size in sizes {
                let keys = keys(kind, size, bits);
                check(kind, gpu, &keys, bits);
                let (expected, found) = (sort(&cpu, &keys, bits), sort(gpu, &keys, bits));
                let stage = format!("{kind}, {size} keys of {bits} bits");
                assert_same_words(&format!("{stage}, keys"), &expected.0, &found.0);
                assert_same_words(&format!("{stage}, order"), &expected.1, &found.1);
            }
        }
    }
}

#[test]
fn the_order_of_lanes_does_not_matter() {
    for size in [17, 4097, 20_000] {
        let keys = keys("random", size, 9);
        let forward = sort(&Device::cpu(), &keys, 9);
        for order in [LaneOrder::Reversed, LaneOrder::Shuffled(1), LaneOrder::Shuffled(2)] {
            let other = sort(&Device::cpu_with_order(order), &keys, 9);
            assert_same_words(&format!("{order:?}, keys"), &forward.0, &other.0);
            assert_same_words(&format!("{order:?}, order"), &forward.1, &other.1);
        }
    }
}

/// The scan of an array, put together as its readers do, and the sum of everything.
fn scanned(device: &Device, input: &[u32]) -> (Vec<u32>, u32) {
    let count = input.len() as u32;
    let blocks = count.div_ceil(SCAN_BLOCK);
    let buffer = device.upload("input", input).unwrap();
    let mut plan = Plan::new();
    let [sums, offsets, totals] = scan(device, &mut plan, &buffer, count).unwrap();
    device.run(&plan).unwrap();
    let sums: Vec<u32> = device.read(&sums, u64::from(count)).unwrap();
    let offsets: Vec<u32> = device.read(&offsets, u64::from(blocks)).unwrap();
    let totals: Vec<u32> = device.read(&totals, u64::from(blocks)).unwrap();
    let all = (0..).zip(&sums).map(|(i, &sum)| sum + offsets[(i / SCAN_BLOCK) as usize]).collect();
    (all, offsets.last().zip(totals.last()).map_or(0, |(before, last)| before + last))
}

fn check_scan(device: &Device, sizes: &[u32]) {
    for &size in sizes {
        // Up to 1023 each: a million of them add up to less than 2³⁰.
        let input: Vec<u32> = (0..size).map(|i| pcg4d([i, 5, 6, 7])[1] >> 22).collect();
        let mut sum = 0u64;
        let expected: Vec<u32> = input
            .iter()
            .map(|&x| {
                let before = u32::try_from(sum).expect("no overflow");
                sum += u64::from(x);
                before
            })
            .collect();
        let (sums, total) = scanned(device, &input);
        assert_same_words(&format!("scan of {size}"), &expected, &sums);
        assert_eq!(u64::from(total), sum, "total of {size}");
    }
}

#[test]
fn a_scan_is_the_sum_of_what_comes_before() {
    check_scan(&Device::cpu(), &[0, 1, 15, 16, 17, 4095, 4096, 4097, 100_000, 1_000_003]);
    check_scan(&Device::cpu_with_order(LaneOrder::Shuffled(3)), &[4097, 50_000]);
}

#[test]
fn a_scan_on_the_gpu_is_the_sum_of_what_comes_before() {
    let Some(gpu) = gpu() else { return };
    check_scan(gpu, &[0, 1, 15, 16, 17, 4095, 4096, 4097, 100_000]);
}

/// Rows that are no multiple of a block, longer and shorter than one, the last cut short.
fn check_rows(device: &Device) {
    for (count, row_length) in [(50, 7), (4096, 16), (30_000, 9_999), (30_000, 4096), (12_289, 4097), (5, 100)] {
        let input: Vec<u32> = (0..count).map(|i| pcg4d([i, row_length, 8, 9])[2] >> 12).collect();
        let rows = count.div_ceil(row_length);
        let params = device.upload("params", &[ScanParams { count, row_length }]).unwrap();
        let input_buffer = device.upload("input", &input).unwrap();
        let sums = device.buffer::<u32>("sums", u64::from(count)).unwrap();
        let totals = device.buffer::<u32>("totals", u64::from(rows)).unwrap();
        let mut plan = Plan::new();
        // Three workgroups too many, which must do nothing.
        plan.groups(Kernel::ScanRows, rows + 3, &[&params, &input_buffer, &sums, &totals]);
        device.run(&plan).unwrap();
        let (mut expected, mut expected_totals) = (Vec::new(), Vec::new());
        for row in input.chunks(row_length as usize) {
            let mut sum = 0;
            for x in row {
                expected.push(sum);
                sum += x;
            }
            expected_totals.push(sum);
        }
        let stage = format!("{count} in rows of {row_length}");
        assert_same_words(&stage, &expected, &device.read(&sums, u64::from(count)).unwrap());
        assert_same_words(&stage, &expected_totals, &device.read(&totals, u64::from(rows)).unwrap());
    }
}

#[test]
fn rows_are_scanned_each_for_itself() {
    check_rows(&Device::cpu());
    check_rows(&Device::cpu_with_order(LaneOrder::Reversed));
    if let Some(gpu) = gpu() {
        check_rows(gpu);
    }
}

/// More workgroups than an axis of a dispatch may have: the rectangle of workgroups that a GPU then gets covers them all.
fn check_many_groups(device: &Device) {
    // Rows of one element: a workgroup each, and a few microseconds of lavapipe.
    let count = 70_000;
    let input: Vec<u32> = (0..count).collect();
    let params = device.upload("params", &[ScanParams { count, row_length: 1 }]).unwrap();
    let input_buffer = device.upload("input", &input).unwrap();
    let sums = device.upload("sums", &vec![7u32; count as usize]).unwrap();
    let totals = device.buffer::<u32>("totals", u64::from(count)).unwrap();
    let mut plan = Plan::new();
    plan.groups(Kernel::ScanRows, count, &[&params, &input_buffer, &sums, &totals]);
    device.run(&plan).unwrap();
    assert_same_words("sums", &vec![0; count as usize], &device.read(&sums, u64::from(count)).unwrap());
    assert_same_words("totals", &input, &device.read(&totals, u64::from(count)).unwrap());
}

#[test]
fn more_workgroups_than_an_axis_may_have_all_run() {
    check_many_groups(&Device::cpu());
    if let Some(gpu) = gpu() {
        check_many_groups(gpu);
    }
}
