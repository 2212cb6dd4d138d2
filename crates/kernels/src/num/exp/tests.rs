//! Errors are measured against f64, whose functions are good to about 2⁻⁵² and so exact to the eye of these tests.

use super::super::samples::{EDGES, Lcg, operand};
use super::*;

// The bounds in the documentation.
const EXP2: f64 = 0.68;
const EXP: f64 = 0.69;
const LOG: f64 = 0.503;
const POW: f64 = 0.76;
const LEAST: f64 = f32::MIN_POSITIVE as f64;

/// The error in units of the last place of `exact`. Zero and infinity are right beyond the ends of normal numbers.
fn ulps(got: f32, exact: f64) -> f64 {
    let size = exact.abs();
    let beyond = if got == 0.0 { size < LEAST } else { got.is_infinite() && size > f64::from(f32::MAX) };
    if beyond && (got == 0.0 || f64::from(got) * exact > 0.0) {
        return 0.0;
    }
    let exponent = (size.max(LEAST).to_bits() >> 52) - 23;
    let error = (f64::from(got) - exact).abs() / f64::from_bits(exponent << 52);
    if error.is_nan() { f64::INFINITY } else { error }
}

fn worst(inputs: impl Iterator<Item = f32>, ours: impl Fn(f32) -> f32, exact: fn(f64) -> f64) -> f64 {
    inputs.map(|x| ulps(ours(x), exact(f64::from(x)))).fold(0.0, f64::max)
}

/// Numbers of every exponent, `count` of each.
fn all_sizes(count: u32) -> impl Iterator<Item = f32> {
    let mut lcg = Lcg(20);
    (0..255 * count).map(move |i| f32::from_bits(((i / count) << 23) | lcg.next_u32() >> 9)).filter(|x| x.is_normal())
}

/// Numbers of every exponent and sign, and an even mesh from −140 to 140, jittered.
fn exponents() -> impl Iterator<Item = f32> {
    let mut lcg = Lcg(21);
    let mesh = (0..1 << 23).map(move |i| (i as f32 - 4_194_304.0 + lcg.next_u32() as f32 * 2.3e-10) * 3.337_86e-5);
    all_sizes(4096).flat_map(|x| [x, -x]).chain(mesh)
}

#[test]
fn exponentials_of_every_size() {
    assert!(worst(exponents(), exp2, f64::exp2) <= EXP2);
    assert!(worst(exponents(), exp, f64::exp) <= EXP);
}

#[test]
fn logarithms_of_every_significand_and_exponent() {
    let significands = || (0x3f00_0000..0x4000_0000).map(f32::from_bits);
    assert!(worst(significands().chain(all_sizes(8192)), log2, f64::log2) <= LOG);
    assert!(worst(significands().chain(all_sizes(8192)), ln, f64::ln) <= LOG);
}

#[test]
fn powers_of_every_size() {
    let mut lcg = Lcg(22);
    for (i, any) in all_sizes(49_152).enumerate() {
        // All sizes; every distance from 1, down to a bit; and results in the range of floats or just beyond.
        let near_one = 0x3f80_0000u32.wrapping_add_signed(lcg.next_u32() as i32 >> (8 + i % 24));
        let x = if i % 2 == 0 { any } else { f32::from_bits(near_one) };
        let wanted = (lcg.next_u32() as f32 * 4.656_613e-10 - 1.0) * 152.0;
        let y = if i % 16 == 0 { f32::from_bits(lcg.next_u32()) } else { wanted / x.log2() };
        if x.is_normal() && y.is_normal() {
            let error = ulps(pow(x, y), f64::from(x).powf(f64::from(y)));
            assert!(error <= POW, "pow({x}, {y}) is {error} ulp off");
        }
    }
}

#[test]
fn exact_results() {
    for n in -126..=127 {
        let power = f32::from_bits(((n + 127) as u32) << 23);
        assert_eq!((exp2(n as f32), log2(power), pow(2.0, n as f32)), (power, n as f32, power));
        assert_eq!(pow(power, 0.5).to_bits(), exp2(n as f32 * 0.5).to_bits());
    }
    for bits in (0x0080_0000..0x7f80_0000).step_by(997).chain(0x3f7f_0000..0x3f81_0000) {
        assert_eq!(pow(f32::from_bits(bits), 1.0).to_bits(), bits);
    }
    for base in 1..4096u64 {
        assert_eq!(pow((base * base) as f32, 0.5), base as f32);
        let powers = (0..24).map(|n| (n, base.saturating_pow(n))).take_while(|&(_, power)| power <= 1 << 24);
        powers.for_each(|(n, power)| assert_eq!(pow(base as f32, n as f32), power as f32));
    }
    assert_eq!([exp(0.0), exp(-1e-30), exp2(1e-30), pow(0.3, 1e-30)], [1.0; 4]);
    assert_eq!((log2(1.0).to_bits(), ln(1.0).to_bits()), (0, 0));
}

#[test]
fn special_values_and_edges() {
    let check = |name: &str, got: f32, is_nan: bool, exact: f64, bound: f64| {
        let good = if is_nan { got.to_bits() == NAN.to_bits() } else { ulps(got, exact) <= bound };
        assert!(good, "{name}: {got} for {exact}");
    };
    for bits in EDGES {
        let (x, exact) = (f32::from_bits(bits), f64::from(operand(bits)));
        let (nan, negative) = (x.is_nan(), exact < 0.0);
        check("exp", exp(x), nan, exact.exp(), EXP);
        check("exp2", exp2(x), nan, exact.exp2(), EXP2);
        check("ln", ln(x), nan || negative, exact.abs().ln(), LOG);
        check("log2", log2(x), nan || negative, exact.abs().log2(), LOG);
        for y in EDGES {
            let power = pow(x, f32::from_bits(y));
            let y = f64::from(operand(y));
            check("pow", power, nan || negative || y.is_nan(), exact.abs().powf(y), POW);
        }
    }
}

#[test]
fn exponentials_grow_across_the_borders_of_their_reduction() {
    for whole in -126..127 {
        let mut x = whole as f32 + 0.5;
        (0..2000).for_each(|_| x = x.next_down());
        for _ in 0..4000 {
            assert!(exp2(x) <= exp2(x.next_up()), "{x}");
            x = x.next_up();
        }
    }
}

/// The checks above must be able to fail.
#[test]
fn planted_faults_show() {
    let faulty_exp2 = |x, fault| {
        let (whole, t, t_lo) = exp_argument(x, 0.0);
        exp_assemble(whole, t, t_lo, exp_tail(t + t_lo) * fault)
    };
    let faulty_log2 = |x, fault| {
        let (exponent, s, s_lo) = log_argument(x);
        let (hi, lo) = log_assemble(exponent, s, s_lo, log_tail((s + s_lo) * (s + s_lo)) * fault);
        hi + lo
    };
    let faulty_exp = |x, fault| {
        let (hi, lo) = times(x, 0.0, LOG2E_TOP, LOG2E_REST * fault);
        exp2_sum(hi, lo)
    };
    let small = || (-1000..1000).map(|i| i as f32 * 0.049);
    let significands = || (0x3f00_0000..0x4000_0000).step_by(997).map(f32::from_bits);
    assert!(worst(small(), |x| faulty_exp2(x, 1.0), f64::exp2) <= EXP2);
    assert!(worst(small(), |x| faulty_exp2(x, 1.000_001), f64::exp2) > EXP2);
    assert!(worst(small(), |x| faulty_exp(x, 1.0), f64::exp) <= EXP);
    assert!(worst(small(), |x| faulty_exp(x, 1.000_01), f64::exp) > EXP);
    assert!(worst(significands(), |x| faulty_log2(x, 1.0), f64::log2) <= LOG);
    assert!(worst(significands(), |x| faulty_log2(x, 1.000_1), f64::log2) > LOG);
    // A logarithm without its second float is good to 24 bits, of which a power with a large exponent loses 7.
    let short = worst(significands(), |x| exp2_sum(77.0 * log2(x), 0.0), |x| x.powf(77.0));
    assert!(short > 10.0 * POW, "{short}");
}
