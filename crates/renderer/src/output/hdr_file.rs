//! Radiance HDR: linear light with a shared exponent (Ward, "Real Pixels", Graphics Gems II, 1991). A channel keeps about 1 % of the
//! pixel's brightest, and nothing below zero.

use super::Image;
use image::codecs::hdr::HdrEncoder;
use image::{ImageFormat, Rgb};

/// Largest float that the format holds: a mantissa of 255/256 at the largest exponent.
const MOST: f32 = 1.69e38;

/// The bytes of a Radiance HDR file.
pub(super) fn encode(image: &Image) -> Result<Vec<u8>, String> {
    // What is not a number is not above 0.
    let stored = |x: f32| if x > 0.0 { x.min(MOST) } else { 0.0 };
    let pixels: Vec<Rgb<f32>> = image.rgb.iter().map(|rgb| Rgb(rgb.map(stored))).collect();
    let mut bytes = Vec::new();
    HdrEncoder::new(&mut bytes)
        .encode(&pixels, image.width as usize, image.height as usize)
        .map_err(|error| error.to_string())?;
    Ok(bytes)
}

/// The picture of a Radiance HDR file.
pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    let decoded = image::load_from_memory_with_format(bytes, ImageFormat::Hdr).map_err(|error| error.to_string())?;
    let decoded = decoded.into_rgb32f();
    let (width, height) = decoded.dimensions();
    Ok(Image { width, height, rgb: decoded.pixels().map(|pixel| pixel.0).collect() })
}
