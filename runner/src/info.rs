//! `caustic info`.

use crate::Failure;
use caustic_device::adapters;

/// Lists the CPU and all adapters.
pub fn devices(json: bool) -> Result<(), Failure> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let adapters = adapters();
    if json {
        let value = serde_json::json!({ "cpu": { "threads": threads, "exact": true }, "adapters": adapters });
        println!("{value:#}");
        return Ok(());
    }
    println!("cpu    CPU, {threads} threads\n       exact: yes");
    for adapter in &adapters {
        let exact = match (adapter.exact, adapter.reason.as_str()) {
            (true, "") => "yes".to_string(),
            (true, note) => format!("yes, but {note}"),
            (false, reason) if adapter.usable => format!("no, {reason}; --precision fast runs"),
            (false, reason) => format!("no, {reason}"),
        };
        println!(
            "gpu:{:<2} {} ({}, {}, {})\n       exact: {exact}; subgroups of {} to {} lanes; workgroups of up to {} lanes with {} KiB of shared memory; buffers of up to {} MiB",
            adapter.index,
            adapter.name,
            adapter.backend,
            adapter.kind,
            adapter.driver,
            adapter.subgroup[0],
            adapter.subgroup[1],
            adapter.max_workgroup_lanes,
            adapter.workgroup_memory_bytes >> 10,
            adapter.max_buffer_bytes >> 20,
        );
    }
    if adapters.is_empty() {
        println!("no GPU: there is no Vulkan driver (on Debian, mesa-vulkan-drivers has a software one)");
    }
    Ok(())
}
