//! What a render models and with which settings: explained, predicted before it begins, and chosen for a budget.
//!
//! [`explain`] says why a render does what it does. A [`Survey`] is made of small renders of the scene; from it, [`Survey::predict`] foretells
//! time, memory, noise and bias of a large one, and [`settle`] finds the settings that a [`Budget`] asks for. [`tradeoff`] measures what
//! this relies on, over all knobs.

mod advice;
mod budget;
pub mod cache;
mod explain;
mod fit;
mod pilot;
mod predict;
mod range;
mod survey;
pub mod tradeoff;

pub use advice::advice;
pub use budget::{Budget, Choice, Given, Quality, choose, settle};
pub use explain::{Line, explain};
pub use fit::fit;
pub use predict::Prediction;
pub use range::{Finding, findings};
pub use survey::{Costs, Survey};
