//! Pictures: PNG and JPEG files as texels.

use crate::scene::text::one_line;
use caustic_kernels::trace::Texel;
use half::f16;
use image::{ImageReader, Limits};
use std::io::Cursor;

/// Most texels along a side.
const MAX_SIDE: u32 = 16_384;
/// Most bytes that decoding a picture may take.
const MAX_ALLOCATED: u64 = 1 << 30;

/// A picture in linear light.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::scene) struct Picture {
    pub width: u32,
    pub height: u32,
    /// How it goes on beyond its edges, as kernels have it.
    pub wrap: u32,
    /// Row by row, the top one first.
    pub texels: Vec<Texel>,
}

/// Decodes a file's bytes. `srgb` says that its colours are encoded by sRGB's curve, else they are linear.
pub(super) fn decode(bytes: &[u8], wrap: u32, srgb: bool) -> Result<Picture, String> {
    let refused = |problem: String| format!("is no picture that can be read: {problem}; give a PNG or JPEG file");
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| refused(one_line(&error.to_string())))?;
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    limits.max_alloc = Some(MAX_ALLOCATED);
    reader.limits(limits);
    let image = reader.decode().map_err(|error| refused(one_line(&error.to_string())))?.into_rgba8();
    let (width, height) = image.dimensions();
    if width == 0 || height == 0 {
        return Err(refused("it has no pixels".to_string()));
    }
    let table: Vec<u32> = (0..256)
        .map(|code| half(if srgb { linear(f64::from(code) / 255.0) } else { f64::from(code) / 255.0 }))
        .collect();
    let texels = image
        .pixels()
        .map(|pixel| {
            let [r, g, b, a] = pixel.0;
            let colour = |code: u8| table[usize::from(code)];
            Texel { rg: colour(r) | colour(g) << 16, ba: colour(b) | half(f64::from(a) / 255.0) << 16 }
        })
        .collect();
    Ok(Picture { width, height, wrap, texels })
}

/// sRGB's curve (IEC 61966-2-1).
fn linear(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

fn half(x: f64) -> u32 {
    f16::from_f64(x).to_bits().into()
}
