//! How a map is built: every photon once, in its cell, the same on every device.

use caustic_device::{Device, Kernel, LaneOrder, Plan};
use caustic_kernels::grid::GRID_BLOCK;
use caustic_kernels::layout::{Arrival, Neighbour, Photon, Site};
use caustic_kernels::num::Limbs;
use caustic_photon_map::{Gather, Hash, MapOptions, PhotonMap, RadixSort};
use caustic_tests::maps::*;
use caustic_tests::points::{PointSet, photons_at, query, sets, uniform};
use caustic_tests::{assert_same_words, gpu};

/// Everything that construction makes.
struct Built {
    keys: Vec<u32>,
    sorted_keys: Vec<u32>,
    order: Vec<u32>,
    sites: Vec<Site>,
    arrivals: Vec<Arrival>,
    begins: Vec<u32>,
}

fn build(device: &Device, set: &PointSet, hash: Hash) -> Built {
    let map = PhotonMap::build(device, &set.photons, &set.options(hash)).unwrap();
    let (count, table) = (u64::from(map.grid().photons), u64::from(map.grid().table));
    let [sites, arrivals, begins] = map.buffers();
    // The map keeps no keys: the same stages again, for themselves.
    let grid = device.upload("grid", &[*map.grid()]).unwrap();
    let unsorted = device.upload("photons", &set.photons).unwrap();
    let keys = device.buffer::<u32>("keys", count).unwrap();
    let mut plan = Plan::new();
    let blocks = (count as u32).div_ceil(GRID_BLOCK);
    let powers = device.buffer::<u32>("powers", 3 * u64::from(blocks)).unwrap();
    plan.groups(Kernel::HashPhotons, blocks, &[&grid, &unsorted, &keys, &powers]);
    device.run(&plan).unwrap();
    let unsorted_keys = device.read(&keys, count).unwrap();
    let mut plan = Plan::new();
    let sorted = RadixSort::plan(device, &mut plan, &keys, count as u32, 32).unwrap();
    device.run(&plan).unwrap();
    Built {
        keys: unsorted_keys,
        sorted_keys: device.read(&sorted.keys, count).unwrap(),
        order: device.read(&sorted.order, count).unwrap(),
        sites: device.read(sites, count).unwrap(),
        arrivals: device.read(arrivals, count).unwrap(),
        begins: device.read(begins, table + 1).unwrap(),
    }
}

fn assert_same_build(stage: &str, a: &Built, b: &Built) {
    assert_same_words(&format!("{stage}, keys"), &a.keys, &b.keys);
    assert_same_words(&format!("{stage}, sorted keys"), &a.sorted_keys, &b.sorted_keys);
    assert_same_words(&format!("{stage}, order"), &a.order, &b.order);
    assert_same_words(&format!("{stage}, begins"), &a.begins, &b.begins);
    assert_same_words(&format!("{stage}, sites"), &a.sites, &b.sites);
    assert_same_words(&format!("{stage}, arrivals"), &a.arrivals, &b.arrivals);
}

#[test]
fn a_map_holds_every_photon_once_in_the_range_of_its_cell() {
    let cpu = Device::cpu();
    for set in sets(3000) {
        for hash in HASHES {
            let built = build(&cpu, &set, hash);
            let stage = format!("{}, {hash:?}", set.name);
            caustic_tests::compare_sorted(&stage, &built.keys, &built.sorted_keys, &built.order).unwrap();
            let scale = |channel: usize| set.photons.iter().map(|photon| photon.power[channel]).fold(0.0, f32::max);
            for (&i, (site, arrival)) in built.order.iter().zip(built.sites.iter().zip(&built.arrivals)) {
                let photon = set.photons[i as usize];
                assert_eq!(*site, Site::new(photon.position, i));
                let limbs = |channel: usize| Limbs::of(photon.power[channel], scale(channel)).0;
                let [red, green, blue] = [0, 1, 2].map(limbs);
                assert_eq!(*arrival, Arrival::new(red, green, blue, photon.direction, photon.primitive));
            }
            let mut covered = 0;
            for (entry, ends) in (0..).zip(built.begins.windows(2)) {
                let range = ends[0] as usize..ends[1] as usize;
                assert!(built.sorted_keys[range.clone()].iter().all(|&key| key == entry), "{stage}: entry {entry}");
                covered += range.len();
            }
            assert_eq!(covered, set.photons.len(), "{stage}");
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
    let options = MapOptions { radius: 1.25, hash: Hash::Teschner, table: None, cell: None };
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
