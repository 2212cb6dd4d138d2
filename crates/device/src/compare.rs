//! Comparing buffers word by word, and what was found.

use crate::Record;
use caustic_kernels::num::{is_nan, ulp_distance};
use serde::Serialize;

/// The first word that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FirstDifference {
    /// The buffer.
    pub buffer: String,
    /// Index of the record.
    pub record: usize,
    /// Index of the word in it.
    pub word: usize,
    /// Bits that were expected.
    pub expected: u32,
    /// Bits that were found.
    pub found: u32,
    /// How many floats lie between them, of a word that is a float.
    pub ulps: Option<u32>,
}

/// What comparing words found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Difference {
    /// Words compared.
    pub words: u64,
    /// Words that differ.
    pub differ: u64,
    /// Floats that are NaN on either side: they count as wrong even where both sides have the same one.
    pub nans: u64,
    /// Most floats that lie between two that differ.
    pub most_ulps: u32,
    /// The first word that differs or is NaN.
    pub first: Option<FirstDifference>,
}

impl Difference {
    /// Compares two buffers of records whose words are of the `kinds` that [`Record::WORDS`] has. Nothing is tolerated: the
    /// sign of a zero counts.
    ///
    /// # Panics
    /// If they are of different lengths: words without a partner would go uncompared.
    #[must_use]
    pub fn between(buffer: &str, kinds: &str, expected: &[u32], found: &[u32]) -> Self {
        assert_eq!(expected.len(), found.len(), "{buffer}: words without a partner");
        let kinds = kinds.as_bytes();
        let mut result = Self { words: expected.len() as u64, ..Self::default() };
        for (i, (&x, &y)) in expected.iter().zip(found).enumerate() {
            let float = kinds[i % kinds.len()] == b'f';
            let (a, b) = (f32::from_bits(x), f32::from_bits(y));
            let nan = float && (is_nan(a) || is_nan(b));
            if x == y && !nan {
                continue;
            }
            result.differ += u64::from(x != y);
            result.nans += u64::from(nan);
            let ulps = float.then(|| ulp_distance(a, b));
            result.most_ulps = result.most_ulps.max(ulps.unwrap_or(0));
            result.first.get_or_insert_with(|| FirstDifference {
                buffer: buffer.to_string(),
                record: i / kinds.len(),
                word: i % kinds.len(),
                expected: x,
                found: y,
                ulps,
            });
        }
        result
    }

    /// Compares two slices of records.
    #[must_use]
    pub fn of<T: Record>(buffer: &str, expected: &[T], found: &[T]) -> Self {
        Self::between(buffer, T::WORDS, bytemuck::cast_slice(expected), bytemuck::cast_slice(found))
    }

    /// Whether nothing differs and nothing is NaN.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.first.is_none()
    }

    /// Adds what another comparison found.
    pub fn add(&mut self, other: Self) {
        self.words += other.words;
        self.differ += other.differ;
        self.nans += other.nans;
        self.most_ulps = self.most_ulps.max(other.most_ulps);
        self.first = self.first.take().or(other.first);
    }
}

impl std::fmt::Display for FirstDifference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { buffer, record, word, expected, found, ulps } = self;
        write!(f, "{buffer} record {record} word {word}: expected {expected:#010x}, found {found:#010x}")?;
        match ulps {
            Some(ulps) => {
                let (x, y) = (f32::from_bits(*expected), f32::from_bits(*found));
                write!(f, " ({x:e} and {y:e}, {ulps} ulp apart)")
            }
            None => Ok(()),
        }
    }
}
