//! Power of photons, added up so that their order does not show.

use crate::exec::Input;
use crate::layout::{Arrival, Photon, Quad, high_parts};
use crate::num::Limbs;

/// Terms after which a sum has to [settle](Power::settle) at the latest.
pub(super) const SETTLE_AFTER: u32 = 1 << 15;

/// Where [`Power::value`] finds in the map's largest powers whether its photons have bits in [`Arrival::low_parts`].
const WIDE: usize = 3;

/// Whether photons of a map have bits in [`Arrival::low_parts`]: then [`Power::add_at`] has to read them.
#[inline]
pub(super) fn is_wide(power: &Input<u32>) -> bool {
    power[WIDE] != 0
}

/// Sums of the three channels, of the parts of 66 bits that an [`Arrival`] has: the highest 16, the next 16, the next 10 and the last
/// 24. None overflows before it is to settle, so that most photons are added without a carry.
#[derive(Clone, Copy)]
pub(crate) struct Power {
    highest: [u32; 3],
    high: [u32; 3],
    middle: [u32; 3],
    low: [u32; 3],
}

impl Power {
    #[inline]
    pub(crate) fn new() -> Self {
        Self { highest: [0; 3], high: [0; 3], middle: [0; 3], low: [0; 3] }
    }

    /// Adds the power of the photon at `slot`. Only if photons are `wide`, their lowest bits are read.
    #[inline]
    pub(super) fn add_at(&mut self, arrivals: &Input<Arrival>, slot: u32, wide: bool) {
        self.add_ahead(arrivals[slot as usize].ahead(), arrivals, slot, wide);
    }

    /// [`Power::add_at`] of a photon of which the highest bits are already here.
    #[inline]
    pub(super) fn add_ahead(&mut self, ahead: Quad, arrivals: &Input<Arrival>, slot: u32, wide: bool) {
        self.add_high(ahead);
        if wide {
            self.add_low(arrivals[slot as usize].low_parts());
        }
    }

    /// Adds a photon's power times a weight of at most 1, rounded to `f32`. `scale` are the largest powers of the map.
    #[inline]
    pub(super) fn add_weighted(&mut self, arrival: Arrival, weight: f32, scale: [f32; 3]) {
        let [high, middle, low] = arrival.limbs();
        let red = Limbs::of(Limbs([high[0], middle[0], low[0]]).value(scale[0]) * weight, scale[0]);
        let green = Limbs::of(Limbs([high[1], middle[1], low[1]]).value(scale[1]) * weight, scale[1]);
        let blue = Limbs::of(Limbs([high[2], middle[2], low[2]]).value(scale[2]) * weight, scale[2]);
        self.add(Arrival::new(red.0, green.0, blue.0, 0, 0));
    }

    /// Adds the power of a photon that is not in parts yet; `power` as in [`Power::value`].
    #[inline]
    pub(crate) fn add_photon(&mut self, photon: &Photon, power: &Input<u32>) {
        let red = Limbs::of(photon.power[0], f32::from_bits(power[0]));
        let green = Limbs::of(photon.power[1], f32::from_bits(power[1]));
        let blue = Limbs::of(photon.power[2], f32::from_bits(power[2]));
        self.add(Arrival::new(red.0, green.0, blue.0, 0, 0));
    }

    /// Adds an arrival.
    #[inline]
    pub(super) fn add(&mut self, arrival: Arrival) {
        self.add_high(arrival.ahead());
        self.add_low(arrival.low_parts());
    }

    #[inline]
    fn add_high(&mut self, high: Quad) {
        let (top, middle) = high_parts(high);
        self.highest = sums(self.highest, [top[0] >> 16, top[1] >> 16, top[2] >> 16]);
        self.high = sums(self.high, [top[0] & 0xffff, top[1] & 0xffff, top[2] & 0xffff]);
        self.middle = sums(self.middle, middle);
    }

    /// Adds lowest parts, and carries what they gather beyond their bits.
    #[inline]
    fn add_low(&mut self, low: [u32; 3]) {
        let low = sums(self.low, low);
        self.middle = sums(self.middle, [low[0] >> 24, low[1] >> 24, low[2] >> 24]);
        self.low = [low[0] & 0x00ff_ffff, low[1] & 0x00ff_ffff, low[2] & 0x00ff_ffff];
    }

    /// Makes room for [`SETTLE_AFTER`] more; returns what leaves the 66 bits of each channel.
    #[inline]
    pub(super) fn settle(&mut self) -> [u32; 3] {
        let high = sums(self.high, [self.middle[0] >> 10, self.middle[1] >> 10, self.middle[2] >> 10]);
        let highest = sums(self.highest, [high[0] >> 16, high[1] >> 16, high[2] >> 16]);
        self.middle = [self.middle[0] & 0x3ff, self.middle[1] & 0x3ff, self.middle[2] & 0x3ff];
        self.high = [high[0] & 0xffff, high[1] & 0xffff, high[2] & 0xffff];
        self.highest = [highest[0] & 0xffff, highest[1] & 0xffff, highest[2] & 0xffff];
        [highest[0] >> 16, highest[1] >> 16, highest[2] >> 16]
    }

    /// The sums, W. `power` are the largest powers of the map, to which parts are aligned, as bits.
    #[inline]
    pub(crate) fn value(mut self, power: &Input<u32>) -> [f32; 3] {
        let above = self.settle();
        self.value_with(above, power)
    }

    /// The sums and what has left their 66 bits, W, of one that has settled.
    #[inline]
    pub(super) fn value_with(&self, above: [u32; 3], power: &Input<u32>) -> [f32; 3] {
        let red = limbs(self.highest[0], self.high[0], self.middle[0], self.low[0]);
        let green = limbs(self.highest[1], self.high[1], self.middle[1], self.low[1]);
        let blue = limbs(self.highest[2], self.high[2], self.middle[2], self.low[2]);
        [
            red.value_with(above[0], f32::from_bits(power[0])),
            green.value_with(above[1], f32::from_bits(power[1])),
            blue.value_with(above[2], f32::from_bits(power[2])),
        ]
    }
}

/// The limbs of a channel that has settled.
#[inline]
fn limbs(highest: u32, high: u32, middle: u32, low: u32) -> Limbs {
    Limbs([(highest << 6) | (high >> 10), ((high & 0x3ff) << 12) | (middle << 2) | (low >> 22), low & 0x003f_ffff])
}

#[inline]
fn sums(a: [u32; 3], b: [u32; 3]) -> [u32; 3] {
    [a[0].wrapping_add(b[0]), a[1].wrapping_add(b[1]), a[2].wrapping_add(b[2])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::samples::Lcg;
    use std::vec::Vec;

    fn arrivals(lcg: &mut Lcg, count: u32, binades: u32, scale: f32) -> Vec<Arrival> {
        (0..count)
            .map(|_| {
                let mut limbs = || {
                    let bits = scale.to_bits() - ((lcg.next_u32() % (binades + 1)) << 23);
                    Limbs::of(f32::from_bits((bits & 0x7f80_0000) | (lcg.next_u32() & 0x007f_ffff)), scale).0
                };
                Arrival::new(limbs(), limbs(), limbs(), 0, 0)
            })
            .collect()
    }

    /// The same sums in limbs, which `num` proves exact.
    fn in_limbs(arrivals: &[Arrival], scale: f32) -> [f32; 3] {
        let (mut sums, mut above) = ([Limbs::ZERO; 3], [0; 3]);
        for arrival in arrivals {
            let [high, middle, low] = arrival.limbs();
            for channel in 0..3 {
                sums[channel].add([high[channel], middle[channel], low[channel]]);
                let left;
                (sums[channel], left) = sums[channel].settle();
                above[channel] += left;
            }
        }
        [0, 1, 2].map(|channel| sums[channel].value_with(above[channel], scale))
    }

    #[test]
    fn parts_add_up_to_what_limbs_do() {
        let mut lcg = Lcg(11);
        for (count, binades, wide) in [
            (0, 5, true),
            (1, 0, false),
            (50, 18, false),
            (1025, 18, false),
            (1025, 60, true),
            (3 * SETTLE_AFTER + 5, 2, false),
            (3 * SETTLE_AFTER, 50, true),
        ] {
            let scale = 1.75;
            let arrivals = arrivals(&mut lcg, count, binades, scale);
            let power = [scale.to_bits(), scale.to_bits(), scale.to_bits(), u32::from(wide)];
            let (mut sum, mut above) = (Power::new(), [0; 3]);
            for slot in 0..count {
                sum.add_at(&arrivals, slot, is_wide(&power));
                if (slot + 1) % SETTLE_AFTER == 0 {
                    let left = sum.settle();
                    above = [above[0] + left[0], above[1] + left[1], above[2] + left[2]];
                }
            }
            let left = sum.settle();
            above = [above[0] + left[0], above[1] + left[1], above[2] + left[2]];
            assert_eq!(sum.value_with(above, &power), in_limbs(&arrivals, scale), "{count} of {binades} binades");
        }
    }

    #[test]
    fn the_largest_terms_fill_no_part_before_it_settles() {
        let limbs = [0x003f_ffff; 3];
        let arrivals = [Arrival::new(limbs, limbs, limbs, 7, 8)];
        assert_eq!(arrivals[0].limbs(), [limbs; 3]);
        assert_eq!((arrivals[0].direction(), arrivals[0].primitive()), (7, 8));
        let mut sum = Power::new();
        for _ in 0..SETTLE_AFTER {
            sum.add_at(&arrivals, 0, true);
        }
        // 2¹⁵ times 2⁶⁶ − 1.
        let above = sum.settle();
        let blue = super::limbs(sum.highest[2], sum.high[2], sum.middle[2], sum.low[2]);
        assert_eq!(
            (above, blue),
            ([SETTLE_AFTER - 1; 3], Limbs([0x003f_ffff, 0x003f_ffff, 0x0040_0000 - SETTLE_AFTER]))
        );
    }
}
