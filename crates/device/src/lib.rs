//! Runs a [`Plan`], a list of kernel stages over named buffers, on the CPU or on a Vulkan GPU.
//!
//! Both backends execute the same list with the same kernel bodies: the CPU calls them from rayon threads, the GPU runs the
//! SPIR-V that rust-gpu made of them. Progress, timing, memory accounting and errors all hang on the names in the list.

mod buffer;
mod choice;
mod compare;
mod cpu;
mod error;
mod gpu;
mod kernel;
mod plan;
mod record;
mod timing;
mod twin;

pub use buffer::{Buffer, BufferBytes};
pub use choice::{DeviceChoice, Precision};
pub use compare::{Difference, FirstDifference};
pub use cpu::LaneOrder;
pub use error::Error;
pub use gpu::{AdapterReport, ShaderManifest, adapters, manifest};
pub use kernel::{Access, Binding, Kernel};
pub use plan::Plan;
pub use record::Record;
pub use timing::StageTime;
pub use twin::StageComparison;

use buffer::{Ledger, Storage};
use bytemuck::Pod;
use cpu::Cpu;
use gpu::Gpu;
use std::sync::Arc;
use timing::Timings;
use twin::Comparisons;

/// The result of device operations.
pub type Result<T> = std::result::Result<T, Error>;

/// A device that executes plans.
pub struct Device {
    backend: Backend,
    ledger: Arc<Ledger>,
    timings: Timings,
}

enum Backend {
    Cpu(Cpu),
    Gpu(Arc<Gpu>),
    /// Both at once, each stage compared.
    Twin(Cpu, Arc<Gpu>, Comparisons),
}

impl Device {
    /// The CPU, all its cores.
    #[must_use]
    pub fn cpu() -> Self {
        Self::cpu_with_order(LaneOrder::Forward)
    }

    /// The CPU, with workgroups and lanes visited in the given order. Results do not depend on it; tests show that.
    #[must_use]
    pub fn cpu_with_order(order: LaneOrder) -> Self {
        Self::new(Backend::Cpu(Cpu::new(order)))
    }

    /// Opens the device that `choice` asks for, exact, and says in one line which that is and why.
    ///
    /// # Errors
    /// [`Error::NoSuchDevice`] if there is none; [`Error::NotExact`] if it cannot run the exact kernels.
    pub fn open(choice: &DeviceChoice) -> Result<(Self, String)> {
        Self::open_with(choice, Precision::Exact)
    }

    /// Opens a device with the given precision. The CPU has only one: its own division and root are exact.
    ///
    /// # Errors
    /// [`Error::NoSuchDevice`] if there is none; [`Error::NotExact`] if it cannot run the kernels of that precision.
    pub fn open_with(choice: &DeviceChoice, precision: Precision) -> Result<(Self, String)> {
        let (gpu, why) = match choice {
            DeviceChoice::Cpu => return Ok((Self::cpu(), format!("device: {} (asked for)", cpu::name()))),
            DeviceChoice::Auto => match gpu::open_hardware(precision)? {
                Some(gpu) => (gpu, "a hardware GPU is present".to_string()),
                None => return Ok((Self::cpu(), format!("device: {} (no hardware GPU found)", cpu::name()))),
            },
            DeviceChoice::Gpu(wanted) => {
                let gpu = gpu::open(wanted.as_deref(), precision)?;
                let note = gpu.note();
                let why = if note.is_empty() { "asked for".to_string() } else { format!("asked for; {note}") };
                (gpu, why)
            }
        };
        let line = format!("device: {} ({why})", gpu.name());
        Ok((Self::new(Backend::Gpu(Arc::new(gpu))), line))
    }

    /// This GPU and the CPU as one device: every stage runs on both, and what it writes is compared. The GPU then goes on with
    /// the CPU's words, so that each stage is judged by itself; from the stage `from` on, with its own. Reading gives the CPU's.
    ///
    /// # Panics
    /// If this device is not a GPU.
    #[must_use]
    pub fn twin(&self, from: Option<Kernel>) -> Self {
        let Backend::Gpu(gpu) = &self.backend else { panic!("{} is not a GPU", self.name()) };
        let cpu = Cpu::new(LaneOrder::Forward);
        Self::new(Backend::Twin(cpu, Arc::clone(gpu), Comparisons::new(from)))
    }

    /// What comparing the stages of a [`Device::twin`] found so far, in the order of first use; nothing for other devices.
    #[must_use]
    pub fn comparisons(&self) -> Vec<StageComparison> {
        match &self.backend {
            Backend::Twin(_, _, comparisons) => comparisons.report(),
            _ => Vec::new(),
        }
    }

    fn new(backend: Backend) -> Self {
        Self { backend, ledger: Arc::default(), timings: Timings::default() }
    }

    /// The device's name.
    #[must_use]
    pub fn name(&self) -> String {
        match &self.backend {
            Backend::Cpu(_) => cpu::name(),
            Backend::Gpu(gpu) | Backend::Twin(_, gpu, _) => gpu.name(),
        }
    }

    /// Whether it is a GPU (a software Vulkan counts as one).
    #[must_use]
    pub fn is_gpu(&self) -> bool {
        !matches!(self.backend, Backend::Cpu(_))
    }

    /// Whether it is a GPU that a CPU plays.
    #[must_use]
    pub fn is_software_gpu(&self) -> bool {
        self.gpu_half().is_some_and(Gpu::is_software)
    }

    /// Lanes of a subgroup, where kernels may use subgroup operations; the CPU takes any kernel.
    #[must_use]
    pub fn subgroup_lanes(&self) -> Option<u32> {
        self.gpu_half().map_or(Some(1), Gpu::subgroup_lanes)
    }

    /// Whether its results are promised to be those of the CPU, bit for bit.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        match &self.backend {
            Backend::Cpu(_) => true,
            Backend::Gpu(gpu) | Backend::Twin(_, gpu, _) => gpu.is_exact(),
        }
    }

    /// The largest buffer that it takes, bytes.
    #[must_use]
    pub fn largest_buffer(&self) -> u64 {
        self.gpu_half().map_or(u64::MAX, Gpu::largest_buffer)
    }

    /// A buffer of `count` records, all zero. `name` appears in errors and in the memory report.
    ///
    /// # Errors
    /// [`Error::BufferTooLarge`] and [`Error::OutOfMemory`].
    pub fn buffer<T: Pod>(&self, name: &str, count: u64) -> Result<Buffer> {
        const { assert!(align_of::<T>() <= 4 && size_of::<T>().is_multiple_of(4)) };
        // A buffer of nothing cannot be bound, so it holds one record that nobody reads.
        let bytes = count.max(1).saturating_mul(size_of::<T>() as u64);
        let storage = Storage {
            cpu: self.cpu_half().map(|_| cpu::allocate(name, bytes)).transpose()?,
            gpu: self.gpu_half().map(|gpu| gpu.allocate(name, bytes)).transpose()?,
        };
        Ok(Buffer::new(name, bytes, storage, &self.ledger))
    }

    /// A buffer that holds `data`.
    ///
    /// # Errors
    /// Those of [`Device::buffer`].
    pub fn upload<T: Pod>(&self, name: &str, data: &[T]) -> Result<Buffer> {
        let buffer = self.buffer::<T>(name, data.len() as u64)?;
        self.write(&buffer, data);
        Ok(buffer)
    }

    /// Overwrites the first records of a buffer.
    ///
    /// # Panics
    /// If the buffer is shorter than `data`.
    pub fn write<T: Pod>(&self, buffer: &Buffer, data: &[T]) {
        let words: &[u32] = bytemuck::cast_slice(data);
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

    fn cpu_half(&self) -> Option<&Cpu> {
        match &self.backend {
            Backend::Cpu(cpu) | Backend::Twin(cpu, _, _) => Some(cpu),
            Backend::Gpu(_) => None,
        }
    }

    fn gpu_half(&self) -> Option<&Gpu> {
        match &self.backend {
            Backend::Gpu(gpu) | Backend::Twin(_, gpu, _) => Some(gpu),
            Backend::Cpu(_) => None,
        }
    }

    /// Executes a plan, in one submission, and waits for it.
    ///
    /// # Errors
    /// [`Error::DeviceLost`] and [`Error::Stage`].
    pub fn run(&self, plan: &Plan) -> Result<()> {
        match &self.backend {
            Backend::Cpu(cpu) => cpu.run(plan, &self.timings),
            Backend::Gpu(gpu) => gpu.run(plan, &self.timings),
            Backend::Twin(cpu, gpu, comparisons) => comparisons.run(plan, cpu, gpu, &self.timings),
        }
    }

    /// How often each stage ran and for how long in all, in the order of first use: GPU time stamps, or wall clock on the CPU.
    #[must_use]
    pub fn stage_times(&self) -> Vec<StageTime> {
        self.timings.report()
    }

    /// Forgets the times so far.
    pub fn reset_stage_times(&self) {
        self.timings.reset();
    }

    /// Bytes of each buffer name, now and at the most, in the order of first use.
    #[must_use]
    pub fn buffer_bytes(&self) -> Vec<BufferBytes> {
        self.ledger.report()
    }

    /// Bytes of all buffers together, now and at the most.
    #[must_use]
    pub fn total_bytes(&self) -> (u64, u64) {
        self.ledger.total()
    }
}
