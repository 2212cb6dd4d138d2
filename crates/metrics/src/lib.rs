//! How much two pictures differ: FLIP, Yee's perceptual metric, relMSE and RMSE, each by the formula of a published paper.
//!
//! ```
//! use caustic_metrics::{Image, Metric, compare};
//!
//! let reference = Image::from_linear(2, 1, vec![[0.5; 3], [1.0; 3]])?;
//! let test = Image::from_linear(2, 1, vec![[0.5; 3], [0.9; 3]])?;
//! let score = compare(&test, &reference, Metric::Rmse)?;
//! assert!((score.value - (0.01f64 / 2.0).sqrt()).abs() < 1e-7);
//! assert_eq!(score.map[0], 0.0);
//! # Ok::<(), caustic_metrics::MetricsError>(())
//! ```
//!
//! Values are sums in one order, so they do not depend on the number of threads. Formulas are computed in `f64` with the functions of
//! the platform's mathematical library, so, unlike renders, they may differ in the last bits between platforms.

mod error;
mod flip;
mod heat;
mod image;
mod read;
mod relmse;
mod rmse;
mod score;
mod srgb;
mod yee;

#[cfg(test)]
mod faults;

pub use error::MetricsError;
pub use flip::{FlipOptions, flip};
pub use heat::heat;
pub use image::{Image, MAX_PIXELS, Range};
pub use relmse::{EPSILON, relmse};
pub use rmse::rmse;
pub use score::{Metric, Score, compare};
pub use srgb::{from_srgb, to_srgb};
pub use yee::sensitivity;
pub use yee::{YeeOptions, yee};
