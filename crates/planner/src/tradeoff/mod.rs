//! The trade between time, memory and error of a scene, measured: every knob swept by itself, and the settings that are worth having.

mod front;
mod point;
mod recall;
mod reference;
mod report;
mod run;
mod stability;

pub use front::{Front, front};
pub use point::{Case, Point, points};
pub use reference::reference;
pub use report::{csv, html, json, svg};
pub use run::{Event, run};
pub use stability::{stability, stability_cases};

/// Results of a sweep in a file.
pub type Store = caustic_experiments::store::StoreOf<Case>;
