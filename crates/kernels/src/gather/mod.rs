//! Finding the k photons nearest to a point, and what they say about the light there.
//!
//! Neighbours are ordered by (squared distance, index the photon had before sorting). That order is total, so "the k
//! nearest" is one set, whatever the hash, the device or the container that collects it; and what is summed over it is
//! summed exactly ([`Sum`](crate::num::Sum)), so that the order in which a container holds it does not show.

mod estimate;
mod heap;
mod histogram;
mod list;
mod search;

pub use estimate::{gather_irradiance, gather_neighbours};
pub use heap::Heap;
pub use histogram::gather_irradiance_by_counting;
pub use list::SortedList;
pub use search::{distance2, search};

use crate::layout::Photon;
use bytemuck::{Pod, Zeroable};

/// Lanes of a gathering workgroup.
pub const GATHER_LANES: u32 = 64;
/// Capacities for which gathering kernels are compiled. A request is served by the smallest that holds it; it still
/// returns exactly what was asked for. The estimate of k photons needs room for k + 1.
pub const CAPACITIES: [u32; 4] = [17, 65, 257, 1025];

/// Parameters of a gathering stage.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GatherParams {
    /// Number of queries.
    pub queries: u32,
    /// Neighbours sought a query, k.
    pub k: u32,
}

/// What a search does with the candidates it meets.
pub trait Candidates {
    /// Whether an offer is a few instructions, so that the search repeats it eight times a turn of its innermost loop: that is
    /// faster, and llvmpipe, which ends loops after 65,535 turns, comes eight times as far.
    const SHORT: bool = false;
    /// Squared distance beyond which a candidate does not matter, m².
    fn bound(&self) -> f32;
    /// Offers candidate `slot`, an index into the sorted `photons`, whose original indices are `order`.
    fn offer(&mut self, distance2: f32, slot: u32, order: &[u32], photons: &[Photon]);
    /// Lowers the bound, if that takes more work than one candidate is worth: called between cells.
    #[inline]
    fn settle(&mut self) {}
}

/// Result in place of a number of photons where the device ended a search before its end: what was found is not the answer.
pub const CUT_SHORT: u32 = 0xffff_ffff;

/// A container that keeps the best of the candidates it is offered.
pub trait Selection: Candidates {
    /// Empties it and sets what it keeps: the `k` first in order among those at most `radius2` (m²) away.
    fn reset(&mut self, k: u32, radius2: f32);
    /// Puts what was kept in order, nearest first.
    fn sort(&mut self, order: &[u32]);
    /// Where, before it is sorted, a full container has what is last in order.
    fn last(&self) -> u32;
    /// How many were kept.
    fn count(&self) -> u32;
    /// Squared distance of the `i`-th, m².
    fn distance2(&self, i: u32) -> f32;
    /// The `i`-th as an index into the sorted photons.
    fn slot(&self, i: u32) -> u32;
}

/// Whether a candidate comes before another in the order of neighbours.
#[inline]
fn before(distance2: f32, slot: u32, other_distance2: f32, other_slot: u32, order: &[u32]) -> bool {
    if distance2 == other_distance2 {
        order[slot as usize] < order[other_slot as usize]
    } else {
        distance2 < other_distance2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{Grid, HASH_TESCHNER};
    use crate::layout::{Irradiance, Photon, Query};
    use crate::num::pcg4d;
    use std::vec;
    use std::vec::Vec;

    const OFFERS: u32 = 300;

    /// What a container keeps of 300 offers with many equal distances, whose slots `order` puts in another order.
    fn kept(mut selection: impl Selection, k: u32, seed: u32) -> Vec<(u32, u32)> {
        let (distances, order) = offers(seed);
        selection.reset(k, 100.0);
        let mut bound = selection.bound();
        let mut seen = vec![];
        for slot in 0..OFFERS {
            let d2 = distances[slot as usize];
            if d2 <= selection.bound() {
                selection.offer(d2, slot, &order, &[]);
                seen.push((d2.to_bits(), order[slot as usize], slot));
                seen.sort_unstable();
                seen.truncate(k as usize);
            }
            if selection.count() == k {
                assert_eq!(Some(selection.slot(selection.last())), seen.last().map(|&(_, _, slot)| slot));
            }
            assert!(selection.bound() <= bound, "a bound never grows");
            bound = selection.bound();
        }
        selection.sort(&order);
        (0..selection.count()).map(|i| (selection.distance2(i).to_bits(), selection.slot(i))).collect()
    }

    fn offers(seed: u32) -> (Vec<f32>, Vec<u32>) {
        let distances = (0..OFFERS).map(|i| (pcg4d([seed, i, 0, 0])[0] % 40) as f32 * 2.6).collect();
        // 7 and 300 have no common factor: a permutation.
        (distances, (0..OFFERS).map(|i| (i * 7 + seed) % OFFERS).collect())
    }

    #[test]
    fn heap_and_list_keep_the_first_k_in_order() {
        for seed in 0..20 {
            let (distances, order) = offers(seed);
            let mut expected: Vec<(u32, u32)> =
                (0..OFFERS).map(|slot| (distances[slot as usize].to_bits(), slot)).collect();
            expected.retain(|&(d2, _)| f32::from_bits(d2) <= 100.0);
            // Bits of positive floats are in the order of the floats.
            expected.sort_by_key(|&(d2, slot)| (d2, order[slot as usize]));
            assert!(expected.len() < OFFERS as usize, "nothing lies outside the radius");
            for k in [1, 2, 3, 16, 17, 64, 299, 300] {
                let first = &expected[..expected.len().min(k as usize)];
                assert_eq!(kept(Heap::<300>::new(), k, seed), first, "heap, k = {k}");
                assert_eq!(kept(SortedList::<300>::new(), k, seed), first, "list, k = {k}");
            }
        }
    }

    /// On a GPU the arrays of a container are not zeroed: what is in them at first must not show.
    #[test]
    fn rubbish_in_a_new_container_does_not_show() {
        for seed in 0..20 {
            for k in [1, 17, 64, 300] {
                assert_eq!(kept(Heap::<300>::of_rubbish(), k, seed), kept(Heap::<300>::new(), k, seed));
                assert_eq!(kept(SortedList::<300>::of_rubbish(), k, seed), kept(SortedList::<300>::new(), k, seed));
            }
        }
    }

    #[test]
    fn a_container_that_is_reset_has_forgotten() {
        let order = [0, 1, 2];
        let mut heap = Heap::<4>::new();
        heap.reset(2, 9.0);
        heap.offer(1.0, 0, &order, &[]);
        heap.offer(2.0, 1, &order, &[]);
        assert_eq!((heap.count(), heap.bound()), (2, 2.0));
        heap.reset(3, 5.0);
        assert_eq!((heap.count(), heap.bound()), (0, 5.0));
        heap.offer(3.0, 2, &order, &[]);
        heap.sort(&order);
        assert_eq!((heap.count(), heap.distance2(0), heap.slot(0), heap.bound()), (1, 3.0, 2, 5.0));
    }

    #[test]
    fn distances_are_symmetric_and_never_subnormal() {
        assert_eq!(distance2([1.0, 2.0, 3.0], [4.0, 6.0, 3.0]), 25.0);
        for i in 0..10_000 {
            let random = pcg4d([i, 1, 2, 3]).map(|x| (x >> 8) as f32 * 1e-6 - 8.0);
            let (a, b) = ([random[0], random[1], random[2]], [random[3], random[0], random[1]]);
            assert_eq!(distance2(a, b).to_bits(), distance2(b, a).to_bits());
        }
        assert_eq!(distance2([1e-20, 0.0, 0.0], [0.0; 3]).to_bits(), 0);
        assert_eq!(distance2([f32::MAX; 3], [f32::MIN; 3]), f32::INFINITY);
    }

    #[test]
    fn cells_that_share_an_entry_give_each_photon_once() {
        // A table of one entry: all 27 cells lead to all photons.
        let photons: Vec<_> = (0..40u32)
            .map(|i| Photon { position: [(i % 4) as f32, (i / 4 % 4) as f32, (i / 16) as f32], ..Photon::default() })
            .collect();
        let order: Vec<u32> = (0..40).collect();
        let cells = [6, 6, 5];
        let grid = Grid { inverse_cell: 1.0, cells, hash: HASH_TESCHNER, table: 1, radius2: 1.0, ..Grid::default() };
        let position = [1.0, 2.0, 1.0];
        let mut heap = Heap::<65>::new();
        heap.reset(64, grid.radius2);
        assert!(search(position, &grid, &photons, &order, &[0], &[40], &mut heap));
        heap.sort(&order);
        let found: Vec<_> = (0..heap.count()).map(|i| heap.slot(i)).collect();
        // Itself, then its neighbours in the lattice, by index; there are only five.
        assert_eq!(found, [25, 9, 21, 24, 26, 29]);
    }

    #[test]
    fn an_estimate_reaches_to_the_first_photon_that_it_does_not_count() {
        let at = |x: f32, power: f32| Photon { position: [x, 0.0, 0.0], power: [power; 3], ..Photon::default() };
        let photons = [at(0.0, 1.0), at(0.25, 2.0), at(0.5, 4.0), at(0.75, 8.0)];
        let cells = [3, 3, 3];
        let grid = Grid { inverse_cell: 0.99, cells, hash: HASH_TESCHNER, table: 1, radius2: 1.0, ..Grid::default() };
        let estimate = |k: u32, queries: &[Query]| {
            let mut out = vec![Irradiance { rgb: [9.0; 3], photons: 9 }; queries.len()];
            let params = GatherParams { queries: queries.len() as u32, k };
            // An invocation too many, which must do nothing.
            for i in 0..=params.queries {
                let list = SortedList::<17>::new();
                gather_irradiance(
                    i,
                    list,
                    &params,
                    &grid,
                    queries,
                    &photons,
                    &[0, 1, 2, 3],
                    &[0],
                    &[4],
                    out.as_mut_slice(),
                );
            }
            out
        };
        let pi = core::f32::consts::PI;
        let here = Query { position: [0.0; 3], active: 1 };
        for (k, power, radius2, counted) in
            [(1, 1.0, 0.0625, 1), (2, 3.0, 0.25, 2), (3, 7.0, 0.5625, 3), (4, 15.0, 1.0, 4), (9, 15.0, 1.0, 4)]
        {
            let expected = Irradiance { rgb: [power / (pi * radius2); 3], photons: counted };
            assert_eq!(estimate(k, &[here]), [expected], "k = {k}");
        }
        let nothing = Irradiance::default();
        assert_eq!(estimate(2, &[Query { active: 0, ..here }, Query { position: [50.0; 3], active: 1 }]), [nothing; 2]);
    }
}
