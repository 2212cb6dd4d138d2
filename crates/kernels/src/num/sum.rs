//! A sum that does not depend on the order of its terms.
//!
//! Floating-point addition rounds, so its result depends on the order; integer addition does not. Terms are converted once, to fixed
//! point below a scale that is the same for all, in three limbs of 22 bits. A limb has ten bits to spare in its `u32`, so that a
//! term is added by three integer additions without a carry (carry-save, as in Kulisch's accumulators; Demmel and Nguyen, "Fast
//! Reproducible Floating-Point Summation", 2013, for the problem). The neighbours of a query can then be summed in whatever order
//! a device, a hash or a container brings them, and the sum is more accurate than any order of `f32` additions.

/// Most terms that are added before a sum has to [settle](Limbs::settle).
pub const MAX_TERMS: u32 = 1 << 10;

/// Bits of a limb.
const BITS: u32 = 22;
const MASK: u32 = (1 << BITS) - 1;
/// Where the lowest bit of a significand lies whose number has the scale's exponent: the highest of 66 bits is its leading one.
const TOP: i32 = 3 * BITS as i32 - 24;

/// A number that is not negative, in units of 2^(e − 127 − 23 − 42), where e is the biased exponent of the scale: the highest limb
/// first. A number keeps all its bits down to 2⁻⁴² of the scale (2·10⁻¹³), and what is below 2⁻⁶⁶ of it is cut off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limbs(pub [u32; 3]);

impl Limbs {
    /// Zero.
    pub const ZERO: Self = Self([0; 3]);

    /// A finite number of at most the exponent of `scale`. Subnormal ones count as zero.
    #[inline]
    #[must_use]
    pub fn of(term: f32, scale: f32) -> Self {
        let bits = term.to_bits();
        let exponent = (bits >> 23) as i32;
        let significand = if exponent == 0 { 0 } else { (bits & 0x007f_ffff) | 0x0080_0000 };
        // Place of its lowest bit.
        let place = TOP - ((scale.to_bits() >> 23) as i32 - exponent);
        Self([
            part(significand, place - 2 * BITS as i32),
            part(significand, place - BITS as i32),
            part(significand, place),
        ])
    }

    /// Adds a term.
    #[inline]
    pub fn add(&mut self, term: [u32; 3]) {
        self.0 = [self.0[0].wrapping_add(term[0]), self.0[1].wrapping_add(term[1]), self.0[2].wrapping_add(term[2])];
    }

    /// Makes room for half of [`MAX_TERMS`] more: moves what the limbs have gathered beyond their 22 bits up. What leaves the highest is
    /// returned.
    #[inline]
    #[must_use]
    pub fn settle(self) -> (Self, u32) {
        let [high, middle, low] = self.carry().0;
        (Self([high & MASK, middle, low]), high >> BITS)
    }

    /// Moves what the lower limbs have gathered beyond their 22 bits up.
    #[inline]
    fn carry(self) -> Self {
        let [high, middle, low] = self.0;
        let middle = middle.wrapping_add(low >> BITS);
        Self([high.wrapping_add(middle >> BITS), middle & MASK, low & MASK])
    }

    /// The number, rounded to the nearest `f32`, ties to even; infinite beyond the largest.
    #[inline]
    #[must_use]
    pub fn value(self, scale: f32) -> f32 {
        self.value_at((scale.to_bits() >> 23) as i32)
    }

    /// The number plus `above` times what the highest limb leaves: 2⁶⁶ of the lowest bit.
    #[inline]
    #[must_use]
    pub fn value_with(self, above: u32, scale: f32) -> f32 {
        let [high, middle, low] = self.carry().0;
        let exponent = (scale.to_bits() >> 23) as i32;
        if above == 0 {
            return Self([high, middle, low]).value_at(exponent);
        }
        // Of the lowest limb it only matters whether there is anything.
        let rest = if low != 0 { 1 } else { 0 };
        Self([above + (high >> BITS), high & MASK, middle | rest]).value_at(exponent + BITS as i32)
    }

    /// [`Limbs::value`] below a scale with this biased exponent.
    #[inline]
    fn value_at(self, exponent: i32) -> f32 {
        let [top, middle, low] = self.carry().0;
        // 76 bits in three words: the highest 32 that are not zero, and whether anything is below.
        if top == 0 && middle == 0 && low == 0 {
            return 0.0;
        }
        let mut head = top;
        let mut tail = (middle << 10) | (low >> 12);
        let mut rest = low << 20;
        // The weight of head's lowest bit.
        let mut place = 2 * BITS as i32;
        if head == 0 {
            head = tail;
            tail = rest;
            rest = 0;
            place -= 32;
        }
        if head == 0 {
            head = tail;
            tail = rest;
            rest = 0;
            place -= 32;
        }
        let zeros = head.leading_zeros();
        if zeros > 0 {
            head = (head << zeros) | (tail >> (32 - zeros));
            tail <<= zeros;
        }
        // The leading bit is now bit 31: 2^(place + 31 − zeros − 42 − 23) of the scale's exponent.
        let mut exponent = exponent + place + 31 - zeros as i32 - TOP - 23;
        let mut significand = head >> 8;
        let below = head & 0xff;
        if below > 0x80 || (below == 0x80 && (tail != 0 || rest != 0 || significand & 1 == 1)) {
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

/// The 22 bits of a significand, whose lowest bit lies at `place` of a limb.
#[inline]
fn part(significand: u32, place: i32) -> u32 {
    if place >= 0 {
        if place < BITS as i32 { (significand << place as u32) & MASK } else { 0 }
    } else if place > -24 {
        (significand >> (0 - place) as u32) & MASK
    } else {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::samples::Lcg;
    use std::vec::Vec;

    fn sum_below(scale: f32, terms: &[f32]) -> f32 {
        let mut sum = Limbs::ZERO;
        for &term in terms {
            sum.add(Limbs::of(term, scale).0);
        }
        sum.value(scale)
    }

    fn sum(terms: &[f32]) -> f32 {
        sum_below(terms.iter().copied().fold(0.0, f32::max), terms)
    }

    /// Positive numbers over twelve decades.
    fn powers(lcg: &mut Lcg, count: u32) -> Vec<f32> {
        (0..count).map(|_| 10f32.powf(lcg.next_u32() as f32 / u32::MAX as f32 * 12.0 - 9.0)).collect()
    }

    #[test]
    fn a_number_comes_back_as_it_was() {
        let mut lcg = Lcg(1);
        for i in 0..200_000u32 {
            let scale = f32::from_bits((lcg.next_u32() % 0x7f00_0000).max(0x1800_0000));
            let down = (i % 43) << 23;
            let term = f32::from_bits((scale.to_bits() & 0x7f80_0000 | lcg.next_u32() & 0x007f_ffff) - down);
            assert_eq!(Limbs::of(term, scale).value(scale).to_bits(), term.to_bits(), "{term:e} below {scale:e}");
        }
        assert_eq!(Limbs::of(1.0, 2f32.powi(65)).value(2f32.powi(65)), 1.0);
        assert_eq!(Limbs::of(1.999, 2f32.powi(66)), Limbs::ZERO);
    }

    #[test]
    fn a_sum_over_twelve_decades_is_the_exact_one_rounded() {
        let mut lcg = Lcg(7);
        for count in [1, 2, 3, 10, 50, 512, 1024] {
            for round in 0..500 {
                let terms = powers(&mut lcg, count);
                let exact: f64 = terms.iter().map(|&term| f64::from(term)).sum();
                // Half a unit in the last place for the rounding, and the bits cut off.
                let unit = f64::from(f32::from_bits((exact as f32).to_bits() + 1)) - f64::from(exact as f32);
                let error = (f64::from(sum(&terms)) - exact).abs();
                assert!(error <= 0.5 * unit * (1.0 + 1e-6), "{count} terms: {error} of {exact}");
                // As well where all of them are twelve decades below the scale: a unit of 2⁻⁶⁶ of it a term.
                let scale = 10f32.powi(round % 13) * terms.iter().copied().fold(0.0, f32::max);
                let error = (f64::from(sum_below(scale, &terms)) - exact).abs();
                let cut = f64::from(count) * 2f64.powi(-65) * f64::from(scale);
                assert!(error <= 0.5 * unit * (1.0 + 1e-6) + cut, "{count} terms below {scale:e}: {error} of {exact}");
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
    fn a_sum_that_is_carried_takes_more_terms() {
        for term in [1.999_999_9f32, 1.1, 3e-7] {
            let (mut sum, mut above) = (Limbs::ZERO, 0);
            for _ in 0..1800 {
                for _ in 0..MAX_TERMS / 2 {
                    sum.add(Limbs::of(term, 1.5).0);
                }
                let leaves;
                (sum, leaves) = sum.settle();
                above += leaves;
            }
            let expected = (f64::from(term) * f64::from(900 * MAX_TERMS)) as f32;
            assert_eq!(sum.value_with(above, 1.5), expected);
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
