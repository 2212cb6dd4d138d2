//! The first k of each column, as neighbours.

use super::BruteParams;
use crate::exec::{Input, Store};
use crate::gather::CUT_SHORT;
use crate::layout::{Neighbour, Query};

/// Copies place `i / queries` of column `i % queries`, if it is a neighbour: so lanes read the matrix side by side. The last neighbour of a
/// query, known by what comes after it, or a query's first place where there is none, writes how many there are.
#[inline]
pub fn brute_copy<N: Store<Neighbour> + ?Sized, C: Store<u32> + ?Sized>(
    i: u32,
    params: &BruteParams,
    queries: &Input<Query>,
    distances: &Input<f32>,
    indices: &Input<u32>,
    sorted: &Input<u32>,
    neighbours: &mut N,
    counts: &mut C,
) {
    let place = i / params.queries;
    if place >= params.k {
        return;
    }
    let column = i % params.queries;
    let q = params.first + column;
    let sorted = sorted[column as usize];
    let active = queries[q as usize].active != 0;
    if active && sorted == CUT_SHORT {
        if place == 0 {
            counts.set(q, CUT_SHORT);
        }
        return;
    }
    let at = place * params.columns + column;
    let is_one = active && place < sorted && distances[at as usize] <= params.radius2;
    if is_one {
        let neighbour = Neighbour { distance2: distances[at as usize], photon: indices[at as usize] };
        neighbours.set(q * params.k + place, neighbour);
        let next = place + 1;
        if next >= params.k || next >= sorted || distances[(at + params.columns) as usize] > params.radius2 {
            counts.set(q, next);
        }
    } else if place == 0 {
        counts.set(q, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    /// Columns with 0, 1, 2, 3, 4 and 5 of 5 places within the radius, one that a device cut short and one of an inactive query.
    #[test]
    fn neighbours_are_those_within_the_radius_and_each_query_has_one_count() {
        let query = |active| Query { position: [0.0; 3], active };
        let mut queries = vec![query(1); 9];
        queries[8].active = 0;
        let distances: vec::Vec<f32> = (0..50)
            .map(|at| {
                let (row, column) = (at / 10, at % 10);
                if row < column || column >= 6 { row as f32 } else { 10.0 + row as f32 }
            })
            .collect();
        let indices: vec::Vec<u32> = (100..150).collect();
        let sorted = [5, 5, 5, 5, 5, 5, CUT_SHORT, 5];
        for k in [1, 3, 5, 8] {
            let params = BruteParams { first: 1, queries: 8, columns: 10, photons: 5, k, radius2: 4.0 };
            let unwritten = Neighbour { distance2: -1.0, photon: 7 };
            let mut neighbours = vec![unwritten; 9 * k as usize];
            let mut counts = vec![77; 9];
            // Invocations too many, which must do nothing.
            for i in 0..8 * k + 20 {
                let (neighbours, counts) = (neighbours.as_mut_slice(), counts.as_mut_slice());
                brute_copy(i, &params, &queries, &distances, &indices, &sorted, neighbours, counts);
            }
            let most = k.min(5);
            let expected = [0, 1, 2, 3, 4, 5].map(|count: u32| count.min(most));
            assert_eq!(counts[0], 77);
            assert_eq!(counts[1..7], expected);
            assert_eq!(counts[7..], [CUT_SHORT, 0]);
            for (place, neighbour) in (0..).zip(&neighbours) {
                let (q, n) = (place / k, place % k);
                let is_one = (1..7).contains(&q) && n < expected[q as usize - 1];
                let wanted = Neighbour { distance2: n as f32, photon: 100 + 10 * n + q.wrapping_sub(1) };
                assert_eq!(*neighbour, if is_one { wanted } else { unwritten }, "query {q}, place {n}");
            }
        }
    }
}
