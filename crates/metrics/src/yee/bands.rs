//! Planes of luminance, blurred: the levels of a Gaussian pyramid and the mean around each pixel.

use super::sensitivity::DARKNESS;
use rayon::prelude::*;

/// Three successive levels of a Gaussian pyramid, at full resolution.
///
/// Level k is what Burt and Adelson ("The Laplacian pyramid as a compact image code", IEEE Transactions on Communications 31(4),
/// 1983) reduce to, before samples are left out: their kernel of five with a = 0.4, its taps 2^k pixels apart. So each pixel has its
/// value without interpolation, and moving both pictures by a pixel moves the result. Beyond the borders the picture is mirrored.
pub(super) struct Blurred {
    levels: [Vec<f32>; 3],
    width: usize,
    /// Pixels between the taps that make the next level.
    spacing: usize,
}

impl Blurred {
    /// Levels 0, the plane itself, to 2.
    pub(super) fn new(plane: &[f32], width: usize) -> Self {
        let first = blur(plane, width, 1);
        let second = blur(&first, width, 2);
        Self { levels: [plane.to_vec(), first, second], width, spacing: 4 }
    }

    /// Goes on by a level.
    pub(super) fn next(&mut self) {
        self.levels.rotate_left(1);
        self.levels[2] = blur(&self.levels[1], self.width, self.spacing);
        self.spacing *= 2;
    }

    /// Contrast of pixel `i` in the band between the first two levels, |G_k − G_(k+1)| / G_(k+2) (Peli, "Contrast in complex
    /// images", Journal of the Optical Society of America A 7(10), 1990). What a float rounds off, a thousandth of the least contrast
    /// that any eye sees, is none.
    pub(super) fn contrast(&self, i: usize) -> f64 {
        let [fine, coarse, around] = self.levels.each_ref().map(|level| f64::from(level[i]));
        ((fine - coarse).abs() / around.max(DARKNESS) - ROUNDING).max(0.0)
    }
}

/// Blurring rounds ten times by at most 2⁻²⁴ of the value.
const ROUNDING: f64 = 10.0 / 16_777_216.0;

/// Burt and Adelson's kernel: 1/4 − a/2, 1/4, a, 1/4, 1/4 − a/2 for a = 0.4.
const KERNEL: [f32; 5] = [0.05, 0.25, 0.4, 0.25, 0.05];

/// The plane convolved with the kernel, its taps `spacing` pixels apart, along rows and then along columns.
fn blur(plane: &[f32], width: usize, spacing: usize) -> Vec<f32> {
    let height = plane.len() / width;
    let mut rows = vec![0.0f32; plane.len()];
    rows.par_chunks_mut(width).zip(plane.par_chunks(width)).for_each(|(out, row)| {
        for (x, value) in out.iter_mut().enumerate() {
            *value = (0..5).map(|tap| KERNEL[tap] * row[mirrored(x, tap, spacing, width)]).sum();
        }
    });
    let mut columns = vec![0.0f32; plane.len()];
    columns.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for tap in 0..5 {
            let row = &rows[mirrored(y, tap, spacing, height) * width..][..width];
            for (value, &other) in out.iter_mut().zip(row) {
                *value += KERNEL[tap] * other;
            }
        }
    });
    columns
}

/// The index that lies (tap − 2) · spacing from `at`, mirrored at the ends of `0..length` as often as it takes.
fn mirrored(at: usize, tap: usize, spacing: usize, length: usize) -> usize {
    // Whole periods of 2 · length are added so that nothing is negative.
    let period = 2 * length;
    let back = (2 * spacing).next_multiple_of(period);
    let index = (at + back + tap * spacing - 2 * spacing) % period;
    index.min(period - 1 - index)
}

/// The mean of each pixel's square of `side` pixels around it, of those that there are.
pub(super) fn local_mean(plane: &[f64], width: usize, height: usize, side: f64) -> Vec<f64> {
    // A square of one pixel is the pixel.
    let reach = ((side.min(1e6) - 1.0).max(0.0) / 2.0).round() as usize;
    let mut rows = plane.to_vec();
    rows.par_chunks_mut(width).for_each(|row| average(row, reach));
    let mut turned = transposed(&rows, width);
    turned.par_chunks_mut(height).for_each(|column| average(column, reach));
    transposed(&turned, height)
}

/// Replaces each value by the mean of those at most `reach` away.
fn average(values: &mut [f64], reach: usize) {
    let mut sums = Vec::with_capacity(values.len() + 1);
    sums.push(0.0);
    for &value in values.iter() {
        sums.push(sums[sums.len() - 1] + value);
    }
    let length = values.len();
    for (i, value) in values.iter_mut().enumerate() {
        let (from, to) = (i.saturating_sub(reach), (i + reach + 1).min(length));
        // The difference of sums can round below 0 where it is black beside something bright.
        *value = ((sums[to] - sums[from]) / (to - from) as f64).max(0.0);
    }
}

fn transposed(plane: &[f64], width: usize) -> Vec<f64> {
    let height = plane.len() / width;
    let mut turned = vec![0.0; plane.len()];
    turned.par_chunks_mut(height).enumerate().for_each(|(x, column)| {
        for (y, value) in column.iter_mut().enumerate() {
            *value = plane[y * width + x];
        }
    });
    turned
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_are_mirrored() {
        // Of a b c d: … d c b a | a b c d | d c b a …
        let taps = |at: usize, spacing: usize| [0, 1, 2, 3, 4].map(|tap| mirrored(at, tap, spacing, 4));
        assert_eq!(taps(0, 1), [1, 0, 0, 1, 2]);
        assert_eq!(taps(3, 1), [1, 2, 3, 3, 2]);
        assert_eq!(taps(1, 4), [1, 2, 1, 2, 1]);
        assert_eq!([0, 1, 2, 3, 4].map(|tap| mirrored(0, tap, 1 << 14, 1)), [0; 5]);
    }

    #[test]
    fn blurring_spreads_a_point_by_the_kernel_and_loses_nothing() {
        let mut plane = vec![0.0; 15 * 15];
        plane[7 * 15 + 7] = 1.0;
        for spacing in [1, 2] {
            let blurred = blur(&plane, 15, spacing);
            for (i, tap) in KERNEL.iter().enumerate() {
                let at = 7 + i * spacing - 2 * spacing;
                assert!(
                    (blurred[7 * 15 + at] - tap * 0.4).abs() < 1e-7 && (blurred[at * 15 + 7] - tap * 0.4).abs() < 1e-7
                );
            }
            assert!((blurred.iter().sum::<f32>() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn means_are_those_of_what_is_there() {
        let plane: Vec<f64> = (0..12).map(f64::from).collect();
        // Rows 0 1 2 3, 4 5 6 7, 8 9 10 11; squares of three.
        let found = local_mean(&plane, 4, 3, 3.0);
        // (0 + 1 + 4 + 5) / 4 in the corner, and (6 + 7 + 10 + 11) / 4 in the other.
        assert_eq!([found[0], found[5], found[11]], [2.5, 5.0, 8.5]);
        assert_eq!(local_mean(&plane, 4, 3, 1.0), plane);
        let all = local_mean(&plane, 4, 3, 1e9);
        assert!(all.iter().all(|mean| (mean - 5.5).abs() < 1e-12));
    }
}
