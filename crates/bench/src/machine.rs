//! What a record says of the machine and of the program.

use caustic_device::{Device, adapters};
use serde::{Deserialize, Serialize};

/// Where rows were measured, and with what.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// The device, with its driver if it is a GPU.
    pub device: String,
    /// The GPU's driver; empty on a CPU.
    pub driver: String,
    /// Whether results are exact there.
    pub exact: bool,
    /// The CPU.
    pub cpu: String,
    /// Threads that caustic uses on the CPU.
    pub threads: usize,
    /// Version of caustic.
    pub caustic: String,
    /// The commit that the program was built from; changes that were not committed do not show. Empty if unknown.
    pub commit: String,
    /// The compiler.
    pub rustc: String,
    /// Operating system and architecture.
    pub system: String,
}

impl Machine {
    /// Whether the device is a GPU.
    #[must_use]
    pub fn is_gpu(&self) -> bool {
        !self.driver.is_empty()
    }

    /// This machine, with this device.
    #[must_use]
    pub fn of(device: &Device) -> Self {
        let name = device.name();
        let driver = if device.is_gpu() {
            let own = adapters().into_iter().find(|a| name.starts_with(&a.name) && name.contains(&a.backend));
            own.map_or(String::new(), |adapter| adapter.driver)
        } else {
            String::new()
        };
        Self {
            device: name,
            driver,
            exact: device.is_exact(),
            cpu: cpu(),
            threads: rayon::current_num_threads(),
            caustic: env!("CARGO_PKG_VERSION").to_string(),
            commit: env!("CAUSTIC_COMMIT").to_string(),
            rustc: env!("CAUSTIC_RUSTC").to_string(),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        }
    }

    /// The device for people: on a CPU, which one.
    #[must_use]
    pub fn title(&self) -> String {
        if self.is_gpu() { self.device.clone() } else { format!("{} ({})", self.device, self.cpu) }
    }
}

/// The CPU's name, where the system tells (Linux).
fn cpu() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("model name"));
    line.and_then(|line| line.split_once(':')).map_or("unknown CPU".to_string(), |(_, name)| name.trim().to_string())
}

/// Memory that can still be had, bytes, where the system tells (Linux).
pub(crate) fn available_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("MemAvailable:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kib| kib * 1024)
}

/// The name by which a target asks for this device: `h100`, `cpu2`, ….
pub(crate) fn is_device(kind: &str, device: &Device) -> bool {
    match kind.strip_prefix("cpu") {
        Some(threads) => !device.is_gpu() && threads.parse() == Ok(rayon::current_num_threads()),
        None => device.is_gpu() && device.name().to_lowercase().contains(&kind.to_lowercase()),
    }
}
