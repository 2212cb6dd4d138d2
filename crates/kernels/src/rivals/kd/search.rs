//! The k nearest photons of a query.

use super::radius::KD_CUT_SHORT;
use super::traverse::traverse;
use crate::exec::{Input, Store};
use crate::gather::{CUT_SHORT, Candidates, Selection};
use crate::layout::{Neighbour, Query, Site};
use crate::rivals::SearchParams;

/// Writes the k nearest neighbours of query `q` within the radius, nearest first, to `neighbours[q·k ..]`, and how many there are, or
/// [`CUT_SHORT`], to `counts[q]`: one walk, in which the bound shrinks.
#[inline]
pub fn kd_nearest<S: Selection + Candidates<(), (), ()>, N: Store<Neighbour> + ?Sized, C: Store<u32> + ?Sized>(
    q: u32,
    selection: S,
    params: &SearchParams,
    queries: &Input<Query>,
    tree: &Input<Site>,
    neighbours: &mut N,
    counts: &mut C,
) {
    if q < params.queries {
        select(q, selection, params.radius2, true, params, queries, tree, neighbours, counts);
    }
}

/// The same, of the photons within a radius that [`kd_radius`](super::kd_radius) found: all of them are met, and a few more than k; so what
/// remains is to put them in order and to leave out the last.
#[inline]
pub fn kd_range<S: Selection + Candidates<(), (), ()>, N: Store<Neighbour> + ?Sized, C: Store<u32> + ?Sized>(
    q: u32,
    selection: S,
    params: &SearchParams,
    queries: &Input<Query>,
    radii2: &Input<f32>,
    tree: &Input<Site>,
    neighbours: &mut N,
    counts: &mut C,
) {
    if q < params.queries {
        let radius2 = radii2[q as usize];
        select(q, selection, radius2, radius2 != KD_CUT_SHORT, params, queries, tree, neighbours, counts);
    }
}

#[inline]
fn select<S: Selection + Candidates<(), (), ()>, N: Store<Neighbour> + ?Sized, C: Store<u32> + ?Sized>(
    q: u32,
    mut selection: S,
    radius2: f32,
    mut whole: bool,
    params: &SearchParams,
    queries: &Input<Query>,
    tree: &Input<Site>,
    neighbours: &mut N,
    counts: &mut C,
) {
    let query = queries[q as usize];
    selection.reset(params.k, radius2);
    if query.active != 0 {
        whole = traverse(query.position, tree, params.photons, &(), &mut (), &mut (), &mut selection) && whole;
        selection.sort(tree);
    }
    let mut n = 0;
    while n < selection.count() {
        let photon = tree[selection.slot(n) as usize].photon();
        neighbours.set(q * params.k + n, Neighbour { distance2: selection.distance2(n), photon });
        n += 1;
    }
    counts.set(q, if whole && n >= selection.count() { n } else { CUT_SHORT });
}
