//! The photon map: every neighbour set and every estimate against brute force, and CPU against GPU bit for bit.

use caustic_device::Device;
use caustic_kernels::gather::distance2;
use caustic_kernels::grid::{cell_of, coordinates, gap};
use caustic_photon_map::{Gather, Hash, MAX_K, MapError, MapOptions, PhotonMap, plan_grid};
use caustic_tests::maps::*;
use caustic_tests::points::{photons_at, query, sets, uniform, unit3};
use caustic_tests::{compare_irradiance, compare_neighbours, gpu, oracle_irradiance, oracle_within};
use proptest::prelude::*;

/// Around every compiled capacity (17, 65, 257, 1025), one of which an estimate uses for itself, and the thesis's 50.
const KS: [u32; 11] = [1, 2, 10, 16, 17, 50, 64, 65, 100, 500, 1024];

#[test]
fn neighbours_and_estimates_are_those_of_brute_force() {
    let cpu = Device::cpu();
    let mut longest = 0;
    for set in sets(2000) {
        let within = all_within(&set);
        longest = longest.max(within.iter().map(Vec::len).max().unwrap_or(0));
        for hash in HASHES {
            check(&cpu, &set, &within, hash, &GATHERS, &KS);
        }
    }
    assert!(longest > 1025, "no query fills the largest container: {longest} photons at most");
}

#[test]
fn the_gpu_finds_the_neighbours_and_estimates_of_brute_force() {
    let Some(gpu) = gpu() else { return };
    if !limits_loops(gpu) {
        for set in sets(2000) {
            let within = all_within(&set);
            for hash in HASHES {
                check(gpu, &set, &within, hash, &GATHERS, &KS);
            }
        }
        return;
    }
    for (i, set) in sets(200).into_iter().enumerate() {
        let within = all_within(&set);
        // Every set with every hash and every gather; sizes in turns.
        for (j, hash) in HASHES.into_iter().enumerate() {
            check(gpu, &set, &within, hash, &GATHERS, &[[1, 50], [10, 64], [2, 16]][(i + j) % 3]);
        }
    }
}

/// The larger containers, filled, within what llvmpipe can do: a heap makes 2·log₂ k steps a photon, a list k / 2.
#[test]
fn the_gpu_fills_its_larger_containers() {
    let Some(gpu) = gpu() else { return };
    let runs = [(1200, Gather::Heap, [65, 255, 1024]), (300, Gather::List, [65, 255, 270])];
    for (n, gather, ks) in runs {
        let mut set = sets(n).into_iter().find(|set| set.name == "all in one cell").unwrap();
        set.queries.truncate(16);
        let within = all_within(&set);
        assert!(within.iter().any(|row| row.len() > ks[ks.len() - 1] as usize), "the containers are not filled");
        check(gpu, &set, &within, Hash::Teschner, &[gather], &ks);
    }
}

/// More candidates than 16 bits count, the nearest of them last: a search that ends early finds others. Where llvmpipe ends one, that is
/// an error.
#[test]
fn a_crowded_cell_is_searched_to_its_end_or_it_is_an_error() {
    let points: Vec<_> = (0..70_000u32).rev().map(|i| [i as f32 * 1e-5, 0.0, 0.0]).collect();
    let photons = photons_at(3, &points);
    let options = MapOptions { radius: 1.0, hash: Hash::Linear, table: None, cell: Some(1.0) };
    let queries = [query([0.0; 3])];
    let within = oracle_within(&photons, [0.0; 3], 1.0);
    let neighbours = vec![within[..3].to_vec()];
    let estimate = [oracle_irradiance(&photons, &within, 3, 1.0)];
    for device in [Some(&Device::cpu()), gpu()].into_iter().flatten() {
        let map = PhotonMap::build(device, &photons, &options).unwrap();
        for gather in GATHERS {
            let stage = format!("{}, {gather:?}", device.name());
            let (found, estimated) =
                (map.k_nearest(device, &queries, 3, gather), map.irradiance(device, &queries, 3, gather));
            let cut = |error: MapError| {
                assert!(limits_loops(device), "{stage}: {error}");
                assert!(matches!(error, MapError::CutShort { searches: 1, .. }), "{stage}: {error}");
            };
            match found {
                Ok(found) => drop(compare_neighbours(&stage, &neighbours, &found).unwrap()),
                Err(error) => cut(error),
            }
            match estimated {
                Ok(estimated) => drop(compare_irradiance(&stage, &estimate, &estimated).unwrap()),
                Err(error) => cut(error),
            }
        }
    }
}

#[test]
fn queries_reach_photons_across_cells_that_share_a_table_entry() {
    // What the set "colliding" is for: without the check of cells a photon would be found once for each such cell.
    for set in sets(2000).iter().filter(|set| set.table == Some(1)) {
        let map = PhotonMap::build(&Device::cpu(), &set.photons, &set.options(Hash::Teschner)).unwrap();
        assert_eq!(map.grid().table, 1);
        let found = map.k_nearest(&Device::cpu(), &set.queries, 1024, Gather::Heap).unwrap();
        assert!(found.iter().any(|row| row.len() > 20), "queries find too few photons for this to show anything");
        for row in found {
            let mut photons: Vec<_> = row.iter().map(|neighbour| neighbour.photon).collect();
            photons.sort_unstable();
            photons.dedup();
            assert_eq!(photons.len(), row.len(), "a photon was found twice");
        }
    }
}

/// Cells are left out of a search by this bound: were it ever too large, photons would be lost.
#[test]
fn no_photon_is_nearer_than_the_gap_to_its_cell() {
    for set in sets(500) {
        let (low, high) = set.bounds();
        for cell in [0.3, 1.0] {
            let options = MapOptions { cell: Some(cell * set.radius), ..set.options(Hash::Teschner) };
            let grid = plan_grid(low, high, set.photons.len() as u64, &[], &options).unwrap();
            let mut bounded = 0;
            for query in &set.queries {
                let c = coordinates(&grid, query.position);
                for photon in &set.photons {
                    let cell = cell_of(&grid, photon.position);
                    let gaps: [f32; 3] = std::array::from_fn(|axis| gap(&grid, c[axis], cell[axis]));
                    let bound: f32 = gaps.map(|gap| gap * gap).iter().sum();
                    let d2 = distance2(query.position, photon.position);
                    assert!(bound <= d2, "{}: {bound:e} > {d2:e}, {query:?}, {photon:?}", set.name);
                    bounded += u32::from(bound > 0.0);
                }
            }
            // Sets of one cell have no neighbouring cells.
            let several = grid.cells.iter().any(|&cells| cells > 2);
            assert!(bounded > 0 || !several || set.photons.len() < 2, "{}: no bound was put to the test", set.name);
        }
    }
}

#[test]
fn more_neighbours_than_photons_gives_all_of_them() {
    let cpu = Device::cpu();
    let photons = photons_at(1, &uniform(1, 7, [0.0; 3], [1.0; 3]));
    for hash in HASHES {
        let map = PhotonMap::build(&cpu, &photons, &MapOptions { radius: 4.0, hash, table: None, cell: None }).unwrap();
        for gather in GATHERS {
            let found = map.k_nearest(&cpu, &[query([0.5; 3])], MAX_K, gather).unwrap();
            let mut indices: Vec<_> = found[0].iter().map(|neighbour| neighbour.photon).collect();
            indices.sort_unstable();
            assert_eq!(indices, [0, 1, 2, 3, 4, 5, 6]);
            let estimate = map.irradiance(&cpu, &[query([0.5; 3])], MAX_K, gather).unwrap();
            assert_eq!(estimate[0].photons, 7);
        }
    }
}

#[test]
fn no_queries_give_no_results() {
    for device in [Some(&Device::cpu()), gpu()].into_iter().flatten() {
        let photons = photons_at(1, &[[0.0; 3]]);
        let options = MapOptions { radius: 1.0, hash: Hash::Linear, table: None, cell: None };
        let map = PhotonMap::build(device, &photons, &options).unwrap();
        assert!(map.k_nearest(device, &[], 5, Gather::Heap).unwrap().is_empty());
        assert!(map.irradiance(device, &[], 5, Gather::Heap).unwrap().is_empty());
    }
}

#[test]
fn tables_of_any_power_of_two_give_the_same_bits() {
    let cpu = Device::cpu();
    for name in ["of mixed sign", "on cell borders", "clustered"] {
        let mut set = sets(1000).into_iter().find(|set| set.name == name).unwrap();
        let within = all_within(&set);
        for table in [1, 2, 4, 1024, 1 << 20] {
            set.table = Some(table);
            for hash in [Hash::Teschner, Hash::Morton] {
                check(&cpu, &set, &within, hash, &[Gather::Heap], &[10]);
            }
        }
    }
    // The largest table is a gibibyte, which not every GPU has or allows in a buffer.
    let mut set = sets(1000).into_iter().find(|set| set.name == "clustered").unwrap();
    set.table = Some(1 << 27);
    let within = all_within(&set);
    for device in [Some(&cpu), gpu()].into_iter().flatten() {
        match PhotonMap::build(device, &set.photons, &set.options(Hash::Teschner)) {
            Ok(_) => check(device, &set, &within, Hash::Teschner, &[Gather::Histogram], &[10]),
            Err(error) => assert!(error.to_string().contains("map: cell"), "{error}"),
        }
    }
    set.table = Some(1 << 28);
    let error = PhotonMap::build(&cpu, &set.photons, &set.options(Hash::Teschner)).err().unwrap();
    assert!(matches!(error, MapError::TableSize { .. }), "{error}");
}

proptest! {
    // 200 cases a run: under a second. Failures are printed with their seed; nothing is written to the source folder.
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_map_finds_what_brute_force_finds(
        seed in any::<u32>(),
        count in 0u32..400,
        centre in prop::array::uniform3(-50f32..50.0),
        scale in -3i32..4,
        relative_size in prop::array::uniform3(0f32..1.0),
        relative_radius in 0.01f32..1.5,
        quantised in any::<bool>(),
        hash in prop::sample::select(&HASHES[..]),
        gather in prop::sample::select(&GATHERS[..]),
        table_bits in prop::option::of(0u32..12),
        cell in prop::option::of(0.02f32..3.0),
        k in 1u32..=MAX_K,
    ) {
        let size = 10f32.powi(scale);
        let high = std::array::from_fn(|axis| centre[axis] + size * relative_size[axis]);
        let mut points = uniform(seed, count, centre, high);
        if quantised {
            // Onto eighths of the size: duplicates, ties and borders.
            points.iter_mut().flatten().for_each(|x| *x = (*x * 8.0 / size).round() * size / 8.0);
        }
        let photons = photons_at(seed, &points);
        let radius = relative_radius * size;
        let options = MapOptions { radius, hash, table: table_bits.map(|bits| 1 << bits), cell: cell.map(|cell| cell * radius) };
        let cpu = Device::cpu();
        let map = PhotonMap::build(&cpu, &photons, &options).unwrap();
        let mut queries: Vec<_> = points.iter().step_by(29).map(|&point| query(point)).collect();
        queries.extend((0..8).map(|i| {
            let unit = unit3(!seed, i);
            query(std::array::from_fn(|axis| centre[axis] + size * (3.0 * unit[axis] - 1.0)))
        }));
        let within: Vec<_> = queries.iter().map(|q| oracle_within(&photons, q.position, radius)).collect();
        let found = map.k_nearest(&cpu, &queries, k, gather).unwrap();
        compare_neighbours("neighbours", &nearest(&within, k), &found).map_err(TestCaseError::fail)?;
        let expected: Vec<_> =
            within.iter().map(|row| oracle_irradiance(&photons, row, k as usize, radius)).collect();
        let found = map.irradiance(&cpu, &queries, k, gather).unwrap();
        compare_irradiance("irradiance", &expected, &found).map_err(TestCaseError::fail)?;
    }
}
