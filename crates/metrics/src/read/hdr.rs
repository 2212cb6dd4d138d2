//! Radiance's pictures: three bytes that share an exponent (Ward, "Real pixels", Graphics Gems II, 1991).

use super::{Decoded, Trouble, check_sides};
use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder};
use std::io::Cursor;

/// Decodes a Radiance picture. Its header's exposures and colour corrections are what numbers were multiplied by ("File Formats",
/// Radiance reference manual), so they are divided out.
pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, Trouble> {
    // Other programs write `#?RGBE`, which the decoder takes only where it forgives everything.
    let strict = bytes.starts_with(image::codecs::hdr::SIGNATURE);
    let decoder = HdrDecoder::with_strictness(Cursor::new(bytes), strict)?;
    let metadata = decoder.metadata();
    let (width, height) = (metadata.width as usize, metadata.height as usize);
    check_sides(width, height)?;
    debug_assert_eq!(decoder.dimensions(), (metadata.width, metadata.height));
    let (red, green, blue) = metadata.color_correction.unwrap_or((1.0, 1.0, 1.0));
    let multiplied = [red, green, blue].map(|correction| correction * metadata.exposure.unwrap_or(1.0));
    let pixels = DynamicImage::from_decoder(decoder)?.into_rgb32f();
    let rgb = pixels.pixels().map(|pixel| std::array::from_fn(|c| pixel.0[c] / multiplied[c])).collect();
    Ok(Decoded { width, height, rgb })
}
