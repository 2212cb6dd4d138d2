//! PNG: codes of sRGB, 8 or 16 bits a channel.

use super::{Decoded, Trouble, check_sides};
use crate::from_srgb;
use image::codecs::png::PngDecoder;
use image::{DynamicImage, ImageDecoder};
use std::io::Cursor;

/// Decodes a PNG. Profiles and gamma chunks are not looked at: what this program writes has none, and is sRGB.
pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, Trouble> {
    let decoder = PngDecoder::new(Cursor::new(bytes))?;
    let (width, height) = decoder.dimensions();
    check_sides(width as usize, height as usize)?;
    let decoded = DynamicImage::from_decoder(decoder)?;
    // 16 bits hold what 1, 2, 4, 8 and 16 do: a code of 8 bits becomes 257 times itself.
    let codes = decoded.into_rgba16();
    if let Some((x, y, _)) = codes.enumerate_pixels().find(|(_, _, pixel)| pixel.0[3] != u16::MAX) {
        return Err(Trouble::Transparent(x, y));
    }
    let linear: Vec<f32> = (0..=u16::MAX).map(|code| from_srgb(f64::from(code) / 65_535.0) as f32).collect();
    let light = |code: u16| linear[usize::from(code)];
    let rgb = codes.pixels().map(|pixel| [light(pixel.0[0]), light(pixel.0[1]), light(pixel.0[2])]).collect();
    Ok(Decoded { width: width as usize, height: height as usize, rgb })
}
