//! The matrix of all distances.

use super::{BRUTE_TILE, BruteParams, least};
use crate::exec::{Input, Lanes, Store};
use crate::gather::distance2;
use crate::layout::{Photon, Query};

/// Shared memory of a workgroup: the positions of its photons, all x before all y before all z, m.
pub type BruteTile = [f32; 3 * BRUTE_TILE as usize];

/// Squared distances, m², of [`BRUTE_TILE`] queries, a lane each, to as many photons, which the workgroup loads once for all of
/// them: photon `p` and query `first + c` have theirs at `distances[p · columns + c]`.
#[inline]
pub fn brute_distance<L: Lanes<[f32; 3]>, D: Store<f32> + ?Sized>(
    lanes: &mut L,
    group: u32,
    shared: &mut BruteTile,
    params: &BruteParams,
    queries: &Input<Query>,
    photons: &Input<Photon>,
    distances: &mut D,
) {
    let across = params.queries.div_ceil(BRUTE_TILE);
    if group >= across * params.photons.div_ceil(BRUTE_TILE) {
        return;
    }
    let first_photon = group / across * BRUTE_TILE;
    let first_column = group % across * BRUTE_TILE;
    lanes.each(shared, move |lane, position: &mut [f32; 3], shared: &mut BruteTile| {
        let column = first_column + lane;
        if column < params.queries {
            *position = queries[(params.first + column) as usize].position;
        }
        let photon = first_photon + lane;
        if photon < params.photons {
            let position = photons[photon as usize].position;
            shared[lane as usize] = position[0];
            shared[(BRUTE_TILE + lane) as usize] = position[1];
            shared[(2 * BRUTE_TILE + lane) as usize] = position[2];
        }
    });
    lanes.each(shared, move |lane, position: &mut [f32; 3], shared: &mut BruteTile| {
        let column = first_column + lane;
        if column < params.queries {
            let count = least(params.photons - first_photon, BRUTE_TILE);
            let mut n = 0;
            while n < count {
                let photon =
                    [shared[n as usize], shared[(BRUTE_TILE + n) as usize], shared[(2 * BRUTE_TILE + n) as usize]];
                distances.set((first_photon + n) * params.columns + column, distance2(*position, photon));
                n += 1;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::Workgroup;
    use std::vec;
    use std::vec::Vec;

    /// Queries and photons at whole numbers along x: a squared distance is the square of a difference.
    #[test]
    fn each_photon_is_a_row_and_each_query_a_column() {
        let queries: Vec<Query> = (0..700u32).map(|i| Query { position: [i as f32, 0.0, 2.0], active: 1 }).collect();
        let order: Vec<u32> = (0..BRUTE_TILE).rev().collect();
        // Fewer than a tile, a tile, and parts of several.
        for (first, count, columns, photons) in
            [(0, 1, 1, 1), (3, 10, 12, 300), (0, 256, 256, 256), (100, 600, 608, 513)]
        {
            let photons: Vec<Photon> =
                (0..photons).map(|p| Photon { position: [3.0 * p as f32, 1.0, 2.0], ..Photon::default() }).collect();
            let params =
                BruteParams { first, queries: count, columns, photons: photons.len() as u32, ..BruteParams::default() };
            let mut distances = vec![-1.0; (columns * params.photons) as usize];
            let groups = count.div_ceil(BRUTE_TILE) * params.photons.div_ceil(BRUTE_TILE);
            // A workgroup too many, which must do nothing; shared memory and registers start with rubbish.
            for group in 0..=groups {
                let mut lanes = Workgroup {
                    registers: &mut [[f32::NAN; 3]; BRUTE_TILE as usize],
                    order: &order,
                    subgroup_lanes: 1,
                };
                let shared = &mut [f32::NAN; 768];
                brute_distance(&mut lanes, group, shared, &params, &queries, &photons, distances.as_mut_slice());
            }
            for (place, &distance) in (0..).zip(&distances) {
                let (photon, column) = (place / columns, place % columns);
                let x = 3.0 * photon as f32 - (first + column) as f32;
                let expected = if column < count { x * x + 1.0 } else { -1.0 };
                assert_eq!(distance, expected, "photon {photon}, column {column}");
            }
        }
    }
}
