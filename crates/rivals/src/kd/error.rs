//! How far off a radius by histograms is. Zhou et al. say "less than 0.1 %" (thesis, section 2.3.3).

use super::{KdSearch, KdTree};
use caustic_device::{Device, Plan};
use caustic_kernels::gather::CUT_SHORT;
use caustic_kernels::layout::{Neighbour, Query};
use caustic_kernels::rivals::kd::KD_CUT_SHORT;
use caustic_photon_map::{MapError, query_count, whole};

/// By how much radii by histograms are larger than the distances of the k-th photons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RadiusError {
    /// Queries that have k photons within the radius of the tree, the k-th of them not in the query's own point.
    pub queries: usize,
    /// Mean error over these, as a share of the k-th photon's distance.
    pub mean: f64,
    /// Largest.
    pub max: f64,
    /// Largest error as a share of the radius of the tree, from which the histograms begin.
    pub max_of_first: f64,
}

/// Measures the error after so many histograms.
///
/// # Errors
/// [`MapError::NotFinite`], [`MapError::K`], [`MapError::TooMany`], [`MapError::CutShort`] and [`MapError::Device`].
pub fn radius_error(
    device: &Device,
    tree: &KdTree,
    queries: &[Query],
    k: u32,
    iterations: u32,
) -> Result<RadiusError, MapError> {
    let count = query_count(queries)?;
    let queries = device.upload("queries", queries)?;
    let mut plan = Plan::new();
    let exact = tree.plan_neighbours(device, &mut plan, &queries, count, k, KdSearch::Nearest)?;
    let radii2 = tree.plan_radii(device, &mut plan, &queries, count, k, iterations)?;
    device.run(&plan)?;
    let counts: Vec<u32> = device.read(&exact.counts, u64::from(count))?;
    let radii2: Vec<f32> = device.read(&radii2, u64::from(count))?;
    whole(device, counts.iter().copied())?;
    whole(device, radii2.iter().map(|&radius2| if radius2 == KD_CUT_SHORT { CUT_SHORT } else { 0 }))?;
    let neighbours: Vec<Neighbour> = device.read(&exact.neighbours, u64::from(count) * u64::from(k))?;
    let mut error = RadiusError::default();
    for ((found, row), radius2) in counts.into_iter().zip(neighbours.chunks(k as usize)).zip(radii2) {
        let exact = f64::from(row[k as usize - 1].distance2).sqrt();
        if found == k && exact > 0.0 {
            let off = f64::from(radius2).sqrt() - exact;
            error.queries += 1;
            error.mean += off / exact;
            error.max = error.max.max(off / exact);
            error.max_of_first = error.max_of_first.max(off / f64::from(tree.radius));
        }
    }
    error.mean /= error.queries.max(1) as f64;
    Ok(error)
}
