//! Benchmarks that are tests: every measured result is hashed and compared, since results are exact and one hash holds for all
//! devices. docs/BIASES.md says what the times leave out.
//!
//! A [`case`] says what is measured; `work` prepares it on a device; [`suite`] measures it and makes a [`row`] of it; `report`
//! and [`record`] write rows down.

pub mod case;
pub mod measure;
pub mod points;
pub mod record;
pub mod report;
pub mod row;
pub mod suite;

mod digest;
mod exact;
mod files;
mod fit;
mod machine;
mod peers;
mod roofline;
mod work;

pub use digest::Digest;
pub use fit::power;
pub use work::Trouble;
