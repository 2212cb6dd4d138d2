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
mod memory;
mod plan;
mod pool;
mod record;
mod timing;
mod twin;

pub use buffer::{Buffer, BufferBytes};
pub use choice::{DeviceChoice, DeviceChoices, Precision};
pub use compare::{Difference, FirstDifference};
pub use cpu::{LaneOrder, Observed, Observer};
pub use error::Error;
pub use gpu::{AdapterReport, ShaderManifest, adapters, manifest};
pub use kernel::{Access, Binding, Kernel, Masked};
pub use plan::Plan;
pub use record::Record;
pub use timing::StageTime;
pub use twin::StageComparison;

use buffer::Accounts;
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
    accounts: Arc<Accounts>,
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

    /// The CPU, telling `observer` of every stage. It stands in for a GPU with subgroups of 32 lanes: plans have the kernels that they
    /// would have there.
    #[must_use]
    pub fn observed(observer: Arc<dyn Observer>) -> Self {
        Self::new(Backend::Cpu(Cpu::observed(observer)))
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

    /// Opens devices that are to work together, and says in a line each which they are.
    ///
    /// # Errors
    /// Those of [`Device::open_with`], and [`Error::NotExact`] if there are several and one of them is not exact: they would not agree.
    pub fn open_several(choices: &DeviceChoices, precision: Precision) -> Result<Vec<(Self, String)>> {
        let all;
        let choices = match choices {
            DeviceChoices::These(choices) => choices,
            DeviceChoices::AllGpus => {
                let indices = gpu::all(precision).into_iter();
                all = indices.map(|index| DeviceChoice::Gpu(Some(index.to_string()))).collect();
                if Vec::is_empty(&all) { &vec![DeviceChoice::Gpu(None)] } else { &all }
            }
        };
        let devices: Vec<_> = choices.iter().map(|choice| Self::open_with(choice, precision)).collect::<Result<_>>()?;
        match devices.iter().find(|(device, _)| devices.len() > 1 && !device.is_exact()) {
            Some((device, _)) => Err(Error::NotExact {
                device: device.name(),
                reason: "several devices must agree bit for bit, and it is not exact".to_string(),
            }),
            None => Ok(devices),
        }
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
        Self { backend, accounts: Arc::default(), timings: Timings::default() }
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
        match &self.backend {
            Backend::Cpu(cpu) => Some(cpu.subgroup_lanes()),
            Backend::Gpu(gpu) | Backend::Twin(_, gpu, _) => gpu.subgroup_lanes(),
        }
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
}
