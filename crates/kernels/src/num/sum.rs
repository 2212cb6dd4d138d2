//! A sum that does not depend on the order of its terms.
//!
//! Floating-point addition rounds, so its result depends on the order; integer addition does not. Terms are aligned to a scale
//! that is the same for all, and added as 64-bit integers, in two `u32`. The neighbours of a query can then be summed in whatever
//! order a device, a hash or a container brings them, and the sum is more accurate than any order of `f32` additions.

/// Most terms of a [`Sum`] that keeps [`GUARD`] bits.
pub const MAX_TERMS: u32 = 1 << 10;
/// Bits kept below the last bit of the largest term: 64 − 24 of a significand − 10 for the number of terms.
pub const GUARD: u32 = 30;

/// Bits kept below the last bit of the largest of up to `terms` terms.
#[must_use]
pub fn guard_for(terms: u32) -> u32 {
    let bits = 32 - terms.leading_zeros();
    if bits > 10 { 40 - bits } else { GUARD }
}

/// The sum of finite numbers that are not negative.
///
/// Its error is below n·2^(−23 − guard) of the largest term that it was made for (bits beyond the guard bits are cut off), then
/// one rounding to the nearest `f32`. Subnormal terms count as zero.
#[derive(Clone, Copy)]
pub struct Sum {
    /// Biased exponent of a term whose significand ends at bit 0.
    zero: i32,
    high: u32,
    low: u32,
}

impl Sum {
    /// An empty sum for terms of at most `largest`, with this many guard bits: at most [`GUARD`].
    #[inline]
    #[must_use]
    pub fn new(largest: f32, guard: u32) -> Self {
        Self { zero: (largest.to_bits() >> 23) as i32 - guard as i32, high: 0, low: 0 }
    }

    /// Adds a term.
    #[inline]
    pub fn add(&mut self, term: f32) {
        let bits = term.to_bits();
        let exponent = (bits >> 23) as i32;
        // Zero, and what is subnormal, has no leading bit.
        let significand = if exponent == 0 { 0 } else { (bits & 0x007f_ffff) | 0x0080_0000 };
        let up = exponent - self.zero;
        let mut high = 0;
        let mut low = 0;
        if up >= 0 {
            let up = up as u32 & 31;
            low = significand << up;
            // In two steps, for a shift by 32 is none.
            high = (significand >> 1) >> (31 - up);
        } else if up > -24 {
            low = significand >> (0 - up) as u32;
        }
        let sum = self.low.wrapping_add(low);
        let carry = if sum < low { 1 } else { 0 };
        self.low = sum;
        self.high = self.high.wrapping_add(high).wrapping_add(carry);
    }

    /// Whether `terms` terms were so small against the scale that the bits cut off may show: fewer than 36 bits are sure. Then the
    /// sum is to be made again with their own largest.
    #[inline]
    #[must_use]
    pub fn is_vague(&self, terms: u32, guard: u32) -> bool {
        // Less than 2^(guard + 6) a term, which is 2⁻¹⁷ of the scale.
        let shift = guard + 6;
        let (high, low) =
            if shift >= 32 { (terms << (shift - 32), 0) } else { (terms >> (32 - shift), terms << shift) };
        self.high < high || (self.high == high && self.low < low)
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
        // A significand that ends at bit 0 has its top bit at 23; the sum's is at 63 − shift.
        let mut exponent = self.zero + 40 - shift as i32;
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
        let mut sum = Sum::new(terms.iter().copied().fold(0.0, f32::max), GUARD);
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

    #[test]
    fn a_sum_of_many_terms_has_room_for_them() {
        for (terms, guard) in [(1, 30), (1023, 30), (1024, 29), (1 << 20, 19), (u32::MAX, 8)] {
            assert_eq!(guard_for(terms), guard);
        }
        let count = (1 << 20) - 1;
        let mut sum = Sum::new(1.5, guard_for(count));
        (0..count).for_each(|_| sum.add(1.999_999_9));
        assert_eq!(sum.value(), (f64::from(1.999_999_9f32) * f64::from(count)) as f32);
    }

    /// What a scale far above the terms costs is noticed before it shows.
    #[test]
    fn a_sum_that_is_not_vague_is_right_whatever_its_scale() {
        let mut lcg = Lcg(5);
        let mut vague = [0, 0];
        for round in 0..2000u32 {
            let terms: Vec<f32> = (0..1 + round % 60).map(|_| 0.5 + lcg.next_u32() as f32 / u32::MAX as f32).collect();
            let exact: f64 = terms.iter().map(|&term| f64::from(term)).sum();
            for guard in [GUARD, 20, 8] {
                let mut sum = Sum::new(2f32.powi((round % 40) as i32), guard);
                terms.iter().for_each(|&term| sum.add(term));
                let is_vague = sum.is_vague(terms.len() as u32, guard);
                vague[usize::from(is_vague)] += 1;
                // 2⁻⁷ a guard bit less of the 2⁻³⁶ that GUARD promises, and the rounding.
                let bound = 2f64.powi(-6 - guard as i32) + 2f64.powi(-24) * 1.000_01;
                assert!(is_vague || (f64::from(sum.value()) - exact).abs() <= exact * bound);
                assert!(!is_vague || round % 40 >= 16, "a scale of 2^{} is no reason", round % 40);
            }
        }
        assert!(vague[0] > 1000 && vague[1] > 1000, "{vague:?}");
    }
}
