//! What a map has to return, computed without one.

use crate::compare_words;
use caustic_kernels::gather::distance2;
use caustic_kernels::layout::{Irradiance, Neighbour, Photon};
use caustic_kernels::num::div;

/// All photons within `radius` of a point, nearest first, ties by index. Brute force, in the kernels' own measure of
/// distance: which photons lie exactly at the radius is a matter of its rounding.
#[must_use]
pub fn oracle_within(photons: &[Photon], query: [f32; 3], radius: f32) -> Vec<Neighbour> {
    let mut found: Vec<_> = photons
        .iter()
        .enumerate()
        .map(|(i, photon)| Neighbour { distance2: distance2(query, photon.position), photon: i as u32 })
        .filter(|neighbour| neighbour.distance2 <= radius * radius)
        .collect();
    found.sort_by(|a, b| a.distance2.total_cmp(&b.distance2).then(a.photon.cmp(&b.photon)));
    found
}

/// The `k` nearest photons within `radius` of a point, nearest first, ties by index.
#[must_use]
pub fn oracle_k_nearest(photons: &[Photon], query: [f32; 3], k: usize, radius: f32) -> Vec<Neighbour> {
    let mut found = oracle_within(photons, query, radius);
    found.truncate(k);
    found
}

/// The sum of positive floats, each cut off 66 bits below the first of `scale`, rounded to the nearest float: what the gathers
/// promise, by 128-bit integers and the conversions of the standard library.
#[must_use]
pub fn sum_rounded_once(terms: impl Iterator<Item = f32>, scale: f32) -> f32 {
    let exponent = |term: f32| (term.to_bits() >> 23) as i32;
    let largest = exponent(scale);
    let scaled = |term: f32| {
        let significand = i128::from(term.to_bits() & 0x007f_ffff | 0x0080_0000) << 42;
        let down = largest - exponent(term);
        if exponent(term) == 0 || down > 66 { 0 } else { significand >> down }
    };
    // In units of 2^(largest − 127 − 23 − 42). Every float is exact in f64, and so is its product with a power of two.
    let sum: i128 = terms.map(scaled).sum();
    (f64::from(sum as f32) * 2f64.powi(largest - 192)) as f32
}

/// The irradiance estimate of eq. 2.1, written out: `within` is what [`oracle_within`] returns.
#[must_use]
pub fn oracle_irradiance(photons: &[Photon], within: &[Neighbour], k: usize, radius: f32) -> Irradiance {
    let counted = &within[..k.min(within.len())];
    let scale = |channel: usize| photons.iter().map(|photon| photon.power[channel]).fold(0.0, f32::max);
    let rgb: [f32; 3] = std::array::from_fn(|channel| {
        sum_rounded_once(
            counted.iter().map(|neighbour| photons[neighbour.photon as usize].power[channel]),
            scale(channel),
        )
    });
    // The disc reaches to the first photon that is not counted; one without extent is replaced by the largest.
    let radius2 = within.get(k).map_or(0.0, |next| next.distance2);
    let radius2 = if radius2 == 0.0 { radius * radius } else { radius2 };
    let area = std::f32::consts::PI * radius2;
    Irradiance { rgb: rgb.map(|sum| div(sum, area)), photons: counted.len() as u32 }
}

/// Compares the neighbours of many queries with the oracle's: the same photons, in the same order, at the same distances.
///
/// # Errors
/// The first query that differs, and how.
pub fn compare_neighbours(
    stage: &str,
    expected: &[Vec<Neighbour>],
    actual: &[Vec<Neighbour>],
) -> Result<usize, String> {
    if expected.len() != actual.len() {
        return Err(format!("{stage}: {} queries expected, {} found", expected.len(), actual.len()));
    }
    let mut words = 0;
    for (i, (a, b)) in expected.iter().zip(actual).enumerate() {
        words += compare_words(&format!("{stage}, query {i}"), a, b)?;
    }
    Ok(words)
}

/// Compares estimates word by word.
///
/// # Errors
/// Those of [`compare_words`].
pub fn compare_irradiance(stage: &str, expected: &[Irradiance], actual: &[Irradiance]) -> Result<usize, String> {
    compare_words(stage, expected, actual)
}

/// Compares the result of a sort of `keys` with that of the standard library's stable sort.
///
/// # Errors
/// Where keys or order differ first.
pub fn compare_sorted(stage: &str, keys: &[u32], sorted: &[u32], order: &[u32]) -> Result<usize, String> {
    let mut expected: Vec<(u32, u32)> = keys.iter().copied().zip(0..).collect();
    expected.sort_by_key(|&(key, _)| key);
    let (expected_keys, expected_order): (Vec<_>, Vec<_>) = expected.into_iter().unzip();
    let words = compare_words(&format!("{stage}, keys"), &expected_keys, sorted)?;
    Ok(words + compare_words(&format!("{stage}, order"), &expected_order, order)?)
}
