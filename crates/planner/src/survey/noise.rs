//! How renders of several seeds differ: noise, and blur.

use crate::scout::Pilot;

/// The same render with each seed.
pub(crate) type Seeds = [Pilot; 3];

/// Two seeds that differ.
const PAIRS: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];
/// How many times as bright one of two seeds is where it has a bright speck and the other has none.
const SPECK: f64 = 2.0;

/// A channel of a pixel, and the part of it that is from photon maps.
fn values(pilot: &Pilot, i: usize) -> [f64; 2] {
    [pilot.image.rgb.as_flattened()[i], pilot.indirect.as_flattened()[i]].map(f64::from)
}

/// What is expected of a picture: channels of its pixels, row by row.
#[derive(Clone)]
pub(super) struct Expected {
    size: [u32; 2],
    channels: Vec<f64>,
}

impl Expected {
    /// The mean of three seeds, or of what photon maps add to them.
    pub(super) fn mean(seeds: &Seeds, only_maps: bool) -> Self {
        let image = &seeds[0].image;
        let mean = |i: usize| seeds.iter().map(|pilot| values(pilot, i)[usize::from(only_maps)]).sum::<f64>() / 3.0;
        Self { size: [image.width, image.height], channels: (0..3 * image.rgb.len()).map(mean).collect() }
    }

    /// Of two seeds of many samples. A bright speck that only one of them has is not expected: set against itself, it would count little.
    pub(super) fn of_two(pair: &[Pilot; 2]) -> Self {
        let image = &pair[0].image;
        let both = |i: usize| {
            let [a, b] = [0, 1].map(|seed: usize| values(&pair[seed], i)[0]);
            let (less, more) = (a.min(b), a.max(b));
            if more > SPECK * less { less } else { 0.5 * (less + more) }
        };
        Self { size: [image.width, image.height], channels: (0..3 * image.rgb.len()).map(both).collect() }
    }

    /// The same picture in another size: pixels are the mean of those in their place.
    pub(super) fn resized(&self, size: [u32; 2]) -> Self {
        let [width, height] = self.size.map(|side| side as usize);
        // The pixels that lie in the place of the i-th of `to`: one at least.
        let range = |i: usize, from: usize, to: usize| {
            let first = i * from / to;
            first..((i + 1) * from / to).max(first + 1)
        };
        let [columns, rows] = size.map(|side| side as usize);
        let mut channels = Vec::with_capacity(3 * columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                let (ys, xs) = (range(row, height, rows), range(column, width, columns));
                let pixels = (ys.len() * xs.len()) as f64;
                for channel in 0..3 {
                    let of = |y: usize| xs.clone().map(|x| self.channels[3 * (y * width + x) + channel]).sum::<f64>();
                    channels.push(ys.clone().map(of).sum::<f64>() / pixels);
                }
            }
        }
        Self { size, channels }
    }

    /// The sum of two pictures of one size.
    pub(super) fn plus(mut self, other: &Self) -> Self {
        for (sum, value) in self.channels.iter_mut().zip(&other.channels) {
            *sum += value;
        }
        self
    }

    /// The mean of `of` a channel over all, relative to the square of what is expected, as in [`caustic_metrics::relmse`].
    fn relative(&self, of: impl Fn(usize) -> f64) -> f64 {
        let one = |(i, expected): (usize, &f64)| of(i) / (expected * expected + caustic_metrics::EPSILON);
        self.channels.iter().enumerate().map(one).sum::<f64>() / self.channels.len().max(1) as f64
    }

    /// relMSE of one picture from noise: half the mean square difference of two seeds.
    pub(super) fn noise_of_two(&self, [a, b]: &[Pilot; 2]) -> f64 {
        self.relative(|i| (values(a, i)[0] - values(b, i)[0]).powi(2) / 2.0)
    }

    /// relMSE of one picture from the noise of its photon maps.
    pub(super) fn noise_of_maps(&self, seeds: &Seeds) -> f64 {
        self.relative(|i| {
            let square = |[a, b]: [usize; 2]| (values(&seeds[a], i)[1] - values(&seeds[b], i)[1]).powi(2) / 2.0;
            PAIRS.into_iter().map(square).sum::<f64>() / 3.0
        })
    }

    /// Mean product of the differences that two seeds see between neighbouring discs: noise of two seeds is independent, so that it has no
    /// part in it.
    pub(super) fn blur(&self, [less, more]: [&Seeds; 2]) -> f64 {
        let differs = |seed: usize, i: usize| values(&more[seed], i)[1] - values(&less[seed], i)[1];
        self.relative(|i| PAIRS.iter().map(|&[a, b]| differs(a, i) * differs(b, i)).sum::<f64>() / 3.0)
    }
}

/// relMSE of a picture from the noise of its photon maps, and the square of how it differs from one of smaller discs but for noise, by three
/// seeds of each.
pub(crate) fn noise_and_blur([less, more]: [&Seeds; 2]) -> [f64; 2] {
    let expected = Expected::mean(more, false);
    [expected.noise_of_maps(more), expected.blur([less, more])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_resized_by_means() {
        let channels = |values: &[f64]| values.iter().flat_map(|&value| [value; 3]).collect::<Vec<_>>();
        let four = Expected { size: [4, 2], channels: channels(&[1.0, 3.0, 0.0, 0.0, 5.0, 7.0, 0.0, 8.0]) };
        let two = four.resized([2, 1]);
        assert_eq!((two.size, &two.channels), ([2, 1], &channels(&[4.0, 2.0])));
        assert_eq!(two.resized([4, 1]).channels, channels(&[4.0, 4.0, 2.0, 2.0]));
        assert_eq!(two.clone().plus(&two).channels, channels(&[8.0, 4.0]));
        // Sides that do not divide: each pixel has a part.
        assert_eq!(four.resized([3, 2]).channels.len(), 18);
    }
}
