//! Brute force: what a search has to find, computed from all photons.

use caustic_kernels::gather::distance2;
use caustic_kernels::layout::{Irradiance, Neighbour, Photon, Query};
use rayon::prelude::*;

/// Most queries that are checked.
const CHECKED: usize = 64;
/// Most distances that a check may compute.
const DISTANCES: usize = 2_000_000_000;

/// How many of `queries` brute force can check among `photons` photons.
pub(crate) fn checked(queries: usize, photons: usize) -> usize {
    (DISTANCES / photons.max(1)).clamp(4, CHECKED).min(queries)
}

/// The `k` nearest photons within √`radius2` of each query, nearest first, ties by index; and the (k + 1)-th if there is one.
pub(crate) fn nearest(photons: &[Photon], queries: &[Query], k: usize, radius2: f32) -> Vec<Vec<Neighbour>> {
    let of_query = |query: &Query| {
        let neighbour = |(i, photon): (usize, &Photon)| {
            let distance2 = distance2(query.position, photon.position);
            (distance2 <= radius2).then_some(Neighbour { distance2, photon: i as u32 })
        };
        let mut all: Vec<Neighbour> = photons.par_iter().enumerate().filter_map(neighbour).collect();
        let order = |a: &Neighbour, b: &Neighbour| a.distance2.total_cmp(&b.distance2).then(a.photon.cmp(&b.photon));
        if all.len() > k + 1 {
            all.select_nth_unstable_by(k, order);
            all.truncate(k + 1);
        }
        all.sort_by(order);
        all
    };
    queries.iter().map(of_query).collect()
}

/// Whether an estimate is that of the photons in `found` (what [`nearest`] returns): the same number, and a sum of their powers
/// over the disc to the (k + 1)-th that is right within rounding. The hash of all results says the bits.
pub(crate) fn is_estimate(
    estimate: &Irradiance,
    photons: &[Photon],
    found: &[Neighbour],
    k: usize,
    radius2: f32,
) -> bool {
    let counted = &found[..k.min(found.len())];
    let reach = found.get(k).map_or(0.0, |next| next.distance2);
    let area = std::f64::consts::PI * f64::from(if reach == 0.0 { radius2 } else { reach });
    let near = |channel: usize| {
        let sum: f64 = counted.iter().map(|n| f64::from(photons[n.photon as usize].power[channel])).sum();
        (f64::from(estimate.rgb[channel]) - sum / area).abs() <= 1e-6 * sum / area
    };
    estimate.photons as usize == counted.len() && (0..3).all(near)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_come_in_order_with_one_more() {
        let at = |x: f32| Photon { position: [x, 0.0, 0.0], power: [1.0; 3], ..Photon::default() };
        let photons = [at(3.0), at(1.0), at(-1.0), at(2.0), at(9.0)];
        let query = [Query { position: [0.0; 3], active: 1 }];
        let indices = |k| -> Vec<u32> { nearest(&photons, &query, k, 16.0)[0].iter().map(|n| n.photon).collect() };
        assert_eq!(indices(1), [1, 2]);
        assert_eq!(indices(3), [1, 2, 3, 0]);
        assert_eq!(indices(9), [1, 2, 3, 0]);
        let found = &nearest(&photons, &query, 2, 16.0)[0];
        let right = Irradiance { rgb: [2.0 / (std::f32::consts::PI * 4.0); 3], photons: 2 };
        assert!(is_estimate(&right, &photons, found, 2, 16.0));
        assert!(!is_estimate(&Irradiance { photons: 3, ..right }, &photons, found, 2, 16.0));
        assert!(!is_estimate(&Irradiance { rgb: right.rgb.map(|x| x * 1.001), ..right }, &photons, found, 2, 16.0));
    }
}
