//! The SPIR-V and the kernels belong together.

use caustic_device::{Access, Kernel, manifest};
use caustic_kernels::gather::{CAPACITIES, COLUMN_LANES, GATHER_LANES};
use caustic_kernels::grid::GRID_BLOCK;
use caustic_kernels::probe::LAYOUTS;
use caustic_kernels::rivals::{BRUTE_TILE, CELLS_LANES};
use caustic_kernels::sort::{SCAN_LANES, SORT_BLOCK};
use std::collections::{BTreeMap, BTreeSet};

const MANIFEST: &str = include_str!("../../crates/device/shaders/manifest.json");

#[test]
fn the_spirv_has_the_entry_point_of_every_kernel_and_no_other() {
    let kernels: BTreeSet<_> = Kernel::ALL.iter().map(|kernel| kernel.entry_point().to_string()).collect();
    let entries: Vec<_> = manifest().entry_points.into_iter().map(|entry| entry.name).collect();
    assert_eq!(kernels.len(), Kernel::ALL.len(), "two kernels share an entry point");
    assert_eq!(entries.iter().cloned().collect::<BTreeSet<_>>(), kernels);
    assert_eq!(entries.len(), kernels.len(), "an entry point is listed twice");
}

#[test]
fn entry_points_have_the_lanes_and_the_bindings_of_their_kernels() {
    let entries: BTreeMap<_, _> =
        manifest().entry_points.into_iter().map(|entry| (entry.name.clone(), entry)).collect();
    for kernel in Kernel::ALL {
        let entry = &entries[kernel.entry_point()];
        assert_eq!(entry.local_size, [kernel.lanes(), 1, 1], "{}", entry.name);
        let found: Vec<_> = entry.bindings.iter().map(|binding| (binding.set, binding.binding)).collect();
        let expected: Vec<_> = (0..).zip(kernel.bindings()).map(|(i, _)| (0, i)).collect();
        assert_eq!(found, expected, "{}", entry.name);
    }
}

/// wgpu lays a read-only buffer out as such, and a shader that wrote it would be undefined.
#[test]
fn entry_points_write_what_their_kernels_write() {
    let manifest: serde_json::Value = serde_json::from_str(MANIFEST).unwrap();
    let entries = manifest["entry_points"].as_array().unwrap();
    for kernel in Kernel::ALL {
        let entry = entries.iter().find(|entry| entry["name"] == kernel.entry_point()).unwrap();
        for (i, binding) in kernel.bindings().iter().enumerate() {
            let expected = match binding.access {
                Access::One | Access::In => "read",
                Access::Out | Access::InOut => "read_write",
            };
            let bindings = entry["bindings"].as_array().unwrap();
            let found = bindings.iter().find(|found| found["binding"] == i).unwrap();
            assert_eq!(found["access"], expected, "{}: `{}`", kernel.entry_point(), binding.name);
            assert_eq!(found["kind"], "storage", "{}: `{}`", kernel.entry_point(), binding.name);
        }
    }
}

/// Sizes and places of fields are measured on the device: `tests/verify.rs`.
#[test]
fn every_record_has_a_layout_kernel() {
    let measured: BTreeSet<_> =
        LAYOUTS.iter().flat_map(|(_, records)| records.iter().map(|row| row.1 as u32 * 4)).collect();
    assert_eq!(LAYOUTS.iter().map(|(_, records)| records.len()).sum::<usize>(), 41);
    for kernel in Kernel::ALL.iter().filter(|kernel| !kernel.entry_point().starts_with("probe_")) {
        for binding in kernel.bindings() {
            // The alignment that `Device::buffer` and the CPU backend rely on.
            assert_eq!(binding.record_bytes % 4, 0, "{}: `{}`", kernel.entry_point(), binding.name);
            assert_eq!(binding.words.len() as u32 * 4, binding.record_bytes);
            // Sites and arrivals are words without fields: tests/map_build.rs compares them with what they should hold.
            let known = binding.record_bytes == 4
                || ["sites", "arrivals", "input", "output"].contains(&binding.name)
                || measured.contains(&binding.record_bytes);
            assert!(known, "{}: no layout kernel has a record like `{}`", kernel.entry_point(), binding.name);
        }
    }
}

#[test]
fn kernels_have_the_lanes_that_their_bodies_assume() {
    assert_eq!(Kernel::ScanRows.lanes(), SCAN_LANES);
    // Digits and items are shared out evenly among lanes.
    for kernel in [Kernel::RadixScatter, Kernel::RadixScatterNarrow, Kernel::RadixScatterPlain] {
        let lanes = kernel.lanes();
        assert!(lanes.is_power_of_two() && SORT_BLOCK.is_multiple_of(8 * lanes));
    }
    for kernel in [Kernel::HashPhotons, Kernel::CellBegins] {
        assert!(GRID_BLOCK.is_multiple_of(kernel.lanes()) && kernel.lanes().is_power_of_two());
    }
    for kernel in [Kernel::IrradianceHistogram, Kernel::NeighboursHistogram] {
        assert_eq!(kernel.lanes(), COLUMN_LANES);
    }
    assert_eq!(Kernel::BruteDistance.lanes(), BRUTE_TILE);
    for kernel in [17, 65, 257, 1025].map(|n| Kernel::named(&format!("cells_neighbours_{n}")).unwrap()) {
        assert_eq!(kernel.lanes(), CELLS_LANES);
    }
    let gathers: Vec<_> = Kernel::ALL
        .iter()
        .filter(|kernel| {
            let name = kernel.entry_point();
            name.starts_with("irradiance_") || name.starts_with("neighbours_")
        })
        // Those without a container.
        .filter(|kernel| {
            !["histogram", "density", "filtered", "compact"].iter().any(|name| kernel.entry_point().contains(name))
        })
        .collect();
    // Two results, two containers.
    assert_eq!(gathers.len(), 4 * CAPACITIES.len());
    for kernel in gathers {
        assert_eq!(kernel.lanes(), GATHER_LANES);
        let capacity = kernel.entry_point().rsplit('_').next().unwrap().parse::<u32>().unwrap();
        assert!(CAPACITIES.contains(&capacity), "{}", kernel.entry_point());
    }
}
