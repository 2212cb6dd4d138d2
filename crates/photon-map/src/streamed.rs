//! Searches among more photons than memory holds: a map of each chunk of them, one after another.

mod density;
mod largest;
mod nearest;
mod power;

pub use density::{DensityStreamed, DensitySums};
pub use largest::LargestPower;
pub use nearest::NearestStreamed;
pub use power::{MAX_K_IN_CHUNKS, NEIGHBOURS_AT_ONCE, NearestPower};

use crate::MapError;
use caustic_device::Buffer;

/// Points on a device at which photons are sought.
#[derive(Clone)]
pub struct Points {
    /// Records of [`Query`](caustic_kernels::layout::Query).
    pub queries: Buffer,
    /// How many.
    pub count: u32,
}

/// How many photons there are with those of another chunk, at most `max`.
fn with_more(photons: u64, chunk: usize, max: u32) -> Result<u64, MapError> {
    let count = photons + chunk as u64;
    if count > u64::from(max) {
        return Err(MapError::TooMany { what: "photons", count, max });
    }
    Ok(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_photons_than_32_bits_count_are_refused() {
        assert_eq!(with_more(4_000_000_000, 7, u32::MAX).unwrap(), 4_000_000_007);
        assert_eq!(with_more(u64::from(u32::MAX) - 5, 5, u32::MAX).unwrap(), u64::from(u32::MAX));
        let refused = with_more(u64::from(u32::MAX) - 5, 6, u32::MAX);
        assert!(matches!(refused, Err(MapError::TooMany { count: 0x1_0000_0000, max: u32::MAX, .. })));
    }
}
