//! How a map is built: every photon once, in its cell, the same on every device.

use caustic_device::{Device, Kernel, LaneOrder, Plan};
use caustic_kernels::layout::{Neighbour, Photon};
use caustic_photon_map::{Gather, Hash, MapOptions, PhotonMap, RadixSort};
use caustic_tests::maps::*;
use caustic_tests::points::{PointSet, photons_at, query, sets, uniform};
use caustic_tests::{assert_same_words, gpu};

/// Everything that construction makes.
struct Built {
    keys: Vec<u32>,
    sorted_keys: Vec<u32>,
    photons: Vec<Photon>,
    order: Vec<u32>,
    starts: Vec<u32>,
    ends: Vec<u32>,
}

fn build(device: &Device, set: &PointSet, hash: Hash) -> Built {
    let map = PhotonMap::build(device, &set.photons, &set.options(hash)).unwrap();
    let (count, table) = (u64::from(map.grid().photons), u64::from(map.grid().table));
    let [photons, order, starts, ends] = map.buffers();
    // The map keeps no keys: the same stages again, for themselves.
    let grid = device.upload("grid", &[*map.grid()]).unwrap();
    let unsorted = device.upload("photons", &set.photons).unwrap();
    let keys = device.buffer::<u32>("keys", count).unwrap();
    let mut plan = Plan::new();
    plan.each(Kernel::HashPhotons, count as u32, &[&grid, &unsorted, &keys]);
    device.run(&plan).unwrap();
    let unsorted_keys = device.read(&keys, count).unwrap();
    let mut plan = Plan::new();
    let sorted = RadixSort::plan(device, &mut plan, &keys, count as u32, 32).unwrap();
    device.run(&plan).unwrap();
    Built {
        keys: unsorted_keys,
        sorted_keys: device.read(&sorted.keys, count).unwrap(),
        photons: device.read(photons, count).unwrap(),
        order: device.read(order, count).unwrap(),
        starts: device.read(starts, table).unwrap(),
        ends: device.read(ends, table).unwrap(),
    }
}

fn assert_same_build(stage: &str, a: &Built, b: &Built) {
    assert_same_words(&format!("{stage}, keys"), &a.keys, &b.keys);
    assert_same_words(&format!("{stage}, sorted keys"), &a.sorted_keys, &b.sorted_keys);
    assert_same_words(&format!("{stage}, order"), &a.order, &b.order);
    assert_same_words(&format!("{stage}, starts"), &a.starts, &b.starts);
    assert_same_words(&format!("{stage}, ends"), &a.ends, &b.ends);
    assert_same_words(&format!("{stage}, photons"), &a.photons, &b.photons);
}

#[test]
fn a_map_holds_every_photon_once_in_the_range_of_its_cell() {
    let cpu = Device::cpu();
    for set in sets(3000) {
        for hash in HASHES {
            let built = build(&cpu, &set, hash);
            let stage = format!("{}, {hash:?}", set.name);
            caustic_tests::compare_sorted(&stage, &built.keys, &built.sorted_keys, &built.order).unwrap();
            let reordered: Vec<_> = built.order.iter().map(|&i| set.photons[i as usize]).collect();
            assert_same_words(&stage, &reordered, &built.photons);
            let mut covered = 0;
            for (entry, (&start, &end)) in (0..).zip(built.starts.iter().zip(&built.ends)) {
                assert!(start <= end, "{stage}: entry {entry} is {start}..{end}");
                assert!(start < end || (start, end) == (0, 0), "{stage}: empty entry {entry} is {start}..{end}");
                let range = start as usize..end as usize;
                assert!(built.sorted_keys[range].iter().all(|&key| key == entry), "{stage}: entry {entry}");
                covered += end - start;
            }
            assert_eq!(covered as usize, set.photons.len(), "{stage}");
        }
    }
}

#[test]
fn the_order_of_lanes_does_not_matter() {
    for set in sets(5000) {
        for hash in HASHES {
            let forward = build(&Device::cpu(), &set, hash);
            for order in [LaneOrder::Reversed, LaneOrder::Shuffled(7)] {
                let other = build(&Device::cpu_with_order(order), &set, hash);
                assert_same_build(&format!("{}, {hash:?}, {order:?}", set.name), &forward, &other);
            }
        }
        let shuffled = Device::cpu_with_order(LaneOrder::Shuffled(8));
        check(&shuffled, &set, &all_within(&set), Hash::Morton, &[Gather::Heap], &[10]);
    }
}

#[test]
fn the_gpu_builds_the_map_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let cpu = Device::cpu();
    for set in sets(5000) {
        for hash in HASHES {
            let stage = format!("{}, {hash:?}", set.name);
            assert_same_build(&stage, &build(&cpu, &set, hash), &build(gpu, &set, hash));
        }
    }
    // Several blocks of the sort and several passes.
    let points = uniform(21, 100_000, [-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]);
    let mut large = sets(1).swap_remove(0);
    (large.name, large.radius, large.photons) = ("100 000 photons", 0.02, photons_at(21, &points));
    for hash in HASHES {
        assert_same_build(large.name, &build(&cpu, &large, hash), &build(gpu, &large, hash));
    }
}

/// More photons than 24 bits count, so that an `f32` used as a counter would stop: all are in the map, and those at its end are
/// found by their indices. A software GPU would take minutes.
#[test]
fn more_photons_than_a_float_can_count() {
    const COUNT: u32 = (1 << 24) + 10_007;
    let photon =
        |i: u32| Photon { position: [(i % 4096) as f32, (i >> 12) as f32, 0.0], power: [1.0; 3], ..Photon::default() };
    let photons: Vec<_> = (0..COUNT).map(photon).collect();
    let options = MapOptions { radius: 1.25, hash: Hash::Teschner, table: None };
    for device in [Some(&Device::cpu()), gpu().filter(|gpu| !limits_loops(gpu))].into_iter().flatten() {
        let map = PhotonMap::build(device, &photons, &options).unwrap();
        let last = photon(COUNT - 1).position;
        let queries = [query([5.0, 0.0, 0.0]), query([7.0, 4096.0, 0.0]), query(last)];
        let found = map.k_nearest(device, &queries, 6, Gather::Heap).unwrap();
        let indices = |row: &[Neighbour]| row.iter().map(|neighbour| neighbour.photon).collect::<Vec<_>>();
        assert_eq!(indices(&found[0]), [5, 4, 6, 4101]);
        assert_eq!(
            indices(&found[1]),
            [(1 << 24) + 7, (1 << 24) - 4089, (1 << 24) + 6, (1 << 24) + 8, (1 << 24) + 4103]
        );
        assert_eq!(indices(&found[2]), [COUNT - 1, COUNT - 4097, COUNT - 2]);
        for gather in GATHERS {
            let counted = map.irradiance(device, &queries, 50, gather).unwrap();
            assert_eq!(counted.iter().map(|estimate| estimate.photons).collect::<Vec<_>>(), [4, 5, 3]);
        }
    }
}
