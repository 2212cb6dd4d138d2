//! Comparing buffers word by word, for tests.

use caustic_device::{Difference, Record};

/// Compares two buffers as `u32` words. Nothing is tolerated: the sign of a zero counts, and a float word that is NaN on
/// either side fails even if both sides have the same NaN, because no result of a kernel may be one.
///
/// # Errors
/// How many words were compared and differ (or are NaN), and the first of them in hexadecimal, as floats and in ulp.
pub fn compare_words<T: Record>(stage: &str, expected: &[T], actual: &[T]) -> Result<usize, String> {
    if expected.len() != actual.len() {
        return Err(format!("{stage}: {} records expected, {} found", expected.len(), actual.len()));
    }
    let Difference { words, differ, nans, first, .. } = Difference::of(stage, expected, actual);
    match first {
        None => Ok(words as usize),
        Some(first) => Err(format!("{stage}: of {words} words {differ} differ and {nans} are NaN; first: {first}")),
    }
}

/// [`compare_words`], for a test.
///
/// # Panics
/// If a word differs or a float is NaN, with the words of [`compare_words`].
#[track_caller]
pub fn assert_same_words<T: Record>(stage: &str, expected: &[T], actual: &[T]) {
    if let Err(difference) = compare_words(stage, expected, actual) {
        panic!("{difference}");
    }
}
