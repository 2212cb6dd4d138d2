//! A sum that does not depend on the order of its terms.
//!
//! Floating-point addition rounds, so its result depends on the order; integer addition does not. Terms are aligned to the
//! largest and added as 64-bit integers, in two `u32`. The neighbours of a query can then be summed in whatever order a
//! device, a hash or a container brings them, and the sum is more accurate than any order of `f32` additions.

/// Most terms of a [`Sum`].
pub const MAX_TERMS: u32 = 1 << 10;

/// Bits kept below the last bit of the largest term: 64 − 24 of a significand − 10 for the number of terms.
const GUARD: u32 = 30;

/// The sum of up to [`MAX_TERMS`] finite numbers that are not negative.
///
/// Its error is below n·2⁻⁵³ of the largest term (bits beyond the guard bits are cut off), then one rounding to the nearest
/// `f32`. Subnormal terms count as zero.
#[derive(Clone, Copy)]
pub struct Sum {
    /// Biased exponent of the largest term.
    exponent: u32,
    high: u32,
    low: u32,
}

impl Sum {
    /// An empty sum for terms of at most `largest`.
    #[inline]
    #[must_use]
    pub fn new(largest: f32) -> Self {
        Self { exponent: (largest.to_bits() >> 23) & 0xff, high: 0, low: 0 }
    }

    /// Adds a term.
    #[inline]
    pub fn add(&mut self, term: f32) {
        let bits = term.to_bits();
        let exponent = (bits >> 23) & 0xff;
        if exponent == 0 {
            return;
        }
        let significand = (bits & 0x007f_ffff) | 0x0080_0000;
        let down = self.exponent - exponent;
        let mut high = 0;
        let mut low = 0;
        if down <= GUARD {
            let up = GUARD - down;
            low = significand << up;
            // The significand has 24 bits: up to eight places it stays in the low word.
            if up > 8 {
                high = significand >> (32 - up);
            }
        } else if down < GUARD + 24 {
            low = significand >> (down - GUARD);
        }
        let sum = self.low.wrapping_add(low);
        let carry = if sum < low { 1 } else { 0 };
        self.low = sum;
        self.high = self.high.wrapping_add(high).wrapping_add(carry);
    }

    /// The sum, rounded to the nearest `f32`, ties to even; infinite beyond the largest.
    #[inline]
    #[must_use]
    pub fn value(&self) -> f32 {
        if self.high == 0 && self.low == 0 {
            return 0.0;
        }
        // Left-justify the 64 bits.
        let mut high = self.high;
        let mut low = self.low;
        let mut shift = 0;
        if high == 0 {
            high = low;
            low = 0;
            shift = 32;
        }
        let zeros = high.leading_zeros();
        if zeros > 0 {
            high = (high << zeros) | (low >> (32 - zeros));
            low <<= zeros;
        }
        shift += zeros;
        // The largest term's significand has its top bit at 23 + GUARD = 53; the sum's is at 63 − shift.
        let mut exponent = self.exponent as i32 + 10 - shift as i32;
        let mut significand = high >> 8;
        let rest = high & 0xff;
        let above_half = rest > 0x80 || (rest == 0x80 && (low != 0 || significand & 1 == 1));
        if above_half {
            significand += 1;
            if significand == 0x0100_0000 {
                significand = 0x0080_0000;
                exponent += 1;
            }
        }
        if exponent >= 255 {
            return f32::from_bits(0x7f80_0000);
        }
        if exponent <= 0 {
            return 0.0;
        }
        f32::from_bits(((exponent as u32) << 23) | (significand & 0x007f_ffff))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::samples::Lcg;
    use std::vec::Vec;

    fn sum(terms: &[f32]) -> f32 {
        let mut sum = Sum::new(terms.iter().copied().fold(0.0, f32::max));
        for &term in terms {
            sum.add(term);
        }
        sum.value()
    }

    /// Positive numbers over twelve decades.
    fn powers(lcg: &mut Lcg, count: u32) -> Vec<f32> {
        (0..count).map(|_| 10f32.powf(lcg.next_u32() as f32 / u32::MAX as f32 * 12.0 - 9.0)).collect()
    }

    #[test]
    fn a_sum_over_twelve_decades_is_the_exact_one_rounded() {
        let mut lcg = Lcg(7);
        for count in [1, 2, 3, 10, 50, 512, 1024] {
            for _ in 0..500 {
                let terms = powers(&mut lcg, count);
                let exact: f64 = terms.iter().map(|&term| f64::from(term)).sum();
                // Half a unit in the last place for the rounding, and the bits cut off: 1024·2⁻⁵³ of it.
                let unit = f64::from(f32::from_bits((exact as f32).to_bits() + 1)) - f64::from(exact as f32);
                let error = (f64::from(sum(&terms)) - exact).abs();
                assert!(error <= 0.5 * unit * (1.0 + 1e-6), "{count} terms: {error} of {exact}");
            }
        }
    }

    #[test]
    fn plain_addition_would_miss_that_bound() {
        let mut lcg = Lcg(7);
        let missed = (0..500)
            .filter(|_| {
                let terms = powers(&mut lcg, 1024);
                let exact: f64 = terms.iter().map(|&term| f64::from(term)).sum();
                terms.iter().sum::<f32>() != exact as f32
            })
            .count();
        assert!(missed > 250, "{missed}");
    }

    #[test]
    fn order_does_not_matter() {
        let mut lcg = Lcg(3);
        for _ in 0..200 {
            let mut terms = powers(&mut lcg, 300);
            let forward = sum(&terms);
            terms.reverse();
            assert_eq!(forward.to_bits(), sum(&terms).to_bits());
            terms.sort_by(f32::total_cmp);
            assert_eq!(forward.to_bits(), sum(&terms).to_bits());
        }
    }

    #[test]
    fn the_ends_of_the_range() {
        assert_eq!(sum(&[]), 0.0);
        assert_eq!(sum(&[0.0, 0.0]), 0.0);
        assert_eq!(sum(&[f32::MIN_POSITIVE; 2]), 2.0 * f32::MIN_POSITIVE);
        assert_eq!(sum(&[1.0, 1e-30]), 1.0);
        assert_eq!(sum(&[16_777_216.0, 1.0]), 16_777_216.0, "ties go to even");
        assert_eq!(sum(&[16_777_216.0, 1.0, 2.0]), 16_777_220.0, "16777219 is a tie, and even is above");
        assert_eq!(sum(&[f32::MAX, f32::MAX]), f32::INFINITY);
        assert_eq!(sum(&[f32::MAX; 1]), f32::MAX);
        assert_eq!(sum(&[1.0; 1024]), 1024.0);
        assert_eq!(sum(&[f32::from_bits(0x3fff_ffff); 1024]), 1024.0 * f32::from_bits(0x3fff_ffff));
    }
}
