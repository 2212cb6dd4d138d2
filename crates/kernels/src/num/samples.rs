//! What the tests of this folder feed on: bit patterns at the edges, and a generator for the rest.

extern crate std;

/// Floats at the edges of every class, both signs.
pub const EDGES: [u32; 40] = both_signs([
    0x0000_0000, // 0
    0x0000_0001, // the smallest subnormal
    0x0040_0000, // a subnormal that IEEE arithmetic would keep
    0x007f_ffff, // the largest subnormal
    0x0080_0000, // the smallest normal
    0x0080_0001,
    0x00ff_ffff,
    0x3eff_ffff, // around 1/2 and 1
    0x3f00_0000,
    0x3f7f_ffff,
    0x3f80_0000,
    0x3f80_0001,
    0x4b00_0000, // 2^23
    0x4b7f_ffff, // 2^24 - 1
    0x4e80_0000, // 2^30
    0x7e80_0000,
    0x7f7f_ffff, // the largest finite number
    0x7f80_0000, // infinity
    0x7f80_0001, // a signalling NaN
    0x7fc0_0000,
]);

const fn both_signs(positive: [u32; 20]) -> [u32; 40] {
    let mut all = [0; 40];
    let mut i = 0;
    while i < 20 {
        all[2 * i] = positive[i];
        all[2 * i + 1] = positive[i] | 0x8000_0000;
        i += 1;
    }
    all
}

/// A 64-bit linear congruential generator (Knuth's MMIX constants), of which the high half is used. It shares nothing
/// with the generators under test.
pub struct Lcg(pub u64);

impl Lcg {
    pub fn next_u32(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) as u32
    }
}

/// What the policy of this folder makes of an IEEE 754 result.
pub fn policy(native: f32) -> u32 {
    if native.is_nan() {
        0x7fc0_0000
    } else if native.is_subnormal() {
        native.to_bits() & 0x8000_0000
    } else {
        native.to_bits()
    }
}

/// `x` with a subnormal replaced by the zero of its sign.
pub fn operand(bits: u32) -> f32 {
    let x = f32::from_bits(bits);
    if x.is_subnormal() { f32::from_bits(bits & 0x8000_0000) } else { x }
}

/// The two 24-bit significands of `count` divisions whose exact quotient lies as near to a rounding boundary as any:
/// with an odd divisor `b`, the remainder `(b ± 1) / 2` of `a · 2^24 / b` is reached by a modular inverse.
pub fn near_halfway(lcg: &mut Lcg, count: u32) -> std::vec::Vec<(u32, u32)> {
    let mut pairs = std::vec::Vec::new();
    while pairs.len() < count as usize {
        let b = u64::from(lcg.next_u32() & 0x007f_ffff | 0x0080_0001);
        let mut inverse = 1;
        // 1/2 is (b + 1) / 2 modulo an odd b; `a < b` has its quotient scaled by 2^24, `a >= b` by 2^23.
        for _ in 0..24 {
            inverse = inverse * b.div_ceil(2) % b;
        }
        for remainder in [b / 2, b.div_ceil(2)] {
            let a = remainder * inverse % b;
            if a >= 0x0080_0000 {
                pairs.push((a as u32, b as u32));
            }
        }
        let above = 2 * inverse % b;
        for remainder in [b / 2, b.div_ceil(2)] {
            let a = remainder * above % b + b;
            if a < 0x0100_0000 {
                pairs.push((a as u32, b as u32));
            }
        }
    }
    pairs
}
