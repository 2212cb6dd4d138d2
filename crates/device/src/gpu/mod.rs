//! The GPU backend: wgpu, with the SPIR-V handed to the Vulkan driver word for word.
//!
//! wgpu's ordinary path translates shaders and drops the NoContraction decorations that keep a result exact, so kernels are
//! loaded by passthrough, which Vulkan alone offers. Where it is missing, the fast kernels take the ordinary, portable path.

mod adapters;
mod branches;
mod memory;
mod passthrough;
mod pipelines;
mod specialise;
mod stamps;
mod submit;

pub use adapters::{AdapterReport, adapters};
pub(crate) use adapters::{all, open, open_hardware};
pub use pipelines::{ShaderManifest, manifest};

use crate::kernel::Masked;
use crate::{Error, Precision, Result};
use pipelines::Pipeline;
use stamps::Stamps;
use std::collections::HashMap;
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex, PoisonError};

pub(crate) struct Gpu {
    name: String,
    note: String,
    precision: Precision,
    /// Whether wgpu translates the kernels.
    portable: bool,
    /// Whether a CPU plays it.
    software: bool,
    /// Lanes of a subgroup, if kernels can rely on them.
    subgroup_lanes: Option<u32>,
    device: wgpu::Device,
    queue: wgpu::Queue,
    limits: wgpu::Limits,
    pipelines: Mutex<HashMap<Masked, Arc<Pipeline>>>,
    /// Why the device was lost, once it is.
    lost: Arc<Mutex<Option<String>>>,
    /// Buffers through which results are read back, when nobody reads.
    staging: Mutex<Vec<wgpu::Buffer>>,
    /// Time stamps that no plan uses at the moment.
    stamps: Mutex<Vec<Stamps>>,
    allocations: AtomicU64,
    /// Nanoseconds a time stamp counts, where the adapter has time stamps.
    timestamp_period: Option<f32>,
}

impl Gpu {
    pub(crate) fn name(&self) -> String {
        self.name.clone()
    }

    pub(crate) fn is_exact(&self) -> bool {
        self.precision == Precision::Exact && !self.portable
    }

    pub(crate) fn is_software(&self) -> bool {
        self.software
    }

    pub(crate) fn subgroup_lanes(&self) -> Option<u32> {
        self.subgroup_lanes
    }

    /// What its user should know about it, or "".
    pub(crate) fn note(&self) -> &str {
        &self.note
    }

    /// Runs `work` and returns the first error that the driver reports for it.
    fn checked<T>(&self, work: impl FnOnce() -> T) -> std::result::Result<T, wgpu::Error> {
        let scopes = [wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::OutOfMemory]
            .map(|filter| self.device.push_error_scope(filter));
        let result = work();
        let mut first = None;
        for scope in scopes.into_iter().rev() {
            let error = pollster::block_on(scope.pop());
            first = first.or(error);
        }
        first.map_or(Ok(result), Err)
    }

    /// Waits until everything submitted has been executed.
    fn wait(&self, stage: &str) -> Result<()> {
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        let lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let reason = match (waited, lost) {
            (_, Some(reason)) => reason,
            (Err(error), None) => error.to_string(),
            (Ok(_), None) => return Ok(()),
        };
        Err(Error::DeviceLost { device: self.name(), stage: stage.to_string(), reason })
    }
}
