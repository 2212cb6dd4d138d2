//! The bytes of a file of photons.

use super::{Header, PhotonFile, PhotonFileError};
use crate::output::replace_with;
use caustic_kernels::layout::Photon;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

/// What a file begins with.
const MAGIC: [u8; 8] = *b"CAUSTICM";
/// The version of the format.
const VERSION: u32 = 1;
/// Bytes before the header.
const PREFIX: usize = 16;
/// Longest header: one of ours has a thousand bytes.
const MAX_HEADER: u32 = 1 << 20;
const DIGEST: u64 = 32;
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

impl<R: Read> Read for Digesting<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(bytes)?;
        self.digest.update(&bytes[..read]);
        Ok(read)
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

pub(super) fn read(path: &Path) -> Result<PhotonFile, PhotonFileError> {
    let file = path.display().to_string();
    let unreadable = |error: io::Error| PhotonFileError::Unreadable { file: file.clone(), reason: error.to_string() };
    let damaged = |reason: &str| PhotonFileError::Damaged { file: file.clone(), reason: reason.to_string() };
    if path.is_dir() {
        return Err(unreadable(io::Error::other("it is a folder")));
    }
    if !is_one(path) {
        // A file that is not there says so.
        File::open(path).map_err(&unreadable)?;
        return Err(PhotonFileError::NotOne { file });
    }
    let opened = File::open(path).map_err(&unreadable)?;
    let length = opened.metadata().map_err(&unreadable)?.len();
    let mut from = Digesting { inner: BufReader::with_capacity(1 << 16, opened), digest: Sha256::new() };
    let short = |error: io::Error| match error.kind() {
        io::ErrorKind::UnexpectedEof => damaged("it ends early"),
        _ => unreadable(error),
    };
    let mut prefix = [0; PREFIX];
    from.read_exact(&mut prefix).map_err(short)?;
    let word = |at: usize| u32::from_le_bytes([prefix[at], prefix[at + 1], prefix[at + 2], prefix[at + 3]]);
    let (found, header_length) = (word(8), word(12));
    if found != VERSION {
        return Err(PhotonFileError::Version { file, found, known: VERSION });
    }
    if header_length > MAX_HEADER {
        return Err(damaged("its header is too long"));
    }
    let mut header = vec![0; header_length as usize];
    from.read_exact(&mut header).map_err(short)?;
    let header: Header = serde_json::from_slice(&header).map_err(|_| damaged("its header cannot be read"))?;
    // Nothing is allocated for photons that the file is too short to hold.
    let stored: u64 = header.maps.iter().map(|map| u64::from(map.stored)).sum();
    let expected = PREFIX as u64 + u64::from(header_length) + stored * PHOTON as u64 + DIGEST;
    if length != expected {
        return Err(damaged(&format!("it has {length} bytes and not {expected}")));
    }
    let mut photons = Vec::new();
    let mut bytes = vec![0; CHUNK * PHOTON];
    for map in &header.maps {
        let mut read = Vec::with_capacity(map.stored as usize);
        while read.len() < map.stored as usize {
            let chunk = &mut bytes[..CHUNK.min(map.stored as usize - read.len()) * PHOTON];
            from.read_exact(chunk).map_err(short)?;
            read.extend(chunk.chunks_exact(PHOTON).map(photon));
        }
        photons.push(read);
    }
    let Digesting { mut inner, digest } = from;
    let mut recorded = [0; DIGEST as usize];
    inner.read_exact(&mut recorded).map_err(short)?;
    if recorded[..] != digest.finalize()[..] {
        return Err(damaged("its checksum does not fit its bytes"));
    }
    // What a program of another's wrote may fit its checksum and be no photons.
    let sound = |photon: &Photon| {
        photon.position.iter().all(|x| x.is_finite()) && photon.power.iter().all(|x| x.is_finite() && *x >= 0.0)
    };
    if !photons.iter().flatten().all(sound) {
        return Err(damaged("a photon has a position or a power that is no number"));
    }
    Ok(PhotonFile { source: file, header, photons })
}

fn photon(bytes: &[u8]) -> Photon {
    let mut words = [0u32; PHOTON / 4];
    for (word, bytes) in words.iter_mut().zip(bytes.chunks_exact(4)) {
        *word = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    }
    bytemuck::cast(words)
}
