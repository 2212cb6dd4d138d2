//! The k nearest of photons that come in chunks.

use super::with_more;
use crate::{Gather, MapError, MapOptions, PhotonMap, query_count};
use caustic_device::Device;
use caustic_kernels::layout::{Neighbour, Photon, Query};

/// The k nearest photons of queries, among photons that come in chunks.
///
/// Neighbours are ordered by (squared distance, index), which is total, so the k first of all are the k first of the k first of each
/// chunk: the result has the bits of one map of all photons, wherever chunks begin.
pub struct NearestStreamed<'a> {
    device: &'a Device,
    options: MapOptions,
    queries: &'a [Query],
    k: u32,
    gather: Gather,
    /// Photons that have come.
    photons: u64,
    /// k places a query.
    found: Vec<Neighbour>,
    counts: Vec<u32>,
    /// Places of one query while it is merged.
    merged: Vec<Neighbour>,
}

/// Neighbours that are searched for at once: 16 bytes each, on the device and again on the host.
const AT_ONCE: usize = 1 << 22;

impl<'a> NearestStreamed<'a> {
    /// No photons yet.
    ///
    /// # Errors
    /// [`MapError::NotFinite`], [`MapError::TooMany`] and [`MapError::K`].
    pub fn new(
        device: &'a Device,
        queries: &'a [Query],
        k: u32,
        gather: Gather,
        options: &MapOptions,
    ) -> Result<Self, MapError> {
        query_count(queries)?;
        crate::capacity(k)?;
        let found = vec![Neighbour::default(); queries.len() * k as usize];
        let counts = vec![0; queries.len()];
        Ok(Self { device, options: *options, queries, k, gather, photons: 0, found, counts, merged: Vec::new() })
    }

    /// Bytes that it takes on the host.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        size_of_val(&self.found[..]) as u64 + size_of_val(&self.counts[..]) as u64
    }

    /// Adds the photons that follow those before. Their indices go on.
    ///
    /// # Errors
    /// All of [`MapError`]; [`MapError::TooMany`] if indices would need more than 32 bits.
    pub fn add(&mut self, photons: &[Photon]) -> Result<(), MapError> {
        let first = self.photons;
        let count = with_more(first, photons.len(), u32::MAX)?;
        let map = PhotonMap::build(self.device, photons, &self.options)?;
        self.photons = count;
        let k = self.k as usize;
        let at_once = (AT_ONCE / k).max(1);
        for (i, queries) in self.queries.chunks(at_once).enumerate() {
            let found = map.k_nearest(self.device, queries, self.k, self.gather)?;
            for (q, news) in (i * at_once..).zip(found) {
                let known = &mut self.found[q * k..][..k];
                let news = news.into_iter().map(|new| Neighbour { photon: first as u32 + new.photon, ..new });
                self.counts[q] = merge(known, self.counts[q], news, |one| one.distance2, &mut self.merged);
            }
        }
        Ok(())
    }

    /// The neighbours of a query so far, nearest first, ties by index.
    #[must_use]
    pub fn neighbours(&self, query: usize) -> &[Neighbour] {
        &self.found[query * self.k as usize..][..self.counts[query] as usize]
    }
}

/// Merges `news` into the first `count` of `known`; both are in order, and the indices of those that are known are lower. Returns how many there
/// are then.
pub(super) fn merge<T: Copy>(
    known: &mut [T],
    count: u32,
    news: impl Iterator<Item = T>,
    distance2: impl Fn(&T) -> f32,
    merged: &mut Vec<T>,
) -> u32 {
    let mut new = news.peekable();
    let full = count as usize == known.len();
    let beyond = |new: &T| full && known.last().is_some_and(|last| distance2(last) <= distance2(new));
    if new.peek().is_none_or(beyond) {
        return count;
    }
    merged.clear();
    let mut old = known[..count as usize].iter().peekable();
    while merged.len() < known.len() {
        // Those that were known come first among equals.
        let takes_old = match (old.peek(), new.peek()) {
            (Some(old), Some(new)) => distance2(old) <= distance2(new),
            (old, _) => old.is_some(),
        };
        let next = if takes_old { old.next().copied() } else { new.next() };
        let Some(next) = next else { break };
        merged.push(next);
    }
    known[..merged.len()].copy_from_slice(merged);
    merged.len() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_both_are_kept_in_order() {
        let of = |pairs: &[(f32, u32)]| -> Vec<Neighbour> {
            pairs.iter().map(|&(distance2, photon)| Neighbour { distance2, photon }).collect()
        };
        let mut merged = Vec::new();
        let mut put = |known: &mut [Neighbour], count, news: &[(f32, u32)]| {
            merge(known, count, of(news).into_iter(), |one| one.distance2, &mut merged)
        };
        let mut known = of(&[(1.0, 4), (2.0, 7), (0.0, 0), (0.0, 0)]);
        assert_eq!(put(&mut known, 2, &[(0.5, 13), (2.0, 10), (9.0, 11)]), 4);
        assert_eq!(known, of(&[(0.5, 13), (1.0, 4), (2.0, 7), (2.0, 10)]));
        assert_eq!(put(&mut known, 4, &[]), 4);
        assert_eq!(put(&mut known, 4, &[(2.0, 20)]), 4);
        assert_eq!(known, of(&[(0.5, 13), (1.0, 4), (2.0, 7), (2.0, 10)]), "one as far comes after");
        let mut known = of(&[(0.0, 0), (0.0, 0)]);
        assert_eq!(put(&mut known, 0, &[(3.0, 6)]), 1);
        assert_eq!(known[0], Neighbour { distance2: 3.0, photon: 6 });
    }
}
