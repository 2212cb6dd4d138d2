//! Estimates from all photons within the radius, of photons that come in chunks.

use super::with_more;
use crate::map::whole;
use crate::{MapError, MapOptions, PhotonMap, RADII, query_count};
use caustic_device::{Buffer, Device, Plan};
use caustic_kernels::gather::{CUT_SHORT, density_of};
use caustic_kernels::layout::{Irradiance, Photon, PowerSum, Query};

/// The largest power of photons in each channel, W: what the sums of a map are aligned to. Of chunks that are to count as one map it has to be
/// known before the first, so all photons are looked at once before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LargestPower(pub [f32; 3]);

impl LargestPower {
    /// Looks at more photons.
    pub fn see(&mut self, photons: &[Photon]) {
        for photon in photons {
            for (largest, power) in self.0.iter_mut().zip(photon.power) {
                *largest = largest.max(power);
            }
        }
    }

    /// Refuses photons above.
    fn check(&self, photons: &[Photon]) -> Result<(), MapError> {
        let above = |photon: &Photon| photon.power.iter().zip(&self.0).any(|(power, largest)| power > largest);
        match photons.iter().position(above) {
            Some(index) => Err(MapError::AboveLargest { index, power: photons[index].power, largest: self.0 }),
            None => Ok(()),
        }
    }

    fn bits(&self) -> [u32; 3] {
        self.0.map(f32::to_bits)
    }
}

/// The irradiance at queries from all photons within the radius, of photons that come in chunks.
///
/// A query's sum is an integer that stays on the device from chunk to chunk. Since integers add up to the same in any order, the result has the
/// bits of [`PhotonMap::density`] in one map of all photons, wherever chunks begin and in whatever order they come.
pub struct DensityStreamed<'a> {
    device: &'a Device,
    options: MapOptions,
    largest: LargestPower,
    parts: Vec<Part>,
    /// Photons that have come.
    photons: u64,
}

/// Queries that are searched for at once, and their sums.
struct Part {
    count: u32,
    queries: Buffer,
    sums: Buffer,
}

/// Queries of a part: 68 bytes each, and 32 while they are sorted.
const AT_ONCE: usize = 1 << 20;
/// Bytes of an estimate.
const ESTIMATE: u64 = size_of::<Irradiance>() as u64;

impl<'a> DensityStreamed<'a> {
    /// No photons yet. `largest` is that of all that will come.
    ///
    /// # Errors
    /// [`MapError::Radius`], [`MapError::NotFinite`], [`MapError::TooMany`] and [`MapError::Device`].
    pub fn new(
        device: &'a Device,
        queries: &[Query],
        largest: LargestPower,
        options: &MapOptions,
    ) -> Result<Self, MapError> {
        query_count(queries)?;
        if !RADII.contains(&options.radius) {
            return Err(MapError::Radius { radius: options.radius });
        }
        let part = |queries: &[Query]| {
            Ok(Part {
                count: queries.len() as u32,
                queries: device.upload("queries", queries)?,
                sums: device.buffer::<PowerSum>("sums of power", queries.len() as u64)?,
            })
        };
        let parts = queries.chunks(AT_ONCE).map(part).collect::<Result<_, MapError>>()?;
        Ok(Self { device, options: *options, largest, parts, photons: 0 })
    }

    /// Bytes that it takes on the device, and those of its estimates on the host.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let of = |part: &Part| part.queries.bytes() + part.sums.bytes() + u64::from(part.count) * ESTIMATE;
        self.parts.iter().map(of).sum()
    }

    /// Adds photons.
    ///
    /// # Errors
    /// All of [`MapError`] but [`MapError::K`]; [`MapError::AboveLargest`] if a photon is more powerful than was said, and [`MapError::TooMany`]
    /// if their number would need more than 32 bits. A search that the device ends early shows in [`DensityStreamed::irradiance`].
    pub fn add(&mut self, photons: &[Photon]) -> Result<(), MapError> {
        let count = with_more(self.photons, photons.len(), CUT_SHORT - 1)?;
        self.largest.check(photons)?;
        let map = PhotonMap::build_below(self.device, photons, &self.options, self.largest.bits())?;
        for Part { count, queries, sums } in &self.parts {
            let mut plan = Plan::new();
            map.plan_power(self.device, &mut plan, queries, *count, sums)?;
            self.device.run(&plan)?;
        }
        self.photons = count;
        Ok(())
    }

    /// The estimates from all photons so far.
    ///
    /// # Errors
    /// [`MapError::CutShort`] and [`MapError::Device`].
    pub fn irradiance(&self) -> Result<Vec<Irradiance>, MapError> {
        let (radius, power) = (self.options.radius, self.largest.bits());
        let mut estimates = Vec::new();
        for part in &self.parts {
            let sums: Vec<PowerSum> = self.device.read(&part.sums, u64::from(part.count))?;
            // The kernels' own code: a device would say the same.
            estimates.extend(sums.iter().map(|sum| density_of(sum, radius * radius, &power)));
        }
        whole(self.device, estimates.iter().map(|estimate| estimate.photons))?;
        Ok(estimates)
    }
}
