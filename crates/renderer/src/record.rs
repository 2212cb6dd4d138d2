//! Bytes of films and sums: the length of a header as a `u32`, the header in JSON, numbers in little-endian order, and the SHA-256 of it all.

use crate::sums::{Film, Sums};
use bytemuck::Pod;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

/// Bytes of a SHA-256.
const SUM: usize = 32;

// Numbers are copied as they lie in memory.
const _: () = assert!(cfg!(target_endian = "little"), "caustic runs on little-endian machines");

/// Appends a header, what `body` appends, and the digest of `bytes` from their begin.
pub(crate) fn digested<H: Serialize>(bytes: &mut Vec<u8>, header: &H, body: impl FnOnce(&mut Vec<u8>)) {
    let Ok(header) = serde_json::to_vec(header) else { unreachable!("a header of numbers and texts is JSON") };
    bytes.extend((header.len() as u32).to_le_bytes());
    bytes.extend(header);
    body(bytes);
    let sum = Sha256::digest(&bytes);
    bytes.extend(sum);
}

/// Checks the digest of all `bytes` and takes the header; `skip` bytes before it are someone else's.
pub(crate) fn undigested_after<H: DeserializeOwned>(bytes: &[u8], skip: usize) -> Option<(H, Bytes<'_>)> {
    let (body, sum) = bytes.split_last_chunk::<SUM>()?;
    if Sha256::digest(body).as_slice() != sum {
        return None;
    }
    let mut rest = Bytes(body.get(skip..)?);
    let length = u32::from_le_bytes(rest.take(4)?.try_into().ok()?);
    let header = serde_json::from_slice(rest.take(length as usize)?).ok()?;
    Some((header, rest))
}

/// [`undigested_after`] nothing.
pub(crate) fn undigested<H: DeserializeOwned>(bytes: &[u8]) -> Option<(H, Bytes<'_>)> {
    undigested_after(bytes, 0)
}

/// Takes numbers from the front of bytes.
pub(crate) struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn values<T: Pod>(&mut self, count: usize) -> Option<Vec<T>> {
        let bytes = self.take(count.checked_mul(size_of::<T>())?)?;
        Some(bytemuck::pod_collect_to_vec(bytes))
    }

    /// Whether all were taken.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Film {
    pub(crate) fn put(&self, bytes: &mut Vec<u8>) {
        bytes.extend(bytemuck::cast_slice::<_, u8>(&self.rgb));
        bytes.extend(bytemuck::cast_slice::<_, u8>(&self.layers));
    }

    pub(crate) fn take(bytes: &mut Bytes<'_>, pixels: usize, layers: usize) -> Option<Self> {
        Some(Self { rgb: bytes.values(pixels)?, layers: bytes.values(layers)? })
    }
}

impl Sums {
    pub(crate) fn put(&self, bytes: &mut Vec<u8>) {
        bytes.extend(bytemuck::cast_slice::<_, u8>(&self.rgb));
        bytes.extend(bytemuck::cast_slice::<_, u8>(&self.squares));
        bytes.extend(bytemuck::cast_slice::<_, u8>(&self.layers));
    }

    pub(crate) fn take(bytes: &mut Bytes<'_>, pixels: usize, layers: usize) -> Option<Self> {
        let mut values = || bytes.values(pixels);
        Some(Self { rgb: values()?, squares: values()?, layers: bytes.values(layers)? })
    }
}
