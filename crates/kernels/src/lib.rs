//! The algorithms of caustic, written once: every function here runs natively on the CPU and, compiled by rust-gpu,
//! as SPIR-V on a GPU, and both give the same bits.
//!
//! Nothing here allocates, fails, prints or knows about threads, files or time. A kernel clamps, or writes down what
//! went wrong beside its result, where the host reads it. [`stages!`] lists every kernel with its buffers; the shader crate makes its entry
//! points from that list and the CPU backend its drivers.
#![no_std]

#[cfg(test)]
extern crate std;

pub mod exec;
pub mod gather;
pub mod grid;
pub mod layout;
pub mod num;
pub mod probe;
pub mod rivals;
pub mod sort;
mod stages;
pub mod trace;
