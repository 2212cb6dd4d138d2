//! Buffers of the GPU.

use super::Gpu;
use crate::error::flag_of;
use crate::{Error, Result};

/// Largest piece that is read back at once, bytes: it needs a second buffer of that size.
const STAGING_BYTES: u64 = 64 << 20;

impl Gpu {
    /// The largest buffer that a stage can have, bytes.
    pub(crate) fn largest_buffer(&self) -> u64 {
        self.limits.max_buffer_size.min(self.limits.max_storage_buffer_binding_size)
    }

    pub(crate) fn allocate(&self, name: &str, bytes: u64) -> Result<wgpu::Buffer> {
        let available = self.largest_buffer();
        if bytes > available {
            return Err(Error::BufferTooLarge {
                buffer: name.to_string(),
                device: self.name(),
                needed: bytes,
                available,
                flag: flag_of(name),
            });
        }
        let descriptor = wgpu::BufferDescriptor {
            label: Some(name),
            size: bytes,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        };
        self.checked(|| self.device.create_buffer(&descriptor)).map_err(|error| Error::OutOfMemory {
            buffer: name.to_string(),
            device: self.name(),
            needed: bytes,
            available: format!("no room for it beside the buffers it holds ({error})"),
            flag: flag_of(name),
        })
    }

    pub(crate) fn write(&self, buffer: &wgpu::Buffer, bytes: &[u8]) {
        if !bytes.is_empty() {
            self.queue.write_buffer(buffer, 0, bytes);
        }
    }

    pub(crate) fn read(&self, name: &str, buffer: &wgpu::Buffer, to: &mut [u8]) -> Result<()> {
        if to.is_empty() {
            return Ok(());
        }
        let stage = format!("read `{name}`");
        let lost = |reason: String| Error::DeviceLost { device: self.name(), stage: stage.clone(), reason };
        let staging = self
            .checked(|| {
                self.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("read back"),
                    size: STAGING_BYTES.min(to.len() as u64),
                    usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                })
            })
            .map_err(|error| lost(error.to_string()))?;
        for (i, piece) in to.chunks_mut(STAGING_BYTES as usize).enumerate() {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(buffer, i as u64 * STAGING_BYTES, &staging, 0, piece.len() as u64);
            self.queue.submit([encoder.finish()]);
            staging.map_async(wgpu::MapMode::Read, ..piece.len() as u64, |_| {});
            self.wait(&stage)?;
            let mapped = staging.get_mapped_range(..piece.len() as u64).map_err(|error| lost(error.to_string()))?;
            piece.copy_from_slice(&mapped);
            drop(mapped);
            staging.unmap();
        }
        Ok(())
    }
}
