//! Comparing buffers word by word.

use bytemuck::Pod;
use caustic_kernels::layout::{Irradiance, Neighbour, Photon, Query};
use caustic_kernels::num::{is_nan, ulp_distance};
use caustic_kernels::trace::{Pixel, Vertex};
use std::fmt::Write;

/// A record whose words are known to be floats or integers.
pub trait Record: Pod {
    /// A letter a word: `f` for a float, `u` for an integer.
    const WORDS: &'static str;
}

macro_rules! records {
    ($($name:ty: $words:literal),* $(,)?) => {
        $(impl Record for $name {
            const WORDS: &'static str = {
                assert!(4 * $words.len() == size_of::<$name>());
                $words
            };
        })*
    };
}

records! {
    u32: "u",
    f32: "f",
    Photon: "fffufffu",
    Query: "fffu",
    Neighbour: "fu",
    Irradiance: "fffu",
    Vertex: "fffuffffff",
    Pixel: "fffu",
}

/// Compares two buffers as `u32` words. Nothing is tolerated: the sign of a zero counts, and a float word that is NaN on
/// either side fails even if both sides have the same NaN, because no result of a kernel may be one.
///
/// # Errors
/// How many words were compared and differ (or are NaN), and the first of them in hexadecimal, as floats and in ulp.
pub fn compare_words<T: Record>(stage: &str, expected: &[T], actual: &[T]) -> Result<usize, String> {
    if expected.len() != actual.len() {
        return Err(format!("{stage}: {} records expected, {} found", expected.len(), actual.len()));
    }
    let kinds = T::WORDS.as_bytes();
    let (a, b): (&[u32], &[u32]) = (bytemuck::cast_slice(expected), bytemuck::cast_slice(actual));
    let (mut differ, mut nans, mut first) = (0, 0, None);
    for (i, (&x, &y)) in a.iter().zip(b).enumerate() {
        let float = kinds[i % kinds.len()] == b'f';
        let nan = float && (is_nan(f32::from_bits(x)) || is_nan(f32::from_bits(y)));
        if x != y || nan {
            differ += usize::from(x != y);
            nans += usize::from(nan);
            first = first.or(Some((i, x, y, float)));
        }
    }
    let Some((i, x, y, float)) = first else { return Ok(a.len()) };
    let mut text = format!(
        "{stage}: of {} words {differ} differ and {nans} are NaN; first at record {} word {}: expected {x:#010x}, found {y:#010x}",
        a.len(),
        i / kinds.len(),
        i % kinds.len(),
    );
    if float {
        let (x, y) = (f32::from_bits(x), f32::from_bits(y));
        write!(text, " ({x:e} and {y:e}, {} ulp apart)", ulp_distance(x, y)).expect("a String takes all");
    }
    Err(text)
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
