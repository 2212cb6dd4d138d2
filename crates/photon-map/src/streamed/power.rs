//! Estimates from the k nearest of photons that come in chunks.

use super::nearest::merge;
use super::{LargestPower, Points};
use crate::map::whole;
use crate::{Gather, MAX_K, MapError, PhotonMap};
use caustic_device::{Device, Plan};
use caustic_kernels::gather::density_of;
use caustic_kernels::layout::{Irradiance, Neighbour, PowerSum};
use caustic_kernels::num::Limbs;
use rayon::prelude::*;

/// A photon that may be one of the nearest. Of equally far ones those of earlier maps come first, as their indices do.
#[derive(Clone, Copy, Default)]
struct Candidate {
    distance2: f32,
    power: [f32; 3],
}

/// Most k of an estimate from photons in chunks: the photon after them is kept as well.
pub const MAX_K_IN_CHUNKS: u32 = MAX_K - 1;

/// Neighbours that are searched for at once: 8 bytes each on the device, twice where they are found in no order, and again on the host.
pub const NEIGHBOURS_AT_ONCE: u32 = 1 << 22;

/// The irradiance at points from the k nearest photons, over maps that come one after another: the bits of [`PhotonMap::irradiance`] in
/// one map of all photons.
///
/// The k + 1 nearest of all are the k + 1 first of the k + 1 nearest of each map, by (squared distance, index). They are kept on the host with
/// their power, so that nothing has to be known of later photons, and their exact sum is aligned when all have come.
pub struct NearestPower<'a> {
    device: &'a Device,
    points: Vec<Points>,
    gather: Gather,
    /// k + 1.
    wanted: u32,
    /// So many places a point.
    found: Vec<Candidate>,
    counts: Vec<u32>,
    largest: LargestPower,
}

impl<'a> NearestPower<'a> {
    /// Nothing yet. Each of `points` is searched for at once: [`NEIGHBOURS_AT_ONCE`] says how many that may be.
    ///
    /// # Errors
    /// [`MapError::K`].
    pub fn new(device: &'a Device, points: Vec<Points>, k: u32, gather: Gather) -> Result<Self, MapError> {
        if k == 0 || k > MAX_K_IN_CHUNKS {
            return Err(MapError::K { k: u64::from(k), max: MAX_K_IN_CHUNKS });
        }
        let count: usize = points.iter().map(|points| points.count as usize).sum();
        let found = vec![Candidate::default(); count * (k as usize + 1)];
        let (wanted, counts, largest) = (k + 1, vec![0; count], LargestPower::default());
        Ok(Self { device, points, gather, wanted, found, counts, largest })
    }

    /// Bytes that a point with an estimate of `k` photons takes on the host.
    #[must_use]
    pub fn bytes_a_point(k: u32) -> u64 {
        u64::from(k + 1) * size_of::<Candidate>() as u64 + size_of::<u32>() as u64
    }

    /// Bytes that it takes on the host.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.found[..]) + size_of_val(&self.counts[..])) as u64
    }

    /// Bytes of neighbours that the host has while a map is added.
    #[must_use]
    pub fn bytes_while_added(&self) -> u64 {
        let most = self.points.iter().map(|points| u64::from(points.count)).max().unwrap_or_default();
        most * u64::from(self.wanted) * size_of::<Neighbour>() as u64
    }

    /// Adds a map of photons with these powers, W: those that follow the ones of maps before.
    ///
    /// # Errors
    /// [`MapError::CutShort`], [`MapError::Compact`], [`MapError::TooMany`] and [`MapError::Device`].
    pub fn add(&mut self, map: &PhotonMap, powers: &[[f32; 3]]) -> Result<(), MapError> {
        let Self { device, wanted, gather, .. } = *self;
        let k = wanted as usize;
        for power in powers {
            self.largest.raise(&LargestPower(*power));
        }
        let (mut rows, mut counts) = (&mut self.found[..], &mut self.counts[..]);
        for Points { queries, count } in &self.points {
            let mut plan = Plan::new();
            let found = map.plan_neighbours(device, &mut plan, queries, *count, wanted, gather)?;
            device.run(&plan)?;
            let news: Vec<u32> = device.read(&found.counts, u64::from(*count))?;
            whole(device, news.iter().copied())?;
            let neighbours: Vec<Neighbour> = device.read(&found.neighbours, u64::from(*count) * u64::from(wanted))?;
            let (part, rest) = rows.split_at_mut(*count as usize * k);
            let (of_part, others) = counts.split_at_mut(*count as usize);
            (rows, counts) = (rest, others);
            let known = part.par_chunks_exact_mut(k).zip(of_part);
            known.zip(neighbours.par_chunks_exact(k).zip(&news)).for_each_init(
                Vec::new,
                |merged, ((known, count), (news, &new))| {
                    let candidate = |&Neighbour { distance2, photon }: &Neighbour| Candidate {
                        distance2,
                        power: powers[photon as usize],
                    };
                    let news = news[..new as usize].iter().map(candidate);
                    *count = merge(known, *count, news, |one| one.distance2, merged);
                },
            );
        }
        Ok(())
    }

    /// The estimates from all maps so far, whose radius is `radius`, m.
    #[must_use]
    pub fn irradiance(&self, radius: f32) -> Vec<Irradiance> {
        let rows = self.found.par_chunks_exact(self.wanted as usize).zip(&self.counts);
        rows.map(|(row, &count)| self.estimate(&row[..count as usize], radius * radius)).collect()
    }

    /// The estimate from the k + 1 nearest photons, or from all within the radius if they are fewer.
    fn estimate(&self, found: &[Candidate], largest2: f32) -> Irradiance {
        let enough = found.len() == self.wanted as usize;
        let (counted, radius2) = match found.split_last() {
            Some((last, nearer)) if enough => (nearer, last.distance2),
            _ => (found, largest2),
        };
        let mut sums = [Limbs::ZERO; 3];
        for candidate in counted {
            for ((sum, power), largest) in sums.iter_mut().zip(candidate.power).zip(self.largest.0) {
                sum.add(Limbs::of(power, largest).0);
            }
        }
        let [red, green, blue] = sums.map(Limbs::settle);
        let limb = |i: usize| [red.0.0[i], green.0.0[i], blue.0.0[i]];
        let above = [red.1, green.1, blue.1];
        let photons = counted.len() as u32;
        let sum = PowerSum { high: limb(0), middle: limb(1), low: limb(2), above, photons };
        // The kernels' own code from here on. Photons that all lie in the point span no disc: the largest one stands for it there as well.
        density_of(&sum, if radius2 == 0.0 { largest2 } else { radius2 }, &self.largest.bits())
    }
}
