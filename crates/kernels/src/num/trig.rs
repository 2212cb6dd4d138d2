//! Sine and cosine of turns, from polynomials in written-out order.

use super::float::{SIGN, flush};

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
