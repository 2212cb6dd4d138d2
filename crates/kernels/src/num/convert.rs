//! Conversions that mean the same on every device: always in range, and NaN never reaches a native one.

use super::float::{INFINITY, SIGN, flush, is_nan};

/// The top 24 bits of `x` as a multiple of 2⁻²⁴ in [0, 1). Exact.
#[inline]
pub fn u32_to_unit(x: u32) -> f32 {
    (x >> 8) as f32 * 5.960_464_5e-8
}

/// `⌊x⌋`, clamped to [−2³⁰, 2³⁰]; NaN gives −2³⁰. Exact within.
#[inline]
pub fn floor_to_i32(x: f32) -> i32 {
    const LIMIT: i32 = 1 << 30;
    let bits = x.to_bits();
    let magnitude = bits & !SIGN;
    // 2³⁰ and above, infinity, NaN: decided on the bits, for a native comparison may take NaN for impossible.
    if magnitude >= 0x4e80_0000 {
        return if magnitude > INFINITY || bits & SIGN != 0 { -LIMIT } else { LIMIT };
    }
    let x = flush(x);
    let toward_zero = x as i32;
    // From 2²⁴ on, where a conversion back might round, x is whole.
    if toward_zero as f32 > x { toward_zero - 1 } else { toward_zero }
}

/// `x` without its fraction, clamped to [0, 2³²−256], the largest float below 2³²; NaN gives 0. Exact within.
#[inline]
pub fn f32_to_u32_clamped(x: f32) -> u32 {
    let bits = x.to_bits();
    // Negative numbers and NaN.
    if bits > INFINITY {
        return 0;
    }
    if bits >= 0x4f80_0000 {
        return 0xffff_ff00;
    }
    if bits < 0x3f80_0000 {
        return 0;
    }
    let significand = (bits & 0x007f_ffff) | 0x0080_0000;
    let exponent = (bits >> 23) - 127;
    if exponent < 23 { significand >> (23 - exponent) } else { significand << (exponent - 23) }
}

/// How many floats lie from `a` to `b`: 0 for equal ones and for zeros of either sign, `u32::MAX` if either is NaN.
/// Subnormals count.
#[inline]
pub fn ulp_distance(a: f32, b: f32) -> u32 {
    if is_nan(a) || is_nan(b) {
        return u32::MAX;
    }
    let x = ordered(a);
    let y = ordered(b);
    // At most 2·0x7f800000, which is below 2³².
    (if x > y { x.wrapping_sub(y) } else { y.wrapping_sub(x) }) as u32
}

/// An integer in step with `x`: 0 for both zeros, ±n for the n-th float above or below.
#[inline]
fn ordered(x: f32) -> i32 {
    let magnitude = (x.to_bits() & !SIGN) as i32;
    if x.to_bits() & SIGN == 0 { magnitude } else { -magnitude }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{EDGES, Lcg, operand};
    use super::*;

    fn patterns() -> impl Iterator<Item = u32> {
        let mut lcg = Lcg(9);
        let near_whole = (-1000i32..1000).flat_map(|i| {
            let bits = (i as f32).to_bits();
            [bits, bits.wrapping_add(1), bits.wrapping_sub(1)]
        });
        let powers = (0..512u32).flat_map(|top| [top << 23, (top << 23) + 1, (top << 23).wrapping_sub(1)]);
        EDGES.into_iter().chain(near_whole).chain(powers).chain((0..1_000_000).map(move |_| lcg.next_u32()))
    }

    #[test]
    fn unit_interval() {
        assert_eq!(u32_to_unit(0).to_bits(), 0);
        assert_eq!(f64::from(u32_to_unit(256)), 2f64.powi(-24));
        assert_eq!(f64::from(u32_to_unit(u32::MAX)), 1.0 - 2f64.powi(-24));
        for i in (0..1 << 24).step_by(101) {
            assert_eq!(f64::from(u32_to_unit(i << 8 | 0xff)), f64::from(i) / f64::from(1 << 24));
        }
    }

    #[test]
    fn floors() {
        for bits in patterns() {
            let x = operand(bits);
            let limit = f64::from(1 << 30);
            let expected = if x.is_nan() { -limit } else { f64::from(x).floor().clamp(-limit, limit) };
            assert_eq!(f64::from(floor_to_i32(f32::from_bits(bits))), expected, "{bits:#010x}");
        }
    }

    #[test]
    fn unsigned() {
        for bits in patterns() {
            let x = f32::from_bits(bits);
            assert_eq!(f32_to_u32_clamped(x), (x as u32).min(0xffff_ff00), "{bits:#010x}");
        }
    }

    #[test]
    fn distances() {
        assert_eq!(ulp_distance(0.0, -0.0), 0);
        assert_eq!(ulp_distance(1.0, 1.0 + f32::EPSILON), 1);
        assert_eq!(ulp_distance(f32::from_bits(1), f32::from_bits(SIGN | 1)), 2);
        assert_eq!(ulp_distance(f32::MIN, f32::MAX), 2 * 0x7f7f_ffff);
        assert_eq!(ulp_distance(f32::NEG_INFINITY, f32::INFINITY), 2 * 0x7f80_0000);
        assert_eq!(ulp_distance(f32::NAN, f32::NAN), u32::MAX);
        for x in patterns().map(f32::from_bits).filter(|x| x.is_finite()) {
            assert_eq!(ulp_distance(x, x.next_up()), 1, "{x}");
        }
    }
}
