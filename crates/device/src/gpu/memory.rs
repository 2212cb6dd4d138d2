//! Buffers of the GPU.

use super::Gpu;
use crate::error::flag_of;
use crate::{Error, Result};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::{MutexGuard, PoisonError};

/// Largest piece that is read back at once, bytes: it needs a second buffer of that size.
const STAGING_BYTES: u64 = 64 << 20;
/// Smallest buffer for that: most of what is read back fits.
const LEAST_STAGING_BYTES: u64 = 64 << 10;

impl Gpu {
    /// Most bytes that a buffer can have.
    pub(crate) fn largest_buffer(&self) -> u64 {
        self.limits.max_buffer_size.min(self.limits.max_storage_buffer_binding_size)
    }

    /// How often memory was asked of wgpu.
    pub(crate) fn allocations(&self) -> u64 {
        self.allocations.load(Relaxed)
    }

    /// Memory of the GPU. All of it is made here.
    pub(super) fn create_buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.allocations.fetch_add(1, Relaxed);
        let label = Some(label);
        self.device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
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
        // Its name is that of its first buffer; others may have it later.
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        self.checked(|| self.create_buffer(name, bytes, usage)).map_err(|error| Error::OutOfMemory {
            buffer: name.to_string(),
            device: self.name(),
            needed: bytes,
            available: format!("no room for it beside the buffers it holds ({error})"),
            flag: flag_of(name),
        })
    }

    /// Lets go of the memory that is kept for reading back, and of all that nobody has any more.
    pub(crate) fn release(&self) {
        self.staging().clear();
        // What was dropped goes when the device is looked at; if it is lost, the next use of it says so.
        let _ = self.device.poll(wgpu::PollType::Poll);
    }

    pub(crate) fn write(&self, buffer: &wgpu::Buffer, bytes: &[u8]) {
        if !bytes.is_empty() {
            self.queue.write_buffer(buffer, 0, bytes);
        }
    }

    /// Fills memory with a word.
    pub(crate) fn fill(&self, buffer: &wgpu::Buffer, word: u32) {
        if word == 0 {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.clear_buffer(buffer, 0, None);
            self.queue.submit([encoder.finish()]);
        } else {
            self.write(buffer, bytemuck::cast_slice(&vec![word; (buffer.size() / 4) as usize]));
        }
    }

    fn staging(&self) -> MutexGuard<'_, Vec<wgpu::Buffer>> {
        self.staging.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn read(&self, name: &str, buffer: &wgpu::Buffer, to: &mut [u8]) -> Result<()> {
        if to.is_empty() {
            return Ok(());
        }
        let stage = format!("read `{name}`");
        let lost = |reason: String| Error::DeviceLost { device: self.name(), stage: stage.clone(), reason };
        // Whoever reads at the same time finds another one, or makes it.
        let kept = self.staging().pop().filter(|kept| kept.size() >= STAGING_BYTES.min(to.len() as u64));
        let staging = match kept {
            Some(staging) => staging,
            None => {
                let size = (to.len() as u64).next_power_of_two().clamp(LEAST_STAGING_BYTES, STAGING_BYTES);
                let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
                let made = self.checked(|| self.create_buffer("read back", size, usage));
                made.map_err(|error| lost(error.to_string()))?
            }
        };
        for (i, piece) in to.chunks_mut(STAGING_BYTES as usize).enumerate() {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(buffer, i as u64 * STAGING_BYTES, &staging, 0, piece.len() as u64);
            self.queue.submit([encoder.finish()]);
            self.read_mapped(&stage, &staging, piece)?;
        }
        self.staging().push(staging);
        Ok(())
    }

    /// Waits for what was submitted and reads what it left in a buffer that can be mapped.
    pub(super) fn read_mapped(&self, stage: &str, buffer: &wgpu::Buffer, to: &mut [u8]) -> Result<()> {
        buffer.map_async(wgpu::MapMode::Read, ..to.len() as u64, |_| {});
        self.wait(stage)?;
        let mapped = buffer.get_mapped_range(..to.len() as u64).map_err(|error| Error::DeviceLost {
            device: self.name(),
            stage: stage.to_string(),
            reason: error.to_string(),
        })?;
        to.copy_from_slice(&mapped);
        drop(mapped);
        buffer.unmap();
        Ok(())
    }
}
