//! Which GPUs there are, and opening one.

use super::{Gpu, passthrough, pipelines};
use crate::{Error, Precision, Result};
use pollster::block_on;
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex, PoisonError};

/// What `caustic info` says of an adapter.
#[derive(Clone, Debug, serde::Serialize)]
pub struct AdapterReport {
    /// Number by which `--device gpu:N` asks for it.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// Vulkan, Metal, Dx12 or Gl.
    pub backend: String,
    /// Discrete, integrated, virtual or software.
    pub kind: String,
    /// The driver and its version.
    pub driver: String,
    /// Smallest and largest number of lanes of a subgroup.
    pub subgroup: [u32; 2],
    /// Largest buffer that a kernel can use, bytes.
    pub max_buffer_bytes: u64,
    /// Largest number of lanes of a workgroup.
    pub max_workgroup_lanes: u32,
    /// Shared memory of a workgroup, bytes.
    pub workgroup_memory_bytes: u32,
    /// Whether the exact kernels run on it.
    pub exact: bool,
    /// Whether kernels run on it at all; if not exactly, then by wgpu's translation of the fast ones.
    pub usable: bool,
    /// Why not; or what to know about it; or "".
    pub reason: String,
}

fn instance() -> wgpu::Instance {
    // WGPU_VALIDATION=1 in the environment turns the Vulkan validation layers on.
    wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env())
}

fn enumerate() -> Vec<wgpu::Adapter> {
    block_on(instance().enumerate_adapters(wgpu::Backends::all()))
}

/// The environment variable that has every GPU treated as one without passthrough.
const PORTABLE: &str = "CAUSTIC_PORTABLE";

/// Mesa's software Vulkan ends all loops of an invocation after 65,535 iterations together (its constant
/// `LP_MAX_TGSI_LOOP_ITERATIONS`) and says nothing; caustic notices.
const LLVMPIPE: &str = "it cannot search hundreds of thousands of photons for one point: then there is an error";

fn is_llvmpipe(info: &wgpu::AdapterInfo) -> bool {
    info.name.to_lowercase().contains("llvmpipe")
}

fn report(index: usize, adapter: &wgpu::Adapter) -> AdapterReport {
    let info = adapter.get_info();
    let limits = adapter.limits();
    let usable = limits.max_storage_buffers_per_shader_stage >= pipelines::most_bindings();
    let reason = if !usable {
        "the driver allows too few storage buffers a stage"
    } else if std::env::var_os(PORTABLE).is_some() {
        "CAUSTIC_PORTABLE asks for the portable path"
    } else if info.backend != wgpu::Backend::Vulkan {
        "only Vulkan takes SPIR-V unchanged"
    } else if !adapter.features().contains(wgpu::Features::PASSTHROUGH_SHADERS) {
        "the driver does not offer shader passthrough"
    } else {
        ""
    };
    let exact = reason.is_empty();
    let reason = if exact && is_llvmpipe(&info) { LLVMPIPE } else { reason };
    AdapterReport {
        index,
        name: info.name,
        backend: format!("{:?}", info.backend),
        kind: match info.device_type {
            wgpu::DeviceType::DiscreteGpu => "discrete",
            wgpu::DeviceType::IntegratedGpu => "integrated",
            wgpu::DeviceType::VirtualGpu => "virtual",
            wgpu::DeviceType::Cpu => "software",
            wgpu::DeviceType::Other => "other",
        }
        .to_string(),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_string(),
        subgroup: [info.subgroup_min_size, info.subgroup_max_size],
        max_buffer_bytes: limits.max_buffer_size.min(limits.max_storage_buffer_binding_size),
        max_workgroup_lanes: limits.max_compute_invocations_per_workgroup,
        workgroup_memory_bytes: limits.max_compute_workgroup_storage_size,
        exact,
        usable,
        reason: reason.to_string(),
    }
}

/// All adapters of this machine.
#[must_use]
pub fn adapters() -> Vec<AdapterReport> {
    enumerate().iter().enumerate().map(|(i, adapter)| report(i, adapter)).collect()
}

fn runs(report: &AdapterReport, precision: Precision) -> bool {
    report.exact || (precision == Precision::Fast && report.usable)
}

/// The first hardware GPU that can run kernels of this precision, if there is one.
pub(crate) fn open_hardware(precision: Precision) -> Result<Option<Gpu>> {
    for (i, adapter) in enumerate().into_iter().enumerate() {
        let report = report(i, &adapter);
        if runs(&report, precision) && report.kind != "software" {
            return open_adapter(&adapter, &report, precision).map(Some);
        }
    }
    Ok(None)
}

/// Indices of all hardware GPUs that can run kernels of this precision; of the software ones if there is no hardware.
pub(crate) fn all(precision: Precision) -> Vec<usize> {
    let reports: Vec<_> = adapters().into_iter().filter(|report| runs(report, precision)).collect();
    let hardware = reports.iter().any(|report| report.kind != "software");
    reports.iter().filter(|report| (report.kind == "software") != hardware).map(|report| report.index).collect()
}

/// The GPU with this index or with this text in its name; without either the first that can run kernels of this precision,
/// exact before portable and hardware before software.
pub(crate) fn open(wanted: Option<&str>, precision: Precision) -> Result<Gpu> {
    let adapters = enumerate();
    let reports: Vec<_> = adapters.iter().enumerate().map(|(i, adapter)| report(i, adapter)).collect();
    let chosen = match wanted {
        None => {
            let exact = |software: bool| reports.iter().find(|r| r.exact && (r.kind == "software") == software);
            let usable = || reports.iter().find(|report| runs(report, precision));
            exact(false).or_else(|| exact(true)).or_else(usable).or(reports.first())
        }
        Some(text) => {
            let by_index = text.parse::<usize>().ok().and_then(|i| reports.get(i));
            let named = |r: &&AdapterReport| r.name.to_lowercase().contains(&text.to_lowercase());
            // The same hardware may appear under several backends: Vulkan is the one that is exact.
            by_index.or_else(|| reports.iter().filter(|r| r.exact).find(named)).or_else(|| reports.iter().find(named))
        }
    };
    let Some(chosen) = chosen else {
        let names: Vec<_> = reports.iter().map(|r| format!("gpu:{} {}", r.index, r.name)).collect();
        return Err(Error::NoSuchDevice {
            wanted: wanted.map_or("gpu".to_string(), |text| format!("gpu:{text}")),
            available: if names.is_empty() { "none".to_string() } else { names.join(", ") },
        });
    };
    open_adapter(&adapters[chosen.index], chosen, precision)
}

fn open_adapter(adapter: &wgpu::Adapter, report: &AdapterReport, precision: Precision) -> Result<Gpu> {
    let not_exact = |reason: String| Error::NotExact { device: report.name.clone(), reason };
    if !runs(report, precision) {
        return Err(not_exact(report.reason.clone()));
    }
    let limits = adapter.limits();
    let timestamps = adapter.features() & wgpu::Features::TIMESTAMP_QUERY;
    let passthrough = if report.exact { wgpu::Features::PASSTHROUGH_SHADERS } else { wgpu::Features::empty() };
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("caustic"),
        required_features: passthrough | timestamps,
        required_limits: limits.clone(),
        experimental_features: passthrough::experimental_features(),
        ..Default::default()
    };
    let (device, queue) = block_on(adapter.request_device(&descriptor)).map_err(|e| not_exact(e.to_string()))?;
    let lost = Arc::new(Mutex::new(None));
    let lost_by_callback = Arc::clone(&lost);
    device.set_device_lost_callback(move |reason, message| {
        *lost_by_callback.lock().unwrap_or_else(PoisonError::into_inner) = Some(format!("{reason:?}: {message}"));
    });
    let timestamp_period = (!timestamps.is_empty()).then(|| queue.get_timestamp_period());
    let note = match (report.exact, precision) {
        (true, Precision::Fast) => "fast: not exact".to_string(),
        (true, Precision::Exact) => report.reason.clone(),
        (false, _) => format!("portable path: not exact here, {}", report.reason),
    };
    Ok(Gpu {
        name: format!("{} ({}, {})", report.name, report.backend, report.driver),
        note,
        precision,
        portable: !report.exact,
        software: report.kind == "software",
        // Where the size can vary, subgroups need not be full. wgpu's translation of subgroup operations is another's word. The kernels
        // that use them have up to 512 lanes.
        subgroup_lanes: (report.exact && report.subgroup[0] == report.subgroup[1] && report.max_workgroup_lanes >= 512)
            .then_some(report.subgroup[0]),
        device,
        queue,
        limits,
        pipelines: Mutex::default(),
        staging: Mutex::default(),
        stamps: Mutex::default(),
        allocations: AtomicU64::new(0),
        lost,
        timestamp_period,
    })
}
