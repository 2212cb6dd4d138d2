//! SPIR-V that reaches the driver word for word: with `photon_file/window.rs` of the renderer, all of caustic that needs `unsafe`.
//!
//! wgpu does not look into a module that it passes through, so it cannot promise that the module is sound, and asks its user
//! to. What stands for that promise: `cargo xtask shaders` validates every module with `spirv-val`; its entry point, workgroup
//! size, bindings and their access are those of `stages!`, which a test compares with what is in the module; and rust-gpu checks
//! the bounds of every access to a buffer. What the device does to a module, a constant for the mask and no blocks that it rules out, was validated
//! likewise, once, for the exact tracing kernels with ten of the masks; a test sees that every mask is understood, not that `spirv-val` accepts it.
#![allow(unsafe_code)]

use crate::kernel::Kernel;
use std::borrow::Cow;

/// Permission to use passthrough, which counts as experimental in wgpu.
pub(super) fn experimental_features() -> wgpu::ExperimentalFeatures {
    // SAFETY: wgpu asks that known bugs of experimental features be acceptable; passthrough's only condition is `load`'s.
    unsafe { wgpu::ExperimentalFeatures::enabled() }
}

/// Hands a kernel's SPIR-V to the driver.
pub(super) fn load(device: &wgpu::Device, kernel: Kernel, words: Vec<u32>) -> wgpu::ShaderModule {
    let entry_point = wgpu::PassthroughShaderEntryPoint {
        name: Cow::Borrowed(kernel.entry_point()),
        workgroup_size: (kernel.lanes(), 1, 1),
    };
    let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
        label: Some(kernel.entry_point()),
        entry_points: Cow::Borrowed(&[entry_point]),
        spirv: Some(Cow::Owned(words)),
        ..Default::default()
    };
    // SAFETY: the module is sound, for the reasons at the top of this file.
    unsafe { device.create_shader_module_passthrough(descriptor) }
}
