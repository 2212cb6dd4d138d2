//! How good an estimate is: against sums in double precision, and without bias.

use caustic_device::Device;
use caustic_kernels::layout::Neighbour;
use caustic_photon_map::{Gather, Hash, MapOptions, PhotonMap};
use caustic_tests::maps::{HASHES, all_within};
use caustic_tests::points::{photons_at, query, sets, uniform};

/// The sum is rounded once and cut off by 1024·2⁻⁵³ at most; π in f32, its product with r² and the quotient are rounded once
/// each. That makes four relative errors of 2⁻²⁴, and a fifth leaves ample room for what they multiply to.
#[test]
fn estimates_are_close_to_sums_in_double_precision() {
    let cpu = Device::cpu();
    let mut worst = 0f64;
    for set in sets(2000).iter().filter(|set| ["evenly spread", "clustered", "on a plane"].contains(&set.name)) {
        let map = PhotonMap::build(&cpu, &set.photons, &set.options(Hash::Morton)).unwrap();
        let within = all_within(set);
        for k in [1, 10, 50, 500] {
            let found = map.irradiance(&cpu, &set.queries, k, Gather::Heap).unwrap();
            for (row, estimate) in within.iter().zip(found).filter(|(row, _)| !row.is_empty()) {
                let counted = row.len().min(k as usize);
                let radius2 = row.get(k as usize).map_or(set.radius * set.radius, |next| next.distance2);
                for channel in 0..3 {
                    let power = |n: &Neighbour| f64::from(set.photons[n.photon as usize].power[channel]);
                    let exact =
                        row[..counted].iter().map(power).sum::<f64>() / (std::f64::consts::PI * f64::from(radius2));
                    let error = (f64::from(estimate.rgb[channel]) / exact - 1.0).abs();
                    assert!(error <= 5.0 * 2f64.powi(-24), "{}: k = {k}: {error:e}", set.name);
                    worst = worst.max(error);
                }
            }
        }
    }
    assert!(worst > 0.0, "nothing was compared");
}

/// Estimates from `k` photons of photons spread evenly over the unit square, whose irradiance is 1 W·m⁻² exactly: for each
/// query with the radius of the (k + 1)-th, as the map has it, and of the k-th, the estimator of eq. 2.1 taken literally.
fn even_estimates(k: u32) -> (Vec<f64>, Vec<f64>) {
    const MAPS: u32 = 20;
    const PHOTONS: u32 = 20_000;
    const RADIUS: f32 = 0.09;
    let cpu = Device::cpu();
    let (mut ours, mut literal) = (Vec::new(), Vec::new());
    for seed in 0..MAPS {
        let mut photons = photons_at(seed, &uniform(1000 + seed, PHOTONS, [0.0; 3], [1.0, 0.0, 1.0]));
        photons.iter_mut().for_each(|photon| photon.power = [1.0 / PHOTONS as f32; 3]);
        let options = MapOptions { radius: RADIUS, hash: HASHES[seed as usize % 3], table: None, cell: None };
        let map = PhotonMap::build(&cpu, &photons, &options).unwrap();
        // Queries 0.0625 apart and 0.09375 or more from the border: discs of 51 photons have a radius of 0.028 or so, so that
        // neither do they overlap nor does the border cut them.
        let queries: Vec<_> = (0..14u32 * 14)
            .map(|i| query([0.09375 + 0.0625 * (i % 14) as f32, 0.0, 0.09375 + 0.0625 * (i / 14) as f32]))
            .collect();
        let estimates = map.irradiance(&cpu, &queries, k, Gather::Heap).unwrap();
        let nearest = map.k_nearest(&cpu, &queries, k, Gather::Heap).unwrap();
        for (estimate, row) in estimates.iter().zip(nearest) {
            assert_eq!(estimate.photons, k, "r_max holds fewer than k photons: the test would be of something else");
            ours.push(f64::from(estimate.rgb[1]));
            let radius2 = f64::from(row.last().unwrap().distance2);
            literal.push(f64::from(k) / f64::from(PHOTONS) / (std::f64::consts::PI * radius2));
        }
    }
    (ours, literal)
}

/// (mean − 1) in standard errors of the mean, both from the data.
fn standard_errors_off(estimates: &[f64]) -> f64 {
    let n = estimates.len() as f64;
    let mean = estimates.iter().sum::<f64>() / n;
    let variance = estimates.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean - 1.0) / (variance / n).sqrt()
}

/// Of N points, the share of the plane in the disc up to the (k + 1)-th is distributed as Beta(k + 1, N − k), whose reciprocal has the
/// mean N / k: the estimate k / (N·share) has the mean 1. With the k-th it is k / (k − 1) instead. Bound: 4 standard errors, which
/// chance exceeds once in 16 000 times; the seeds are fixed.
#[test]
fn estimates_of_an_evenly_lit_plane_have_no_bias() {
    for k in [10, 50] {
        let (ours, literal) = even_estimates(k);
        let off = standard_errors_off(&ours);
        assert!(off.abs() < 4.0, "k = {k}: {off} standard errors off");
        // The same test does catch the bias that the map avoids: a planted fault.
        let fault = standard_errors_off(&literal);
        assert!(fault > 4.0, "k = {k}: the literal estimator is only {fault} standard errors off");
        println!("k = {k}: {off:.2} standard errors off; with r_k {fault:.2}");
    }
}
