//! The model of traffic: the fewest bytes that a method of its kind can read and write, whatever the implementation does. A
//! share of the roofline near 1 therefore means that nothing is left to gain; a small one, that something else than bytes
//! bounds the time, such as the candidates that a gather looks at, which caches mostly hold.

/// Bits of a digit of the radix sort that the model is of.
const DIGIT_BITS: u32 = 8;

/// Sorting `n` pairs by `bits` bits: one reading of the keys to count all digits, then a pass a digit that reads and writes each
/// pair once; the first has no indices to read.
pub(super) fn sort(n: u32, bits: u32) -> u64 {
    let passes = u64::from(bits.div_ceil(DIGIT_BITS));
    u64::from(n) * (4 + 16 * passes - 4)
}

/// [`sort`] without the indices.
pub(super) fn sort_keys(n: u32, bits: u32) -> u64 {
    let passes = u64::from(bits.div_ceil(DIGIT_BITS));
    u64::from(n) * (4 + 8 * passes)
}

/// Building a map of `n` photons with a table of `entries`: photons read and keys written, the sort, keys read and the table
/// written, then photons and order read and sites and arrivals written.
pub(super) fn build(n: u32, entries: u32) -> u64 {
    let bits = (u32::BITS - entries.saturating_sub(1).leading_zeros()).max(1);
    u64::from(n) * (32 + 4 + 4 + 4 + 32 + 64) + sort(n, bits) + 4 * u64::from(entries)
}

/// Searching a map: sites, arrivals, table and queries read once, results written once; the sort of the queries is not in it.
pub(super) fn search(n: u32, entries: u32, queries: u32, result: u64) -> u64 {
    u64::from(n) * 64 + 4 * u64::from(entries) + u64::from(queries) * (16 + result)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sort_of_24_bits_moves_48_bytes_a_pair() {
        assert_eq!(sort(10, 24), 480);
        assert_eq!(sort(10, 32), 640);
        assert_eq!(sort_keys(10, 32), 360);
        assert_eq!(build(10, 1 << 24), 10 * 140 + 480 + (4 << 24));
        assert_eq!(search(10, 100, 5, 16), 640 + 400 + 160);
    }
}
