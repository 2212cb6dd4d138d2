//! How wide cells should be, from a sample of the photons.

use crate::MapOptions;
use std::f64::consts::SQRT_2;

/// Photons that a photon's cell should hold, its own included, on average over all photons: where fewer, a search visits more
/// rows than it saves candidates, and where more, the other way round (measured on an H100: ARCHITECTURE.md).
pub(crate) const OCCUPANCY: f64 = 5.0;
/// Most positions that are looked at.
const SAMPLE: usize = 4096;
/// Pairs in one cell below which chance decides: 1/√64 is 12 %.
const PAIRS: f64 = 64.0;

/// The width of cells in which a photon finds [`OCCUPANCY`] photons on average, m.
///
/// In a sample of m out of n photons, the pairs that share a cell, over all pairs, estimate the chance that two photons do, without
/// bias, and n times that is the mean occupancy as photons see it: crowds count as often as they have members. Where cells
/// that small hold too few pairs, the last two widths that have enough are extrapolated.
pub(crate) fn cell_width(
    low: [f32; 3],
    sides: [f64; 3],
    photons: u64,
    sample: &[[f32; 3]],
    options: &MapOptions,
) -> f64 {
    let longest = sides.into_iter().fold(0.0, f64::max);
    if longest == 0.0 || sample.len() < 2 {
        return f64::from(options.radius);
    }
    let stride = sample.len().div_ceil(SAMPLE);
    let sample: Vec<[f64; 3]> = sample
        .iter()
        .step_by(stride)
        .map(|position| std::array::from_fn(|axis| f64::from(position[axis]) - f64::from(low[axis])))
        .collect();
    // Widths fall by √2: every other one is a half.
    let pairs = [longest, longest / SQRT_2].map(|width| pairs_by_halves(&sample, width));
    let all_pairs = sample.len() as f64 * (sample.len() - 1) as f64 / 2.0;
    let occupancy = |pairs: f64| pairs / all_pairs * photons as f64;
    // The occupancy of two steps, which is half the width, gives the slope.
    let mut steps = vec![(longest, all_pairs)];
    let mut few = false;
    loop {
        let (width, found) = steps[steps.len() - 1];
        let next = width / SQRT_2;
        let next_pairs = pairs[steps.len() % 2][steps.len() / 2];
        if occupancy(found) <= OCCUPANCY || next < longest * 1e-6 {
            break;
        }
        if next_pairs < PAIRS {
            few = true;
            break;
        }
        steps.push((next, next_pairs));
    }
    let (_, fewest) = steps[steps.len() - 1];
    if occupancy(fewest) > OCCUPANCY && !few {
        // However small, cells hold as many: photons lie in the same points. Then the widest that hold no more will do.
        let enough = |&(_, pairs): &(f64, f64)| pairs <= 1.3 * fewest;
        steps.truncate(steps.iter().position(enough).unwrap_or(0) + 1);
        return steps[steps.len() - 1].0;
    }
    let (width, pairs) = steps[steps.len() - 1];
    let before = steps[steps.len().saturating_sub(3)];
    // Photons fill lines, surfaces or space.
    let slope = if before.0 > width { (before.1 / pairs).ln() / (before.0 / width).ln() } else { 3.0 };
    width * (OCCUPANCY / occupancy(pairs)).powf(1.0 / slope.clamp(1.0, 3.0))
}

/// Photons that a photon's cell holds on average over all photons, its own left out, if cells are `width` m wide; 0 where chance decides.
pub(crate) fn occupancy(low: [f32; 3], photons: u64, sample: &[[f32; 3]], width: f64) -> f64 {
    let counts = cell_counts(low, sample, width);
    let pairs: f64 = counts.iter().map(|&count| f64::from(count) * f64::from(count - 1) / 2.0).sum();
    let all_pairs = sample.len() as f64 * (sample.len() as f64 - 1.0) / 2.0;
    if pairs < PAIRS { 0.0 } else { pairs / all_pairs * photons as f64 }
}

/// Estimate of how many cells of `width` m the photons lie in, from how many cells have one and two of the sample: Chao's lower bound
/// (Chao, "Nonparametric Estimation of the Number of Classes in a Population", 1984, bias-corrected).
pub(crate) fn occupied_cells(low: [f32; 3], photons: u64, sample: &[[f32; 3]], width: f64) -> f64 {
    let counts = cell_counts(low, sample, width);
    let with = |n: u32| counts.iter().filter(|&&count| count == n).count() as f64;
    let (ones, twos) = (with(1), with(2));
    let unseen = ones * (ones - 1.0) / (2.0 * (twos + 1.0));
    // No more cells than photons, and no fewer than were seen; without a sample, a cell for each.
    if sample.is_empty() { photons as f64 } else { (counts.len() as f64 + unseen).min(photons as f64) }
}

/// Positions of the sample in each cell that has any.
fn cell_counts(low: [f32; 3], sample: &[[f32; 3]], width: f64) -> Vec<u32> {
    let cell = |position: &[f32; 3]| -> [u64; 3] {
        std::array::from_fn(|axis| ((f64::from(position[axis]) - f64::from(low[axis])) / width) as u64)
    };
    let mut cells: Vec<_> = sample.iter().map(cell).collect();
    cells.sort_unstable();
    cells.chunk_by(|a, b| a == b).map(|cell| cell.len() as u32).collect()
}

/// Halvings of a width: below a millionth of the longest side, where it ends.
const HALVINGS: u32 = 21;

/// Pairs of positions in one cell, for cells of `width`, a half, a quarter and so on.
///
/// In the order of a curve through the cells of all these widths, those who share a cell are neighbours, and the highest bit in which
/// two numbers on the curve differ says which cells they share (Morton 1966): one sort serves all widths.
fn pairs_by_halves(sample: &[[f64; 3]], width: f64) -> Vec<f64> {
    let finest = f64::from(1 << (HALVINGS - 1)) / width;
    let mut places: Vec<u64> =
        sample.iter().map(|position| interleave(position.map(|x| (x * finest) as u64))).collect();
    places.sort_unstable();
    let of_level = |level: u32| {
        let cells = places.chunk_by(|a, b| (a ^ b) >> (3 * (HALVINGS - 1 - level)) == 0);
        cells.map(|cell| cell.len() as f64 * (cell.len() - 1) as f64 / 2.0).sum()
    };
    (0..HALVINGS).map(of_level).collect()
}

/// The lowest 21 bits of x, y and z in turns.
fn interleave(cell: [u64; 3]) -> u64 {
    let spread = |x: u64| {
        let x = x & 0x1f_ffff;
        let x = (x | (x << 32)) & 0x001f_0000_0000_ffff;
        let x = (x | (x << 16)) & 0x001f_0000_ff00_00ff;
        let x = (x | (x << 8)) & 0x100f_00f0_0f00_f00f;
        let x = (x | (x << 4)) & 0x10c3_0c30_c30c_30c3;
        (x | (x << 2)) & 0x1249_2492_4924_9249
    };
    spread(cell[0]) | (spread(cell[1]) << 1) | (spread(cell[2]) << 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Hash;
    use caustic_kernels::num::pcg4d;

    /// Pairs of positions in one cell, by sorting the cells.
    fn pairs_in_cells(sample: &[[f64; 3]], width: f64) -> f64 {
        let mut cells: Vec<[u32; 3]> = sample.iter().map(|position| position.map(|x| (x / width) as u32)).collect();
        cells.sort_unstable();
        cells.chunk_by(|a, b| a == b).map(|cell| cell.len() as f64 * (cell.len() - 1) as f64 / 2.0).sum()
    }

    #[test]
    fn one_sort_counts_the_pairs_of_all_widths() {
        // From the whole, 3 m, down to cells of 3 µm; a third of the places twice.
        let places: Vec<[f64; 3]> = (0..1000u32)
            .map(|i| pcg4d([i % 700, 1, 2, 3]))
            .map(|r| [0, 1, 2].map(|axis| f64::from(r[axis]) / 4_294_967_296.0 * 3.0))
            .collect();
        for width in [3.0, 3.0 / SQRT_2] {
            let pairs = pairs_by_halves(&places, width);
            for (halvings, &found) in (0..).zip(&pairs) {
                assert_eq!(found, pairs_in_cells(&places, width / f64::from(1 << halvings)), "{width} {halvings}");
            }
            assert!(pairs[0] > 30_000.0 && pairs[20] == 300.0, "{pairs:?}");
        }
    }

    /// Photons in space, on a floor, in a crowd: cells hold about as many as they should.
    #[test]
    fn cells_hold_the_photons_that_they_should() {
        let at = |i: u32| pcg4d([i, 5, 6, 7]).map(|x| x as f32 / 4_294_967_296.0);
        let space = |i| [at(i)[0], at(i)[1], at(i)[2]];
        let floor = |i| [at(i)[0], 0.5, at(i)[2]];
        let crowd = |i| if at(i)[3] < 0.1 { space(i) } else { space(i).map(|x| 0.3 + 0.1 * x) };
        let options = MapOptions { radius: 1.0, hash: Hash::Linear, table: None, cell: None };
        for (n, name, place) in [
            (100_000, "space", &space as &dyn Fn(u32) -> [f32; 3]),
            (100_000, "floor", &floor),
            (1_000_000, "floor", &floor),
            (100_000, "crowd", &crowd),
        ] {
            let positions: Vec<[f32; 3]> = (0..n).map(place).collect();
            let width = cell_width([0.0; 3], [1.0; 3], u64::from(n), &positions, &options);
            let whole: Vec<[f64; 3]> = positions.iter().map(|p| p.map(f64::from)).collect();
            let found = 2.0 * pairs_in_cells(&whole, width) / f64::from(n);
            assert!((3.0..8.0).contains(&found), "{name}, {n}: {found} a cell {width} wide");
        }
    }

    /// Photons evenly on the faces of a cube, from 4096 of which the cells of all of them are estimated.
    #[test]
    fn occupied_cells_are_estimated_from_few() {
        let photons = 500_000;
        let on_cube = |i: u32| {
            let random = pcg4d([i, 8, 9, 10]);
            let mut position = [random[0], random[1], random[2]].map(|x| x as f32 / 4_294_967_296.0);
            position[random[3] as usize % 3] = (random[3] >> 31) as f32;
            position
        };
        let positions: Vec<_> = (0..photons).map(on_cube).collect();
        for width in [0.1, 0.01, 0.004] {
            let cells = cell_counts([0.0; 3], &positions, width).len() as f64;
            let estimate = occupied_cells([0.0; 3], photons.into(), &positions[..4096], width);
            assert!((0.6..1.6).contains(&(estimate / cells)), "{estimate} of {cells} cells {width} wide");
        }
        assert_eq!(occupied_cells([0.0; 3], 100, &[[0.0; 3]; 50], 0.1), 1.0);
        assert_eq!(occupied_cells([0.0; 3], 100, &[], 0.1), 100.0);
    }

    #[test]
    fn no_sample_or_no_extent_gives_the_radius() {
        let options = MapOptions { radius: 0.5, hash: Hash::Linear, table: None, cell: None };
        assert_eq!(cell_width([0.0; 3], [1.0; 3], 100, &[], &options), 0.5);
        assert_eq!(cell_width([0.0; 3], [0.0; 3], 100, &[[0.0; 3]; 100], &options), 0.5);
        // All but one in one point: no cell helps, however small.
        let mut sample = vec![[0.25; 3]; 5000];
        sample[77] = [1.0; 3];
        let width = cell_width([0.0; 3], [1.0; 3], 5000, &sample, &options);
        assert!(width > 0.5, "{width}");
    }
}
