//! Samples against their density, by χ² over cells: what the tests of samplers share.

use super::vector::{from_frame, to_frame};
use core::f64::consts::{PI, TAU};
use glam::Vec3;
use std::vec;
use std::vec::Vec;

const ROWS: usize = 32;
const COLUMNS: usize = 16;
/// Steps of the quadrature along each side of a cell.
const FINE: usize = 24;
/// Samples of a test.
pub(crate) const SAMPLES: u32 = 1 << 17;

/// The direction about `n` with (1 + cos θ) / 2 = `x` and φ / 2π = `y`: uniform in solid angle.
pub(crate) fn on_sphere(n: Vec3, x: f64, y: f64) -> Vec3 {
    let z = 2.0 * x - 1.0;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (y * TAU).sin_cos();
    from_frame(n, (r * cos) as f32, (r * sin) as f32, z as f32)
}

/// The cell of the sphere about `n` that holds a direction: rows are even in θ, so that narrow lobes about the normal have many.
fn cell(n: Vec3, d: Vec3) -> usize {
    let local = to_frame(n, d);
    let x = f64::from(local.z).acos() / PI;
    let y = f64::from(local.y).atan2(f64::from(local.x)) / TAU + 1.0;
    let row = ((x * ROWS as f64) as usize).min(ROWS - 1);
    row * COLUMNS + ((y.fract() * COLUMNS as f64) as usize).min(COLUMNS - 1)
}

/// Samples by cell, and how many the density makes of them.
pub(crate) struct Counts {
    found: Vec<f64>,
    expected: Vec<f64>,
}

impl Counts {
    /// χ² and its degrees of freedom, where cells expect `fault` times what they should.
    pub(crate) fn chi_square(&self, fault: f64) -> (f64, usize) {
        // Cells that expect few are one cell together, as the test's theory wants it.
        let mut few = [0.0; 2];
        let (mut chi2, mut cells) = (0.0, 0);
        for (&found, &expected) in self.found.iter().zip(&self.expected) {
            let expected = expected * fault;
            if expected < 20.0 {
                few = [few[0] + found, few[1] + expected];
            } else {
                chi2 += (found - expected) * (found - expected) / expected;
                cells += 1;
            }
        }
        chi2 += (few[0] - few[1]) * (few[0] - few[1]) / f64::max(few[1], 20.0);
        (chi2, cells)
    }

    /// Fails if χ² is too large, or is not too large for a density that is `fault` times as large.
    pub(crate) fn judge(&self, fault: f64, what: &str) {
        let (chi2, cells) = self.chi_square(1.0);
        std::println!("{what}: χ² {chi2:.1} of {cells} cells, limit {:.1}", limit(cells));
        assert!(cells > 8 && chi2 < limit(cells), "{what}: χ² {chi2} of {cells} cells, limit {}", limit(cells));
        let (chi2, cells) = self.chi_square(fault);
        assert!(chi2 > limit(cells), "{what}: a density that is {fault} times as large does not show: {chi2}");
    }
}

/// [`SAMPLES`] directions, and the integral of their density, sr⁻¹, over cells about `n`. What the density leaves of 1 has to be the share of
/// samples that are none.
pub(crate) fn of_directions(
    n: Vec3,
    sample: impl Fn(u32) -> Option<Vec3>,
    density: impl Fn(Vec3) -> f32,
    what: &str,
) -> Counts {
    let mut expected = vec![0.0; ROWS * COLUMNS];
    for row in 0..ROWS * FINE {
        for column in 0..COLUMNS * FINE {
            let x = (row as f64 + 0.5) / (ROWS * FINE) as f64;
            let y = (column as f64 + 0.5) / (COLUMNS * FINE) as f64;
            let theta = x * PI;
            let pdf = density(on_sphere(n, theta.cos() * 0.5 + 0.5, y));
            let area = theta.sin() * 2.0 * PI.powi(2) / (ROWS * COLUMNS * FINE * FINE) as f64;
            expected[row / FINE * COLUMNS + column / FINE] += f64::from(pdf) * area * f64::from(SAMPLES);
        }
    }
    let rest = f64::from(SAMPLES) - expected.iter().sum::<f64>();
    let mut found = vec![0.0; ROWS * COLUMNS];
    let mut without = 0.0;
    for i in 0..SAMPLES {
        match sample(i) {
            Some(direction) => found[cell(n, direction)] += 1.0,
            None => without += 1.0,
        }
    }
    // Five standard deviations, and 0.4 % for the quadrature, which steps over the edges of lobes: it is 0.2 % off at worst.
    let off = (without - rest).abs();
    assert!(off < 0.004 * f64::from(SAMPLES) + 5.0 * f64::sqrt(without), "{what}: {without} without, against {rest}");
    Counts { found, expected }
}

/// [`SAMPLES`] points of the disc of radius 1, against an even density.
pub(crate) fn of_disc(sample: impl Fn(u32) -> [f32; 2]) -> Counts {
    const SIDE: usize = 16;
    const FINER: usize = 64;
    let mut expected = vec![0.0; SIDE * SIDE];
    let at = |i: usize| (i as f64 + 0.5) / (SIDE * FINER) as f64 * 2.0 - 1.0;
    for i in 0..SIDE * FINER {
        for k in 0..SIDE * FINER {
            if at(i).hypot(at(k)) < 1.0 {
                let area = 4.0 / (SIDE * SIDE * FINER * FINER) as f64;
                expected[i / FINER * SIDE + k / FINER] += area / PI * f64::from(SAMPLES);
            }
        }
    }
    let mut found = vec![0.0; SIDE * SIDE];
    for i in 0..SAMPLES {
        let [x, y] = sample(i).map(|x| (((x + 1.0) / 2.0 * SIDE as f32) as usize).min(SIDE - 1));
        found[x * SIDE + y] += 1.0;
    }
    Counts { found, expected }
}

/// The value that χ² exceeds once in 10⁶ times (Wilson and Hilferty 1931). Of n tests at fixed seeds, one would fail by chance with 1 − (1 − 10⁻⁶)ⁿ
/// (Šidák 1967): 10⁻⁴ for the hundred that there are.
pub(crate) fn limit(degrees: usize) -> f64 {
    let k = degrees as f64;
    let z = 4.753; // of the normal distribution
    k * (1.0 - 2.0 / (9.0 * k) + z * (2.0 / (9.0 * k)).sqrt()).powi(3)
}
