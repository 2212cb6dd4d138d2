//! Watching what a CPU device runs.

use crate::{Kernel, Result};

/// A stage that has just run.
pub struct Observed<'a> {
    /// Its name, with its scope.
    pub stage: &'a str,
    /// Its kernel.
    pub kernel: Kernel,
    /// What it knows, if it takes a mask.
    pub known: u32,
    /// How many workgroups ran.
    pub groups: u32,
    /// The words of its buffers after it ran, in the order of their bindings. Those that it reads are as it found them.
    pub buffers: &'a [&'a [u32]],
}

/// Told of every stage that a [`Device::observed`](crate::Device::observed) runs.
pub trait Observer: Send + Sync {
    /// Called before each stage. An error ends the plan in its place: a device that is lost, for tests of those who use one.
    ///
    /// # Errors
    /// Whatever the device is to fail with.
    fn begin(&self, _stage: &str) -> Result<()> {
        Ok(())
    }

    /// Called after each stage.
    fn observe(&self, stage: &Observed<'_>);
}
