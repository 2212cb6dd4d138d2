//! Estimates from all photons within the radius, of photons that come in chunks.

use super::{LargestPower, Points, with_more};
use crate::map::whole;
use crate::{MapError, MapOptions, PhotonMap, RADII, query_count};
use caustic_device::{Buffer, Device, Plan};
use caustic_kernels::gather::{CUT_SHORT, density_of};
use caustic_kernels::layout::{Irradiance, Photon, PowerSum, Query};

/// Sums of the power of all photons within the radius of points, over maps that come one after another.
///
/// A point's sum is an integer that stays on the device from map to map. Since integers add up to the same in any order, the estimate has the
/// bits of [`PhotonMap::density`] in one map of all photons, wherever chunks begin and in whatever order they come.
pub struct DensitySums<'a> {
    device: &'a Device,
    parts: Vec<(Points, Buffer)>,
}

impl<'a> DensitySums<'a> {
    /// Nothing yet. Points of a part are searched for at once.
    ///
    /// # Errors
    /// [`MapError::Device`].
    pub fn new(device: &'a Device, parts: impl IntoIterator<Item = Points>) -> Result<Self, MapError> {
        let part = |points: Points| {
            let sums = device.buffer::<PowerSum>("sums of power", u64::from(points.count))?;
            Ok((points, sums))
        };
        Ok(Self { device, parts: parts.into_iter().map(part).collect::<Result<_, MapError>>()? })
    }

    /// Forgets all that was added.
    pub fn clear(&self) {
        for (points, sums) in &self.parts {
            self.device.write(sums, &vec![PowerSum::default(); points.count as usize]);
        }
    }

    /// Adds what a map holds. All maps have to be aligned to the same largest power, and to have the same radius.
    ///
    /// # Errors
    /// [`MapError::Device`]. A search that the device ends early shows in [`DensitySums::irradiance`].
    pub fn add(&self, map: &PhotonMap) -> Result<(), MapError> {
        for (points, sums) in &self.parts {
            let mut plan = Plan::new();
            map.plan_power(self.device, &mut plan, &points.queries, points.count, sums)?;
            self.device.run(&plan)?;
        }
        Ok(())
    }

    /// The estimates from all maps so far, which have `radius` (m) and are aligned to `largest`.
    ///
    /// # Errors
    /// [`MapError::CutShort`] and [`MapError::Device`].
    pub fn irradiance(&self, radius: f32, largest: &LargestPower) -> Result<Vec<Irradiance>, MapError> {
        let power = largest.bits();
        let mut estimates = Vec::with_capacity(self.parts.iter().map(|(points, _)| points.count as usize).sum());
        for (points, sums) in &self.parts {
            let sums: Vec<PowerSum> = self.device.read(sums, u64::from(points.count))?;
            // The kernels' own code: a device would say the same.
            estimates.extend(sums.iter().map(|sum| density_of(sum, radius * radius, &power)));
        }
        whole(self.device, estimates.iter().map(|estimate| estimate.photons))?;
        Ok(estimates)
    }
}

/// The irradiance at queries of the host from all photons within the radius, of photons of the host that come in chunks: [`DensitySums`].
pub struct DensityStreamed<'a> {
    options: MapOptions,
    largest: LargestPower,
    sums: DensitySums<'a>,
    /// Photons that have come.
    photons: u64,
}

/// Queries that are searched for at once: 68 bytes each, and 32 while they are sorted.
const AT_ONCE: usize = 1 << 20;

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
        let part =
            |queries: &[Query]| Ok(Points { queries: device.upload("queries", queries)?, count: queries.len() as u32 });
        let parts = queries.chunks(AT_ONCE).map(part).collect::<Result<Vec<_>, MapError>>()?;
        Ok(Self { options: *options, largest, sums: DensitySums::new(device, parts)?, photons: 0 })
    }

    /// Bytes that it takes on the device, and those of its estimates on the host.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let estimates = |points: &Points| u64::from(points.count) * size_of::<Irradiance>() as u64;
        let parts = self.sums.parts.iter();
        parts.map(|(points, sums)| points.queries.bytes() + sums.bytes() + estimates(points)).sum()
    }

    /// Adds photons.
    ///
    /// # Errors
    /// All of [`MapError`] but [`MapError::K`]; [`MapError::AboveLargest`] if a photon is more powerful than was said, and [`MapError::TooMany`]
    /// if their number would need more than 32 bits. A search that the device ends early shows in [`DensityStreamed::irradiance`].
    pub fn add(&mut self, photons: &[Photon]) -> Result<(), MapError> {
        let count = with_more(self.photons, photons.len(), CUT_SHORT - 1)?;
        self.largest.check(photons)?;
        let map = PhotonMap::build_below(self.sums.device, photons, &self.options, self.largest)?;
        self.sums.add(&map)?;
        self.photons = count;
        Ok(())
    }

    /// The estimates from all photons so far.
    ///
    /// # Errors
    /// [`MapError::CutShort`] and [`MapError::Device`].
    pub fn irradiance(&self) -> Result<Vec<Irradiance>, MapError> {
        self.sums.irradiance(self.options.radius, &self.largest)
    }
}
