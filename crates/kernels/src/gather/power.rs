//! Power of photons, added up so that their order does not show.

use crate::exec::Input;
use crate::layout::{Arrival, Photon};
use crate::num::Limbs;

/// Sums of the three channels, in limbs.
#[derive(Clone, Copy)]
pub(crate) struct Power {
    high: [u32; 3],
    middle: [u32; 3],
    low: [u32; 3],
}

impl Power {
    #[inline]
    pub(crate) fn new() -> Self {
        Self { high: [0; 3], middle: [0; 3], low: [0; 3] }
    }

    /// Sums whose limbs are given, of red, green and blue each.
    #[inline]
    pub(super) fn of_limbs(high: [u32; 3], middle: [u32; 3], low: [u32; 3]) -> Self {
        Self { high, middle, low }
    }

    /// The limbs of red, green and blue, the highest first.
    #[inline]
    pub(super) fn limbs(&self) -> [[u32; 3]; 3] {
        [self.high, self.middle, self.low]
    }

    /// Adds a photon's power: at most [`MAX_TERMS`](crate::num::MAX_TERMS) of them.
    #[inline]
    pub(super) fn add(&mut self, arrival: Arrival) {
        let [high, middle, low] = arrival.limbs();
        self.high = sums(self.high, high);
        self.middle = sums(self.middle, middle);
        self.low = sums(self.low, low);
    }

    /// Adds a photon's power times a weight of at most 1, rounded to `f32`. `scale` are the largest powers of the map.
    #[inline]
    pub(super) fn add_weighted(&mut self, arrival: Arrival, weight: f32, scale: [f32; 3]) {
        let [high, middle, low] = arrival.limbs();
        let red = Limbs([high[0], middle[0], low[0]]).value(scale[0]) * weight;
        let green = Limbs([high[1], middle[1], low[1]]).value(scale[1]) * weight;
        let blue = Limbs([high[2], middle[2], low[2]]).value(scale[2]) * weight;
        self.add_power([red, green, blue], scale);
    }

    /// Adds the power of a photon that is not in limbs yet; `power` as in [`Power::value`].
    #[inline]
    pub(crate) fn add_photon(&mut self, photon: &Photon, power: &Input<u32>) {
        self.add_power(photon.power, [f32::from_bits(power[0]), f32::from_bits(power[1]), f32::from_bits(power[2])]);
    }

    /// Adds a power that is not in limbs yet, W; `scale` as in [`Power::add_weighted`].
    #[inline]
    pub(super) fn add_power(&mut self, power: [f32; 3], scale: [f32; 3]) {
        let red = Limbs::of(power[0], scale[0]).0;
        let green = Limbs::of(power[1], scale[1]).0;
        let blue = Limbs::of(power[2], scale[2]).0;
        self.high = sums(self.high, [red[0], green[0], blue[0]]);
        self.middle = sums(self.middle, [red[1], green[1], blue[1]]);
        self.low = sums(self.low, [red[2], green[2], blue[2]]);
    }

    /// Makes room for half as many more; returns what leaves the highest limb of each channel.
    #[inline]
    pub(super) fn settle(&mut self) -> [u32; 3] {
        let (red, above_red) = self.channel(0).settle();
        let (green, above_green) = self.channel(1).settle();
        let (blue, above_blue) = self.channel(2).settle();
        self.high = [red.0[0], green.0[0], blue.0[0]];
        self.middle = [red.0[1], green.0[1], blue.0[1]];
        self.low = [red.0[2], green.0[2], blue.0[2]];
        [above_red, above_green, above_blue]
    }

    /// The limbs of a channel.
    #[inline]
    pub(super) fn channel(&self, channel: usize) -> Limbs {
        Limbs([self.high[channel], self.middle[channel], self.low[channel]])
    }

    /// The sums, W. `power` are the largest powers of the map, to which limbs are aligned, as bits.
    #[inline]
    pub(crate) fn value(&self, power: &Input<u32>) -> [f32; 3] {
        [
            self.channel(0).value(f32::from_bits(power[0])),
            self.channel(1).value(f32::from_bits(power[1])),
            self.channel(2).value(f32::from_bits(power[2])),
        ]
    }
}

#[inline]
fn sums(a: [u32; 3], b: [u32; 3]) -> [u32; 3] {
    [a[0].wrapping_add(b[0]), a[1].wrapping_add(b[1]), a[2].wrapping_add(b[2])]
}
