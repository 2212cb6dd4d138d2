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
                self.counts[q] = merge(known, self.counts[q], &news, first as u32, &mut self.merged);
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

/// Merges `news`, of which index 0 is `first`, into the first `count` of `known`; both are in order. Returns how many there are then.
fn merge(known: &mut [Neighbour], count: u32, news: &[Neighbour], first: u32, merged: &mut Vec<Neighbour>) -> u32 {
    if news.is_empty() {
        return count;
    }
    merged.clear();
    let (mut old, mut new) = (known[..count as usize].iter().peekable(), news.iter().peekable());
    while merged.len() < known.len() {
        // Those that were known have lower indices, so that they come first among equals.
        let takes_old = match (old.peek(), new.peek()) {
            (Some(old), Some(new)) => old.distance2 <= new.distance2,
            (old, _) => old.is_some(),
        };
        let next = if takes_old {
            old.next().copied()
        } else {
            new.next().map(|new| Neighbour { photon: first + new.photon, ..*new })
        };
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
        let mut known = of(&[(1.0, 4), (2.0, 7), (0.0, 0), (0.0, 0)]);
        let mut merged = Vec::new();
        assert_eq!(merge(&mut known, 2, &of(&[(0.5, 3), (2.0, 0), (9.0, 1)]), 10, &mut merged), 4);
        assert_eq!(known, of(&[(0.5, 13), (1.0, 4), (2.0, 7), (2.0, 10)]));
        assert_eq!(merge(&mut known, 4, &[], 20, &mut merged), 4);
        let mut known = of(&[(0.0, 0), (0.0, 0)]);
        assert_eq!(merge(&mut known, 0, &of(&[(3.0, 1)]), 5, &mut merged), 1);
        assert_eq!(known[0], Neighbour { distance2: 3.0, photon: 6 });
    }
}
