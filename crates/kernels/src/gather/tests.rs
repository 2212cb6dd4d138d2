//! What containers keep, and what estimates of few photons are.

use super::*;
use crate::grid::{Grid, HASH_TESCHNER, MAX_REACH, Row};
use crate::layout::{Arrival, Irradiance, Query};
use crate::num::{Limbs, pcg4d};
use std::vec;
use std::vec::Vec;

const OFFERS: u32 = 300;

/// What a container keeps of 300 offers with many equal distances, whose slots `sites` puts in another order.
fn kept(mut selection: impl Selection + Candidates<(), (), ()>, k: u32, seed: u32) -> Vec<(u32, u32)> {
    let (distances, sites) = offers(seed);
    selection.reset(k, 100.0);
    let mut bound = selection.bound();
    let mut seen = vec![];
    for slot in 0..OFFERS {
        let d2 = distances[slot as usize];
        if d2 <= selection.bound() {
            selection.offer(&mut (), &mut (), d2, slot, &sites, &());
            seen.push((d2.to_bits(), sites[slot as usize].photon(), slot));
            seen.sort_unstable();
            seen.truncate(k as usize);
        }
        if selection.count() == k {
            assert_eq!(Some(selection.slot(selection.last())), seen.last().map(|&(_, _, slot)| slot));
        }
        assert!(selection.bound() <= bound, "a bound never grows");
        bound = selection.bound();
    }
    selection.sort(&sites);
    (0..selection.count()).map(|i| (selection.distance2(i).to_bits(), selection.slot(i))).collect()
}

fn site(photon: u32) -> Site {
    Site::new([0.0; 3], photon)
}

fn offers(seed: u32) -> (Vec<f32>, Vec<Site>) {
    let distances = (0..OFFERS).map(|i| (pcg4d([seed, i, 0, 0])[0] % 40) as f32 * 2.6).collect();
    // 7 and 300 have no common factor: a permutation.
    (distances, (0..OFFERS).map(|i| site((i * 7 + seed) % OFFERS)).collect())
}

/// All rows that cells as wide as the radius need, nearest first enough.
fn rows() -> Vec<Row> {
    let offsets = [0, 1, -1, 2, -2].map(|n: i32| (n + MAX_REACH as i32) as u32);
    offsets.iter().flat_map(|&z| offsets.map(|y| Row { y, z, least2: 0.0 })).collect()
}

/// A grid whose table has one entry, for searches within 1 m.
fn one_entry(inverse_cell: f32, cells: [u32; 3], rows: &[Row]) -> Grid {
    let (hash, rows) = (HASH_TESCHNER, rows.len() as u32);
    Grid { inverse_cell, cells, hash, table: 1, radius2: 1.0, cell_width: 1.0, rows, ..Grid::default() }
}

#[test]
fn heap_and_list_keep_the_first_k_in_order() {
    for seed in 0..20 {
        let (distances, sites) = offers(seed);
        let mut expected: Vec<(u32, u32)> =
            (0..OFFERS).map(|slot| (distances[slot as usize].to_bits(), slot)).collect();
        expected.retain(|&(d2, _)| f32::from_bits(d2) <= 100.0);
        // Bits of positive floats are in the order of the floats.
        expected.sort_by_key(|&(d2, slot)| (d2, sites[slot as usize].photon()));
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
    let sites = [0, 1, 2].map(site);
    let mut heap = Heap::<4>::new();
    let offer = |heap: &mut Heap<4>, d2, slot| heap.offer(&mut (), &mut (), d2, slot, &sites, &());
    let bound = |heap: &Heap<4>| Candidates::<(), (), ()>::bound(heap);
    heap.reset(2, 9.0);
    offer(&mut heap, 1.0, 0);
    offer(&mut heap, 2.0, 1);
    assert_eq!((heap.count(), bound(&heap)), (2, 2.0));
    heap.reset(3, 5.0);
    assert_eq!((heap.count(), bound(&heap)), (0, 5.0));
    offer(&mut heap, 3.0, 2);
    heap.sort(&sites);
    assert_eq!((heap.count(), heap.distance2(0), heap.slot(0), bound(&heap)), (1, 3.0, 2, 5.0));
}

#[test]
fn distances_are_symmetric_and_never_subnormal() {
    assert_eq!(distance2([1.0, 2.0, 3.0], [4.0, 6.0, 3.0]), 25.0);
    for i in 0..10_000 {
        let random = pcg4d([i, 1, 2, 3]).map(|x| (x >> 8) as f32 * 1e-6 - 8.0);
        let (a, b) = ([random[0], random[1], random[2]], [random[3], random[0], random[1]]);
        assert_eq!(distance2(a, b).to_bits(), distance2(b, a).to_bits());
    }
    for tiny in [1e-30, 1e-20, 7e-12] {
        assert_eq!(distance2([tiny, 0.0, 0.0], [0.0; 3]).to_bits(), 0);
    }
    assert_eq!(distance2([8e-12, 0.0, 0.0], [0.0; 3]), 8e-12 * 8e-12);
    assert_eq!(distance2([f32::MAX; 3], [f32::MIN; 3]), f32::INFINITY);
}

/// Flushing products that are subnormal changes no squared distance.
#[test]
fn a_device_without_subnormals_has_the_same_distances() {
    let flush = |x: f32| if x.abs() < f32::MIN_POSITIVE { 0.0 } else { x };
    let mut flushed = 0;
    for i in 0..100_000u32 {
        let random = pcg4d([i, 8, 8, 8]);
        // Differences of 2⁻³⁶ … 2⁻⁶⁷, whose squares lie on both sides of 2⁻¹²⁶ and of the least squared distance.
        let d: [f32; 3] = core::array::from_fn(|axis| {
            f32::from_bits(((127 - 36 - random[axis] % 32) << 23) | (random[3] >> axis) & 0x007f_ffff)
        });
        let squares = d.map(|d| flush(d * d));
        flushed += u32::from(d.iter().zip(squares).any(|(d, square)| d * d != square));
        let sum = flush(flush(squares[0] + squares[1]) + squares[2]);
        let expected = if sum < 2f32.powi(-74) { 0.0 } else { sum };
        assert_eq!(distance2(d, [0.0; 3]).to_bits(), expected.to_bits(), "{d:?}");
    }
    assert!(flushed > 10_000);
}

#[test]
fn a_root_above_is_above_and_near() {
    for i in 0..1_000_000u32 {
        let x = f32::from_bits(0x0100_0000 + i * 2100);
        let (root, above) = (f64::from(x).sqrt(), f64::from(root_above(x)));
        assert!(above >= root && above <= 1.09 * root, "{x}: {root} {above}");
    }
    assert!(root_above(0.0) >= 0.0 && root_above(0.0) < 1e-18);
}

#[test]
fn cells_that_share_an_entry_give_each_photon_once() {
    // A table of one entry: all cells lead to all photons.
    let at = |i: u32| [(i % 4) as f32, (i / 4 % 4) as f32, (i / 16) as f32];
    let sites: Vec<_> = (0..40u32).map(|i| Site::new(at(i), i)).collect();
    let rows = rows();
    let grid = one_entry(1.0, [4, 4, 3], &rows);
    let mut heap = Heap::<65>::new();
    heap.reset(64, grid.radius2);
    let (none, begins) = (&(), [0, 40]);
    assert!(search::<false, _, _, _, _, _>(
        [1.0, 2.0, 1.0],
        &grid,
        &rows,
        &sites,
        none,
        &begins,
        &mut (),
        &mut (),
        &mut heap
    ));
    heap.sort(&sites);
    let found: Vec<_> = (0..heap.count()).map(|i| heap.slot(i)).collect();
    // Itself, then its neighbours in the lattice, by index; there are only five.
    assert_eq!(found, [25, 9, 21, 24, 26, 29]);
}

#[test]
fn an_estimate_reaches_to_the_first_photon_that_it_does_not_count() {
    let sites = [0.0, 0.25, 0.5, 0.75].map(|x| Site::new([x, 0.0, 0.0], (x * 4.0) as u32));
    let arrivals = [1.0, 2.0, 4.0, 8.0].map(|power: f32| {
        let limbs = |power: f32| Limbs::of(power, 8.0).0;
        Arrival::new(limbs(power), limbs(0.0), limbs(power * 1e-9), 0, 0)
    });
    let rows = rows();
    let grid = one_entry(0.99, [1, 1, 1], &rows);
    let estimate = |k: u32, queries: &[Query]| {
        let mut out = [(); 3].map(|()| vec![Irradiance { rgb: [9.0; 3], photons: 9 }; queries.len()]);
        let mut reaches = vec![Reach::default(); queries.len()];
        let params = GatherParams { queries: queries.len() as u32, k, guess: 1.0 };
        let order: Vec<u32> = (0..params.queries).rev().collect();
        let power = [8f32, 0.0, 8.0].map(f32::to_bits);
        // An invocation too many, which must do nothing.
        for i in 0..=params.queries {
            let list = SortedList::<17>::new();
            let by_list = out[0].as_mut_slice();
            gather_irradiance(
                i,
                list,
                &params,
                &grid,
                &rows,
                queries,
                &order,
                &sites,
                &arrivals,
                &[0, 4],
                &power,
                by_list,
            );
            let by_counting = out[1].as_mut_slice();
            gather_irradiance_by_counting::<false, _>(
                i,
                3,
                &mut [7; 1024],
                &params,
                &grid,
                &rows,
                queries,
                &order,
                &sites,
                &arrivals,
                &[0, 4],
                &power,
                by_counting,
            );
            let reaches = reaches.as_mut_slice();
            gather_reach::<false, _, _>(
                i,
                3,
                &mut [7; 1024],
                &params,
                &grid,
                &rows,
                queries,
                &order,
                &sites,
                &[0, 4],
                reaches,
            );
        }
        // The same in two stages: how far, then what is there, weighed alike and of any surface.
        let params = EstimateParams { queries: params.queries, reach: 1, ..EstimateParams::default() };
        for i in 0..=params.queries {
            gather_filtered::<false, _>(
                i,
                &params,
                &grid,
                &rows,
                queries,
                &order,
                &reaches,
                &[],
                &[],
                &sites,
                &arrivals,
                &[0, 4],
                &power,
                out[2].as_mut_slice(),
            );
        }
        assert_eq!(out[0], out[1], "k = {k}");
        assert_eq!(out[0], out[2], "k = {k}");
        out[0].clone()
    };
    let pi = core::f32::consts::PI;
    let here = Query { position: [0.0; 3], active: 1 };
    for (k, power, radius2, counted) in
        [(1, 1.0, 0.0625, 1), (2, 3.0, 0.25, 2), (3, 7.0, 0.5625, 3), (4, 15.0, 1.0, 4), (9, 15.0, 1.0, 4)]
    {
        let found = estimate(k, &[here])[0];
        // The last channel is far below the scale, which the others have made.
        let expected = [power / (pi * radius2), 0.0, 1e-9 * power / (pi * radius2)];
        assert_eq!((found.photons, found.rgb[0], found.rgb[1]), (counted, expected[0], 0.0), "k = {k}");
        assert!((found.rgb[2] / expected[2] - 1.0).abs() < 2e-7, "k = {k}: {}", found.rgb[2]);
    }
    let nothing = Irradiance::default();
    assert_eq!(estimate(2, &[Query { active: 0, ..here }, Query { position: [50.0; 3], active: 1 }]), [nothing; 2]);
}
