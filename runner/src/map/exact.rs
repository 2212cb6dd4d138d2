//! What `caustic map` is checked against: all photons looked at, for a few queries.

use caustic_kernels::gather::distance2;
use caustic_kernels::layout::{Irradiance, Neighbour, Photon, Query};
use caustic_photon_map::LargestPower;
use std::f32::consts::PI;

/// The nearest photons of a few queries.
pub struct ExactNearest {
    queries: Vec<Query>,
    k: usize,
    radius2: f32,
    pub best: Vec<Vec<Neighbour>>,
}

impl ExactNearest {
    /// No photons yet.
    pub fn new(queries: &[Query], k: u32, radius: f32) -> Self {
        let best = vec![Vec::new(); queries.len()];
        Self { queries: queries.to_vec(), k: k as usize, radius2: radius * radius, best }
    }

    /// Looks at the photons from index `first` on.
    pub fn add(&mut self, photons: &[Photon], first: u32) {
        for (query, best) in self.queries.iter().zip(&mut self.best) {
            let bound = if best.len() < self.k { self.radius2 } else { best[self.k - 1].distance2 };
            let near = (first..).zip(photons).filter_map(|(photon, &Photon { position, .. })| {
                let distance2 = distance2(query.position, position);
                (distance2 <= bound).then_some(Neighbour { distance2, photon })
            });
            best.extend(near);
            best.sort_by(|a, b| a.distance2.total_cmp(&b.distance2).then(a.photon.cmp(&b.photon)));
            best.truncate(self.k);
        }
    }
}

/// The irradiance of a few queries from all photons within the radius, by 128-bit integers and the conversions of the standard library.
pub struct ExactDensity {
    queries: Vec<Query>,
    radius2: f32,
    /// The scale of each channel: its biased exponent.
    scale: [i32; 3],
    /// In units of 2^(scale − 192).
    sums: Vec<[u128; 3]>,
    counts: Vec<u32>,
}

impl ExactDensity {
    /// No photons yet; none will be more powerful than `largest`.
    pub fn new(queries: &[Query], largest: LargestPower, radius: f32) -> Self {
        let scale = largest.0.map(|power| (power.to_bits() >> 23) as i32);
        let (sums, counts) = (vec![[0; 3]; queries.len()], vec![0; queries.len()]);
        Self { queries: queries.to_vec(), radius2: radius * radius, scale, sums, counts }
    }

    /// Looks at more photons.
    pub fn add(&mut self, photons: &[Photon]) {
        let places = self.sums.iter_mut().zip(&mut self.counts);
        for (query, (sums, count)) in self.queries.iter().zip(places) {
            for photon in photons {
                if distance2(query.position, photon.position) > self.radius2 {
                    continue;
                }
                *count += 1;
                for ((sum, scale), power) in sums.iter_mut().zip(self.scale).zip(photon.power) {
                    let exponent = (power.to_bits() >> 23) as i32;
                    let significand = u128::from(power.to_bits() & 0x007f_ffff | 0x0080_0000) << 42;
                    if exponent > 0 && scale - exponent <= 66 {
                        *sum += significand >> (scale - exponent);
                    }
                }
            }
        }
    }

    /// The estimates.
    fn irradiance(&self) -> Vec<Irradiance> {
        let value = |(sum, scale): (u128, i32)| (f64::from(sum as f32) * 2f64.powi(scale - 192)) as f32;
        let area = PI * self.radius2;
        let estimate = |(sums, &photons): (&[u128; 3], &u32)| {
            let rgb = std::array::from_fn(|channel| value((sums[channel], self.scale[channel])) / area);
            Irradiance { rgb, photons }
        };
        self.sums.iter().zip(&self.counts).map(estimate).collect()
    }

    /// How many of the queries have another estimate among `found`, which begins with theirs. One whose device is not exact may differ in the
    /// last places.
    pub fn differ(&self, found: &[Irradiance], exact: bool) -> usize {
        let same = |a: &Irradiance, b: &Irradiance| {
            let near = |a: f32, b: f32| a == b || (!exact && (a - b).abs() <= 1e-5 * b.abs());
            a.photons == b.photons && a.rgb.iter().zip(b.rgb).all(|(&a, b)| near(a, b))
        };
        self.irradiance().iter().zip(found).filter(|(exact, found)| !same(found, exact)).count()
    }
}
