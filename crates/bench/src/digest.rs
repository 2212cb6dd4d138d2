//! The hash of a result's bytes.

use bytemuck::Pod;
use sha2::{Digest as _, Sha256};

/// A SHA-256 that is fed piece by piece.
#[derive(Default)]
pub struct Digest(Sha256);

impl Digest {
    /// Takes in records: their words, least byte first.
    pub fn add<T: Pod>(&mut self, records: &[T]) {
        if cfg!(target_endian = "little") {
            self.0.update(bytemuck::cast_slice::<T, u8>(records));
            return;
        }
        for word in bytemuck::cast_slice::<T, u32>(records) {
            self.0.update(word.to_le_bytes());
        }
    }

    /// The hash in hexadecimal.
    pub fn hex(self) -> String {
        self.0.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_that_of_the_standard() {
        // FIPS 180-2, appendix B.1: "abc"; and pieces make no difference.
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        let mut digest = Digest::default();
        digest.add(b"a");
        digest.add(b"bc");
        assert_eq!(digest.hex(), abc);
    }
}
