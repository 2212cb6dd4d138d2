//! Photons in chunks: the neighbours that one map of all has, wherever chunks begin.

use caustic_device::Device;
use caustic_kernels::layout::Neighbour;
use caustic_photon_map::{Gather, Hash, MapError, MapOptions, NearestStreamed, PhotonMap};
use caustic_tests::gpu;
use caustic_tests::points::{photons_at, query, uniform};
use caustic_tests::program::*;

#[test]
fn chunks_have_the_neighbours_of_one_map() {
    let cpu = Device::cpu();
    let mut positions = uniform(1, 3000, [0.0; 3], [1.0; 3]);
    // Many at the same distance, in all chunks: the lowest indices count.
    positions.extend(std::iter::repeat_n([0.25; 3], 300));
    positions.extend(uniform(2, 700, [0.2; 3], [0.3; 3]));
    let photons = photons_at(1, &positions);
    let mut queries: Vec<_> = uniform(3, 200, [0.0; 3], [1.0; 3]).into_iter().map(query).collect();
    queries.extend([query([0.25; 3]), query([9.0; 3])]);
    let options = MapOptions { radius: 0.15, hash: Hash::Linear, table: None, cell: None };
    for k in [1, 20, 400] {
        let whole = PhotonMap::build(&cpu, &photons, &options).unwrap();
        let expected = whole.k_nearest(&cpu, &queries, k, Gather::Auto).unwrap();
        for device in [Some(&cpu), gpu()].into_iter().flatten() {
            for size in [photons.len(), 1111, 977, 250] {
                let mut streamed = NearestStreamed::new(device, &queries, k, Gather::Auto, &options).unwrap();
                photons.chunks(size).for_each(|chunk| streamed.add(chunk).unwrap());
                let found: Vec<&[Neighbour]> = (0..queries.len()).map(|q| streamed.neighbours(q)).collect();
                assert!(found == expected, "k = {k}, chunks of {size} on {}", device.name());
            }
        }
        // Chunks in another order have other indices, so that this could have failed.
        let mut turned = NearestStreamed::new(&cpu, &queries, k, Gather::Auto, &options).unwrap();
        photons.chunks(1111).rev().for_each(|chunk| turned.add(chunk).unwrap());
        assert!((0..queries.len()).any(|q| turned.neighbours(q) != expected[q]));
    }
    assert!(matches!(NearestStreamed::new(&cpu, &queries, 0, Gather::Auto, &options).err(), Some(MapError::K { .. })));
}

#[test]
fn a_map_of_chunks_stays_within_its_memory() {
    let folder = folder();
    let map = ["map", "--photons", "uniform:3000000", "--queries", "1000", "--k", "20", "--device", "cpu", "--memory"];
    let told = json(&succeeds(&folder, &[&map[..], &["700MB", "--json"]].concat()).stdout);
    assert_eq!(
        (told["queries_that_differ_from_brute_force"].as_u64(), told["checked_queries"].as_u64()),
        (Some(0), Some(8))
    );
    let number = |name: &str| told[name].as_u64().expect(name);
    println!(
        "{} chunks, {} bytes predicted, {} at the most",
        number("chunks"),
        number("predicted_bytes"),
        number("peak_bytes")
    );
    assert!(number("chunks") > 1 && number("peak_bytes") <= 700_000_000);
    refused(&folder, &[&map[..], &["10MB"]].concat(), &["--memory", "too little", "give at least"]);
    refused(&folder, &[&map[..], &["10"]].concat(), &["--memory", "512MB or 2GiB"]);
    std::fs::write(folder.path().join("points.txt"), "0 0 0").expect("a file");
    refused(&folder, &["map", "--photons", "points.txt", "--memory", "1GB"], &["--memory", "synthetic"]);
}
