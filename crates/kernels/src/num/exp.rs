//! Exponentials, logarithms and powers, from polynomials and from sums of two floats in written-out order.
//!
//! Everything is [`exp2_sum`] or [`log2_sum`] times something, and every product is [`times`]: operands are cut into
//! halves of 12 bits, whose products are exact, and what is left over is carried in a second float (Dekker, "A
//! floating-point technique for extending the available precision", 1971). No step comes near the subnormal range,
//! unless to add something to 1 that is far below its last bit. Fast: the driver's own.

use super::float::{INFINITY, NAN, SIGN, is_nan};

/// 2ˣ, within 0.68 ulp of the exact value (measured for all floats); exact where `x` is whole. It never decreases.
///
/// +∞ from 128 on, 0 below −126. −∞ gives 0, +∞ itself and NaN [`NAN`]. Source: reduction to |r| ≤ ½ as in Muller,
/// "Elementary Functions" (2016), chapter 11; a minimax polynomial of degree 7 (Lawson's iteration, 10⁻¹⁰ off).
#[inline]
pub fn exp2(x: f32) -> f32 {
    #[cfg(all(target_arch = "spirv", feature = "fast"))]
    return spirv_std::num_traits::Float::exp2(x);
    if is_nan(x) { NAN } else { exp2_sum(bounded(x), 0.0) }
}

/// eˣ, within 0.69 ulp of the exact value (measured for all floats).
///
/// +∞ above 88.72283, 0 below −87.336544. −∞ gives 0, +∞ itself and NaN [`NAN`]. Source: [`exp2`] of `x`·log₂e, whose
/// constant is cut into a short and a long part as in Cody and Waite, "Software Manual for the Elementary Functions"
/// (1980).
#[inline]
pub fn exp(x: f32) -> f32 {
    #[cfg(all(target_arch = "spirv", feature = "fast"))]
    return spirv_std::num_traits::Float::exp(x);
    if is_nan(x) {
        return NAN;
    }
    let (hi, lo) = times(bounded(x), 0.0, LOG2E_TOP, LOG2E_REST);
    exp2_sum(hi, lo)
}

/// log₂ `x`, within 0.503 ulp of the exact value (measured for all significands); exact where `x` is a power of two.
///
/// A zero or a subnormal of either sign gives −∞, another negative number and NaN [`NAN`], +∞ itself. Source:
/// 2·artanh((m − 1) / (m + 1)) of the significand `m` in [√½, √2), as in Tang, "Table-driven implementation of the
/// logarithm function" (1990), without the table; a minimax polynomial of degree 7 (Lawson's iteration, 10⁻¹¹ off).
#[inline]
pub fn log2(x: f32) -> f32 {
    #[cfg(all(target_arch = "spirv", feature = "fast"))]
    return spirv_std::num_traits::Float::log2(x);
    if is_special(x) {
        return special_log(x);
    }
    let (hi, lo) = log2_sum(x);
    hi + lo
}

/// ln `x`, within 0.503 ulp of the exact value (measured for all floats); exact at 1 only.
///
/// The special cases are those of [`log2`], of which this is the value before its last rounding, times ln 2.
#[inline]
pub fn ln(x: f32) -> f32 {
    #[cfg(all(target_arch = "spirv", feature = "fast"))]
    return spirv_std::num_traits::Float::ln(x);
    if is_special(x) {
        return special_log(x);
    }
    let (hi, lo) = log2_sum(x);
    let (hi, lo) = times(hi, lo, LN2_TOP, LN2_REST);
    hi + lo
}

/// `x`ʸ, within 0.76 ulp of the exact value (0.735 measured over 3·10⁸ pairs).
///
/// It is [`exp2`] of `y`·log₂ `x`, where both the logarithm and the product are sums of two floats. Special cases are
/// those of IEEE 754's `pow`, with two exceptions: a negative `x` gives [`NAN`], whatever `y`, and so does a NaN as
/// either operand. So `pow(x, 0)` and `pow(1, y)` are 1, also with an infinity; a zero `x` of either sign gives 0 for
/// y > 0 and +∞ for y < 0, and an infinite `x` the reverse. An exact result that is a normal float comes out as such,
/// as those of `pow(x, 1)` (all floats tested) or `pow(3, 2)`: the error before the last rounding is a quarter of an
/// ulp.
#[inline]
pub fn pow(x: f32, y: f32) -> f32 {
    #[cfg(all(target_arch = "spirv", feature = "fast"))]
    return spirv_std::num_traits::Float::powf(x, y);
    if is_nan(x) || is_nan(y) {
        return NAN;
    }
    if is_special(x) {
        let bits = x.to_bits();
        let zero = bits & INFINITY == 0;
        return if bits & SIGN != 0 && !zero {
            NAN
        } else if y.to_bits() & INFINITY == 0 {
            1.0
        } else {
            f32::from_bits(if zero == (y.to_bits() & SIGN != 0) { INFINITY } else { 0 })
        };
    }
    let (hi, lo) = log2_sum(x);
    let y = bounded(y);
    let y_top = top(y);
    let (hi, lo) = times(hi, lo, y_top, y - y_top);
    exp2_sum(hi, lo)
}

// Each constant in 12 bits and the rest of it in 24 more.
const LN2_TOP: f32 = 0.693_115_23;
const LN2_REST: f32 = 3.194_618_3e-5;
const LOG2E_TOP: f32 = 1.442_382_8;
const LOG2E_REST: f32 = 0.000_312_228_4;
const TWO_LOG2E_TOP: f32 = 2.884_765_6;
const TWO_LOG2E_REST: f32 = 0.000_624_456_8;
const THIRD_TOP: f32 = 0.333_251_95;
const THIRD_REST: f32 = 8.138_021e-5;

/// The leading 12 bits of `x`. What they leave has 12 as well, and any product of two such numbers is exact.
#[inline]
fn top(x: f32) -> f32 {
    f32::from_bits(x.to_bits() & 0xffff_f000)
}

/// `a + b` rounded, and what the rounding lost; |a| is no less than |b|, or `a` is 0 (Dekker's exact sum).
#[inline]
fn add(a: f32, b: f32) -> (f32, f32) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// `(a + a_lo) · (b_top + b_rest)` as a sum of two floats, the first of which is exact; `a_lo` is small beside `a`,
/// `b_rest` beside `b_top`, which has 12 bits.
#[inline]
fn times(a: f32, a_lo: f32, b_top: f32, b_rest: f32) -> (f32, f32) {
    let a_top = top(a);
    let a_rest = (a - a_top) + a_lo;
    (a_top * b_top, a_top * b_rest + a_rest * (b_top + b_rest))
}

/// `x` with a magnitude of 2⁴⁰ if it is larger or infinite, and 0 if it is below 2⁻⁴⁰. Exponentials cannot tell: they
/// overflow or underflow, or are 1 (a power's exponent meets logarithms of 2⁻²⁴ at least, and of 128 at most).
#[inline]
fn bounded(x: f32) -> f32 {
    let magnitude = x.to_bits() & !SIGN;
    if magnitude < 0x2b80_0000 {
        0.0
    } else if magnitude > 0x5380_0000 {
        f32::from_bits(0x5380_0000 | (x.to_bits() & SIGN))
    } else {
        x
    }
}

/// 2 to the power `hi + lo`, where `lo` is small beside `hi` and both are finite.
#[inline]
fn exp2_sum(hi: f32, lo: f32) -> f32 {
    // Nothing beyond ±200 is a float; below, exponents stay within i32.
    if hi.to_bits() & !SIGN > 0x4348_0000 {
        return f32::from_bits(if hi.to_bits() & SIGN == 0 { INFINITY } else { 0 });
    }
    let (whole, t, t_lo) = exp_argument(hi, lo);
    exp_assemble(whole, t, t_lo, exp_tail(t + t_lo))
}

/// `hi + lo` as a whole number and ln 2 times the rest: `t + t_lo`, within ±0.3466.
#[inline]
fn exp_argument(hi: f32, lo: f32) -> (i32, f32, f32) {
    let (hi, lo) = add(hi, lo);
    // The float below ½, for with ½ itself that float would be rounded up to 1, and leave a rest that is not exact.
    let half = f32::from_bits(0x3eff_ffff | (hi.to_bits() & SIGN));
    let whole = (hi + half) as i32;
    let r = hi - whole as f32;
    let (t, t_lo) = times(r, lo, LN2_TOP, LN2_REST);
    (whole, t, t_lo)
}

/// `(eᵗ − 1 − t) / t²` for |t| ≤ 0.3466.
#[inline]
fn exp_tail(t: f32) -> f32 {
    0.5 + t * (0.166_666_66 + t * (0.041_666_463 + t * (0.008_333_57 + t * (0.001_393_508 + t * 0.000_197_402_65))))
}

/// `2ʷʰᵒˡᵉ·(1 + t + t_lo + t²·tail)`. What 1 + t rounds off is added back, so the sum errs little more than its
/// last rounding does.
#[inline]
fn exp_assemble(whole: i32, t: f32, t_lo: f32, tail: f32) -> f32 {
    let sum = t + t_lo;
    let (head, lost) = add(1.0, t);
    let significand = head + (lost + (t_lo + sum * sum * tail));
    // The exponent is added to the bits, for a multiplication may flush or not, and round twice.
    let exponent = (significand.to_bits() >> 23) as i32 + whole;
    if exponent <= 0 {
        0.0
    } else if exponent >= 255 {
        f32::from_bits(INFINITY)
    } else {
        f32::from_bits(((exponent as u32) << 23) | (significand.to_bits() & 0x007f_ffff))
    }
}

/// Anything but a positive normal number.
#[inline]
fn is_special(x: f32) -> bool {
    (x.to_bits() >> 23).wrapping_sub(1) >= 254
}

/// The logarithm of what [`is_special`].
#[inline]
fn special_log(x: f32) -> f32 {
    let bits = x.to_bits();
    if bits & INFINITY == 0 {
        f32::from_bits(SIGN | INFINITY)
    } else if bits == INFINITY {
        x
    } else {
        NAN
    }
}

/// log₂ of a positive normal `x` as a sum of two floats, within 2⁻³¹·⁹ of its size.
#[inline]
fn log2_sum(x: f32) -> (f32, f32) {
    let (exponent, s, s_lo) = log_argument(x);
    let size = s + s_lo;
    log_assemble(exponent, s, s_lo, log_tail(size * size))
}

/// `x` as a power of two and a significand `m` in [√½, √2), given by `s + s_lo = (m − 1) / (m + 1)`; `s` has 12 bits.
#[inline]
fn log_argument(x: f32) -> (f32, f32, f32) {
    // The bits of √½ as the origin: what is above them counts binades from there.
    let exponent = (x.to_bits() as i32 - 0x3f35_04f3) >> 23;
    let m = f32::from_bits((x.to_bits() as i32 - (exponent << 23)) as u32);
    let f = m - 1.0;
    let d = m + 1.0;
    // Newton steps from a line within 1.5 % of 1/d. The division is exact but for `s_lo`, by the remainder of `s`.
    let y = 0.507_028 - 0.239_015_27 * f;
    let y = y * (2.0 - d * y);
    let y = y * (2.0 - d * y);
    let s = top(f * y);
    let d_top = top(d);
    let remainder = (f - s * d_top) - s * (m - (d_top - 1.0));
    (exponent as f32, s, remainder * y)
}

/// `(artanh(s)/s − 1 − s²/3) / s⁴` for s² = `z` ≤ 0.0295.
#[inline]
fn log_tail(z: f32) -> f32 {
    0.200_000_76 + z * (0.142_735_42 + z * 0.117_099_5)
}

/// `exponent + 2·log₂e·artanh(s + s_lo)` as a sum of two floats.
#[inline]
fn log_assemble(exponent: f32, s: f32, s_lo: f32, tail: f32) -> (f32, f32) {
    let size = s + s_lo;
    // artanh s = s + s·(s²/3 + tail·s⁴)
    let (square, square_lo) = (s * s, (s + size) * s_lo);
    let (u, u_lo) = times(square, square_lo, THIRD_TOP, THIRD_REST + size * size * tail);
    let (v, v_lo) = times(u, u_lo, s, s_lo);
    let (w, w_lo) = add(s, v);
    let (l, l_lo) = times(w, w_lo + (s_lo + v_lo), TWO_LOG2E_TOP, TWO_LOG2E_REST);
    let (log, lost) = add(exponent, l);
    // The second float as small as it can be, for its own rounding errors are those of a power.
    add(log, lost + l_lo)
}

#[cfg(test)]
mod tests;
