//! Power of photons, added up so that their order does not show.

use crate::layout::Arrival;
use crate::num::{Sum, max};

/// Sums of the three channels, W.
///
/// Terms are aligned to the largest power of the map, so that one walk is enough. Where a channel is so weak beside it that the
/// result might not be exact to an `f32` any more, it is [vague](Power::is_vague), and is summed again with a scale of its own:
/// that is rare, and depends on the terms alone. A channel that is zero in the whole map is zero.
#[derive(Clone, Copy)]
pub(super) struct Power {
    red: Sum,
    green: Sum,
    blue: Sum,
}

impl Power {
    #[inline]
    pub(super) fn new(scale: [f32; 3], guard: u32) -> Self {
        Self { red: Sum::new(scale[0], guard), green: Sum::new(scale[1], guard), blue: Sum::new(scale[2], guard) }
    }

    #[inline]
    pub(super) fn add(&mut self, arrival: &Arrival) {
        let power = arrival.power;
        self.red.add(power[0]);
        self.green.add(power[1]);
        self.blue.add(power[2]);
    }

    /// Which channels have to be summed again.
    #[inline]
    fn vague(&self, scale: [f32; 3], guard: u32, terms: u32) -> [bool; 3] {
        [
            scale[0] > 0.0 && self.red.is_vague(terms, guard),
            scale[1] > 0.0 && self.green.is_vague(terms, guard),
            scale[2] > 0.0 && self.blue.is_vague(terms, guard),
        ]
    }

    /// Whether a channel has to be summed again.
    #[inline]
    pub(super) fn is_vague(&self, scale: [f32; 3], guard: u32, terms: u32) -> bool {
        let vague = self.vague(scale, guard, terms);
        vague[0] || vague[1] || vague[2]
    }

    #[inline]
    pub(super) fn value(&self) -> [f32; 3] {
        [self.red.value(), self.green.value(), self.blue.value()]
    }

    /// The sums, those that are vague taken from `again`.
    #[inline]
    pub(super) fn value_or(&self, again: &Self, scale: [f32; 3], guard: u32, terms: u32) -> [f32; 3] {
        let vague = self.vague(scale, guard, terms);
        let (first, second) = (self.value(), again.value());
        [
            if vague[0] { second[0] } else { first[0] },
            if vague[1] { second[1] } else { first[1] },
            if vague[2] { second[2] } else { first[2] },
        ]
    }
}

/// The largest powers of the map, which the construction left as bits.
#[inline]
pub(super) fn scale_of(power: &[u32]) -> [f32; 3] {
    [f32::from_bits(power[0]), f32::from_bits(power[1]), f32::from_bits(power[2])]
}

/// The larger of each channel.
#[inline]
pub(super) fn larger(scale: [f32; 3], arrival: &Arrival) -> [f32; 3] {
    let power = arrival.power;
    [max(scale[0], power[0]), max(scale[1], power[1]), max(scale[2], power[2])]
}
