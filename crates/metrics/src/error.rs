//! Why two pictures cannot be compared, in one sentence with the remedy.

use std::path::PathBuf;

/// Why two pictures cannot be compared.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MetricsError {
    /// The ending names no format that can be read.
    #[error("`{}` does not end in .png, .exr or .hdr, the formats that can be compared; convert it to one of them", .path.display())]
    UnknownEnding {
        /// The file.
        path: PathBuf,
    },
    /// The file holds nothing.
    #[error("`{}` is empty; write the picture again", .path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The file begins otherwise than files with its ending do.
    #[error("`{}` does not begin as {format} does; give it the ending of what it holds, or write the picture again", .path.display())]
    OtherFormat {
        /// The file.
        path: PathBuf,
        /// What its ending says.
        format: &'static str,
    },
    /// The file cannot be read.
    #[error("cannot read the picture `{}`: {reason}; check the path, or write the picture again", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's or the decoder's words, in one line.
        reason: String,
    },
    /// The picture shows something behind it, which the file does not hold.
    #[error(
        "`{}` is transparent at pixel ({x}, {y}), and what lies behind it is not in the file; flatten it onto a background",
        .path.display()
    )]
    Transparent {
        /// The file.
        path: PathBuf,
        /// Column, from the left.
        x: u32,
        /// Row, from the top.
        y: u32,
    },
    /// The sides are out of bounds or do not belong to the pixels.
    #[error(
        "{name} cannot have {width} × {height} pixels made of {pixels}: sides are at least 1, and their product is the number of pixels and at most 268435456"
    )]
    Shape {
        /// The picture.
        name: String,
        /// Pixels in a row.
        width: usize,
        /// Pixels in a column.
        height: usize,
        /// Pixels there are.
        pixels: usize,
    },
    /// A channel of a pixel is infinite or not a number.
    #[error(
        "{name} holds {value} in the {channel} channel of pixel ({x}, {y}), counted from the top left, so nothing can be said of it; render it again, or mend this pixel"
    )]
    NotFinite {
        /// The picture.
        name: String,
        /// `NaN`, `inf` or `-inf`.
        value: f32,
        /// `red`, `green` or `blue`.
        channel: &'static str,
        /// Column, from the left.
        x: usize,
        /// Row, from the top.
        y: usize,
    },
    /// The pictures have different sizes.
    #[error(
        "{} has {} × {} pixels and {} has {} × {}: only pictures of one size can be compared; render both with the same --size",
        .test.0, .test.1, .test.2, .reference.0, .reference.1, .reference.2
    )]
    Sizes {
        /// Name, width and height of the picture in question.
        test: (String, usize, usize),
        /// Name, width and height of the reference.
        reference: (String, usize, usize),
    },
    /// A metric's parameter is out of bounds.
    #[error("{name} is {value} but must be {range}")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// FLIP has no value for these pictures.
    #[error(
        "FLIP cannot compare {test} with {reference}: {reason}; compare smaller parts of them, with fewer pixels a degree, or with another metric"
    )]
    Flip {
        /// The picture in question.
        test: String,
        /// The reference.
        reference: String,
        /// What is too much for it.
        reason: String,
    },
}
