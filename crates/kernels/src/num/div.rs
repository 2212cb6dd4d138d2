//! Division, correctly rounded whatever the device's own division is worth.

use super::float::{INFINITY, NAN, SIGN};
#[cfg(not(target_arch = "spirv"))]
use super::float::{canonical, flush};

/// `a / b` rounded to nearest, ties to even: the IEEE 754 quotient, under this folder's policy for subnormals and NaN.
///
/// `x / 0` is ±∞, `0 / 0` and `∞ / ∞` are [`NAN`]. Vulkan lets a native quotient be 2.5 ulp off (Vulkan specification,
/// "Precision and Operation of SPIR-V Instructions"), and some devices use all of it; so a GPU corrects a native
/// quotient by [`div_corrected`], while Rust defines the CPU's to be IEEE 754's. The tests hold one against the other.
///
/// Fast: the driver's own quotient.
#[inline]
pub fn div(a: f32, b: f32) -> f32 {
    #[cfg(all(target_arch = "spirv", feature = "fast"))]
    return a / b;
    #[cfg(target_arch = "spirv")]
    return {
        let (numerator, denominator) = scaled_operands(a, b);
        div_corrected(numerator / denominator, a, b)
    };
    #[cfg(not(target_arch = "spirv"))]
    canonical(flush(flush(a) / flush(b)))
}

/// `1 / x`, rounded as [`div`] does.
#[inline]
pub fn recip(x: f32) -> f32 {
    div(1.0, x)
}

/// The significands of `a` and `b` as floats, that of `a` doubled where it is the smaller: a quotient in [1, 2) that no
/// device can overflow or flush. Meaningless where an operand is not a normal number.
#[inline]
#[cfg(any(target_arch = "spirv", test))]
fn scaled_operands(a: f32, b: f32) -> (f32, f32) {
    let fa = a.to_bits() & 0x007f_ffff;
    let fb = b.to_bits() & 0x007f_ffff;
    let exponent = if fa < fb { 0x4000_0000 } else { 0x3f80_0000 };
    (f32::from_bits(exponent | fa), f32::from_bits(0x3f80_0000 | fb))
}

/// `a / b`, correctly rounded, from a `guess` within 8 ulp of the quotient of their significands scaled to [1, 2).
///
/// The quotient of the 24-bit significands is taken as an integer, `q = ⌊n / d⌋` with `n = a·2²³` or `a·2²⁴`. The
/// remainder `n − q·d` of a `q` up to 15 off is below 2²⁹, so arithmetic modulo 2³² has all of it, though `n` has 48 bits.
/// No quotient of two 24-bit integers lies halfway between two others (`2n = (2q + 1)·d` needs 2²⁴ to divide `d`), nor
/// rounds up to the next power of two (`n/d ≤ 2²⁴ − 1`), so comparing twice the remainder with `d` decides. Source: the remainder
/// test of Markstein, "Computation of elementary functions on the IBM RISC System/6000" (1990), in integers.
#[inline]
pub fn div_corrected(guess: f32, a: f32, b: f32) -> f32 {
    let a_bits = a.to_bits();
    let b_bits = b.to_bits();
    let sign = (a_bits ^ b_bits) & SIGN;
    let a_exponent = (a_bits >> 23) & 0xff;
    let b_exponent = (b_bits >> 23) & 0xff;
    // One comparison each: neither 0 (zero, subnormal) nor 255 (infinite, NaN).
    if a_exponent.wrapping_sub(1) >= 254 || b_exponent.wrapping_sub(1) >= 254 {
        return special(a_bits & !SIGN, b_bits & !SIGN, sign);
    }
    let n = (a_bits & 0x007f_ffff) | 0x0080_0000;
    let d = (b_bits & 0x007f_ffff) | 0x0080_0000;
    let below_one = if n < d { 1 } else { 0 };
    // The bits of a float in [1, 2) are its significand plus a constant; just outside, the error at most doubles.
    // Starting 16 too low leaves 0..32 to add, a binary digit at a time.
    let mut q = guess.to_bits().wrapping_sub(0x3f00_0000 + 16);
    let mut remainder = (n << (23 + below_one)).wrapping_sub(q.wrapping_mul(d));
    (q, remainder) = add_digit(q, remainder, d, 16);
    (q, remainder) = add_digit(q, remainder, d, 8);
    (q, remainder) = add_digit(q, remainder, d, 4);
    (q, remainder) = add_digit(q, remainder, d, 2);
    (q, remainder) = add_digit(q, remainder, d, 1);
    if remainder > d >> 1 {
        q = q.wrapping_add(1);
    }
    let exponent = (a_exponent + 127) as i32 - (b_exponent + below_one) as i32;
    if exponent <= 0 {
        // The one quotient below 2⁻¹²⁶ that IEEE 754 rounds up to it, a tie in subnormal precision:
        // (1 − 2⁻²⁴)·2⁻¹²⁶, which only a power of two as divisor gives.
        let tie = exponent == 0 && d == 0x0080_0000 && q == 0x00ff_ffff;
        return f32::from_bits(if tie { sign | 0x0080_0000 } else { sign });
    }
    if exponent >= 255 {
        return f32::from_bits(sign | INFINITY);
    }
    f32::from_bits(sign | ((exponent as u32) << 23) | (q & 0x007f_ffff))
}

/// `q + digit` and the remainder that leaves, if there is one.
#[inline]
fn add_digit(q: u32, remainder: u32, d: u32, digit: u32) -> (u32, u32) {
    let multiple = d * digit;
    if remainder >= multiple { (q.wrapping_add(digit), remainder - multiple) } else { (q, remainder) }
}

/// The quotient where an operand is zero, subnormal, infinite or NaN; `a` and `b` are bits without sign.
#[inline]
fn special(a: u32, b: u32, sign: u32) -> f32 {
    let a_zero = a < 0x0080_0000;
    let b_zero = b < 0x0080_0000;
    if a > INFINITY || b > INFINITY || (a_zero && b_zero) || (a == INFINITY && b == INFINITY) {
        NAN
    } else if a == INFINITY || b_zero {
        f32::from_bits(sign | INFINITY)
    } else {
        f32::from_bits(sign)
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{EDGES, Lcg, near_halfway, operand, policy};
    use super::*;

    /// Random significand pairs, each met with all 17 guess errors.
    const RANDOM_PAIRS: u32 = 1_500_000;
    /// Significand pairs for each of the 2¹⁶ pairs of exponents and each pair of signs.
    const PAIRS_AN_EXPONENT: u32 = 8;
    const EDGE_FRACTIONS: [u32; 12] =
        [0, 1, 2, 3, 0x3f_ffff, 0x40_0000, 0x40_0001, 0x2a_aaaa, 0x55_5555, 0x7f_fffd, 0x7f_fffe, 0x7f_ffff];

    fn guess(a: u32, b: u32, error: i32) -> f32 {
        let (numerator, denominator) = scaled_operands(f32::from_bits(a), f32::from_bits(b));
        f32::from_bits((numerator / denominator).to_bits().wrapping_add_signed(error))
    }

    fn check(a: u32, b: u32, error: i32) {
        let expected = policy(operand(a) / operand(b));
        let (x, y) = (f32::from_bits(a), f32::from_bits(b));
        let corrected = div_corrected(guess(a, b, error), x, y).to_bits();
        assert_eq!(corrected, expected, "{a:#010x} / {b:#010x}, guess off by {error}");
        assert_eq!(div(x, y).to_bits(), expected, "div {a:#010x} / {b:#010x}");
    }

    fn check_all_errors(a: u32, b: u32) {
        for error in -8..=8 {
            check(a, b, error);
        }
    }

    #[test]
    fn every_pair_of_exponents_and_signs() {
        let mut lcg = Lcg(3);
        let mut error = -8;
        for exponents in 0..1u32 << 16 {
            for signs in 0..4 {
                let a = (exponents & 0xff) << 23 | (signs & 1) << 31;
                let b = (exponents >> 8) << 23 | (signs >> 1) << 31;
                check(a, b, error);
                for _ in 0..PAIRS_AN_EXPONENT {
                    check(a | lcg.next_u32() >> 9, b | lcg.next_u32() >> 9, error);
                    error = if error == 8 { -8 } else { error + 1 };
                }
            }
        }
    }

    #[test]
    fn edge_significands_at_edge_exponents() {
        for a in EDGES {
            for b in EDGES {
                check_all_errors(a, b);
            }
        }
        for exponents in 0..1u32 << 16 {
            let (ea, eb) = (exponents & 0xff, exponents >> 8);
            // The quotient's exponent around 0, 1 and 255, where flushing and overflow begin, and one ordinary pair.
            let e = ea as i32 - eb as i32 + 127;
            let edge = (-1..=2).contains(&e) || (253..=256).contains(&e) || (ea, eb) == (127, 127);
            for (i, fa) in EDGE_FRACTIONS.into_iter().enumerate().filter(|_| edge) {
                for (j, fb) in EDGE_FRACTIONS.into_iter().enumerate() {
                    check(ea << 23 | fa, eb << 23 | fb, ((i + 5 * j) % 17) as i32 - 8);
                }
            }
        }
        for fa in EDGE_FRACTIONS {
            for fb in EDGE_FRACTIONS {
                check_all_errors(0x3f80_0000 | fa, 0x3f80_0000 | fb);
            }
        }
    }

    #[test]
    fn random_significands_with_every_guess_error() {
        let mut lcg = Lcg(4);
        for _ in 0..RANDOM_PAIRS {
            check_all_errors(0x3f80_0000 | lcg.next_u32() >> 9, 0x3f80_0000 | lcg.next_u32() >> 9);
        }
    }

    #[test]
    fn quotients_next_to_halfway_with_every_guess_error() {
        for (a, b) in near_halfway(&mut Lcg(5), 100_000) {
            let nearest = 2 * ((u64::from(a) << (23 + u32::from(a < b))) % u64::from(b));
            assert!(nearest.abs_diff(u64::from(b)) <= 2, "{a} / {b} is not a hard case");
            check_all_errors(0x3f00_0000 + a, 0x3f00_0000 + b);
        }
    }

    /// The checks above must be able to fail.
    #[test]
    fn planted_faults_show() {
        let pairs = near_halfway(&mut Lcg(6), 10_000);
        let (mut uncorrected, mut beyond) = (0, 0);
        for &(a, b) in &pairs {
            let (x, y) = (f32::from_bits(0x3f00_0000 + a), f32::from_bits(0x3f00_0000 + b));
            let raw = guess(x.to_bits(), y.to_bits(), 1);
            let (numerator, denominator) = scaled_operands(x, y);
            uncorrected += u32::from(raw != numerator / denominator);
            beyond += u32::from(div_corrected(guess(x.to_bits(), y.to_bits(), 40), x, y) != x / y);
        }
        assert_eq!(uncorrected as usize, pairs.len());
        assert_eq!(beyond as usize, pairs.len(), "a guess out of reach was corrected");
    }

    #[test]
    fn reciprocals() {
        assert_eq!(recip(4.0), 0.25);
        assert_eq!(recip(-0.0).to_bits(), 0xff80_0000);
        assert_eq!(recip(f32::MAX).to_bits(), 0, "2^-128 is subnormal");
    }
}
