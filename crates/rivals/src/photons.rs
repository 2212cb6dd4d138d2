//! Photons on a device, as every technique is given them.

use caustic_device::{Buffer, Device};
use caustic_kernels::layout::Photon;
use caustic_photon_map::{MapError, bounds, sample};

/// Photons on a device, and what the host knows of them.
pub struct Photons {
    /// Records of [`Photon`], in the order that decides among those at the same distance.
    pub buffer: Buffer,
    /// How many.
    pub count: u32,
    /// Lowest corner of their box, m.
    pub low: [f32; 3],
    /// Highest corner of their box, m.
    pub high: [f32; 3],
    /// Positions of some, evenly from all, m.
    pub sample: Vec<[f32; 3]>,
    /// The largest power in each channel, as bits of an `f32`, W.
    pub power: Buffer,
}

impl Photons {
    /// Puts photons on a device.
    ///
    /// # Errors
    /// [`MapError::NotFinite`], [`MapError::TooMany`] and [`MapError::Device`].
    pub fn upload(device: &Device, photons: &[Photon]) -> Result<Self, MapError> {
        let (low, high) = bounds("photons", photons.iter().map(|photon| photon.position))?;
        let count = u32::try_from(photons.len()).map_err(|_| MapError::TooMany {
            what: "photons",
            count: photons.len() as u64,
            max: u32::MAX,
        })?;
        let largest = |channel: usize| photons.iter().map(|photon| photon.power[channel]).fold(0.0, f32::max).to_bits();
        Ok(Self {
            buffer: device.upload("photons", photons)?,
            count,
            low,
            high,
            sample: sample(photons),
            power: device.upload("photons: largest powers", &[largest(0), largest(1), largest(2)])?,
        })
    }
}
