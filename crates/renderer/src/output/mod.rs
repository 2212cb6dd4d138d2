//! Pictures in files: PNG to look at, EXR to compute with, Radiance HDR for programs that read nothing else.

mod denoise;
mod error;
mod exr_file;
mod hdr_file;
mod layers;
pub(crate) mod place;
mod png_file;
mod tone;

#[cfg(test)]
mod tests;

pub use denoise::{LAYERS as DENOISER_LAYERS, can_denoise, denoise};
pub use error::OutputError;
pub use layers::{Layer, LayerKind};
pub use place::{check as check_place, replace, replace_with};
pub use png_file::{from_srgb8, to_srgb8};
pub use tone::{Display, MAX_EXPOSURE, ToneMap};

use sha2::{Digest, Sha256};
use std::path::Path;

/// Most pixels along one side of a picture.
const MAX_SIDE: u32 = 65_536;

/// A picture in linear light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Pixels in a row.
    pub width: u32,
    /// Pixels in a column.
    pub height: u32,
    /// Radiance, W·sr⁻¹·m⁻², for each of red, green and blue (primaries of sRGB), row by row from the top left.
    pub rgb: Vec<[f32; 3]>,
}

impl Image {
    /// SHA-256 of the floats, row by row, in little-endian order.
    #[must_use]
    pub fn sha256(&self) -> String {
        let bytes: Vec<u8> = self.rgb.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
        Sha256::digest(bytes).iter().fold(String::new(), |text, byte| format!("{text}{byte:02x}"))
    }
}

/// What an EXR says about how its picture was made, in the attributes `caustic.version`, `caustic.scene`, `caustic.seed` and
/// `caustic.settings`, the last with a line `name=value` for each.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Metadata {
    /// Version of the program.
    pub version: String,
    /// Name of the scene.
    pub scene: String,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Settings of the render, name and value.
    pub settings: Vec<(String, String)>,
}

/// The formats of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// sRGB, 8 bits a channel.
    Png,
    /// `OpenEXR`: linear, 32-bit floats, with [`Metadata`] and [`Layer`]s.
    Exr,
    /// Radiance HDR: linear, 8 bits a channel and a shared exponent.
    Hdr,
}

impl Format {
    /// The format that the file's ending asks for.
    ///
    /// # Errors
    /// If it is not one of the known ones.
    pub fn of(path: &Path) -> Result<Self, OutputError> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            Some("hdr") => Ok(Self::Hdr),
            _ => Err(OutputError::UnknownEnding { path: path.to_path_buf() }),
        }
    }
}

/// Checks, before a picture is made, that it can be written to `path`.
///
/// # Errors
/// If its ending is unknown, it is a folder, or its folder does not exist or cannot be written to.
pub fn check_path(path: &Path) -> Result<(), OutputError> {
    Format::of(path)?;
    place::check(path)
}

/// What a picture's file is made of beside the picture.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extras<'a> {
    /// Layers of an EXR.
    pub layers: &'a [Layer],
    /// How light becomes the codes of a PNG.
    pub display: Display,
}

/// Writes a picture without extras: [`write_with`].
///
/// # Errors
/// Those of [`write_with`].
pub fn write(path: &Path, image: &Image, metadata: &Metadata) -> Result<(), OutputError> {
    write_with(path, image, metadata, &Extras::default())
}

/// Writes a picture in the format that the file's ending asks for. The file appears at once and whole, or not at all.
///
/// Only an EXR holds metadata and layers. The same picture, metadata and extras give the same bytes.
///
/// # Errors
/// If `path` fails [`check_path`], the picture or a layer has no pixels or not the number that its sides say, layers are given to another format
/// than EXR, or the disk fails.
pub fn write_with(path: &Path, image: &Image, metadata: &Metadata, extras: &Extras) -> Result<(), OutputError> {
    let format = Format::of(path)?;
    let pixels = u64::from(image.width) * u64::from(image.height);
    let sides = 1..=MAX_SIDE;
    if !sides.contains(&image.width) || !sides.contains(&image.height) || pixels != image.rgb.len() as u64 {
        return Err(OutputError::Shape { width: image.width, height: image.height, pixels: image.rgb.len() });
    }
    if let Some(layer) = extras.layers.first().filter(|_| format != Format::Exr) {
        return Err(OutputError::NoLayers { path: path.to_path_buf(), layer: layer.kind.name() });
    }
    for Layer { kind, values } in extras.layers {
        let channels = kind.channels().len();
        if values.len() != image.rgb.len() * channels {
            let pixels = values.len() / channels;
            return Err(OutputError::Shape { width: image.width, height: image.height, pixels });
        }
    }
    let bytes = match format {
        Format::Png => png_file::encode(image, &extras.display),
        Format::Exr => exr_file::encode(image, extras.layers, metadata),
        Format::Hdr => hdr_file::encode(image),
    };
    let bytes = bytes.map_err(|reason| OutputError::Write { path: path.to_path_buf(), reason })?;
    place::check(path)?;
    place::replace(path, &bytes)
}

/// Reads a picture back: an EXR's floats as they are, without its layers; a PNG's colours as linear light from 0 to 1.
///
/// # Errors
/// If the ending is unknown or the file cannot be read or is damaged.
pub fn read(path: &Path) -> Result<Image, OutputError> {
    let format = Format::of(path)?;
    let failed = |reason: String| OutputError::Read { path: path.to_path_buf(), reason };
    let bytes = std::fs::read(path).map_err(|error| failed(error.to_string()))?;
    match format {
        Format::Png => png_file::decode(&bytes),
        Format::Exr => exr_file::decode(&bytes),
        Format::Hdr => hdr_file::decode(&bytes),
    }
    .map_err(failed)
}
