//! The two sorts that Garcia et al. compare: a lane sorts the column of its query.
//!
//! Both leave the first in order in the first rows, and their photons in `indices`, which has columns like the matrix. `sorted` says how
//! many places are in order, or [`CUT_SHORT`].

use super::{BruteParams, least};
use crate::exec::{Store, Update};
use crate::gather::CUT_SHORT;

/// Garcia's modified insertion sort: only the first k places are kept in order, and a photon that is not nearer than the last of
/// them costs one comparison. Photons come in the order of their indices and go after those as near: ties are in order.
#[inline]
pub fn brute_insertion_sort<D: Update<f32> + ?Sized, I: Update<u32> + ?Sized, S: Store<u32> + ?Sized>(
    column: u32,
    params: &BruteParams,
    distances: &mut D,
    indices: &mut I,
    sorted: &mut S,
) {
    if column >= params.queries {
        return;
    }
    let columns = params.columns;
    let wanted = least(params.k, params.photons);
    let mut whole = true;
    let mut last = 0.0;
    let mut photon = 0;
    while photon < params.photons {
        let distance = distances.get(photon * columns + column);
        if photon < wanted || distance < last {
            let mut place = least(photon, wanted - 1);
            let mut shifting = place > 0;
            while shifting {
                let previous = (place - 1) * columns + column;
                let before = distances.get(previous);
                shifting = distance < before;
                if shifting {
                    distances.set(previous + columns, before);
                    indices.set(previous + columns, indices.get(previous));
                    place -= 1;
                    shifting = place > 0;
                }
            }
            whole = whole && !shifting;
            distances.set(place * columns + column, distance);
            indices.set(place * columns + column, photon);
            last = distances.get(least(photon, wanted - 1) * columns + column);
        }
        photon += 1;
    }
    sorted.set(column, if whole && photon >= params.photons { wanted } else { CUT_SHORT });
}

/// Comb sort (Dobosiewicz, "An efficient variation of bubble sort", 1980): bubble sort of elements that lie a gap apart, which shrinks by 1.3
/// from pass to pass. It sorts the whole column, with ties in the order of indices.
#[inline]
pub fn brute_comb_sort<D: Update<f32> + ?Sized, I: Update<u32> + ?Sized, S: Store<u32> + ?Sized>(
    column: u32,
    params: &BruteParams,
    distances: &mut D,
    indices: &mut I,
    sorted: &mut S,
) {
    if column >= params.queries {
        return;
    }
    let columns = params.columns;
    let mut photon = 0;
    while photon < params.photons {
        indices.set(photon * columns + column, photon);
        photon += 1;
    }
    let mut whole = photon >= params.photons;
    let mut gap = params.photons;
    let mut again = true;
    while again {
        gap = smaller(gap);
        again = gap > 1;
        let mut row = gap;
        while row < params.photons {
            let low = (row - gap) * columns + column;
            let high = row * columns + column;
            let (near, far) = (distances.get(low), distances.get(high));
            let (first, second) = (indices.get(low), indices.get(high));
            if far < near || (far == near && second < first) {
                distances.set(low, far);
                distances.set(high, near);
                indices.set(low, second);
                indices.set(high, first);
                again = true;
            }
            row += 1;
        }
        whole = whole && row >= params.photons;
    }
    sorted.set(column, if whole && !again { params.photons } else { CUT_SHORT });
}

/// The next gap: ÷ 1.3 in whole numbers, without overflow, and never 0.
#[inline]
fn smaller(gap: u32) -> u32 {
    let next = gap / 13 * 10 + gap % 13 * 10 / 13;
    if next > 1 { next } else { 1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::pcg4d;
    use std::vec;
    use std::vec::Vec;

    type Sort = fn(u32, &BruteParams, &mut [f32], &mut [u32], &mut [u32]);

    /// Distances of 5 columns, of which 4 are used, with many ties.
    fn matrix(photons: u32, kind: u32) -> Vec<f32> {
        let distance = |photon: u32, column: u32| match kind {
            0 => pcg4d([photon, column, 1, 2])[0] % 50,
            1 => photon,
            2 => photons - photon,
            _ => 7,
        };
        (0..5 * photons).map(|place| distance(place / 5, place % 5) as f32).collect()
    }

    /// Sorts columns 0 to 3 and holds the first `k` against what a sort of the host gives.
    fn check(sort: Sort, all: bool, photons: u32, k: u32, kind: u32) {
        let params = BruteParams { queries: 4, columns: 5, photons, k, ..BruteParams::default() };
        let given = matrix(photons, kind);
        let mut distances = given.clone();
        // What was there before must not show.
        let mut indices = vec![u32::MAX; (5 * photons) as usize];
        let mut sorted = vec![9; 6];
        // Two lanes too many, which must do nothing.
        for column in (0..6).rev() {
            sort(column, &params, &mut distances, &mut indices, &mut sorted);
        }
        let wanted = if all { photons } else { photons.min(k) };
        assert_eq!(sorted, [wanted, wanted, wanted, wanted, 9, 9]);
        for column in 0..5 {
            let mut expected: Vec<(u32, u32)> =
                (0..photons).map(|p| (given[(5 * p + column) as usize] as u32, p)).collect();
            if column < 4 {
                expected.sort_unstable();
                for (row, &(distance, photon)) in expected[..wanted as usize].iter().enumerate() {
                    let at = 5 * row + column as usize;
                    assert_eq!((distances[at], indices[at]), (distance as f32, photon), "row {row} of {photons}");
                }
            } else {
                assert!((0..photons).all(|p| indices[(5 * p + column) as usize] == u32::MAX), "a column of nobody");
            }
        }
    }

    #[test]
    fn both_sorts_put_the_first_in_order_and_ties_by_index() {
        for kind in 0..4 {
            for photons in [0, 1, 2, 12, 13, 14, 300] {
                for k in [1, 2, 13, 299, 300, 1024] {
                    check(brute_insertion_sort, false, photons, k, kind);
                    check(brute_comb_sort, true, photons, k, kind);
                }
            }
        }
    }

    #[test]
    fn gaps_shrink_by_one_point_three_and_end_at_one() {
        let mut gaps = vec![1000];
        while gaps.last() != Some(&1) {
            gaps.push(smaller(gaps[gaps.len() - 1]));
        }
        assert_eq!(
            gaps,
            [1000, 769, 591, 454, 349, 268, 206, 158, 121, 93, 71, 54, 41, 31, 23, 17, 13, 10, 7, 5, 3, 2, 1]
        );
        for gap in (0..5000).chain([u32::MAX - 1, u32::MAX]) {
            assert_eq!(u64::from(smaller(gap)), (u64::from(gap) * 10 / 13).max(1));
        }
    }
}
