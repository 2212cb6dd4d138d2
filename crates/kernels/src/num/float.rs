//! Questions about a float that its bits answer, whatever the device does with NaN and subnormal operands.

/// Bits of +∞.
pub(super) const INFINITY: u32 = 0x7f80_0000;
/// The sign bit.
pub(super) const SIGN: u32 = 0x8000_0000;

/// The one NaN that comes out of this module: quiet, positive, without payload.
pub const NAN: f32 = f32::from_bits(0x7fc0_0000);

/// `x`, or the zero of its sign where `x` is subnormal. Exact.
///
/// It makes a device that keeps subnormals agree with one that flushes them, with one exception that no later step can
/// mend: a product whose exact value is below 2⁻¹²⁶ by less than 2⁻¹⁵⁰ rounds to 2⁻¹²⁶ in subnormal precision, but is
/// flushed by hardware that decides after rounding to 24 bits. Kernels keep their products away from 2⁻¹²⁶.
#[inline]
pub fn flush(x: f32) -> f32 {
    let bits = x.to_bits();
    let keep = if bits & INFINITY == 0 { SIGN } else { u32::MAX };
    f32::from_bits(bits & keep)
}

/// `x`, or [`NAN`] where `x` is any NaN. Exact.
#[inline]
pub fn canonical(x: f32) -> f32 {
    if is_nan(x) { NAN } else { x }
}

/// Whether `x` is neither infinite nor NaN.
#[inline]
pub fn is_finite(x: f32) -> bool {
    x.to_bits() & INFINITY != INFINITY
}

/// Whether `x` is NaN.
#[inline]
pub fn is_nan(x: f32) -> bool {
    x.to_bits() & !SIGN > INFINITY
}

/// `x` with a positive sign, NaN included. Exact.
#[inline]
pub fn abs(x: f32) -> f32 {
    f32::from_bits(x.to_bits() & !SIGN)
}

/// 1 with the sign of `x`: −1 for −0 and for a NaN with the sign bit set, too. Exact.
#[inline]
pub fn fsign(x: f32) -> f32 {
    f32::from_bits(0x3f80_0000 | (x.to_bits() & SIGN))
}

/// The smaller operand; the second one if they are equal (zeros are, whatever their sign) or if either is NaN. Exact.
#[inline]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger operand; the second one if they are equal (zeros are, whatever their sign) or if either is NaN. Exact.
#[inline]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// An integer that orders as the floats do: negative NaN < −∞ < … < −0 < +0 < … < +∞ < positive NaN.
///
/// Source: Herf, "Radix Tricks" (2001); the order is IEEE 754-2019's totalOrder.
#[inline]
pub fn total_order_key(x: f32) -> u32 {
    let bits = x.to_bits();
    bits ^ if bits & SIGN == 0 { SIGN } else { u32::MAX }
}

/// The float whose [`total_order_key`] is `key`. Exact.
#[inline]
pub fn from_total_order_key(key: u32) -> f32 {
    f32::from_bits(key ^ if key & SIGN == 0 { u32::MAX } else { SIGN })
}

/// 2ᵉ for `e` in −126..=127. Exact; 0 below that range and +∞ above it.
#[inline]
pub fn powi2(e: i32) -> f32 {
    let low = if e < -127 { -127 } else { e };
    let clamped = if low > 128 { 128 } else { low };
    f32::from_bits(((clamped + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::super::samples::{EDGES, Lcg};
    use super::*;

    const MIN_NORMAL: u32 = 0x0080_0000;

    #[test]
    fn flush_only_touches_subnormals() {
        assert_eq!(flush(f32::from_bits(MIN_NORMAL - 1)).to_bits(), 0);
        assert_eq!(flush(f32::from_bits(SIGN | 1)).to_bits(), SIGN);
        for bits in EDGES {
            let x = f32::from_bits(bits);
            let expected = if x.is_subnormal() { bits & SIGN } else { bits };
            assert_eq!(flush(x).to_bits(), expected, "{bits:#x}");
        }
    }

    #[test]
    fn classes_and_signs_agree_with_core() {
        let mut lcg = Lcg(1);
        let random: [u32; 4096] = core::array::from_fn(|_| lcg.next_u32());
        for bits in EDGES.into_iter().chain(random) {
            let x = f32::from_bits(bits);
            assert_eq!(is_nan(x), x.is_nan());
            assert_eq!(is_finite(x), x.is_finite());
            assert_eq!(abs(x).to_bits(), x.abs().to_bits());
            assert_eq!(fsign(x).to_bits(), 1f32.copysign(x).to_bits());
            assert_eq!(canonical(x).to_bits(), if x.is_nan() { 0x7fc0_0000 } else { bits });
            assert_eq!(from_total_order_key(total_order_key(x)).to_bits(), bits);
        }
    }

    #[test]
    fn keys_order_as_total_cmp_does() {
        let mut lcg = Lcg(2);
        for a in EDGES {
            let random: [u32; 256] = core::array::from_fn(|_| lcg.next_u32());
            for b in EDGES.into_iter().chain(random) {
                let (x, y) = (f32::from_bits(a), f32::from_bits(b));
                assert_eq!(total_order_key(x).cmp(&total_order_key(y)), x.total_cmp(&y), "{a:#x} {b:#x}");
            }
        }
    }

    #[test]
    fn min_and_max_give_the_second_of_equals_and_of_nan() {
        assert_eq!((min(1.0, 2.0), min(2.0, 1.0), max(1.0, 2.0), max(2.0, 1.0)), (1.0, 1.0, 2.0, 2.0));
        assert_eq!(min(0.0, -0.0).to_bits(), SIGN);
        assert_eq!(max(-0.0, 0.0).to_bits(), 0);
        assert_eq!((min(NAN, 3.0), max(NAN, 3.0)), (3.0, 3.0));
        assert!(is_nan(min(3.0, NAN)) && is_nan(max(3.0, NAN)));
    }

    #[test]
    fn powers_of_two() {
        for e in -126..=127 {
            assert_eq!(f64::from(powi2(e)), 2f64.powi(e));
        }
        assert_eq!(powi2(-127).to_bits(), 0);
        assert_eq!(powi2(i32::MIN).to_bits(), 0);
        assert_eq!(powi2(128).to_bits(), INFINITY);
        assert_eq!(powi2(i32::MAX).to_bits(), INFINITY);
    }
}
