//! The embedded SPIR-V, and the pipelines made of it.

use super::{Gpu, branches, passthrough, specialise};
use crate::kernel::{Access, Kernel, Masked};
use crate::{Error, Result};
use serde::Deserialize;
use std::sync::{Arc, PoisonError};

const MANIFEST: &str = include_str!("../../shaders/manifest.json");

/// What `cargo xtask shaders` wrote down about the SPIR-V.
#[derive(Clone, Debug, Deserialize)]
pub struct ShaderManifest {
    /// Its entry points.
    pub entry_points: Vec<EntryPoint>,
}

/// An entry point of the SPIR-V.
#[derive(Clone, Debug, Deserialize)]
pub struct EntryPoint {
    /// Its name.
    pub name: String,
    /// Lanes of a workgroup along each axis.
    pub local_size: [u32; 3],
    /// Its buffers.
    pub bindings: Vec<EntryBinding>,
}

/// A buffer of an entry point.
#[derive(Clone, Debug, Deserialize)]
pub struct EntryBinding {
    /// Descriptor set.
    pub set: u32,
    /// Binding number.
    pub binding: u32,
}

/// What `cargo xtask shaders` wrote down about the embedded SPIR-V.
///
/// # Panics
/// If the file that was embedded when caustic was built is broken; a test reads it.
#[must_use]
pub fn manifest() -> ShaderManifest {
    serde_json::from_str(MANIFEST).expect("crates/device/shaders/manifest.json is written by `cargo xtask shaders`")
}

/// A kernel, ready to run.
pub(super) struct Pipeline {
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) layout: wgpu::BindGroupLayout,
}

/// The largest number of buffers that a kernel has.
pub(super) fn most_bindings() -> u32 {
    Kernel::ALL.iter().map(|kernel| kernel.bindings().len()).max().unwrap_or(0) as u32
}

impl Gpu {
    /// The pipeline of a kernel that knows so much, made when it is first used.
    pub(super) fn pipeline(&self, masked: Masked) -> Result<Arc<Pipeline>> {
        let mut pipelines = self.pipelines.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pipeline) = pipelines.get(&masked) {
            return Ok(Arc::clone(pipeline));
        }
        let made = self.checked(|| self.make_pipeline(masked)).map_err(|error| Error::Stage {
            device: self.name(),
            stage: masked.kernel.entry_point().to_string(),
            reason: error.to_string(),
        })?;
        let made = Arc::new(made);
        pipelines.insert(masked, Arc::clone(&made));
        Ok(made)
    }

    /// The module of a kernel, with its mask as a constant: word for word, or translated where that is not possible.
    fn load(&self, Masked { kernel, known }: Masked) -> wgpu::ShaderModule {
        let words = branches::without_unreachable(specialise::with(&kernel.words(self.precision), known));
        if !self.portable {
            return passthrough::load(&self.device, kernel, words);
        }
        self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(kernel.entry_point()),
            source: wgpu::ShaderSource::SpirV(words.into()),
        })
    }

    fn make_pipeline(&self, masked: Masked) -> Pipeline {
        let kernel = masked.kernel;
        let label = Some(kernel.entry_point());
        let entries: Vec<_> = kernel
            .bindings()
            .iter()
            .enumerate()
            .map(|(i, binding)| wgpu::BindGroupLayoutEntry {
                binding: i as u32,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage {
                        read_only: matches!(binding.access, Access::One | Access::In),
                    },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            })
            .collect();
        let layout =
            self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
        let pipeline_layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: Some(&pipeline_layout),
            module: &self.load(masked),
            entry_point: label,
            // Kernels write shared memory before they read it; passthrough would not zero it anyway.
            compilation_options: wgpu::PipelineCompilationOptions {
                zero_initialize_workgroup_memory: false,
                ..Default::default()
            },
            cache: None,
        });
        Pipeline { pipeline, layout }
    }
}
