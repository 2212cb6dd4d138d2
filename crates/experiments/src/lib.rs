//! The experiments of the thesis's chapter 5, measured again: which of its claims hold on today's devices?
//!
//! A [`figure`] names the [`case`]s that it is made of; [`run`] measures them and keeps what came of each in a [`store`], from
//! which [`report`] makes pages, tables and plots.

pub mod case;
pub mod claim;
pub mod figure;
pub mod report;
pub mod scope;
pub mod store;
pub mod subject;

mod measure;
mod picture;
mod run;
mod stage;

pub use run::{Event, Options, merge, run};
