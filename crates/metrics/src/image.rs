//! A picture that can be compared: finite numbers in linear light.

use crate::MetricsError;
use crate::read;
use std::path::Path;

/// Most pixels of a picture: as many as a render can have.
pub const MAX_PIXELS: usize = 1 << 28;

/// What the numbers of a picture can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// From 0, black, to 1, a display's white: a PNG.
    Display,
    /// Radiances without an upper bound: an EXR or a Radiance HDR.
    Scene,
}

/// A picture in linear light: red, green and blue by the primaries of sRGB, row by row from the top left, all finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    name: String,
    width: usize,
    height: usize,
    rgb: Vec<[f32; 3]>,
    range: Range,
}

impl Image {
    /// A picture of radiances, or whatever linear numbers: [`Range::Scene`].
    ///
    /// # Errors
    /// If a side is 0, the sides do not belong to the number of pixels, or a channel is infinite or not a number.
    pub fn from_linear(width: usize, height: usize, rgb: Vec<[f32; 3]>) -> Result<Self, MetricsError> {
        Self::new("the picture".to_string(), width, height, rgb, Range::Scene)
    }

    /// A picture of sRGB codes of 8 bits: [`Range::Display`].
    ///
    /// # Errors
    /// If a side is 0 or the sides do not belong to the number of pixels.
    pub fn from_srgb8(width: usize, height: usize, codes: &[[u8; 3]]) -> Result<Self, MetricsError> {
        let linear: Vec<f32> = (0..=255).map(|code| crate::from_srgb(f64::from(code) / 255.0) as f32).collect();
        let rgb = codes.iter().map(|rgb| rgb.map(|code| linear[usize::from(code)])).collect();
        Self::new("the picture".to_string(), width, height, rgb, Range::Display)
    }

    /// Reads a file, by its ending.
    ///
    /// * `.png`: 8 or 16 bits a channel, colour or grey, decoded as sRGB whatever profile it names. An alpha channel is left out if
    ///   it is opaque everywhere, and an error otherwise.
    /// * `.exr`: the first layer with channels R, G and B, at full resolution, of the data window. An alpha channel is left out: an
    ///   EXR's colours are premultiplied, that is, they are what is seen before black.
    /// * `.hdr`: Radiance's RGBE, divided by the exposures and colour corrections of its header.
    ///
    /// # Errors
    /// If the ending is unknown, the file cannot be read, is empty, cut short or something else, or a channel is infinite or not a
    /// number: always one sentence that names the file.
    pub fn read(path: &Path) -> Result<Self, MetricsError> {
        read::read(path)
    }

    pub(crate) fn new(
        name: String,
        width: usize,
        height: usize,
        rgb: Vec<[f32; 3]>,
        range: Range,
    ) -> Result<Self, MetricsError> {
        if rgb.is_empty() || width.checked_mul(height) != Some(rgb.len()) || rgb.len() > MAX_PIXELS {
            return Err(MetricsError::Shape { name, width, height, pixels: rgb.len() });
        }
        if let Some(at) = rgb.as_flattened().iter().position(|value| !value.is_finite()) {
            let (pixel, channel) = (at / 3, ["red", "green", "blue"][at % 3]);
            let value = rgb.as_flattened()[at];
            return Err(MetricsError::NotFinite { name, value, channel, x: pixel % width, y: pixel / width });
        }
        Ok(Self { name, width, height, rgb, range })
    }

    /// The same picture under a name that errors call it by.
    #[must_use]
    pub fn named(self, name: &str) -> Self {
        Self { name: name.to_string(), ..self }
    }

    /// What a display shows of the picture at an exposure in stops: numbers times 2^`stops`, cut off below 0 and above 1.
    #[must_use]
    pub fn displayed(&self, stops: f32) -> Self {
        let scale = f64::from(stops).exp2();
        let show = |value: f32| (f64::from(value) * scale).clamp(0.0, 1.0) as f32;
        let rgb = self.rgb.iter().map(|rgb| rgb.map(show)).collect();
        Self { name: self.name.clone(), rgb, range: Range::Display, ..*self }
    }

    /// Its name: the file it was read from, in quotes, or what [`Self::named`] said.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Pixels in a row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels in a column.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Red, green and blue of each pixel, row by row from the top left.
    #[must_use]
    pub fn rgb(&self) -> &[[f32; 3]] {
        &self.rgb
    }

    /// What its numbers can be.
    #[must_use]
    pub fn range(&self) -> Range {
        self.range
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_finite_is_named() {
        for (value, word) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf"), (f32::NEG_INFINITY, "-inf")] {
            let mut rgb = vec![[0.0; 3]; 6];
            rgb[5][1] = value;
            let error = Image::from_linear(3, 2, rgb).unwrap_err().to_string();
            assert!(error.contains(&format!("holds {word} in the green channel of pixel (2, 1)")), "{error}");
        }
    }

    #[test]
    fn sides_belong_to_the_pixels() {
        for (width, height) in [(0, 0), (0, 4), (2, 3), (usize::MAX, usize::MAX)] {
            let error = Image::from_linear(width, height, vec![[0.0; 3]; 4]).unwrap_err();
            assert!(matches!(error, MetricsError::Shape { .. }), "{error}");
        }
        assert!(Image::from_linear(0, 0, Vec::new()).is_err());
    }

    #[test]
    fn a_display_cuts_off() {
        let scene = Image::from_linear(4, 1, vec![[-1.0; 3], [0.25; 3], [0.75; 3], [f32::MAX; 3]]).unwrap();
        let shown = scene.displayed(1.0);
        assert_eq!(shown.rgb(), [[0.0; 3], [0.5; 3], [1.0; 3], [1.0; 3]]);
        assert_eq!((scene.range(), shown.range()), (Range::Scene, Range::Display));
        let codes = Image::from_srgb8(2, 1, &[[0, 128, 255], [255; 3]]).unwrap();
        assert_eq!(codes.displayed(0.0), codes);
    }
}
