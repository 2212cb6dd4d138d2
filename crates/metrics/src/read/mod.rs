//! Pictures from files.

mod exr;
mod hdr;
mod png;

#[cfg(test)]
mod tests;

use crate::image::MAX_PIXELS;
use crate::{Image, MetricsError, Range};
use std::path::Path;

/// What a file holds: sides and linear pixels.
struct Decoded {
    width: usize,
    height: usize,
    rgb: Vec<[f32; 3]>,
}

/// Why a decoder gave up.
enum Trouble {
    /// In the decoder's words.
    Words(String),
    /// The pixel is transparent.
    Transparent(u32, u32),
}

impl<E: std::error::Error> From<E> for Trouble {
    fn from(error: E) -> Self {
        Self::Words(error.to_string())
    }
}

/// A format: its ending, the words for its files, how they begin, what its numbers can be, its decoder.
struct Format {
    ending: &'static str,
    words: &'static str,
    begins: &'static [u8],
    range: Range,
    decode: fn(&[u8]) -> Result<Decoded, Trouble>,
}

const FORMATS: [Format; 3] = [
    Format {
        ending: "png",
        words: "a PNG file",
        begins: b"\x89PNG\r\n\x1a\n",
        range: Range::Display,
        decode: png::decode,
    },
    Format {
        ending: "exr",
        words: "an EXR file",
        begins: &[0x76, 0x2f, 0x31, 0x01],
        range: Range::Scene,
        decode: exr::decode,
    },
    Format { ending: "hdr", words: "a Radiance HDR file", begins: b"#?R", range: Range::Scene, decode: hdr::decode },
];

/// Reads a picture by its file's ending.
pub(crate) fn read(path: &Path) -> Result<Image, MetricsError> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    let format = FORMATS.iter().find(|format| Some(format.ending) == ending.as_deref());
    let Some(format) = format else { return Err(MetricsError::UnknownEnding { path: path.to_path_buf() }) };
    let failed = |reason: String| MetricsError::Read { path: path.to_path_buf(), reason: one_line(&reason) };
    if path.is_dir() {
        return Err(failed("it is a folder".to_string()));
    }
    let bytes = std::fs::read(path).map_err(|error| failed(error.to_string()))?;
    if bytes.is_empty() {
        return Err(MetricsError::Empty { path: path.to_path_buf() });
    }
    // A file that ends within its first bytes is cut short rather than something else.
    if !bytes.starts_with(format.begins) && !format.begins.starts_with(&bytes) {
        return Err(MetricsError::OtherFormat { path: path.to_path_buf(), format: format.words });
    }
    let decoded = (format.decode)(&bytes).map_err(|trouble| match trouble {
        Trouble::Words(words) => failed(words),
        Trouble::Transparent(x, y) => MetricsError::Transparent { path: path.to_path_buf(), x, y },
    })?;
    let name = format!("`{}`", path.display());
    Image::new(name, decoded.width, decoded.height, decoded.rgb, format.range)
}

/// Refuses sides before memory is taken for them: a damaged header can say anything.
fn check_sides(width: usize, height: usize) -> Result<(), Trouble> {
    let fits = width.checked_mul(height).is_some_and(|pixels| (1..=MAX_PIXELS).contains(&pixels));
    if fits {
        return Ok(());
    }
    Err(Trouble::Words(format!("its header says {width} × {height} pixels, which is none or more than {MAX_PIXELS}")))
}

/// A decoder's words without line breaks and control characters.
fn one_line(words: &str) -> String {
    let clean: String = words.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    clean.split_whitespace().collect::<Vec<_>>().join(" ")
}
