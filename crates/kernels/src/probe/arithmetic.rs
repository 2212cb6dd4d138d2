//! Every operation of [`num`](crate::num), and plain sums of products, over operands of every kind.

use crate::exec::Store;
use crate::num::{
    Limbs, atan2_turns, div, exp, exp2, f32_to_u32_clamped, floor_to_i32, inv_sqrt, ln, log2, max, pcg4d, pow,
    sin_cos_turns, sqrt, total_order_key,
};
use bytemuck::{Pod, Zeroable};

/// Which operands.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ArithmeticParams {
    /// First pair of operands.
    pub first: u32,
    /// Pairs.
    pub count: u32,
    /// Seed of the random ones.
    pub seed: u32,
}

/// Operands and results, all as bits.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Arithmetic {
    /// a and b.
    pub operands: [u32; 2],
    /// `div(a, b)`.
    pub quotient: u32,
    /// `sqrt(a)`.
    pub root: u32,
    /// `inv_sqrt(a)`.
    pub inverse_root: u32,
    /// `sin_cos_turns(a)`.
    pub sin_cos: [u32; 2],
    /// `atan2_turns(a, b)`.
    pub angle: u32,
    /// `exp2(a)` and `exp(a)`.
    pub exponentials: [u32; 2],
    /// `log2(a)` and `ln(a)`.
    pub logarithms: [u32; 2],
    /// `pow(a, b)`.
    pub power: u32,
    /// a·b + a, of a and b within 2³³: a device that contracts it rounds once and not twice.
    pub product_sum: u32,
    /// (a + b) − a, of the same: a device that reassociates it gives b.
    pub difference: u32,
    /// `floor_to_i32(a)`, `f32_to_u32_clamped(a)` and `total_order_key(a)`.
    pub conversions: [u32; 3],
    /// The exact sum of |a|, |b|, |a|, |b|, |b|, of the same.
    pub sum: u32,
}

const _: () = assert!(size_of::<Arithmetic>() == 76);

/// Computes everything for pair `first + i`.
#[inline]
pub fn arithmetic<R: Store<Arithmetic> + ?Sized>(i: u32, params: &ArithmeticParams, results: &mut R) {
    if i >= params.count {
        return;
    }
    let [a_bits, b_bits] = operands(params.first + i, params.seed);
    let (a, b) = (f32::from_bits(a_bits), f32::from_bits(b_bits));
    let (tame_a, tame_b) = (tame(a_bits), tame(b_bits));
    let (sin, cos) = sin_cos_turns(a);
    let (x, y) = (f32::from_bits(tame_a.to_bits() & 0x7fff_ffff), f32::from_bits(tame_b.to_bits() & 0x7fff_ffff));
    let scale = max(x, y);
    let (x, y) = (Limbs::of(x, scale), Limbs::of(y, scale));
    let mut sum = Limbs::ZERO;
    sum.add(x.0);
    sum.add(y.0);
    sum.add(x.0);
    sum.add(y.0);
    sum.add(y.0);
    results.set(
        i,
        Arithmetic {
            operands: [a_bits, b_bits],
            quotient: div(a, b).to_bits(),
            root: sqrt(a).to_bits(),
            inverse_root: inv_sqrt(a).to_bits(),
            sin_cos: [sin.to_bits(), cos.to_bits()],
            angle: atan2_turns(a, b).to_bits(),
            exponentials: [exp2(a).to_bits(), exp(a).to_bits()],
            logarithms: [log2(a).to_bits(), ln(a).to_bits()],
            power: pow(a, b).to_bits(),
            product_sum: (tame_a * tame_b + tame_a).to_bits(),
            difference: ((tame_a + tame_b) - tame_a).to_bits(),
            conversions: [floor_to_i32(a) as u32, f32_to_u32_clamped(a), total_order_key(a)],
            sum: sum.value(scale).to_bits(),
        },
    );
}

/// The number with the sign and significand of `bits`, brought into 2⁻³¹ to 2³³.
#[inline]
fn tame(bits: u32) -> f32 {
    f32::from_bits((bits & 0x807f_ffff) | ((((bits >> 23) & 0x3f) + 96) << 23))
}

/// Pair `n` of operands: in turns any bits; dense significands in one binade; significands that nearly agree; small whole
/// numbers; squares and their neighbours; every pair of exponents; numbers about 1; the ends of the range.
#[inline]
fn operands(n: u32, seed: u32) -> [u32; 2] {
    let random = pcg4d([n, seed, 0xa817, 0]);
    let (r, s) = (random[0], random[1]);
    let kind = n % 8;
    if kind == 0 {
        [r, s]
    } else if kind == 1 {
        [0x3f80_0000 | (r >> 9), 0x3f80_0000 | (s >> 9)]
    } else if kind == 2 {
        [0x3f80_0000 + (r >> 9), 0x3f80_0000 + (r >> 9) + (s >> 28)]
    } else if kind == 3 {
        [((r >> 20) as f32).to_bits(), ((s >> 20) as f32 + 1.0).to_bits()]
    } else if kind == 4 {
        let root = (r >> 20) as f32;
        [(root * root).to_bits() + (s & 3), (root + 1.0).to_bits()]
    } else if kind == 5 {
        let pair = n / 8;
        [((pair & 0xff) << 23) | (r >> 9), (((pair >> 8) & 0xff) << 23) | (s >> 9) | (r << 31)]
    } else if kind == 6 {
        [(((r >> 9) & 7) + 124) << 23 | (s >> 9) | (r << 31), (((r >> 12) & 7) + 124) << 23 | (random[2] >> 9)]
    } else {
        let top = if r & 1 == 0 { 0 } else { 251 };
        [(((r >> 1) & 3) + top) << 23 | (s >> 9), (((r >> 3) & 0xff) << 23) | (random[2] >> 9)]
    }
}
