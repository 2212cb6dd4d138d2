//! Photons that stay in their file: what a program reads of them that has less memory than they take.

use super::{Header, PhotonFileError, record, window};
use caustic_kernels::layout::Photon;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read};
use std::ops::Range;
use std::path::Path;

/// A file of photons that has been looked through once and found whole. Photons are numbered through all of its maps, in the order of the header.
#[derive(Debug)]
pub struct SavedPhotons {
    name: String,
    header: Header,
    file: File,
    /// Where the first photon begins.
    begin: u64,
    count: u64,
    largest_power: [f32; 3],
}

/// Bytes of a photon.
const PHOTON: u64 = size_of::<Photon>() as u64;

impl SavedPhotons {
    /// Opens a file and looks at all of it, a window after another: at its checksum, and whether every photon is one.
    ///
    /// # Errors
    /// All of [`PhotonFileError`] but [`PhotonFileError::Write`] and [`PhotonFileError::OtherScene`].
    pub fn open(path: &Path) -> Result<Self, PhotonFileError> {
        let name = path.display().to_string();
        let unreadable =
            |error: io::Error| PhotonFileError::Unreadable { file: name.clone(), reason: error.to_string() };
        let damaged = |reason: String| PhotonFileError::Damaged { file: name.clone(), reason };
        let short = |error: io::Error| match error.kind() {
            io::ErrorKind::UnexpectedEof => damaged("it ends early".to_string()),
            _ => unreadable(error),
        };
        if path.is_dir() {
            return Err(unreadable(io::Error::other("it is a folder")));
        }
        let mut file = File::open(path).map_err(unreadable)?;
        if !record::is_one(path) {
            return Err(PhotonFileError::NotOne { file: name });
        }
        let length = file.metadata().map_err(unreadable)?.len();
        let mut prefix = [0; record::PREFIX];
        file.read_exact(&mut prefix).map_err(short)?;
        let [found, header_length] = record::version_and_length(&prefix);
        if found != record::VERSION {
            return Err(PhotonFileError::Version { file: name, found, known: record::VERSION });
        }
        if header_length > record::MAX_HEADER {
            return Err(damaged("its header is too long".to_string()));
        }
        let mut text = vec![0; header_length as usize];
        file.read_exact(&mut text).map_err(short)?;
        let header: Header =
            serde_json::from_slice(&text).map_err(|_| damaged("its header cannot be read".to_string()))?;
        // Nothing is looked for that the file is too short to hold.
        let count = header.maps.iter().map(|map| u64::from(map.stored)).sum();
        let begin = prefix.len() as u64 + u64::from(header_length);
        let expected = begin + count * PHOTON + record::DIGEST;
        if length != expected {
            return Err(damaged(format!("it has {length} bytes and not {expected}")));
        }
        let mut digest = Sha256::new();
        digest.update(prefix);
        digest.update(&text);
        let mut largest_power = [0f32; 3];
        let mut seen = 0;
        let mut unsound = None;
        window::each(&file, begin..length - record::DIGEST, |bytes| {
            digest.update(bytes);
            for photon in record::photons(bytes) {
                let sound = photon.position.iter().all(|x| x.is_finite())
                    && photon.power.iter().all(|x| x.is_finite() && *x >= 0.0);
                if !sound {
                    unsound = unsound.or(Some(seen));
                }
                for (largest, power) in largest_power.iter_mut().zip(photon.power) {
                    *largest = largest.max(power);
                }
                seen += 1;
            }
        })
        .map_err(short)?;
        let mut recorded = Vec::new();
        window::each(&file, length - record::DIGEST..length, |bytes| recorded.extend_from_slice(bytes))
            .map_err(short)?;
        if recorded[..] != digest.finalize()[..] {
            return Err(damaged("its checksum does not fit its bytes".to_string()));
        }
        // What a program of another's wrote may fit its checksum and be no photons.
        if let Some(photon) = unsound {
            return Err(damaged(format!("photon {photon} has a position or a power that is no number")));
        }
        Ok(Self { name, header, file, begin, count, largest_power })
    }

    /// What the file says of its photons.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// How many photons all maps have.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The largest power of any photon in each channel, W.
    #[must_use]
    pub fn largest_power(&self) -> [f32; 3] {
        self.largest_power
    }

    /// Some photons, of those that there are.
    ///
    /// # Errors
    /// [`PhotonFileError::Unreadable`], also if the file has become shorter.
    pub fn read(&self, photons: Range<u64>) -> Result<Vec<Photon>, PhotonFileError> {
        let photons = photons.start.min(self.count)..photons.end.min(self.count);
        let mut read = Vec::with_capacity(photons.end.saturating_sub(photons.start) as usize);
        let place = |photon: u64| self.begin + photon * PHOTON;
        window::each(&self.file, place(photons.start)..place(photons.end), |bytes| read.extend(record::photons(bytes)))
            .map_err(|error| PhotonFileError::Unreadable { file: self.name.clone(), reason: error.to_string() })?;
        Ok(read)
    }

    /// The file's name, as it was given.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }
}
