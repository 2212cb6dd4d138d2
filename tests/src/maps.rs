//! Searching maps in every way, and holding what is found against brute force.

use crate::points::PointSet;
use crate::{compare_irradiance, compare_neighbours, oracle_irradiance, oracle_within};
use caustic_device::Device;
use caustic_kernels::layout::{Irradiance, Neighbour, Query};
use caustic_photon_map::{Gather, Hash, PhotonMap};

/// Every hash.
pub const HASHES: [Hash; 3] = [Hash::Linear, Hash::Teschner, Hash::Morton];

/// Every way to find the nearest.
pub const GATHERS: [Gather; 3] = [Gather::Histogram, Gather::Heap, Gather::List];

/// What brute force finds within the radius of each query of a set.
pub fn all_within(set: &PointSet) -> Vec<Vec<Neighbour>> {
    let within = |query: &Query| {
        if query.active == 0 { Vec::new() } else { oracle_within(&set.photons, query.position, set.radius) }
    };
    set.queries.iter().map(within).collect()
}

/// The `k` nearest of what was found.
pub fn nearest(within: &[Vec<Neighbour>], k: u32) -> Vec<Vec<Neighbour>> {
    within.iter().map(|row| row[..row.len().min(k as usize)].to_vec()).collect()
}

/// The estimates from `k` photons of what was found.
pub fn estimates(set: &PointSet, within: &[Vec<Neighbour>], k: u32) -> Vec<Irradiance> {
    let estimate = |(query, row): (&Query, &Vec<Neighbour>)| {
        if query.active == 0 {
            Irradiance::default()
        } else {
            oracle_irradiance(&set.photons, row, k as usize, set.radius)
        }
    };
    set.queries.iter().zip(within).map(estimate).collect()
}

/// Compares neighbours and estimates on a device with the oracle's. Since every combination is held against the same
/// oracle bit for bit, hashes, containers, table sizes and devices agree with each other, too.
pub fn check(device: &Device, set: &PointSet, within: &[Vec<Neighbour>], hash: Hash, gathers: &[Gather], ks: &[u32]) {
    let map = PhotonMap::build(device, &set.photons, &set.options(hash)).unwrap();
    for &gather in gathers {
        for &k in ks {
            let stage = format!("{}, table {:?}, {hash:?}, {gather:?}, k = {k}", set.name, set.table);
            let found =
                map.k_nearest(device, &set.queries, k, gather).unwrap_or_else(|error| panic!("{stage}: {error}"));
            compare_neighbours(&stage, &nearest(within, k), &found).unwrap();
            let found =
                map.irradiance(device, &set.queries, k, gather).unwrap_or_else(|error| panic!("{stage}: {error}"));
            let compared = compare_irradiance(&stage, &estimates(set, within, k), &found).unwrap();
            assert_eq!(compared, 4 * set.queries.len());
        }
    }
}

/// llvmpipe ends all loops of an invocation, without a word, once they have run 65 535 times together
/// (`LP_MAX_TGSI_LOOP_ITERATIONS` in Mesa's `lp_bld_limits.h`), and does a thousandth of a GPU's work in its time.
pub fn limits_loops(device: &Device) -> bool {
    device.name().contains("llvmpipe")
}
