//! The memory of dropped buffers: a second frame takes that of the first, and nothing depends on what it held.

use caustic_device::{Device, DeviceChoice, Error, Kernel, LaneOrder, Plan};
use caustic_kernels::layout::Query;
use caustic_photon_map::{Gather, Hash, MapOptions, PhotonMap};
use caustic_renderer::{Settings, Show};
use caustic_tests::renders::{floats, load, run, small};
use caustic_tests::{assert_same_words, gpu, points};

/// The CPU, a GPU and both at once, each new: these tests look at accounts that they must have to themselves.
fn devices() -> Vec<(&'static str, Device)> {
    let mut devices = vec![("cpu", Device::cpu()), ("shuffled cpu", Device::cpu_with_order(LaneOrder::Shuffled(5)))];
    if gpu().is_some() {
        let named = std::env::var("CAUSTIC_TEST_GPU");
        let choice: DeviceChoice = named.as_deref().unwrap_or("gpu").parse().unwrap();
        let [gpu, half] = [0, 1].map(|_| Device::open(&choice).unwrap().0);
        devices.extend([("gpu", gpu), ("twin", half.twin(None))]);
    }
    devices
}

#[test]
fn a_second_frame_allocates_nothing_and_does_not_depend_on_what_the_first_left() {
    let scene = load("cornell");
    let wide = Settings { size: [72, 40], photons: 5000, ..small(&scene) };
    let lists = Settings { gather: Gather::List, hash: Hash::Teschner, ..wide.clone() };
    let part = Settings { show: Show::MapCaustic, ..wide.clone() };
    for (name, device) in devices() {
        for settings in [&wide, &lists, &part] {
            // So small that one dispatch a pass and one tile will do, however fast the device is.
            let first = run(&scene, settings, &device);
            let allocations = device.allocations();
            for frame in ["second", "third"] {
                device.spoil();
                let again = run(&scene, settings, &device);
                assert_eq!(device.allocations(), allocations, "{name}: {frame} frame");
                assert_same_words(&format!("{name}: {frame} frame"), floats(&first.image), floats(&again.image));
                assert_eq!(again.report.peak_bytes, first.report.peak_bytes, "{name}: {frame} frame");
            }
        }
        let (now, peak) = device.total_bytes();
        assert_eq!(now, 0, "{name}");
        let kept = device.kept_bytes();
        assert!(kept > 0 && kept <= peak + peak.max(64 << 20), "{name}: {kept} of {peak} bytes");
        assert!(device.comparisons().iter().all(|row| row.difference.is_none()), "{name}");
        // What is given back has to be had again.
        let allocations = device.allocations();
        assert_eq!((device.trim(), device.kept_bytes(), device.trim()), (kept, 0, 0), "{name}");
        run(&scene, &wide, &device);
        assert!(device.allocations() > allocations, "{name}");
    }
}

#[test]
fn a_frame_of_another_seed_finds_most_of_what_it_needs() {
    let scene = load("cornell");
    let settings = Settings { photons: 20_000, caustic_photons: 10_000, size: [16, 16], ..small(&scene) };
    let device = Device::cpu();
    run(&scene, &settings, &device);
    let first = device.allocations();
    for seed in 1..20 {
        run(&scene, &Settings { seed, ..settings.clone() }, &device);
    }
    let more = device.allocations() - first;
    assert!(more < 19 * first / 4, "{more} in 19 frames after the {first} of the first");
}

#[test]
fn maps_answer_the_same_in_used_memory() {
    let set = points::sets(2000).into_iter().next().unwrap();
    let queries: Vec<Query> =
        set.photons.iter().step_by(7).map(|photon| Query { position: photon.position, active: 1 }).collect();
    for (name, device) in devices() {
        for hash in [Hash::Linear, Hash::Teschner] {
            let options = MapOptions { radius: set.radius, hash, table: None, cell: None };
            let answers = || {
                let map = PhotonMap::build(&device, &set.photons, &options).unwrap();
                let mut estimates = map.density(&device, &queries).unwrap();
                let mut neighbours = Vec::new();
                for gather in [Gather::Histogram, Gather::Heap, Gather::List] {
                    estimates.extend(map.irradiance(&device, &queries, 20, gather).unwrap());
                    neighbours.extend(map.k_nearest(&device, &queries, 20, gather).unwrap());
                }
                (estimates, neighbours)
            };
            let first = answers();
            let allocations = device.allocations();
            device.spoil();
            assert!(answers() == first, "{name}, {hash:?}");
            assert_eq!(device.allocations(), allocations, "{name}, {hash:?}");
        }
    }
}

#[test]
fn a_buffer_is_zero_and_ends_where_it_should_whatever_its_memory_was() {
    for (name, device) in devices() {
        let old = device.upload("old", &[7u32; 10_240]).unwrap();
        // A GPU that reads has memory for that from then on.
        device.read::<u32>(&old, 10_240).unwrap();
        drop(old);
        let allocations = device.allocations();
        for words in [10_240, 10_239, 10_000, 10_240] {
            device.spoil();
            let buffer = device.buffer::<u32>("new", words).unwrap();
            assert_eq!((buffer.bytes(), device.total_bytes().0), (4 * words, 40_960), "{name}");
            assert_same_words(name, &vec![0u32; words as usize], &device.read(&buffer, words).unwrap());
            assert_eq!(device.allocations(), allocations, "{name}");
        }
    }
}

#[test]
fn a_kernel_does_not_reach_the_rest_of_the_memory() {
    let Some(device) = devices().into_iter().find_map(|(name, device)| (name == "gpu").then_some(device)) else {
        return;
    };
    let from = device.upload("from", &[1u32; 10_240]).unwrap();
    drop(device.upload("old", &[7u32; 10_240]).unwrap());
    device.spoil();
    let to = device.scratch::<u32>("to", 10_000).unwrap();
    let mut plan = Plan::new();
    plan.each(Kernel::CopyQuads, 2560, &[&from, &to]);
    device.run(&plan).unwrap();
    assert_eq!(device.read::<u32>(&to, 10_000).unwrap(), [1; 10_000]);
    drop((plan, to));
    let all = device.scratch::<u32>("all", 10_240).unwrap();
    let rest = &device.read::<u32>(&all, 10_240).unwrap()[10_000..];
    assert!(rest.iter().all(|&word| word == rest[0] && word > 7), "{:x} …", rest[0]);
}

#[test]
fn what_is_kept_goes_before_memory_is_said_to_be_out() {
    let cpu = Device::cpu();
    drop(cpu.buffer::<u32>("small", 1024).unwrap());
    assert_eq!(cpu.kept_bytes(), 4096);
    let error = cpu.buffer::<u32>("photons", 1 << 48).err();
    assert!(matches!(error, Some(Error::OutOfMemory { .. })));
    assert_eq!(cpu.kept_bytes(), 0);
}
