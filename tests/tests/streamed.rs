//! Photons in chunks: the neighbours and the sums that one map of all has, wherever chunks begin.

use caustic_device::Device;
use caustic_kernels::gather::{CUT_SHORT, GatherParams, density_of, gather_power};
use caustic_kernels::grid::{Grid, Row};
use caustic_kernels::layout::{Arrival, Neighbour, Photon, PowerSum, Query, Site};
use caustic_photon_map::{
    DensityStreamed, Gather, Hash, LargestPower, MapError, MapOptions, NearestStreamed, PhotonMap,
};
use caustic_tests::gpu;
use caustic_tests::points::{photons_at, query, uniform};
use caustic_tests::program::*;
use serde_json::Value;
use tempfile::TempDir;

/// Photons, many of them at the same distance and in all chunks, and queries, one of which finds nothing.
fn photons_and_queries() -> (Vec<Photon>, Vec<Query>) {
    let mut positions = uniform(1, 3000, [0.0; 3], [1.0; 3]);
    positions.extend(std::iter::repeat_n([0.25; 3], 300));
    positions.extend(uniform(2, 700, [0.2; 3], [0.3; 3]));
    let mut queries: Vec<_> = uniform(3, 200, [0.0; 3], [1.0; 3]).into_iter().map(query).collect();
    queries.extend([query([0.25; 3]), query([9.0; 3])]);
    (photons_at(1, &positions), queries)
}

#[test]
fn chunks_have_the_neighbours_of_one_map() {
    let cpu = Device::cpu();
    let (photons, queries) = photons_and_queries();
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

/// The estimates of queries from chunks that come in this order.
fn streamed<'a>(
    device: &Device,
    queries: &[Query],
    largest: LargestPower,
    options: &MapOptions,
    chunks: impl Iterator<Item = &'a [Photon]>,
) -> Vec<[u32; 4]> {
    let mut streamed = DensityStreamed::new(device, queries, largest, options).unwrap();
    chunks.for_each(|chunk| streamed.add(chunk).unwrap());
    bytemuck::cast_vec(streamed.irradiance().unwrap())
}

#[test]
fn chunks_in_any_order_have_the_sums_of_one_map() {
    let cpu = Device::cpu();
    let (photons, mut queries) = photons_and_queries();
    queries[5].active = 0;
    let mut largest = LargestPower::default();
    largest.see(&photons);
    for (hash, radius) in [(Hash::Linear, 0.15), (Hash::Teschner, 0.3), (Hash::Linear, 2.0)] {
        let options = MapOptions { radius, hash, table: None, cell: None };
        let whole = PhotonMap::build(&cpu, &photons, &options).unwrap().density(&cpu, &queries).unwrap();
        assert!(whole.iter().any(|estimate| estimate.photons > 1024) || radius < 2.0);
        let whole: Vec<[u32; 4]> = bytemuck::cast_vec(whole);
        for device in [Some(&cpu), gpu()].into_iter().flatten() {
            let sums = |chunks: &mut dyn Iterator<Item = &[Photon]>| {
                // Only what the iterator gives is borrowed.
                let chunks: Vec<Vec<Photon>> = chunks.map(<[Photon]>::to_vec).collect();
                streamed(device, &queries, largest, &options, chunks.iter().map(Vec::as_slice))
            };
            for size in [photons.len(), 1111, 977, 250] {
                assert!(sums(&mut photons.chunks(size)) == whole, "chunks of {size} on {}", device.name());
                assert!(sums(&mut photons.chunks(size).rev()) == whole, "{size}, reversed, on {}", device.name());
            }
            // A chunk that is missing or comes twice shows.
            assert!(sums(&mut photons.chunks(977).skip(1)) != whole);
            assert!(sums(&mut photons.chunks(977).chain([&photons[..977]])) != whole);
        }
        // So does another scale: of one far above all powers, the lowest bits are cut off.
        let above = LargestPower(largest.0.map(|power| power * 2f32.powi(45)));
        assert!(streamed(&cpu, &queries, above, &options, photons.chunks(977)) != whole);
        // And one that a photon is above is refused.
        let below = LargestPower(largest.0.map(|power| 0.5 * power));
        let mut refused = DensityStreamed::new(&cpu, &queries, below, &options).unwrap();
        let added = photons.chunks(977).try_for_each(|chunk| refused.add(chunk));
        assert!(matches!(added, Err(MapError::AboveLargest { .. })), "{added:?}");
    }
}

#[test]
fn without_photons_it_is_dark() {
    let (cpu, options) = (Device::cpu(), MapOptions { radius: 0.1, hash: Hash::Auto, table: None, cell: None });
    let mut none = DensityStreamed::new(&cpu, &[query([0.0; 3])], LargestPower::default(), &options).unwrap();
    none.add(&[]).unwrap();
    let estimates = none.irradiance().unwrap();
    assert_eq!((estimates[0].rgb, estimates[0].photons), ([0.0; 3], 0));
    let options = MapOptions { radius: -1.0, ..options };
    let refused = DensityStreamed::new(&cpu, &[query([0.0; 3])], LargestPower::default(), &options);
    assert!(matches!(refused.err(), Some(MapError::Radius { .. })));
}

/// The kernel itself, which goes on from a sum of almost as many photons as 32 bits count, each of the largest power there is below the scale's next
/// power of two. 128 bits say what comes of it.
#[test]
fn four_thousand_million_photons_are_no_overflow() {
    let cpu = Device::cpu();
    let power = f32::from_bits(0x3fff_ffff);
    // Three settlings' worth.
    let photons = vec![Photon { power: [power; 3], ..Photon::default() }; 1700];
    let options = MapOptions { radius: 1.0, hash: Hash::Linear, table: None, cell: None };
    let map = PhotonMap::build(&cpu, &photons, &options).unwrap();
    let [grid, rows, sites, begins] = map.search_buffers();
    let grid: Grid = cpu.read(grid, 1).unwrap()[0];
    let rows: Vec<Row> = cpu.read(rows, u64::from(grid.rows)).unwrap();
    let sites: Vec<Site> = cpu.read(sites, 1700).unwrap();
    let begins: Vec<u32> = cpu.read(begins, u64::from(grid.table) + 1).unwrap();
    let arrivals: Vec<Arrival> = cpu.read(map.buffers()[1], 1700).unwrap();
    let params = GatherParams { queries: 1, k: 0, guess: 1.0 };
    // In units of 2^-65: a significand of 24 bits, 42 above the lowest.
    let term = 0x00ff_ffff_u128 << 42;
    let before = u128::from(CUT_SHORT - 1 - 1700);
    let limbs = |sum: u128| {
        [66, 44, 22, 0].map(|place| (sum >> place) as u32 & if place == 66 { u32::MAX } else { 0x003f_ffff })
    };
    let [above, high, middle, low] = limbs(before * term).map(|limb| [limb; 3]);
    let mut sums = [PowerSum { high, middle, low, above, photons: before as u32 }];
    let queries = [query([0.0; 3])];
    gather_power::<true, [PowerSum]>(
        0,
        &params,
        &grid,
        &rows,
        &queries,
        &[0],
        &sites,
        &arrivals,
        &begins,
        &mut sums[..],
    );
    let all = (before + 1700) * term;
    assert_eq!(sums[0].photons, CUT_SHORT - 1);
    assert_eq!([sums[0].above, sums[0].high, sums[0].middle, sums[0].low], limbs(all).map(|limb| [limb; 3]));
    let estimate = density_of(&sums[0], 1.0, &[power.to_bits(); 3]);
    let exact = (all as f32 * 2f32.powi(-65)) / std::f32::consts::PI;
    assert_eq!(estimate.rgb, [exact; 3]);
    assert_eq!(estimate.photons, CUT_SHORT - 1);
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

/// What the program says of a map, after it found brute force's results.
fn told(folder: &TempDir, photons: &str, more: &[&str]) -> Value {
    let map = ["map", "--photons", photons, "--queries", "2000", "--k", "20", "--device", "cpu", "--json"];
    let told = json(&succeeds(folder, &[&map[..], more].concat()).stdout);
    assert_eq!(told["queries_that_differ_from_brute_force"].as_u64(), Some(0));
    assert!(told["checked_queries"].as_u64() >= Some(8));
    told
}

#[test]
fn the_density_of_chunks_is_that_of_one_map() {
    let folder = folder();
    let density = |more: &[&str]| told(&folder, "clustered:600000", &[&["--estimate", "density"], more].concat());
    let whole = density(&["--repeat", "1"]);
    let chunks = density(&["--memory", "450MB"]);
    assert!(chunks["chunks"].as_u64() > Some(1) && chunks["peak_bytes"].as_u64() <= Some(450_000_000), "{chunks}");
    assert!(whole["irradiance_sha256"].is_string());
    assert_eq!(whole["irradiance_sha256"], chunks["irradiance_sha256"]);
    // It is the photons that are hashed: another radius finds others.
    let wider = density(&["--memory", "450MB", "--radius", "0.02"]);
    assert_ne!(whole["irradiance_sha256"], wider["irradiance_sha256"]);
}

#[test]
fn a_saved_map_is_searched_in_chunks() {
    let folder = folder();
    let photons = ["photons", "cornell", "-o", "a.caustic", "--device", "cpu", "--quiet"];
    succeeds(&folder, &[&photons[..], &["--photons", "150000", "--caustic-photons", "50000"]].concat());
    let density = |more: &[&str]| told(&folder, "a.caustic", &[&["--estimate", "density"], more].concat());
    let (whole, chunks) = (density(&["--repeat", "1"]), density(&["--memory", "440MB"]));
    assert!(chunks["chunks"].as_u64() > Some(1), "{chunks}");
    for same in ["photons", "radius", "irradiance_sha256"] {
        assert_eq!(whole[same], chunks[same]);
    }
    assert!(told(&folder, "a.caustic", &["--memory", "440MB"])["chunks"].as_u64() > Some(1));

    let path = folder.path().join("a.caustic");
    let bytes = std::fs::read(&path).expect("a file");
    let with = |bytes: &[u8], words: &[&str]| {
        std::fs::write(&path, bytes).expect("a file");
        refused(&folder, &["map", "--photons", "a.caustic", "--memory", "440MB"], words);
    };
    with(&bytes[..bytes.len() / 2], &["a.caustic", "damaged", "bytes and not", "copy it again"]);
    with(&bytes[..12], &["a.caustic", "damaged", "it ends early"]);
    with(b"no photons", &["a.caustic", "is not a photon map", "caustic photons"]);
    let mut changed = bytes.clone();
    changed[bytes.len() / 2] ^= 1;
    with(&changed, &["a.caustic", "damaged", "checksum"]);
    refused(&folder, &["map", "--photons", "none.caustic", "--memory", "440MB"], &["none.caustic", "cannot read"]);
}
