//! What a render models and with which settings: explained, predicted before it begins, and chosen for a budget.
//!
//! [`explain`] says why a render does what it does. A [`Survey`] is made of small renders of the scene; from it, [`Survey::predict`] foretells
//! time, memory, noise and bias of a large one, and [`settle`] finds the settings that a [`Budget`] asks for, and rehearses them. [`tradeoff`] measures what
//! this relies on, over all knobs.

mod advice;
mod budget;
pub mod cache;
mod explain;
mod fit;
mod predict;
mod range;
mod rehearsal;
mod scout;
mod survey;
pub mod tradeoff;

pub use advice::advice;
pub use budget::{Budget, Choice, Given, Quality, choose, foresee, settle};
pub use cache::Surveyor;
pub use explain::{Line, explain};
pub use fit::fit;
pub use predict::Prediction;
pub use range::{Finding, findings};
pub use rehearsal::Rehearsal;
pub use scout::{Costs, Scout};
pub use survey::{Correction, Survey};
