//! What the tests share: the GPU, comparisons word by word, sets of points and an oracle.
//!
//! Comparisons return a `Result`, so that `tests/faults.rs` can show of each that a planted fault makes it fail.

mod gpu;
pub mod maps;
mod oracle;
pub mod points;
pub mod program;
pub mod rays;
pub mod renders;
pub mod soups;
mod words;

pub use gpu::gpu;
pub use oracle::{
    compare_irradiance, compare_neighbours, compare_sorted, oracle_irradiance, oracle_k_nearest, oracle_within,
    sum_rounded_once,
};
pub use words::{assert_same_words, compare_words};
