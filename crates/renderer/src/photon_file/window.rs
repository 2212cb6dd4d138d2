//! Parts of a file seen as memory: beside `gpu/passthrough.rs` of `caustic-device`, the one module of caustic that needs `unsafe`.
//!
//! What is mapped changes if the file does, which Rust forbids memory to do, and is gone if the file becomes shorter, which ends a program with a
//! signal. So nothing keeps a window: its bytes are copied out at once, as numbers of which every pattern of bits is one, and the file's length is
//! looked at just before. caustic itself never changes a file of photons: it writes another and renames it.
#![allow(unsafe_code)]

use memmap2::{Mmap, MmapOptions};
use std::fs::File;
use std::io;
use std::ops::Range;

/// Bytes of a window: little against any memory, and enough for the system to read ahead.
pub(super) const WINDOW: u64 = 16 << 20;

/// Shows `see` these bytes of a file, window by window: what a process has of the file in its memory is never more than one.
pub(super) fn each(file: &File, bytes: Range<u64>, mut see: impl FnMut(&[u8])) -> io::Result<()> {
    let mut begin = bytes.start;
    while begin < bytes.end {
        let length = WINDOW.min(bytes.end - begin);
        if file.metadata()?.len() < begin + length {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        see(&map(file, begin, length as usize)?);
        begin += length;
    }
    Ok(())
}

fn map(file: &File, begin: u64, length: usize) -> io::Result<Mmap> {
    // SAFETY: the window is read only, and only by `each`, for the reasons at the top of this file.
    unsafe { MmapOptions::new().offset(begin).len(length).map(file) }
}
