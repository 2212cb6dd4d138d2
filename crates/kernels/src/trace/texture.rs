//! Pictures on surfaces.
//!
//! A texel is four numbers of 16 bits in linear light: what is not linear in a file is made so by the host, and what is read from a
//! half is the same float on every device.

use crate::exec::Input;
use crate::num::{floor_to_i32, max, min};
use bytemuck::{Pod, Zeroable};
use glam::Vec4;

/// [`Texture::wrap`]: beyond its edges the picture begins anew.
pub const WRAP_REPEAT: u32 = 0;
/// [`Texture::wrap`]: beyond its edges are its outermost texels.
pub const WRAP_CLAMP: u32 = 1;
/// [`Texture::wrap`]: beyond its edges the picture is its mirror image.
pub const WRAP_MIRROR: u32 = 2;

/// A picture.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Texture {
    /// Its first texel. They lie row by row, the top one first.
    pub first: u32,
    /// Texels of a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// How it goes on beyond its edges: a `WRAP_` constant for u, and four times one for v.
    pub wrap: u32,
}

/// Red, green, blue and alpha as halves (IEEE 754 binary16), none of them negative or infinite.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Texel {
    /// Red, and above it green.
    pub rg: u32,
    /// Blue, and above it alpha.
    pub ba: u32,
}

const _: () = {
    assert!(size_of::<Texture>() == 16);
    assert!(size_of::<Texel>() == 8);
};

/// Red, green, blue and alpha at (u, v), from (0, 0) at the top left corner to (1, 1): between the middles of four texels, bilinear.
#[inline]
#[must_use]
pub fn texel_at(texture: &Texture, uv: [f32; 2], texels: &Input<Texel>) -> Vec4 {
    let (x0, x1, x) = neighbours(uv[0], texture.width, texture.wrap & 3);
    let (y0, y1, y) = neighbours(uv[1], texture.height, texture.wrap >> 2);
    let top = texture.first + y0 * texture.width;
    let bottom = texture.first + y1 * texture.width;
    let above = between(colour(texels[(top + x0) as usize]), colour(texels[(top + x1) as usize]), x);
    let below = between(colour(texels[(bottom + x0) as usize]), colour(texels[(bottom + x1) as usize]), x);
    between(above, below, y)
}

/// The two texels of a row of `size` that `at` is between, and how far it is from the first, 0 to 1.
#[inline]
fn neighbours(at: f32, size: u32, wrap: u32) -> (u32, u32, f32) {
    let mut unit = max(0.0, min(at, 1.0));
    if wrap == WRAP_REPEAT {
        unit = fraction(at);
    } else if wrap == WRAP_MIRROR {
        let half = fraction(at * 0.5) * 2.0;
        unit = min(half, 2.0 - half);
    }
    let place = unit * size as f32 - 0.5;
    let first = floor_to_i32(place);
    let part = place - first as f32;
    let last = size as i32 - 1;
    let mut before = first;
    let mut after = first + 1;
    if before < 0 {
        before = if wrap == WRAP_REPEAT { last } else { 0 };
    }
    if after > last {
        after = if wrap == WRAP_REPEAT { 0 } else { last };
    }
    (before as u32, after as u32, part)
}

/// What `x` has behind its point, 0 to 1. The host keeps texture coordinates so small that they have something there.
#[inline]
fn fraction(x: f32) -> f32 {
    x - floor_to_i32(x) as f32
}

#[inline]
fn between(a: Vec4, b: Vec4, t: f32) -> Vec4 {
    a + (b - a) * t
}

#[inline]
fn colour(texel: Texel) -> Vec4 {
    Vec4::new(
        half_to_f32(texel.rg & 0xffff),
        half_to_f32(texel.rg >> 16),
        half_to_f32(texel.ba & 0xffff),
        half_to_f32(texel.ba >> 16),
    )
}

/// The float that a half is that is not negative and finite. Exact.
#[inline]
#[must_use]
pub fn half_to_f32(half: u32) -> f32 {
    if half < 0x400 {
        // Subnormal: units of 2⁻²⁴.
        return half as f32 * 5.960_464_5e-8;
    }
    f32::from_bits((half << 13) + (112 << 23))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four texels in a row, red 1, 2, 3 and 4.
    fn red(u: f32, wrap: u32) -> f32 {
        let texels = [0x3c00, 0x4000, 0x4200, 0x4400].map(|half| Texel { rg: half, ba: 0x3c00 << 16 });
        let texture = Texture { first: 0, width: 4, height: 1, wrap: wrap * 5 };
        let texel = texel_at(&texture, [u, 7.25], &texels);
        assert_eq!((texel.y, texel.z, texel.w), (0.0, 0.0, 1.0));
        texel.x
    }

    #[test]
    fn texels_are_met_in_their_middles_and_mixed_between() {
        for wrap in [WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR] {
            for i in 0..4 {
                assert_eq!(red((i as f32 + 0.5) / 4.0, wrap), i as f32 + 1.0);
            }
            assert_eq!(red(0.25, wrap), 1.5);
        }
    }

    #[test]
    fn a_picture_goes_on_as_it_is_told() {
        // At the very edge the first and the last are mixed, or there is one only.
        assert_eq!([red(0.0, WRAP_REPEAT), red(0.0, WRAP_CLAMP), red(0.0, WRAP_MIRROR)], [2.5, 1.0, 1.0]);
        assert_eq!([red(1.0, WRAP_REPEAT), red(1.0, WRAP_CLAMP), red(1.0, WRAP_MIRROR)], [2.5, 4.0, 4.0]);
        assert_eq!([red(1.125, WRAP_REPEAT), red(1.125, WRAP_CLAMP), red(1.125, WRAP_MIRROR)], [1.0, 4.0, 4.0]);
        assert_eq!([red(-0.375, WRAP_REPEAT), red(-0.375, WRAP_CLAMP), red(-0.375, WRAP_MIRROR)], [3.0, 1.0, 2.0]);
        assert_eq!(red(1e6 + 0.125, WRAP_REPEAT), 1.0);
    }

    #[test]
    fn halves_are_exact() {
        assert_eq!(
            [0x0000, 0x0001, 0x03ff, 0x0400].map(half_to_f32),
            [0.0, 2f32.powi(-24), 1023.0 * 2f32.powi(-24), 2f32.powi(-14)]
        );
        assert_eq!([0x3c00, 0x3c01, 0x7bff].map(half_to_f32), [1.0, 1.0 + 1.0 / 1024.0, 65504.0]);
    }
}
