//! Chunks of photons and batches of samples that fit a memory.

use crate::survey::Survey;
use caustic_device::Device;
use caustic_kernels::layout::Arrival;
use caustic_renderer::scene::CompiledScene;
use caustic_renderer::{Chunk, Settings, peak_bytes};

/// Fewest photons of a chunk that is chosen, where so many are emitted: with fewer, a search for each costs more than all else.
const FEWEST: u32 = 10_000;

/// Settings with which a render takes no more than so many bytes, if whole maps would: photons come in chunks then, of as many as are asked for, if
/// [`Settings::chunk`] is given. Half of what is free, or as much as all take, goes to a batch of samples, for each of which all photons
/// are traced, and the rest to a chunk, for each of which all samples search.
///
/// # Errors
/// The least number of bytes that suffices.
pub fn fit(
    survey: &Survey,
    scene: &CompiledScene,
    settings: &Settings,
    bytes: u64,
    device: &Device,
) -> Result<Settings, u64> {
    let peak = |settings: &Settings| peak_bytes(scene, settings, survey.maps(scene, settings), device);
    let fits = |settings: &Settings| {
        let largest = survey.maps(scene, settings).map(|map| {
            let chunks = settings.chunk.map_or(1, |chunk| chunk.cut(map.emitted as u32).0);
            map.stored / f64::from(chunks.max(1)) * size_of::<Arrival>() as f64
        });
        peak(settings) <= bytes && largest.iter().all(|&bytes| bytes <= device.largest_buffer() as f64)
    };
    if settings.chunk.is_none() && fits(settings) {
        return Ok(settings.clone());
    }
    let with = |photons: u32, samples: u32| Settings { chunk: Some(Chunk { photons, samples }), ..settings.clone() };
    let emitted = settings.photons.max(settings.caustic_photons);
    let (fewest, most) = settings.chunk.map_or((FEWEST.min(emitted), emitted), |chunk| (chunk.photons, chunk.photons));
    let least = with(fewest, settings.spp);
    if !fits(&least) {
        return Err(peak(&least));
    }
    let [width, height] = settings.size.map(u64::from);
    let samples = (width * height * u64::from(settings.spp)).min(u64::from(u32::MAX)) as u32;
    let half = (bytes - peak(&least)) / 2 / Chunk::bytes_a_sample(settings);
    let batch = half.clamp(u64::from(settings.spp), u64::from(samples)) as u32;
    // A batch that is searched at once takes more than its own bytes: then it is smaller than half.
    let batch = largest(settings.spp, batch, |samples| fits(&with(fewest, samples)));
    let photons = largest(fewest, most, |photons| fits(&with(photons, batch)));
    Ok(with(photons, largest(batch, samples, |samples| fits(&with(photons, samples)))))
}

/// The largest number from `least` to `most` that is good, if `least` is and none is behind one that is not.
fn largest(least: u32, most: u32, good: impl Fn(u32) -> bool) -> u32 {
    let (mut low, mut high) = (least, most.max(least));
    while low < high {
        let middle = low + (high - low).div_ceil(2);
        if good(middle) {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_that_is_good_is_found() {
        for (limit, expected) in [(1, 3), (3, 3), (7, 7), (9, 9), (100, 9)] {
            assert_eq!(largest(3, 9, |n| n <= limit), expected);
        }
        assert_eq!(largest(5, 2, |_| true), 5);
    }
}
