//! Every technique on every device: the neighbours of brute force on the host, in their order, and the estimates made of them.

use caustic_device::{Device, LaneOrder};
use caustic_kernels::layout::{Neighbour, Query};
use caustic_photon_map::MapError;
use caustic_rivals::{Photons, Technique, irradiance, k_nearest};
use caustic_tests::maps::{all_within, estimates, limits_loops, nearest};
use caustic_tests::points::{PointSet, sets};
use caustic_tests::{compare_irradiance, compare_neighbours, gpu};

/// Holds a technique against the oracle, on one set of points.
fn check(device: &Device, technique: Technique, set: &PointSet, within: &[Vec<Neighbour>], ks: &[u32]) {
    let photons = Photons::upload(device, &set.photons).unwrap();
    let index = technique.build(device, &photons, set.radius).unwrap();
    let index = index.as_ref();
    for &k in ks {
        let stage = format!("{}, {technique:?} on {}, k = {k}", set.name, device.name());
        let failed = |error: MapError| -> ! { panic!("{stage}: {error}") };
        let found = k_nearest(device, index, &set.queries, k).unwrap_or_else(|error| failed(error));
        compare_neighbours(&stage, &nearest(within, k), &found).unwrap();
        let found =
            irradiance(device, index, &photons, set.radius, &set.queries, k).unwrap_or_else(|error| failed(error));
        compare_irradiance(&stage, &estimates(set, within, k), &found).unwrap();
    }
}

/// Every technique that a device can run, on every set.
fn check_all(device: &Device, photons: u32, ks: &[u32]) {
    for set in sets(photons) {
        let within = all_within(&set);
        for technique in Technique::ALL.iter().filter(|technique| technique.runs_on(device)) {
            check(device, *technique, &set, &within, ks);
        }
    }
}

#[test]
fn every_technique_finds_what_brute_force_finds() {
    check_all(&Device::cpu(), 600, &[1, 10, 50, 257, 500]);
}

/// Shared memory full of rubbish, and lanes in another order.
#[test]
fn the_order_of_lanes_does_not_show() {
    for order in [LaneOrder::Reversed, LaneOrder::Shuffled(1)] {
        check_all(&Device::cpu_with_order(order), 150, &[7, 70]);
    }
}

#[test]
fn every_technique_finds_it_on_the_gpu_too() {
    let Some(gpu) = gpu() else { return };
    if limits_loops(gpu) { check_all(gpu, 150, &[1, 20, 64]) } else { check_all(gpu, 600, &[1, 10, 50, 257, 500]) }
}

#[test]
fn no_photons_and_no_queries_are_no_error() {
    for device in [Some(&Device::cpu()), gpu()].into_iter().flatten() {
        for technique in Technique::ALL.iter().filter(|technique| technique.runs_on(device)) {
            let none = Photons::upload(device, &[]).unwrap();
            let index = technique.build(device, &none, 0.5).unwrap();
            let query = Query { position: [0.0; 3], active: 1 };
            assert_eq!(k_nearest(device, index.as_ref(), &[query; 3], 4).unwrap(), vec![vec![]; 3], "{technique:?}");
            let some = sets(100).remove(0);
            let photons = Photons::upload(device, &some.photons).unwrap();
            let index = technique.build(device, &photons, some.radius).unwrap();
            assert!(k_nearest(device, index.as_ref(), &[], 4).unwrap().is_empty(), "{technique:?}");
        }
    }
}

#[test]
fn k_out_of_range_is_refused_with_the_range() {
    let cpu = Device::cpu();
    let set = sets(100).remove(0);
    let photons = Photons::upload(&cpu, &set.photons).unwrap();
    for technique in Technique::ALL.iter().filter(|technique| technique.runs_on(&cpu)) {
        let index = technique.build(&cpu, &photons, set.radius).unwrap();
        for k in [0, 1025, 5000] {
            let refused = k_nearest(&cpu, index.as_ref(), &set.queries, k);
            assert!(matches!(refused, Err(MapError::K { max: 1024, .. })), "{technique:?}, k = {k}");
        }
    }
}
