//! Filters: an even surface is estimated as what it is, whatever the filter. Seeds are fixed.

use caustic_device::Device;
use caustic_photon_map::{Estimate, Filter, Hash, MapOptions, PhotonMap, Surface};
use caustic_tests::points::{photons_at, query, uniform};
use caustic_tests::renders::mean_and_error;

const FILTERS: [Filter; 4] = [Filter::Constant, Filter::Cone, Filter::Gaussian, Filter::Epanechnikov];

/// Estimates in the middle of photons spread evenly over the unit square, whose irradiance is 1 W·m⁻² exactly.
fn even_estimates(filter: Filter, k: Option<u32>) -> Vec<f64> {
    const MAPS: u32 = 20;
    const PHOTONS: u32 = 20_000;
    let cpu = Device::cpu();
    let mut found = Vec::new();
    for seed in 0..MAPS {
        let mut photons = photons_at(seed, &uniform(1000 + seed, PHOTONS, [0.0; 3], [1.0, 0.0, 1.0]));
        photons.iter_mut().for_each(|photon| photon.power = [1.0 / PHOTONS as f32; 3]);
        let hash = [Hash::Linear, Hash::Teschner, Hash::Morton][seed as usize % 3];
        // Discs of 40 photons or so, which neither overlap nor reach the border.
        let radius = if k.is_some() { 0.09 } else { 0.0252 };
        let map = PhotonMap::build(&cpu, &photons, &MapOptions { radius, hash, table: None, cell: None }).unwrap();
        let queries: Vec<_> = (0..14u32 * 14)
            .map(|i| query([0.09375 + 0.0625 * (i % 14) as f32, 0.0, 0.09375 + 0.0625 * (i / 14) as f32]))
            .collect();
        let estimate = Estimate { filter, surface: Surface::Any, k, ..Estimate::default() };
        let estimates = map.estimate(&cpu, &queries, &estimate).unwrap();
        found.extend(estimates.iter().map(|estimate| f64::from(estimate.rgb[1])));
    }
    found
}

/// 3920 independent estimates: the standard error of their mean is below 0.4 %, and the bias of a constant that was wrong
/// would not be: Jensen's own for his Gaussian gives 0.53, a cone divided by the whole disc 1/3.
#[test]
fn an_even_surface_is_as_bright_as_it_is_under_every_filter() {
    for filter in FILTERS {
        for k in [None, Some(10), Some(50)] {
            let (mean, se) = mean_and_error(&even_estimates(filter, k));
            println!("{filter:?}, k = {k:?}: {mean:.5}, SE {se:.5}");
            assert!((mean - 1.0).abs() < 4.0 * se && se < 8e-3, "{filter:?}, k = {k:?}: {mean} ± {se}");
        }
    }
}

/// Narrower filters are noisier, by what their weights say: the variance of an estimate from a disc of m photons on average
/// is ∫w² / (∫w)² · 1/m, with w over the unit disc: 1, 3/2, …, 4/3.
#[test]
fn filters_are_as_noisy_as_their_weights_say() {
    // ∫₀¹ w(x) and w²(x) dx: constant 1, 1; cone ⅓, 1/6; Epanechnikov ½, ⅓.
    for (filter, factor) in [(Filter::Constant, 1.0), (Filter::Cone, 1.5), (Filter::Epanechnikov, 4.0 / 3.0)] {
        let estimates = even_estimates(filter, None);
        let m = 20_000.0 * std::f64::consts::PI * 0.0252f64.powi(2);
        let scatter = estimates.iter().map(|value| (value - 1.0).powi(2)).sum::<f64>() / estimates.len() as f64;
        // The variance of 3920 estimates is known to 1/√1960 = 2.3 %: four of them.
        assert!((scatter * m / factor - 1.0).abs() < 0.09, "{filter:?}: {} and {factor}", scatter * m);
    }
}
