//! Why a picture or another file cannot be written or read, in one sentence with the remedy.

use std::path::PathBuf;

/// Why a picture cannot be written or read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The ending names no format.
    #[error("`{}` does not end in .png, .exr or .hdr, the formats there are; give the picture one of these endings", .path.display())]
    UnknownEnding {
        /// The file.
        path: PathBuf,
    },
    /// Layers for a format that has none.
    #[error("`{}` can hold no layers, such as `{layer}`; give the picture the ending .exr", .path.display())]
    NoLayers {
        /// The file.
        path: PathBuf,
        /// The first of the layers.
        layer: &'static str,
    },
    /// An exposure or a tone curve for a format that keeps light as it is.
    #[error("--exposure and --tone-map are for PNGs, and `{}` keeps the light as it is; leave them out or give the picture the ending .png", .path.display())]
    NotShown {
        /// The file.
        path: PathBuf,
    },
    /// The program has no denoiser.
    #[error(
        "--denoise: this program was built without a denoiser; build it with `--features denoise`, which needs the library OpenImageDenoise (docs/output.md)"
    )]
    NoDenoiser,
    /// The denoiser failed.
    #[error("OpenImageDenoise failed: {reason}; leave out --denoise")]
    Denoise {
        /// The library's words.
        reason: String,
    },
    /// The folder is not there.
    #[error("the folder `{}` does not exist; create it or write elsewhere", .folder.display())]
    NoFolder {
        /// The folder.
        folder: PathBuf,
    },
    /// What should be a folder is something else.
    #[error("`{}` is not a folder, so no file can be in it; write elsewhere", .folder.display())]
    NotAFolder {
        /// What should be a folder.
        folder: PathBuf,
    },
    /// The path is taken by something that is not a file.
    #[error("`{}` is {what}, not a file to replace; write to another name", .path.display())]
    Taken {
        /// The path.
        path: PathBuf,
        /// What is there.
        what: &'static str,
    },
    /// The folder takes no new file.
    #[error("cannot write into the folder `{}`: {reason}; make it writable or write elsewhere", .folder.display())]
    NotWritable {
        /// The folder.
        folder: PathBuf,
        /// The system's words.
        reason: String,
    },
    /// The sides are out of bounds or do not belong to the pixels.
    #[error(
        "a picture of {width} × {height} pixels cannot be made of {pixels}: each side must be from 1 to 65536 and their product the number of pixels"
    )]
    Shape {
        /// Pixels in a row.
        width: u32,
        /// Pixels in a column.
        height: u32,
        /// Pixels there are.
        pixels: usize,
    },
    /// Writing failed.
    #[error("cannot write `{}`: {reason}; check the disk's free space or write it elsewhere", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's words.
        reason: String,
    },
    /// Reading failed.
    #[error("cannot read the picture `{}`: {reason}; give a PNG, EXR or HDR file", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The decoder's words.
        reason: String,
    },
}
