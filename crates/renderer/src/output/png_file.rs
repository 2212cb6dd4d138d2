//! PNG: sRGB (IEC 61966-2-1), 8 bits a channel.

use super::{Display, Image};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageFormat};

/// The sRGB code, 0 to 255, of linear light: 0 for what is negative or not a number, 255 for 1 and more.
#[must_use]
pub fn to_srgb8(linear: f32) -> u8 {
    code(encode_srgb(f64::from(linear)))
}

/// Linear light as a display takes it, 0 to 1.
pub(super) fn encode_srgb(x: f64) -> f64 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// The nearest of 256 codes.
pub(super) fn code(encoded: f64) -> u8 {
    // `as` clamps, and makes 0 of what is not a number.
    (encoded * 255.0 + 0.5) as u8
}

/// The linear light, 0 to 1, of an sRGB code.
#[must_use]
pub fn from_srgb8(code: u8) -> f32 {
    let x = f64::from(code) / 255.0;
    let linear = if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    linear as f32
}

/// The bytes of a PNG.
pub(super) fn encode(image: &Image, display: &Display) -> Result<Vec<u8>, String> {
    let codes: Vec<u8> = image.rgb.iter().flat_map(|&rgb| display.codes(rgb)).collect();
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(&codes, image.width, image.height, ExtendedColorType::Rgb8)
        .map_err(|error| error.to_string())?;
    Ok(bytes)
}

/// The picture of a PNG.
pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    let decoded = image::load_from_memory_with_format(bytes, ImageFormat::Png).map_err(|error| error.to_string())?;
    let decoded = decoded.into_rgb8();
    let (width, height) = decoded.dimensions();
    let rgb = decoded.pixels().map(|pixel| pixel.0.map(from_srgb8)).collect();
    Ok(Image { width, height, rgb })
}
