//! Random numbers that are a function of what they are for, so the schedule cannot change them.

use super::convert::u32_to_unit;

/// Four random words of four words, by two rounds of a linear congruential step and a multiply-add around the ring.
///
/// Source: Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020, listing `pcg4d`. A bijection of
/// 128 bits.
#[inline]
pub fn pcg4d(input: [u32; 4]) -> [u32; 4] {
    let x = input[0].wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let y = input[1].wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let z = input[2].wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let w = input[3].wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let [x, y, z, w] = mix(x, y, z, w);
    mix(x ^ (x >> 16), y ^ (y >> 16), z ^ (z >> 16), w ^ (w >> 16))
}

#[inline]
fn mix(x: u32, y: u32, z: u32, w: u32) -> [u32; 4] {
    let x = x.wrapping_add(y.wrapping_mul(w));
    let y = y.wrapping_add(z.wrapping_mul(x));
    let z = z.wrapping_add(x.wrapping_mul(y));
    let w = w.wrapping_add(y.wrapping_mul(z));
    [x, y, z, w]
}

/// A source of random numbers for one photon, path or pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rng {
    /// The user's seed of the whole render.
    pub seed: u32,
    /// What the numbers are for: emission, camera, … and the pass.
    pub stream: u32,
    /// Which photon, path or pixel of the stream.
    pub index: u32,
}

impl Rng {
    /// Four independent numbers, uniform among the multiples of 2⁻²⁴ in [0, 1): the same ones for the same seed, stream,
    /// index and `dimension` (a bounce and a purpose, numbered by the caller), whoever asks and when.
    #[inline]
    pub fn draw4(&self, dimension: u32) -> [f32; 4] {
        let words = pcg4d([self.index, dimension, self.stream, self.seed]);
        [u32_to_unit(words[0]), u32_to_unit(words[1]), u32_to_unit(words[2]), u32_to_unit(words[3])]
    }
}

/// Point `i` of Sobol's two-dimensional (0, 2)-sequence, its digits flipped where `scramble` has ones: every 2ᵏ points that
/// start at a multiple of 2ᵏ, up to 2²⁴, put one point into every elementary interval of area 2⁻ᵏ in [0, 1)².
///
/// The first coordinate is van der Corput's. Sources: Kollig and Keller, "Efficient Multidimensional Sampling", Computer
/// Graphics Forum 21(3), 2002, for the sequence and its scrambling; Ahmed, "An Implementation Algorithm of 2D Sobol
/// Sequence Fast, Elegant, and Compact", EGSR 2024, for the second coordinate without a loop.
#[inline]
pub fn sobol2(i: u32, scramble: [u32; 2]) -> [f32; 2] {
    let x = i.reverse_bits();
    [u32_to_unit(x ^ scramble[0]), u32_to_unit(pascal(x) ^ scramble[1])]
}

/// `v` times Pascal's triangle modulo 2, which is the fifth Kronecker power of its 2 × 2 corner: one step each.
#[inline]
fn pascal(v: u32) -> u32 {
    let v = v ^ (v << 16);
    let v = v ^ ((v & 0x00ff_00ff) << 8);
    let v = v ^ ((v & 0x0f0f_0f0f) << 4);
    let v = v ^ ((v & 0x3333_3333) << 2);
    v ^ ((v & 0x5555_5555) << 1)
}

/// Shuffles the indices of a sequence so that every aligned block of 2ⁿ of them stays one: the shuffled [`sobol2`] is a
/// (0, 2)-sequence too, and sequences shuffled with different keys can be used side by side for one integral (Burley,
/// "Practical Hash-based Owen Scrambling", JCGT 2020; the hash is that of Laine and Karras).
#[inline]
#[must_use]
pub fn shuffle_index(i: u32, key: u32) -> u32 {
    let mut x = i.reverse_bits().wrapping_add(key);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRAWS: u32 = 1 << 20;

    fn rng(index: u32) -> Rng {
        Rng { seed: 1, stream: 2, index }
    }

    /// The paper's listing, written the way the paper does: in place, over a vector.
    #[test]
    fn pcg4d_is_the_listing() {
        fn listing(mut v: [u32; 4]) -> [u32; 4] {
            v = v.map(|a| a.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
            for round in 0..2 {
                if round == 1 {
                    v = v.map(|a| a ^ (a >> 16));
                }
                for (to, a, b) in [(0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)] {
                    v[to] = v[to].wrapping_add(v[a].wrapping_mul(v[b]));
                }
            }
            v
        }
        for i in 0..1000u32 {
            let input = [i, i.wrapping_mul(0x9e37_79b9), !i, i << 16];
            assert_eq!(pcg4d(input), listing(input));
        }
    }

    /// Known moments: mean ½ and variance 1/12, within 5 standard errors of 2²⁰ draws.
    #[test]
    fn moments() {
        for lane in 0..4 {
            let (mut sum, mut squares) = (0.0, 0.0);
            for i in 0..DRAWS {
                let u = f64::from(rng(i).draw4(0)[lane]) - 0.5;
                sum += u;
                squares += u * u;
            }
            let n = f64::from(DRAWS);
            assert!((sum / n).abs() < 5.0 * (1.0 / 12.0 / n).sqrt(), "mean of lane {lane}");
            // The variance of (u − ½)² is 1/80 − 1/144 = 1/180.
            assert!((squares / n - 1.0 / 12.0).abs() < 5.0 * (1.0 / 180.0 / n).sqrt(), "variance of lane {lane}");
        }
    }

    /// χ² of 256 cells has mean 255 and standard deviation √510 ≈ 22.6; five of them either way.
    fn assert_even(cells: &[u32; 256], n: u32, what: &str) {
        let expected = f64::from(n) / 256.0;
        let chi2: f64 = cells.iter().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum();
        assert!((142.0..368.0).contains(&chi2), "{what}: chi-square {chi2}");
    }

    fn cell(u: f32, v: f32) -> usize {
        (u * 16.0) as usize * 16 + (v * 16.0) as usize
    }

    /// Pairs within a draw, of neighbouring indices, dimensions, streams and seeds fill a 16 × 16 grid evenly.
    #[test]
    fn neighbours_are_independent() {
        type Neighbour = fn(u32) -> [f32; 4];
        let neighbours: [(&str, Neighbour); 4] = [
            ("indices", |i| rng(i + 1).draw4(0)),
            ("dimensions", |i| rng(i).draw4(1)),
            ("streams", |i| Rng { stream: 3, ..rng(i) }.draw4(0)),
            ("seeds", |i| Rng { seed: 2, ..rng(i) }.draw4(0)),
        ];
        for (what, neighbour) in neighbours {
            let (mut across, mut within) = ([[0; 256]; 16], [[0; 256]; 4]);
            for i in 0..DRAWS / 4 {
                let (u, v) = (rng(i).draw4(0), neighbour(i));
                for (k, cells) in across.iter_mut().enumerate() {
                    cells[cell(u[k / 4], v[k % 4])] += 1;
                }
                for (k, cells) in within.iter_mut().enumerate() {
                    cells[cell(v[k], v[(k + 1) % 4])] += 1;
                }
            }
            for cells in across.iter().chain(&within) {
                assert_even(cells, DRAWS / 4, what);
            }
        }
    }

    #[test]
    fn first_points() {
        let points = [0, 1, 2, 3, 4, 5].map(|i| sobol2(i, [0; 2]));
        let expected = [[0.0, 0.0], [0.5, 0.5], [0.25, 0.75], [0.75, 0.25], [0.125, 0.625], [0.625, 0.125]];
        assert_eq!(points, expected);
        assert_eq!(sobol2(0, [1 << 31, 3 << 30]), [0.5, 0.75]);
    }

    /// Kollig and Keller's loop over the digits (their `RI_S`), against the five steps used here.
    #[test]
    fn second_coordinate_is_the_loop() {
        for i in (0..1u32 << 16).chain((0..1000).map(|i| u32::MAX - i * i)) {
            let (mut y, mut digits, mut column) = (0, i, 1u32 << 31);
            while digits != 0 {
                y ^= if digits & 1 != 0 { column } else { 0 };
                digits >>= 1;
                column ^= column >> 1;
            }
            assert_eq!(pascal(i.reverse_bits()), y, "{i}");
        }
    }

    /// How often an elementary interval of `2^k` points from `start` on has not just one point.
    fn violations(k: u32, start: u32, point: impl Fn(u32) -> [f32; 2]) -> u32 {
        let mut bad = 0;
        for columns in 0..=k {
            let (wide, high) = ((1u32 << columns) as f32, (1u32 << (k - columns)) as f32);
            let mut cells = [0; 4096];
            for i in start..start + (1 << k) {
                let [x, y] = point(i);
                cells[(x * wide) as usize * high as usize + (y * high) as usize] += 1;
            }
            bad += cells[..1 << k].iter().map(|&c| u32::from(c != 1)).sum::<u32>();
        }
        bad
    }

    #[test]
    fn every_elementary_interval_has_one_point() {
        for scramble in [[0, 0], [0x1234_5678, 0x9abc_def0], [u32::MAX, 1]] {
            for k in [4, 8, 12] {
                for block in [0, 1, 5] {
                    assert_eq!(violations(k, block << k, |i| sobol2(i, scramble)), 0, "2^{k} points, block {block}");
                }
            }
        }
        // Random points must fail the same test.
        assert!(violations(8, 0, |i| [rng(i).draw4(0)[0], rng(i).draw4(0)[1]]) > 100);
    }

    #[test]
    fn shuffled_sequences_stay_stratified_and_part_from_each_other() {
        for key in [0, 1, 0x1234_5678, 0xffff_ffff] {
            // 256 points: one in each of the 16 × 16 cells.
            let mut cells = [0u32; 256];
            for i in 0..256 {
                let [x, y] = sobol2(shuffle_index(i, key), [0x9e37_79b9, 0x7f4a_7c15]);
                cells[(x * 16.0) as usize * 16 + (y * 16.0) as usize] += 1;
            }
            assert_eq!(cells, [1; 256], "key {key:#x}");
        }
        // Unshuffled, x of the one sequence fixes the stratum of x of the other; shuffled, all pairs of strata occur.
        let pairs = |keys: [u32; 2]| {
            let mut seen = [false; 64];
            for i in 0..4096 {
                let [a, b] = keys.map(|key| sobol2(if key == 0 { i } else { shuffle_index(i, key) }, [0, 0])[0]);
                seen[(a * 8.0) as usize * 8 + (b * 8.0) as usize] = true;
            }
            seen.into_iter().filter(|&seen| seen).count()
        };
        assert_eq!((pairs([0, 0]), pairs([77, 1234])), (8, 64));
    }
}
