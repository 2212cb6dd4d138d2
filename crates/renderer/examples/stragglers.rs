//! A farm on paper: how long a render takes on up to 10,000 devices of which some are slow and some fail, merged by the code that merges
//! real parts, and how fast that is. docs/SCALING.md says what it means.
//!
//! `cargo run --release -p caustic-renderer --example stragglers [-- PASS_SECONDS LINK_BYTES_A_SECOND]`

use caustic_kernels::num::pcg4d;
use caustic_kernels::trace::Pixel;
use caustic_renderer::ProgressState;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::time::Instant;

/// The picture of the simulation: small, since only its bits matter.
const SMALL: [u32; 2] = [4, 2];
/// The picture whose bytes and sums are measured.
const FULL: [u32; 2] = [1920, 1080];
/// Passes a device computes between two failures of it, on average.
const FAILS_ONCE_IN: f64 = 2000.0;

/// A number from 0 to 1 of three others.
fn unit(a: u32, b: u32, c: u32) -> f64 {
    (f64::from(pcg4d([a, b, c, 0x57a6])[0]) + 0.5) / 4_294_967_296.0
}

/// How long a device takes for a pass, in passes of a healthy one: a tenth more or less, and one of fifty devices three times as long.
fn slowness(device: u32) -> f64 {
    let slow = if unit(device, 0, 1) < 0.02 { 3.0 } else { 1.0 };
    slow * (0.95 + 0.1 * unit(device, 0, 2))
}

/// A pass of the small picture.
fn pass(number: u32) -> ProgressState {
    let value = |pixel: u32| pcg4d([number, pixel, 0, 1])[0] as f32 * 1e-9;
    let film: Vec<_> = (0..SMALL[0] * SMALL[1]).map(|i| Pixel { rgb: [value(i); 3], ..Pixel::default() }).collect();
    ProgressState::of_pass(SMALL, 0.1, number, &film)
}

/// Passes from one queue; a device that fails is away for as long as ten passes take, and its pass is computed by another. Returns the time
/// in passes of a healthy device, and how many passes were lost.
fn simulate(devices: u32, passes: u32, fails: bool, merged: &mut ProgressState) -> (f64, u32) {
    // (time in millionths at which it is free, device, what it then has)
    let mut free: BinaryHeap<Reverse<(u64, u32, Option<u32>)>> =
        (0..devices).map(|device| Reverse((0, device, None))).collect();
    let mut returned = Vec::new();
    let (mut next, mut done, mut lost, mut taken, mut end) = (0, 0, 0, 0, 0);
    let after = |now: u64, passes: f64| now + (passes * 1e6) as u64;
    while done < passes {
        let Some(Reverse((now, device, has))) = free.pop() else { unreachable!("there are devices until all is done") };
        if let Some(number) = has {
            let failed = fails && unit(device, taken, 3) < 1.0 / FAILS_ONCE_IN;
            if failed {
                lost += 1;
                returned.push(number);
                free.push(Reverse((after(now, 10.0), device, None)));
                continue;
            }
            if merged.absorb(pass(number)).is_ok() {
                done += 1;
                end = now;
            }
        }
        taken += 1;
        let number = returned.pop().or_else(|| {
            next += 1;
            (next <= passes).then(|| next - 1)
        });
        match number {
            Some(number) => free.push(Reverse((after(now, slowness(device)), device, Some(number)))),
            // It looks again soon: somebody may fail.
            None => free.push(Reverse((after(now, 0.5), device, None))),
        }
    }
    (end as f64 / 1e6, lost)
}

/// Seconds for one node of a 1080p picture to be added to another.
fn seconds_a_sum() -> f64 {
    let film = vec![Pixel { rgb: [0.5, 0.25, 0.125], ..Pixel::default() }; (FULL[0] * FULL[1]) as usize];
    // Two passes make a node, two nodes the next: three sums, one of them of nodes alone.
    let states: Vec<_> = (0..4).map(|pass| ProgressState::of_pass(FULL, 0.1, pass, &film)).collect();
    let mut states = states.into_iter();
    let mut pair = || {
        let mut left = states.next().expect("four passes");
        left.absorb(states.next().expect("four passes")).expect("others");
        left
    };
    let (mut left, right) = (pair(), pair());
    let begun = Instant::now();
    left.absorb(right).expect("others");
    begun.elapsed().as_secs_f64()
}

fn main() {
    let number =
        |at: usize, default: f64| std::env::args().nth(at).map_or(default, |text| text.parse().expect("a number"));
    let (pass_seconds, link) = (number(1, 0.1), number(2, 12.5e9));
    let sum = (0..5).map(|_| seconds_a_sum()).fold(f64::MAX, f64::min);
    let bytes = f64::from(FULL[0] * FULL[1]) * 48.0;
    println!(
        "a node of 1080p is {:.1} MB; two are added in {:.1} ms; a pass takes {pass_seconds} s, a link {:.1} GB/s",
        bytes / 1e6,
        sum * 1e3,
        link / 1e9
    );

    let passes = 20_000;
    let mut expected = ProgressState::new(SMALL, 0.1, false);
    (0..passes).for_each(|number| expected.absorb(pass(number)).expect("each once"));
    println!("efficiency for {passes} passes, of all that the devices could do:");
    println!(" devices  equal parts     queue  queue, failures  passes lost");
    for devices in [1, 10, 100, 1000, 10_000] {
        let ideal = f64::from(passes) / (0..devices).map(|device| 1.0 / slowness(device)).sum::<f64>();
        let parts = (0..devices).map(|device| f64::from(passes / devices) * slowness(device)).fold(0.0, f64::max);
        let mut row = Vec::new();
        for fails in [false, true] {
            let mut merged = ProgressState::new(SMALL, 0.1, false);
            let (time, lost) = simulate(devices, passes, fails, &mut merged);
            assert!(merged == expected, "{devices} devices merged something else");
            row.push((ideal / time * 1e2, lost));
        }
        let parts = ideal / parts * 1e2;
        println!("{devices:8} {parts:10.1} % {:7.1} % {:14.1} % {:12}", row[0].0, row[1].0, row[1].1);
    }
    println!(
        "1e12 photons, a million a pass, parts merged by one process or by pairs of processes:\n devices  compute   one process   speed-up   by pairs   speed-up"
    );
    let work = 1e6 * pass_seconds;
    for devices in [1.0f64, 100.0, 1000.0, 3000.0, 10_000.0] {
        let one = (devices - 1.0) * (bytes / link + sum);
        let pairs = devices.log2().ceil() * (bytes / link + sum);
        let compute = work / devices;
        println!(
            "{devices:8} {compute:8.0} s {one:11.1} s {:10.0} {pairs:8.1} s {:10.0}",
            work / (compute + one),
            work / (compute + pairs)
        );
    }
}
