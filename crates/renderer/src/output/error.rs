//! Why a picture cannot be written or read, in one sentence with the remedy.

use std::path::PathBuf;

/// Why a picture cannot be written or read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The ending names no format.
    #[error("`{}` does not end in .png or .exr, the formats there are; give the picture one of these endings", .path.display())]
    UnknownEnding {
        /// The file.
        path: PathBuf,
    },
    /// The folder is not there.
    #[error("the folder `{}` does not exist; create it or write the picture elsewhere", .folder.display())]
    NoFolder {
        /// The folder.
        folder: PathBuf,
    },
    /// What should be a folder is something else.
    #[error("`{}` is not a folder, so no picture can be in it; write the picture elsewhere", .folder.display())]
    NotAFolder {
        /// What should be a folder.
        folder: PathBuf,
    },
    /// The path is taken by something that is not a file.
    #[error("`{}` is {what}, not a file to replace; write the picture to another name", .path.display())]
    Taken {
        /// The path.
        path: PathBuf,
        /// What is there.
        what: &'static str,
    },
    /// The folder takes no new file.
    #[error("cannot write into the folder `{}`: {reason}; make it writable or write the picture elsewhere", .folder.display())]
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
    #[error("cannot write the picture `{}`: {reason}; check the disk's free space or write it elsewhere", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's words.
        reason: String,
    },
    /// Reading failed.
    #[error("cannot read the picture `{}`: {reason}; give a PNG or EXR file that this program wrote", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The decoder's words.
        reason: String,
    },
}
