//! What makes no map, and no search of one.

use caustic_device::Device;
use caustic_photon_map::{Gather, Hash, MAX_K, MapError, MapOptions, PhotonMap};
use caustic_tests::maps::GATHERS;
use caustic_tests::points::{photons_at, query, uniform};

#[test]
fn positions_that_are_no_numbers_are_counted_and_the_first_is_named() {
    let cpu = Device::cpu();
    let mut photons = photons_at(1, &uniform(1, 100, [0.0; 3], [1.0; 3]));
    let options = MapOptions { radius: 0.1, hash: Hash::Linear, table: None, cell: None };
    let map = PhotonMap::build(&cpu, &photons, &options).unwrap();
    photons[40].position[0] = f32::NAN;
    photons[41].position[1] = f32::INFINITY;
    photons[99].position[2] = f32::NEG_INFINITY;
    let error = PhotonMap::build(&cpu, &photons, &options).err().unwrap();
    assert!(matches!(error, MapError::NotFinite { what: "photons", count: 3, first: 40 }), "{error}");
    let text = error.to_string();
    assert!(text.contains("3 of the photons") && text.contains("index 40"), "{text}");
    for bad in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let queries = [query([0.0; 3]), query([0.0, bad, 0.0]), query([bad; 3])];
        let error = map.k_nearest(&cpu, &queries, 1, Gather::Heap).unwrap_err();
        assert!(matches!(error, MapError::NotFinite { what: "queries", count: 2, first: 1 }), "{error}");
        let error = map.irradiance(&cpu, &queries, 1, Gather::List).unwrap_err();
        assert!(matches!(error, MapError::NotFinite { what: "queries", count: 2, first: 1 }), "{error}");
    }
}

#[test]
fn impossible_numbers_of_neighbours_are_refused_with_the_bounds() {
    let cpu = Device::cpu();
    let options = MapOptions { radius: 0.1, hash: Hash::Linear, table: None, cell: None };
    let map = PhotonMap::build(&cpu, &photons_at(1, &[[0.0; 3]]), &options).unwrap();
    for k in [0, MAX_K + 1, 100_000_000, u32::MAX] {
        for gather in GATHERS {
            for error in [
                map.k_nearest(&cpu, &[query([0.0; 3])], k, gather).unwrap_err(),
                map.irradiance(&cpu, &[query([0.0; 3])], k, gather).unwrap_err(),
            ] {
                assert!(matches!(error, MapError::K { .. }), "{error}");
                assert_eq!(error.to_string(), format!("k is {k} but must be 1 to {MAX_K}"));
            }
        }
    }
    for k in [1, MAX_K] {
        assert_eq!(map.k_nearest(&cpu, &[query([0.0; 3])], k, Gather::Heap).unwrap()[0].len(), 1);
        assert_eq!(map.irradiance(&cpu, &[query([0.0; 3])], k, Gather::Heap).unwrap()[0].photons, 1);
    }
}

#[test]
fn options_that_make_no_map_are_refused() {
    let cpu = Device::cpu();
    let photons = photons_at(1, &[[0.0; 3], [100.0; 3]]);
    let build =
        |radius, hash, table| PhotonMap::build(&cpu, &photons, &MapOptions { radius, hash, table, cell: None }).err();
    for radius in [0.0, -0.0, -1.0, 1e-30, 1e30, f32::NAN, f32::INFINITY] {
        assert!(matches!(build(radius, Hash::Linear, None), Some(MapError::Radius { .. })), "{radius}");
    }
    // However small, a radius only makes cells as small as they can be.
    assert!(build(1e-9, Hash::Linear, None).is_none() && build(1e-9, Hash::Teschner, None).is_none());
    for table in [0, 3, 1000, 1 << 28] {
        assert!(matches!(build(1.0, Hash::Morton, Some(table)), Some(MapError::TableSize { .. })), "{table}");
    }
    assert!(build(1e-2, Hash::Teschner, Some(1)).is_none());
    // The box of these would have an infinite side.
    let photons = photons_at(1, &[[f32::MIN; 3], [f32::MAX; 3]]);
    let options = MapOptions { radius: 1e18, hash: Hash::Teschner, table: None, cell: None };
    assert!(matches!(PhotonMap::build(&cpu, &photons, &options).err(), Some(MapError::Extent { .. })));
}
