//! Square roots, correctly rounded, from arithmetic that every device does alike.

use super::div::recip;
use super::float::{INFINITY, NAN, SIGN};

/// `√x` rounded to nearest, ties to even: the IEEE 754 root. −0 gives −0, a subnormal the zero of its
/// sign, a negative number [`NAN`].
///
/// One body for every device, without any native root: integers repair a few Newton steps, as in [`sqrt_corrected`].
///
/// Fast: the driver's own root. A negative number then gives 0: `1 − a / b` can be one for `a` below `b`, where the
/// driver's division is off.
#[inline]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(all(target_arch = "spirv", feature = "fast"))]
    return spirv_std::num_traits::Float::sqrt(super::float::max(x, 0.0));
    let bits = x.to_bits();
    if is_special(bits) {
        return special(bits);
    }
    // Newton's guess is within 3 ulp, so start 4 too low and leave out the digits 16 and 8.
    let n = scaled_integer(bits);
    let s = newton(scaled_operand(x)).to_bits().wrapping_sub(0x3f00_0000 + 4);
    let remainder = n.wrapping_sub(s.wrapping_mul(s));
    pack(bits, finish(s, remainder))
}

/// `1 / √x`, off the exact value by less than 1.5 ulp and from its nearest float by at most 1 (all significands tested).
///
/// Fast: one over the driver's own root, which drivers know as one operation.
#[inline]
pub fn inv_sqrt(x: f32) -> f32 {
    recip(sqrt(x))
}

/// The significand of `x`, doubled where its exponent is odd: in [1, 4), so that no device can overflow or flush.
/// Meaningless where `x` is not a normal number.
#[inline]
fn scaled_operand(x: f32) -> f32 {
    let bits = x.to_bits();
    // A biased exponent that is odd stands for an even one.
    let exponent = 0x4000_0000 - (bits & 0x0080_0000);
    f32::from_bits(exponent | (bits & 0x007f_ffff))
}

/// The root of `x` in [1, 4), within 1 ulp, with separate or with fused multiplications and additions.
///
/// The first guess of 1/√x and the constants of its first step are Kadlec's (2010, error 6.5e-4 after that step; see
/// Moroz et al., "Fast calculation of inverse square root with the use of magic constant", 2018). One Newton step makes
/// it 6.4e-7; the last, taken on the root itself, leaves rounding errors.
#[inline]
fn newton(x: f32) -> f32 {
    let y0 = f32::from_bits(0x5f1f_fff9 - (x.to_bits() >> 1));
    let y1 = y0 * 0.703_952_25 * (2.389_244_6 - x * y0 * y0);
    let y2 = y1 * (1.5 - 0.5 * x * y1 * y1);
    let s = x * y2;
    s + 0.5 * y2 * (x - s * s)
}

/// `√x`, correctly rounded, from a `guess` within 8 ulp of the root of `x`'s significand scaled to [1, 4) by an even
/// power of two.
///
/// The root is the integer `s = ⌊√n⌋` with `n = m·2²³` or `m·2²⁴`, `m` the 24-bit significand. The remainder `n − s²` of
/// an `s` up to 15 off is below 2³¹, so arithmetic modulo 2³² has all of it. No root is halfway between two integers
/// (`n` is one, `(s + ½)²` is not), nor rounds up to 2²⁴ (the largest is 2²⁴ − ½ − 2⁻²⁷).
#[inline]
pub fn sqrt_corrected(guess: f32, x: f32) -> f32 {
    let bits = x.to_bits();
    if is_special(bits) {
        return special(bits);
    }
    let n = scaled_integer(bits);
    // The bits of a float in [1, 2) are its significand plus a constant. Starting 16 too low leaves 0..32 to add.
    let s = guess.to_bits().wrapping_sub(0x3f00_0000 + 16);
    let remainder = n.wrapping_sub(s.wrapping_mul(s));
    let (s, remainder) = add_digit(s, remainder, 16);
    let (s, remainder) = add_digit(s, remainder, 8);
    pack(bits, finish(s, remainder))
}

/// Anything but a positive normal number: its sign and exponent are 0, 255 or more.
#[inline]
fn is_special(bits: u32) -> bool {
    (bits >> 23).wrapping_sub(1) >= 254
}

/// The 24-bit significand times 2²³ or, where the exponent is odd (its biased form even), 2²⁴; modulo 2³².
#[inline]
fn scaled_integer(bits: u32) -> u32 {
    ((bits & 0x007f_ffff) | 0x0080_0000) << (24 - ((bits >> 23) & 1))
}

/// `s + digit` and the remainder that leaves, if there is one: (s + digit)² = s² + digit·(2s + digit).
#[inline]
fn add_digit(s: u32, remainder: u32, digit: u32) -> (u32, u32) {
    let increase = digit.wrapping_mul(s.wrapping_mul(2).wrapping_add(digit));
    if remainder >= increase { (s.wrapping_add(digit), remainder - increase) } else { (s, remainder) }
}

/// The nearest root, from an `s` that is 0..8 too low.
#[inline]
fn finish(s: u32, remainder: u32) -> u32 {
    let (s, remainder) = add_digit(s, remainder, 4);
    let (s, remainder) = add_digit(s, remainder, 2);
    let (s, remainder) = add_digit(s, remainder, 1);
    // (s + ½)² = s² + s + ¼
    if remainder > s { s.wrapping_add(1) } else { s }
}

/// The float with the root `s` of the significand and half the exponent of `bits`.
#[inline]
fn pack(bits: u32, s: u32) -> f32 {
    f32::from_bits(((((bits >> 23) + 127) >> 1) << 23) | (s & 0x007f_ffff))
}

/// The root where `x`, given by its bits, is zero, subnormal, negative, infinite or NaN.
#[inline]
fn special(bits: u32) -> f32 {
    if bits & INFINITY == 0 {
        f32::from_bits(bits & SIGN)
    } else if bits == INFINITY {
        f32::from_bits(INFINITY)
    } else {
        NAN
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{EDGES, Lcg, operand, policy};
    use super::*;

    fn off_by(root: f32, error: i32) -> f32 {
        f32::from_bits(root.to_bits().wrapping_add_signed(error))
    }

    fn check(bits: u32, error: i32) {
        let x = f32::from_bits(bits);
        let expected = policy(operand(bits).sqrt());
        let corrected = sqrt_corrected(off_by(scaled_operand(x).sqrt(), error), x).to_bits();
        assert_eq!(corrected, expected, "{bits:#010x}, guess off by {error}");
        assert_eq!(sqrt(x).to_bits(), expected, "{bits:#010x}, sqrt");
    }

    /// The root depends on the exponent's parity only, so two binades are all significands there are.
    #[test]
    fn every_significand() {
        let mut error = -8;
        for bits in 0x3f80_0000..0x4080_0000 {
            check(bits, error);
            error = if error == 8 { -8 } else { error + 1 };
        }
    }

    #[test]
    fn every_guess_error() {
        let mut lcg = Lcg(7);
        for step in 0..1usize << 20 {
            // Dense samples, and the ends of both binades in full.
            let random = 0x3f80_0000 + (lcg.next_u32() >> 8);
            let end =
                [0x3f80_0000u32, 0x4000_0000, 0x4080_0000][step % 3].wrapping_add_signed((step as i32 & 0x7ff) - 1024);
            for error in -8..=8 {
                let bits = if step < 1 << 13 { end } else { random };
                let x = f32::from_bits(bits);
                let corrected = sqrt_corrected(off_by(scaled_operand(x).sqrt(), error), x);
                assert_eq!(corrected.to_bits(), x.sqrt().to_bits(), "{bits:#010x}, guess off by {error}");
            }
        }
    }

    #[test]
    fn every_exponent_and_sign() {
        let mut lcg = Lcg(8);
        for bits in EDGES {
            check(bits, 0);
        }
        for top in 0..512 {
            for fraction in [0, 1, 2, 0x3f_ffff, 0x40_0000, 0x7f_fffe, 0x7f_ffff] {
                check(top << 23 | fraction, 8);
                check(top << 23 | fraction, -8);
            }
            for i in 0..4096 {
                check(top << 23 | lcg.next_u32() >> 9, i % 17 - 8);
            }
        }
    }

    /// `sqrt` reaches 3 ulp, so the guess may differ between devices without the root noticing.
    #[test]
    fn newton_stays_within_one_ulp() {
        let worst = (0x3f80_0000..0x4080_0000u32).map(|bits| {
            let x = f32::from_bits(bits);
            newton(x).to_bits().abs_diff(x.sqrt().to_bits())
        });
        assert!(worst.max() <= Some(1));
    }

    /// The checks above must be able to fail.
    #[test]
    fn planted_faults_show() {
        let (mut uncorrected, mut beyond, mut all) = (0, 0, 0);
        for bits in (0x3f80_0000..0x4080_0000).step_by(1009) {
            let x = f32::from_bits(bits);
            all += 1;
            uncorrected += u32::from(newton(x) != x.sqrt());
            beyond += u32::from(sqrt_corrected(off_by(scaled_operand(x).sqrt(), 40), x) != x.sqrt());
        }
        assert!(uncorrected > all / 100, "Newton's steps alone are off too rarely: {uncorrected} of {all}");
        assert_eq!(beyond, all, "a guess beyond the correction's reach went unnoticed");
    }

    #[test]
    fn inverse_root_bound() {
        for bits in 0x3f80_0000..0x4080_0000 {
            let exact = 1.0 / f64::from(f32::from_bits(bits)).sqrt();
            let error = inv_sqrt(f32::from_bits(bits)).to_bits().abs_diff((exact as f32).to_bits());
            assert!(error <= 1, "{bits:#010x}: {error} ulp");
        }
        assert_eq!(inv_sqrt(-0.0).to_bits(), 0xff80_0000);
        assert_eq!(inv_sqrt(f32::from_bits(INFINITY)).to_bits(), 0);
        assert_eq!(inv_sqrt(-1.0).to_bits(), NAN.to_bits());
    }
}
