//! The buffers of a device: where their memory is from, what is in it, and how much it is.

use crate::buffer::BufferBytes;
use crate::cpu::Cpu;
use crate::gpu::Gpu;
use crate::pool::{Storage, size_class};
use crate::{Backend, Buffer, Device, Error, Result, cpu};
use bytemuck::Pod;

/// What memory holds where nothing may depend on it: as a float a small negative number, as an index beyond any buffer.
const RUBBISH: u32 = 0xa5a5_a5a5;

impl Device {
    /// A buffer of `count` records, all zero. `name` appears in errors and in the memory report.
    ///
    /// # Errors
    /// [`Error::BufferTooLarge`] and [`Error::OutOfMemory`].
    pub fn buffer<T: Pod>(&self, name: &str, count: u64) -> Result<Buffer> {
        let (buffer, new) = self.take::<T>(name, count)?;
        if !new {
            self.fill(&buffer, 0);
        }
        Ok(buffer)
    }

    /// [`Device::buffer`] for what is written before it is read: it holds whatever the memory held before.
    ///
    /// # Errors
    /// Those of [`Device::buffer`].
    pub fn scratch<T: Pod>(&self, name: &str, count: u64) -> Result<Buffer> {
        match &self.backend {
            // Whole buffers are compared, also what a stage leaves as it was.
            Backend::Twin(..) => self.buffer::<T>(name, count),
            Backend::Cpu(cpu) if cpu.begins_with_rubbish() => {
                let (buffer, _) = self.take::<T>(name, count)?;
                self.fill(&buffer, RUBBISH);
                Ok(buffer)
            }
            Backend::Cpu(_) | Backend::Gpu(_) => Ok(self.take::<T>(name, count)?.0),
        }
    }

    /// A buffer, and whether its memory is new and therefore zero.
    fn take<T: Pod>(&self, name: &str, count: u64) -> Result<(Buffer, bool)> {
        const { assert!(align_of::<T>() <= 4 && size_of::<T>().is_multiple_of(4)) };
        // A buffer of nothing cannot be bound, so it holds one record that nobody reads.
        let bytes = count.max(1).saturating_mul(size_of::<T>() as u64);
        let most = self.gpu_half().map_or(u64::MAX, Gpu::largest_buffer);
        let class = Some(size_class(bytes)).filter(|&class| class <= most).unwrap_or(bytes);
        let kept = self.accounts.pool.take(class);
        let new = kept.is_none();
        let mut storage = match kept {
            Some(storage) => storage,
            None => match self.allocate(name, class) {
                // What is kept for other buffers may be what is missing.
                Err(Error::OutOfMemory { .. }) if self.trim() > 0 => self.allocate(name, class)?,
                made => made?,
            },
        };
        storage.fit(bytes);
        Ok((Buffer::new(name, bytes, storage, &self.accounts), new))
    }

    fn allocate(&self, name: &str, bytes: u64) -> Result<Storage> {
        Ok(Storage {
            bytes,
            cpu: self.cpu_half().map(|cpu| cpu.allocate(name, bytes)).transpose()?,
            gpu: self.gpu_half().map(|gpu| gpu.allocate(name, bytes)).transpose()?,
        })
    }

    /// Fills a buffer with a word.
    fn fill(&self, buffer: &Buffer, word: u32) {
        if self.cpu_half().is_some() {
            cpu::lock_write(buffer.on_cpu()).fill(word);
        }
        if let Some(gpu) = self.gpu_half() {
            gpu.fill(buffer.on_gpu(), word);
        }
    }

    /// Gives the memory that dropped buffers left, and that the device keeps for the next ones, back to the system; returns how many
    /// bytes. A device never holds more than twice what its buffers had at once, or that and 64 MiB.
    pub fn trim(&self) -> u64 {
        let bytes = self.accounts.pool.empty();
        if let Some(gpu) = self.gpu_half() {
            gpu.release();
        }
        bytes
    }

    /// Fills the memory that dropped buffers left with rubbish. Nothing may depend on it, which tests show with this.
    pub fn spoil(&self) {
        self.accounts.pool.for_each(|storage| {
            if let Some(memory) = &storage.cpu {
                cpu::lock_write(memory).fill(RUBBISH);
            }
            if let (Some(gpu), Some(memory)) = (self.gpu_half(), &storage.gpu) {
                gpu.fill(memory, RUBBISH);
            }
        });
    }

    /// Bytes that the device keeps for the next buffers.
    #[must_use]
    pub fn kept_bytes(&self) -> u64 {
        self.accounts.pool.bytes()
    }

    /// How often memory was asked of the system for a buffer, or on a GPU for anything that is as large: a second frame like the
    /// first does not.
    #[must_use]
    pub fn allocations(&self) -> u64 {
        self.cpu_half().map_or(0, Cpu::allocations) + self.gpu_half().map_or(0, Gpu::allocations)
    }

    /// A buffer that holds `data`.
    ///
    /// # Errors
    /// Those of [`Device::buffer`].
    pub fn upload<T: Pod>(&self, name: &str, data: &[T]) -> Result<Buffer> {
        let buffer = self.scratch::<T>(name, data.len() as u64)?;
        self.write(&buffer, data);
        Ok(buffer)
    }

    /// Overwrites the first records of a buffer.
    ///
    /// # Panics
    /// If the buffer is shorter than `data`.
    pub fn write<T: Pod>(&self, buffer: &Buffer, data: &[T]) {
        let words: &[u32] = bytemuck::cast_slice(data);
        assert!(size_of_val(words) as u64 <= buffer.bytes(), "`{}` is written past its end", buffer.name());
        if self.cpu_half().is_some() {
            cpu::lock_write(buffer.on_cpu())[..words.len()].copy_from_slice(words);
        }
        if let Some(gpu) = self.gpu_half() {
            gpu.write(buffer.on_gpu(), bytemuck::cast_slice(words));
        }
    }

    /// The first `count` records of a buffer.
    ///
    /// # Errors
    /// [`Error::DeviceLost`].
    ///
    /// # Panics
    /// If the buffer is shorter than that.
    pub fn read<T: Pod>(&self, buffer: &Buffer, count: u64) -> Result<Vec<T>> {
        assert!(count * size_of::<T>() as u64 <= buffer.bytes(), "`{}` is read past its end", buffer.name());
        if self.cpu_half().is_some() {
            let memory = cpu::lock_read(buffer.on_cpu());
            let records: &[T] = bytemuck::cast_slice(&memory[..count as usize * size_of::<T>() / 4]);
            return Ok(records.to_vec());
        }
        let mut records = vec![T::zeroed(); count as usize];
        if let Some(gpu) = self.gpu_half() {
            gpu.read(buffer.name(), buffer.on_gpu(), bytemuck::cast_slice_mut(&mut records))?;
        }
        Ok(records)
    }

    /// Bytes of each buffer name, now and at the most, in the order of first use.
    #[must_use]
    pub fn buffer_bytes(&self) -> Vec<BufferBytes> {
        self.accounts.ledger.report()
    }

    /// Forgets the most bytes so far: [`Device::total_bytes`] has the most from here on.
    pub fn reset_peak_bytes(&self) {
        self.accounts.ledger.reset_peak();
    }

    /// Bytes of all buffers together, now and at the most. What the device keeps for the next ones is not in it.
    #[must_use]
    pub fn total_bytes(&self) -> (u64, u64) {
        self.accounts.ledger.total()
    }
}
