//! Filters: how much a photon counts, by its distance.
//!
//! A photon at the distance d of a query has the weight w(x), x = d²/r². Where photons are spread evenly over a surface, the area
//! within the distance s grows by 2π·s·ds, so that an estimate is exact if the sum of the weighted power is divided by
//!
//! ∫ w dA = π·r²·W(1), with W(x) = ∫₀ˣ w(t) dt.
//!
//! That holds for a fixed radius. It holds as well for the radius of the (k + 1)-th neighbour, which is not counted: given its radius,
//! the k before it are spread evenly within, and the mean of k over the photons expected there is 1.
//!
//! Sources: Jensen, "Realistic Image Synthesis Using Photon Mapping", 2001, section 7.4 (cone, Gaussian); Silverman, "Density
//! Estimation for Statistics and Data Analysis", 1986, section 4.2 (Epanechnikov). Jensen's own constant for the Gaussian, α = 0.918,
//! makes an even surface 0.53 times as bright as it is.

use crate::num::{exp, max, sqrt};

/// All photons count the same.
pub const FILTER_CONSTANT: u32 = 0;
/// w = 1 − d/r: Jensen's cone with k = 1.
pub const FILTER_CONE: u32 = 1;
/// w = 1 − (1 − e^(−β·d²/2r²)) / (1 − e^(−β)), β = 1.953.
pub const FILTER_GAUSSIAN: u32 = 2;
/// w = 1 − d²/r².
pub const FILTER_EPANECHNIKOV: u32 = 3;

/// β/2.
const HALF_BETA: f32 = 0.9765;
/// 2/β.
const INVERSE: f32 = 1.024_065_5;
/// 1 / (1 − e^(−β)).
const DEPTH: f32 = 1.165_294_6;

/// The weight w(x) of a photon at x = d²/r², from 0 to 1.
#[inline]
#[must_use]
pub fn filter_weight(filter: u32, x: f32) -> f32 {
    if filter == FILTER_CONE {
        max(0.0, 1.0 - sqrt(x))
    } else if filter == FILTER_GAUSSIAN {
        1.0 - DEPTH * (1.0 - exp(-HALF_BETA * x))
    } else if filter == FILTER_EPANECHNIKOV {
        max(0.0, 1.0 - x)
    } else {
        1.0
    }
}

/// The integral W(x) of the weight from 0 to x.
#[inline]
#[must_use]
pub fn filter_integral(filter: u32, x: f32) -> f32 {
    if filter == FILTER_CONE {
        x - (2.0 / 3.0) * x * sqrt(x)
    } else if filter == FILTER_GAUSSIAN {
        x - DEPTH * (x - INVERSE * (1.0 - exp(-HALF_BETA * x)))
    } else if filter == FILTER_EPANECHNIKOV {
        x - 0.5 * x * x
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [u32; 4] = [FILTER_CONSTANT, FILTER_CONE, FILTER_GAUSSIAN, FILTER_EPANECHNIKOV];

    /// W is what it stands for, and weights fall from 1 and are never negative.
    #[test]
    fn the_integral_of_a_filter_is_the_integral_of_its_weight() {
        const STEPS: u32 = 100_000;
        for filter in ALL {
            let mut sum = 0.0;
            let mut before = 1.0;
            for i in 0..STEPS {
                let x = (f64::from(i) + 0.5) / f64::from(STEPS);
                let weight = filter_weight(filter, x as f32);
                assert!((0.0..=before + 1e-6).contains(&weight), "{filter} at {x}: {weight} after {before}");
                before = weight;
                sum += f64::from(weight) / f64::from(STEPS);
                if i % 9999 == 0 {
                    let found = f64::from(filter_integral(filter, (x + 0.5 / f64::from(STEPS)) as f32));
                    // f32 in the integral, midpoints in the sum.
                    assert!((found - sum).abs() < 1e-6, "{filter} to {x}: {found} and {sum}");
                }
            }
            assert_eq!(filter_weight(filter, 0.0), 1.0);
            // A squared distance over a squared radius may be rounded to more than 1.
            assert!(filter_weight(filter, 1.000_000_1) >= 0.0);
        }
        let whole = ALL.map(|filter| filter_integral(filter, 1.0));
        // The third by hand: 1 − 1.1652946·(1 − 1.0240655·0.6233716).
        for (found, expected) in whole.into_iter().zip([1.0, 1.0 / 3.0, 0.578_600, 0.5]) {
            assert!((found - expected).abs() < 2e-6, "{found} and {expected}");
        }
    }
}
