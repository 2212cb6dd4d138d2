//! Power of photons, added up so that their order does not show.

use crate::layout::Arrival;
use crate::num::{Sum, max};

/// Sums of the three channels, W.
///
/// Terms are aligned to the largest power of the map, so that one walk is enough. Where a channel is so weak beside it that the
/// result might not be exact to an `f32` any more, it is [vague](Power::is_vague), and is summed again with a scale of its own:
/// that is rare, and depends on the terms alone.
#[derive(Clone, Copy)]
pub(super) struct Power {
    sums: [Sum; 3],
    /// All bits of a channel's terms, to know whether there was anything at all.
    bits: [u32; 3],
    guard: u32,
}

impl Power {
    #[inline]
    pub(super) fn new(scale: [f32; 3], guard: u32) -> Self {
        Self {
            sums: [Sum::new(scale[0], guard), Sum::new(scale[1], guard), Sum::new(scale[2], guard)],
            bits: [0; 3],
            guard,
        }
    }

    #[inline]
    pub(super) fn add(&mut self, arrival: &Arrival) {
        let power = arrival.power;
        self.sums[0].add(power[0]);
        self.sums[1].add(power[1]);
        self.sums[2].add(power[2]);
        self.bits = [
            self.bits[0] | power[0].to_bits(),
            self.bits[1] | power[1].to_bits(),
            self.bits[2] | power[2].to_bits(),
        ];
    }

    #[inline]
    fn channel_is_vague(&self, channel: usize, terms: u32) -> bool {
        self.bits[channel] >> 23 != 0 && self.sums[channel].is_vague(terms, self.guard)
    }

    /// Whether a channel has to be summed again.
    #[inline]
    pub(super) fn is_vague(&self, terms: u32) -> bool {
        self.channel_is_vague(0, terms) || self.channel_is_vague(1, terms) || self.channel_is_vague(2, terms)
    }

    #[inline]
    pub(super) fn value(&self) -> [f32; 3] {
        [self.sums[0].value(), self.sums[1].value(), self.sums[2].value()]
    }

    /// The sums, those that are vague taken from `again`.
    #[inline]
    pub(super) fn value_or(&self, again: &Self, terms: u32) -> [f32; 3] {
        let (first, second) = (self.value(), again.value());
        [
            if self.channel_is_vague(0, terms) { second[0] } else { first[0] },
            if self.channel_is_vague(1, terms) { second[1] } else { first[1] },
            if self.channel_is_vague(2, terms) { second[2] } else { first[2] },
        ]
    }
}

/// The larger of each channel.
#[inline]
pub(super) fn larger(scale: [f32; 3], arrival: &Arrival) -> [f32; 3] {
    let power = arrival.power;
    [max(scale[0], power[0]), max(scale[1], power[1]), max(scale[2], power[2])]
}
