//! Sine and cosine of turns and back, from polynomials in written-out order.

use super::div::div;
use super::float::{NAN, SIGN, abs, flush, is_nan};

/// `(sin 2πt, cos 2πt)`, each within 8e-8 of the exact value and never above 1; exactly 0 and ±1 at multiples
/// of ¼.
///
/// The argument loses nothing: 4t is exact, and so is its distance `r` to the nearest whole number, so the bound holds for
/// every finite `t`. Floats from 2²⁴ on are whole turns; ±∞ and NaN are taken for such and give (0, 1). A zero sine may
/// have either sign. Source: odd and even minimax polynomials of degree 7 and 8 for |r| ≤ ½ (Lawson's iteration,
/// 4·10⁻⁹ and 5·10⁻¹¹ off in exact arithmetic; what remains is rounding).
///
/// Fast: the driver's own, up to 2⁻¹¹ off, which the Vulkan specification grants within ±π only; so whole turns go first.
#[inline]
pub fn sin_cos_turns(t: f32) -> (f32, f32) {
    #[cfg(all(target_arch = "spirv", feature = "fast"))]
    return {
        use spirv_std::num_traits::Float;
        ((t - t.round()) * core::f32::consts::TAU).sin_cos()
    };
    let whole_turns = t.to_bits() & !SIGN >= 0x4b80_0000;
    let quarters = if whole_turns { 0.0 } else { 4.0 * flush(t) };
    // Truncation of |4t| + ½ needs no native `round`. Near a tie the sum's rounding may go either way and does no harm; but
    // from 2²³ on, where 4t is whole, it would be off by one.
    let half = if quarters.to_bits() & !SIGN < 0x4b00_0000 { 0x3f00_0000 } else { 0 };
    let half = f32::from_bits(half | (quarters.to_bits() & SIGN));
    let quadrant = (quarters + half) as i32;
    let r = quarters - quadrant as f32;
    let r2 = r * r;
    let sin = r * (1.570_796_4 + r2 * (-0.645_964_8 + r2 * (0.079_689_88 + r2 * -0.004_622_96)));
    let cos = 1.0 + r2 * (-1.233_700_5 + r2 * (0.253_669_24 + r2 * (-0.020_860_29 + r2 * 0.000_904_021_66)));
    // sin: quadrants 0 to 3 give s, c, −s, −c; cos: c, −s, −c, s. Swapped by XOR, for the quadrant is as good as random and a
    // branch on it is mispredicted half the time.
    let turn = quadrant as u32;
    let swap = (sin.to_bits() ^ cos.to_bits()) & 0u32.wrapping_sub(turn & 1);
    let s_sign = (turn & 2) << 30;
    let c_sign = (turn.wrapping_add(1) & 2) << 30;
    (f32::from_bits(sin.to_bits() ^ swap ^ s_sign), f32::from_bits(cos.to_bits() ^ swap ^ c_sign))
}

/// The angle of the vector (x, y) from the x axis, in turns from −½ to ½: within 4e-8 of the exact value for finite coordinates,
/// 0 for no vector, and [`NAN`] for what has no angle. Source: a polynomial through the Chebyshev points of atan(√s) / (2π√s), s from 0 to 1, 3·10⁻⁹ off in exact
/// arithmetic; what remains is rounding.
///
/// Fast: the driver's own.
#[inline]
pub fn atan2_turns(y: f32, x: f32) -> f32 {
    #[cfg(all(target_arch = "spirv", feature = "fast"))]
    return {
        use spirv_std::num_traits::Float;
        if x == 0.0 && y == 0.0 { 0.0 } else { y.atan2(x) * (1.0 / core::f32::consts::TAU) }
    };
    let (y, x) = (flush(y), flush(x));
    let (across, along) = (abs(y), abs(x));
    let steep = across > along;
    let mut a = 0.0;
    if steep {
        a = div(along, across);
    } else if along > 0.0 {
        a = div(across, along);
    }
    let s = a * a;
    let high = 0.016_899_662 + s * (-0.011_867_953 + s * (0.006_706_411 + s * (-0.002_503_706 + s * 0.000_440_267_7)));
    let mut turns = a * (0.159_154_94 + s * (-0.053_051_176 + s * (0.031_818_053 + s * (-0.022_596_497 + s * high))));
    if steep {
        turns = 0.25 - turns;
    }
    if x < 0.0 {
        turns = 0.5 - turns;
    }
    let turns = flush(turns);
    // Devices differ in the bits of a NaN.
    if is_nan(turns) {
        NAN
    } else if y < 0.0 {
        -turns
    } else {
        turns
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::Lcg;
    use super::*;

    /// The larger error of the two, against f64.
    fn error(t: f32) -> f64 {
        let (s, c) = sin_cos_turns(t);
        // f64's remainder is exact, so the reference is good for a large `t` as well.
        let (exact_s, exact_c) = (core::f64::consts::TAU * (f64::from(t) % 1.0)).sin_cos();
        assert!(s.abs() <= 1.0 && c.abs() <= 1.0, "{t}: {s}, {c}");
        let norm = f64::from(s) * f64::from(s) + f64::from(c) * f64::from(c);
        assert!((norm - 1.0).abs() <= 2.5e-7, "{t}: s² + c² = {norm}");
        (f64::from(s) - exact_s).abs().max((f64::from(c) - exact_c).abs())
    }

    #[test]
    fn multiples_of_a_millionth() {
        for i in 0..=1u32 << 20 {
            let t = i as f32 / (1 << 20) as f32;
            assert!(error(t) <= 8e-8, "{t}: {}", error(t));
        }
    }

    #[test]
    fn random_turns_of_every_size() {
        let mut lcg = Lcg(10);
        for _ in 0..1_000_000 {
            let unit = f32::from_bits(0x3f80_0000 | lcg.next_u32() >> 9) - 1.0;
            let any = f32::from_bits(lcg.next_u32());
            assert!(error(unit) <= 8e-8, "{unit}: {}", error(unit));
            assert!(!any.is_finite() || error(any) <= 8e-8, "{any}: {}", error(any));
        }
    }

    #[test]
    fn exact_at_quarters() {
        for i in -64..=64 {
            let expected = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][(i & 3) as usize];
            assert_eq!(sin_cos_turns(i as f32 * 0.25), expected);
        }
    }

    #[test]
    fn beyond_whole_turns_and_not_finite() {
        for t in [16_777_216.0, -f32::MAX, f32::INFINITY, f32::NAN, 1e-40, 0.0] {
            assert_eq!(sin_cos_turns(t), (0.0, 1.0), "{t}");
        }
    }

    #[test]
    fn angles_of_vectors_of_every_direction_and_size() {
        let mut lcg = Lcg(12);
        let mut worst = 0f64;
        for i in 0..2_000_000u32 {
            // Even in angle, of every size; then any two numbers.
            let (s, c) = (f64::from(i) * 3.141_593e-6 + 1e-7).sin_cos();
            let size = f32::from_bits(((lcg.next_u32() % 200 + 20) << 23) | lcg.next_u32() >> 9);
            let (mut y, mut x) = ((s * f64::from(size)) as f32, (c * f64::from(size)) as f32);
            if i % 4 == 3 {
                y = f32::from_bits(lcg.next_u32());
                x = f32::from_bits(lcg.next_u32());
            }
            // No vector has no angle, whatever f64 says of −0.
            if !y.is_finite() || !x.is_finite() || (flush(y) == 0.0 && flush(x) == 0.0) {
                continue;
            }
            let exact = f64::from(flush(y)).atan2(f64::from(flush(x))) / core::f64::consts::TAU;
            let error = (f64::from(atan2_turns(y, x)) - exact).abs();
            // −½ and ½ are one direction.
            worst = worst.max(error.min((error - 1.0).abs()));
        }
        assert!(worst <= 4e-8 && worst > 1e-9, "{worst}");
    }

    #[test]
    fn angles_are_exact_at_quarters() {
        for size in [1.0, 1e-30, 1e30] {
            let angles = [[0.0, size], [size, 0.0], [0.0, -size], [-size, 0.0]].map(|[y, x]| atan2_turns(y, x));
            assert_eq!(angles, [0.0, 0.25, 0.5, -0.25]);
        }
        assert_eq!([atan2_turns(0.0, 0.0), atan2_turns(1e-40, -1e-41)], [0.0, 0.0]);
    }

    /// A bound that cannot be missed bounds nothing: a last coefficient off by one part in 200 has to show.
    #[test]
    fn planted_fault_shows() {
        let missed = (0..1000u32).filter(|i| {
            let t = f64::from(*i) / 8000.0;
            let fault = 0.005 * 0.004_622_96 * (4.0 * t).powi(7);
            let (s, _) = sin_cos_turns(t as f32);
            let exact = (core::f64::consts::TAU * f64::from(t as f32)).sin();
            (f64::from(s) + fault - exact).abs() > 8e-8
        });
        assert!(missed.count() > 50);
    }
}
