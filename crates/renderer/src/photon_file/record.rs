//! The bytes of a file of photons.

use super::{PhotonFile, PhotonFileError};
use crate::output::replace_with;
use caustic_kernels::layout::Photon;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

/// What a file begins with.
const MAGIC: [u8; 8] = *b"CAUSTICM";
/// The version of the format.
pub(super) const VERSION: u32 = 1;
/// Bytes before the header.
pub(super) const PREFIX: usize = 16;
/// Longest header: one of ours has a thousand bytes.
pub(super) const MAX_HEADER: u32 = 1 << 20;
pub(super) const DIGEST: u64 = 32;
const PHOTON: usize = size_of::<Photon>();
/// Photons that are converted at once.
const CHUNK: usize = 1 << 14;

/// Passes bytes on and digests them.
struct Digesting<T> {
    inner: T,
    digest: Sha256,
}

impl<W: Write> Write for Digesting<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.digest.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

pub(super) fn write(file: &PhotonFile, path: &Path) -> Result<(), PhotonFileError> {
    replace_with(path, |to| {
        let header = serde_json::to_vec(&file.header)?;
        let mut to = Digesting { inner: to, digest: Sha256::new() };
        to.write_all(&MAGIC)?;
        to.write_all(&VERSION.to_le_bytes())?;
        to.write_all(&(header.len() as u32).to_le_bytes())?;
        to.write_all(&header)?;
        let mut bytes = Vec::with_capacity(CHUNK * PHOTON);
        for photons in file.photons.iter().flat_map(|photons| photons.chunks(CHUNK)) {
            bytes.clear();
            bytes.extend(bytemuck::cast_slice::<_, u32>(photons).iter().flat_map(|word| word.to_le_bytes()));
            to.write_all(&bytes)?;
        }
        let Digesting { inner, digest } = to;
        inner.write_all(&digest.finalize())
    })?;
    Ok(())
}

pub(super) fn is_one(path: &Path) -> bool {
    let mut begin = [0; MAGIC.len()];
    File::open(path).and_then(|mut file| file.read_exact(&mut begin)).is_ok() && begin == MAGIC
}

/// The two numbers that follow the name of the format: its version, and the length of the header.
pub(super) fn version_and_length(prefix: &[u8; PREFIX]) -> [u32; 2] {
    [8, 12].map(|at| u32::from_le_bytes([prefix[at], prefix[at + 1], prefix[at + 2], prefix[at + 3]]))
}

/// The photons of a file's bytes.
pub(super) fn photons(bytes: &[u8]) -> impl Iterator<Item = Photon> {
    bytes.chunks_exact(PHOTON).map(photon)
}

fn photon(bytes: &[u8]) -> Photon {
    let mut words = [0u32; PHOTON / 4];
    for (word, bytes) in words.iter_mut().zip(bytes.chunks_exact(4)) {
        *word = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    }
    bytemuck::cast(words)
}
