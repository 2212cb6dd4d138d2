//! Brute force: chunks of queries, and the decomposition of its time. And searches that a device ends early.

use caustic_device::Device;
use caustic_photon_map::{Hash, MapError};
use caustic_rivals::{BruteForce, BruteSort, Photons, Technique, k_nearest};
use caustic_tests::compare_neighbours;
use caustic_tests::gpu;
use caustic_tests::maps::{all_within, limits_loops, nearest};
use caustic_tests::points::{PointSet, photons_at, query, sets};

fn named(name: &str, photons: u32) -> PointSet {
    sets(photons).into_iter().find(|set| set.name == name).unwrap()
}

/// Matrices that hold no query (so it gets one), one, a few, one fewer than all, all and more.
#[test]
fn results_do_not_depend_on_how_queries_are_cut_into_chunks() {
    let set = named("of mixed sign", 200);
    let queries = set.queries.len() as u64;
    let column = 4 * set.photons.len() as u64;
    let within = all_within(&set);
    assert!(within.iter().any(|row| row.len() > 7) && within.iter().any(Vec::is_empty));
    for device in [Some(&Device::cpu()), gpu()].into_iter().flatten() {
        let photons = Photons::upload(device, &set.photons).unwrap();
        for sort in [BruteSort::Insertion, BruteSort::Comb] {
            for (matrix, chunks) in [
                (0, queries),
                (column, queries),
                (2 * column - 1, queries),
                (7 * column, queries.div_ceil(7)),
                // More than 32 columns are a multiple of 32.
                (40 * column, queries.div_ceil(32)),
                (1 << 24, 1),
            ] {
                device.reset_stage_times();
                let index = BruteForce::new(&photons, set.radius, sort, Some(matrix)).unwrap();
                let found = k_nearest(device, &index, &set.queries, 7).unwrap();
                let stage = format!("{sort:?}, {matrix} bytes on {}", device.name());
                compare_neighbours(&stage, &nearest(&within, 7), &found).unwrap();
                if !device.is_gpu() {
                    let runs: Vec<_> = device.stage_times().iter().map(|time| u64::from(time.runs)).collect();
                    assert_eq!(runs, [chunks; 3], "{stage}");
                }
            }
        }
    }
}

#[test]
fn stages_have_the_names_of_the_decomposition() {
    let device = Device::cpu();
    let set = named("evenly spread", 100);
    let photons = Photons::upload(&device, &set.photons).unwrap();
    for (sort, name) in [(BruteSort::Insertion, "brute_insertion_sort"), (BruteSort::Comb, "brute_comb_sort")] {
        device.reset_stage_times();
        let index = Technique::Brute { sort }.build(&device, &photons, set.radius).unwrap();
        assert_eq!(index.bytes(), 0, "photons are searched where they lie");
        k_nearest(&device, index.as_ref(), &set.queries, 3).unwrap();
        let stages: Vec<_> = device.stage_times().into_iter().map(|time| time.stage).collect();
        assert_eq!(stages, ["brute_distance", name, "brute_copy"]);
    }
}

/// A column of distances that fall makes insertion sort move all that it keeps for each: more turns than llvmpipe has.
#[test]
fn a_sort_that_a_device_ends_early_is_an_error() {
    let Some(gpu) = gpu() else { return };
    if !limits_loops(gpu) {
        return;
    }
    let points: Vec<_> = (0..600).map(|i| [600.0 - i as f32, 0.0, 0.0]).collect();
    let photons = photons_at(1, &points);
    let photons = Photons::upload(gpu, &photons).unwrap();
    let query = query([0.0; 3]);
    let insertion = BruteForce::new(&photons, 1e3, BruteSort::Insertion, None).unwrap();
    let found = k_nearest(gpu, &insertion, &[query], 300);
    assert!(matches!(found, Err(MapError::CutShort { searches: 1, .. })), "{found:?}");
    let comb = BruteForce::new(&photons, 1e3, BruteSort::Comb, None).unwrap();
    let found = k_nearest(gpu, &comb, &[query], 300).unwrap();
    assert!(found[0].iter().map(|neighbour| neighbour.photon).eq((300..600).rev()));
}

/// Each of 70,000 photons in one point may be the one of the lowest index: a single invocation has to see them all.
#[test]
fn a_search_that_a_device_ends_early_is_an_error() {
    let Some(gpu) = gpu() else { return };
    if !limits_loops(gpu) {
        return;
    }
    let mut points = vec![[0.5; 3]; 70_000];
    points[0] = [0.0; 3];
    let photons = Photons::upload(gpu, &photons_at(1, &points)).unwrap();
    for technique in [
        Technique::Brute { sort: BruteSort::Insertion },
        Technique::Brute { sort: BruteSort::Comb },
        Technique::Jensen,
        Technique::Cells { hash: Hash::Linear },
        Technique::Cells { hash: Hash::Teschner },
    ] {
        let index = technique.build(gpu, &photons, 0.25).unwrap();
        let found = k_nearest(gpu, index.as_ref(), &[query([0.5; 3]), query([0.0; 3])], 1);
        // What is in one workgroup or subgroup with it may be ended, too.
        assert!(matches!(found, Err(MapError::CutShort { .. })), "{technique:?}: {found:?}");
    }
}
