//! Sets of positions, each a function of (seed, stream, index): the same on every machine, whoever asks and in what order.

use caustic_kernels::layout::{Photon, Query};
use caustic_kernels::num::{Rng, pcg4d};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::ops::Range;

/// Stream of the photons' positions.
const PHOTONS: u32 = 0;
/// Stream of the queries' positions.
const QUERIES: u32 = 1;
/// Stream of the photons' powers.
const POWERS: u32 = 2;
/// Stream of the keys of a sort.
const KEYS: u32 = 3;

/// Side of the cube in which [`Distribution::Caustic`] has most of its points: a thousandth of the unit cube.
const CLUSTER: f32 = 0.1;
/// Share of the points of [`Distribution::Caustic`] that are in there.
const CLUSTERED: f32 = 0.9;

/// How points are spread over the unit cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Distribution {
    /// Evenly in the unit cube.
    Uniform,
    /// Evenly on its six faces, the walls of a room.
    Surface,
    /// Nine of ten in a thousandth of its volume, the others evenly everywhere: what a caustic does.
    Caustic,
    /// All in a cube whose side is the query radius: one cell of the grid has them all.
    Cell,
}

/// A set of points: a distribution, and for [`Distribution::Cell`] the side of its cube.
#[derive(Clone, Copy, Debug)]
pub struct Points {
    /// How they are spread.
    pub distribution: Distribution,
    /// Side of the cell, m.
    pub cell: f32,
}

impl Points {
    /// The distribution, and the cell that queries for `k` of `n` photons have.
    #[must_use]
    pub fn new(distribution: Distribution, n: u32, k: u32) -> Self {
        Self { distribution, cell: Distribution::Uniform.radius(n, k) }
    }

    fn draw(&self, stream: u32, index: u32) -> [f32; 3] {
        let [x, y, z, w] = Rng { seed: 0, stream, index }.draw4(0);
        match self.distribution {
            Distribution::Surface => {
                let face = (w * 6.0) as u32;
                let mut position = [x, y, z];
                position[face as usize % 3] = (face / 3) as f32;
                position
            }
            Distribution::Caustic if w < CLUSTERED => [x, y, z].map(|u| 0.45 + CLUSTER * u),
            // From a corner on, where the steps of f32 are finest and no rounding can leave the cube.
            Distribution::Cell => [x, y, z].map(|u| self.cell * u),
            Distribution::Uniform | Distribution::Caustic => [x, y, z],
        }
    }

    /// Position of photon `index`.
    #[must_use]
    pub fn photon(&self, index: u32) -> [f32; 3] {
        self.draw(PHOTONS, index)
    }

    /// Position of query `index`.
    #[must_use]
    pub fn query(&self, index: u32) -> [f32; 3] {
        self.draw(QUERIES, index)
    }

    /// `n` photons, of powers from 0.5 to 1.5 so that an estimate shows which of them it took.
    #[must_use]
    pub fn photons(&self, n: u32) -> Vec<Photon> {
        self.photons_of(0..n)
    }

    /// The photons of these indices.
    #[must_use]
    pub fn photons_of(&self, indices: Range<u32>) -> Vec<Photon> {
        let photon = |index| {
            let [r, g, b, _] = Rng { seed: 0, stream: POWERS, index }.draw4(0);
            Photon { position: self.photon(index), power: [r, g, b].map(|u| 0.5 + u), ..Photon::default() }
        };
        indices.into_par_iter().map(photon).collect()
    }

    /// `n` queries.
    #[must_use]
    pub fn queries(&self, n: u32) -> Vec<Query> {
        (0..n).into_par_iter().map(|index| Query { position: self.query(index), active: 1 }).collect()
    }
}

impl Distribution {
    /// A radius within which 2·k of `n` photons are expected around an average query that is not near an edge; at most 1 m.
    #[must_use]
    pub fn radius(self, n: u32, k: u32) -> f32 {
        let wanted = 2.0 * f64::from(k) / f64::from(n.max(1));
        let radius = match self {
            Self::Surface => (6.0 * wanted / PI).sqrt(),
            Self::Caustic => f64::from(CLUSTER) * (wanted / f64::from(CLUSTERED) * 0.75 / PI).cbrt(),
            Self::Uniform | Self::Cell => (wanted * 0.75 / PI).cbrt(),
        };
        radius.min(1.0) as f32
    }
}

/// `n` keys, uniform among those of `bits` bits.
#[must_use]
pub fn keys(n: u32, bits: u32) -> Vec<u32> {
    let mask = u32::MAX >> (u32::BITS - bits.clamp(1, u32::BITS));
    (0..n).into_par_iter().map(|index| pcg4d([index, 0, KEYS, 0])[0] & mask).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustic_photon_map::{Hash, MapOptions, bounds, plan_grid};

    const N: u32 = 60_000;

    fn count(distribution: Distribution, inside: impl Fn([f32; 3]) -> bool) -> usize {
        let points = Points::new(distribution, N, 50);
        (0..N).filter(|&i| inside(points.photon(i))).count()
    }

    /// A count of a thing of probability `p`, within five standard deviations. Nothing is random here: it holds or not.
    fn assert_share(count: usize, p: f64) {
        let (mean, deviation) = (f64::from(N) * p, (f64::from(N) * p * (1.0 - p)).sqrt());
        assert!((count as f64 - mean).abs() < 5.0 * deviation, "{count} of {N}, expected {mean} ± {deviation}");
    }

    #[test]
    fn uniform_points_fill_every_octant_alike() {
        for octant in 0..8 {
            let side = |axis: usize, x: f32| (x >= 0.5) == ((octant >> axis) & 1 == 1);
            assert_share(count(Distribution::Uniform, |p| (0..3).all(|axis| side(axis, p[axis]))), 0.125);
        }
    }

    #[test]
    fn surface_points_lie_on_six_faces_alike() {
        for axis in 0..3 {
            for side in [0.0, 1.0] {
                assert_share(count(Distribution::Surface, |p| p[axis] == side), 1.0 / 6.0);
            }
        }
        assert_eq!(count(Distribution::Surface, |p| p.iter().any(|&x| x == 0.0 || x == 1.0)), N as usize);
    }

    #[test]
    fn nine_of_ten_points_of_a_caustic_lie_in_a_thousandth() {
        let inside = |p: [f32; 3]| p.iter().all(|x| (0.45..=0.55).contains(x));
        assert_share(count(Distribution::Caustic, inside), 0.9 + 0.1 * 0.001);
        let everywhere = |p: [f32; 3]| p.iter().all(|x| (0.0..1.0).contains(x));
        assert_eq!(count(Distribution::Caustic, everywhere), N as usize);
    }

    #[test]
    fn all_points_of_a_cell_have_one_key() {
        for (n, k) in [(N, 50), (1 << 16, 10), (1000, 1), (1, 1024)] {
            let points = Points::new(Distribution::Cell, n, k);
            let radius = Distribution::Cell.radius(n, k);
            let (low, high) = bounds("photons", (0..n).map(|i| points.photon(i))).unwrap();
            let options = MapOptions { radius, hash: Hash::Linear, table: None, cell: Some(radius) };
            let grid = plan_grid(low, high, n.into(), &[], &options).unwrap();
            assert_eq!(grid.cells, [1; 3], "{n} {k}");
        }
    }

    #[test]
    fn twice_k_photons_are_expected_within_the_radius() {
        for (distribution, k) in [(Distribution::Uniform, 50), (Distribution::Surface, 50), (Distribution::Caustic, 20)]
        {
            let points = Points::new(distribution, N, k);
            let radius2 = distribution.radius(N, k).powi(2);
            // Queries away from edges, where a sphere would hang over.
            let centre = match distribution {
                Distribution::Surface => [0.5, 0.5, 0.0],
                _ => [0.5; 3],
            };
            let mut found = 0;
            for i in 0..16 {
                let offset = [(i % 4) as f32, (i / 4) as f32, 0.0].map(|x| 0.01 * (x - 1.5));
                let query: [f32; 3] = std::array::from_fn(|axis| centre[axis] + offset[axis]);
                let distance2 = |p: [f32; 3]| (0..3).map(|a| (p[a] - query[a]).powi(2)).sum::<f32>();
                found += (0..N).filter(|&j| distance2(points.photon(j)) <= radius2).count();
            }
            let mean = found as f64 / 16.0;
            assert!((0.8..1.25).contains(&(mean / (2.0 * f64::from(k)))), "{distribution:?}: {mean} for k = {k}");
        }
    }

    #[test]
    fn keys_have_their_bits_and_every_thread_the_same() {
        let keys = keys(10_000, 24);
        assert!(keys.iter().all(|key| key >> 24 == 0) && keys.iter().any(|key| key >> 23 == 1));
        assert_eq!(keys[7], pcg4d([7, 0, KEYS, 0])[0] & 0xff_ffff);
    }
}
