//! Plans, buffers, accounts and errors of devices.

use caustic_device::{Access, Device, DeviceChoice, Error, Kernel, LaneOrder, Plan, adapters};
use caustic_kernels::sort::ScanParams;
use caustic_tests::{assert_same_words, gpu};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What a call panics with.
fn panic_of(call: impl FnOnce()) -> String {
    let payload = catch_unwind(AssertUnwindSafe(call)).expect_err("it did not panic");
    let text = payload.downcast_ref::<String>().cloned();
    text.or(payload.downcast_ref::<&str>().map(ToString::to_string)).unwrap_or_default()
}

/// A plan that scans 0 .. 100 in one row.
fn scan_plan(device: &Device) -> (Plan, caustic_device::Buffer) {
    let input: Vec<u32> = (0..100).collect();
    let params = device.upload("params", &[ScanParams { count: 100, row_length: 100 }]).unwrap();
    let input = device.upload("input", &input).unwrap();
    let sums = device.buffer::<u32>("sums", 100).unwrap();
    let totals = device.buffer::<u32>("totals", 1).unwrap();
    let mut plan = Plan::new();
    plan.groups(Kernel::ScanRows, 1, &[&params, &input, &sums, &totals]);
    (plan, sums)
}

#[test]
fn a_stage_with_too_few_or_too_many_buffers_is_refused() {
    let cpu = Device::cpu();
    let buffers: Vec<_> = (0..5).map(|_| cpu.buffer::<u32>("words", 2).unwrap()).collect();
    let buffers: Vec<_> = buffers.iter().collect();
    for count in [0, 3, 5] {
        let text = panic_of(|| Plan::new().groups(Kernel::ScanRows, 1, &buffers[..count]));
        assert!(text.contains("scan_rows: number of buffers"), "{text}");
    }
    Plan::new().groups(Kernel::ScanRows, 1, &buffers[..4]);
}

#[test]
fn a_buffer_that_is_written_must_not_be_bound_twice() {
    let cpu = Device::cpu();
    let [a, b, c] = ["a", "b", "c"].map(|name| cpu.buffer::<u32>(name, 2).unwrap());
    // Written and read; written twice, also through another handle.
    for buffers in [[&a, &b, &b, &c], [&a, &b, &c, &c], [&a, &b, &c, &c.clone()], [&a, &b, &a, &c]] {
        let text = panic_of(|| Plan::new().groups(Kernel::ScanRows, 1, &buffers));
        assert!(text.contains("scan_rows") && text.contains("written and bound twice"), "{text}");
    }
    // Changed in place and also read.
    let d = cpu.buffer::<u32>("d", 2).unwrap();
    for buffers in [[&a, &b, &b, &c], [&a, &b, &c, &c], [&a, &b, &c, &b], [&a, &b, &a, &c]] {
        let text = panic_of(|| Plan::new().groups(Kernel::BruteCombSort, 1, &buffers));
        assert!(text.contains("brute_comb_sort") && text.contains("written and bound twice"), "{text}");
    }
    Plan::new().groups(Kernel::BruteCombSort, 1, &[&a, &b, &c, &d]);
    // Read twice is allowed, and so is an equal name.
    let another_b = cpu.buffer::<u32>("b", 2).unwrap();
    Plan::new().groups(Kernel::ScanRows, 1, &[&a, &a, &b, &another_b]);
}

#[test]
fn every_kernel_reads_before_it_writes_and_has_a_buffer_to_write() {
    for kernel in Kernel::ALL {
        let bindings = kernel.bindings();
        let probe = kernel.entry_point().starts_with("layout_") || kernel == &Kernel::CopyQuads;
        assert!(probe || bindings[0].access == Access::One, "{}: parameters come first", kernel.entry_point());
        assert!(bindings.iter().any(|binding| binding.access.writes()), "{}", kernel.entry_point());
    }
}

#[test]
fn the_ledger_knows_current_and_peak_bytes_by_name() {
    let check = |device: &Device| {
        assert_eq!(device.total_bytes(), (0, 0));
        let a = device.buffer::<u32>("a", 100).unwrap();
        let other_a = device.upload("a", &[1u32; 50]).unwrap();
        let b = device.buffer::<[f32; 4]>("b", 10).unwrap();
        assert_eq!((a.name(), a.bytes(), other_a.bytes(), b.bytes()), ("a", 400, 200, 160));
        assert_eq!(device.total_bytes(), (760, 760));
        let handle = a.clone();
        drop(a);
        assert_eq!(device.total_bytes(), (760, 760), "a handle is left");
        drop(handle);
        assert_eq!(device.total_bytes(), (360, 760));
        let c = device.buffer::<u32>("a", 10).unwrap();
        let rows: Vec<_> =
            device.buffer_bytes().iter().map(|row| (row.buffer.clone(), row.bytes, row.peak_bytes)).collect();
        assert_eq!(rows, [("a".to_string(), 240, 600), ("b".to_string(), 160, 160)]);
        drop((other_a, b, c));
        assert_eq!(device.total_bytes(), (0, 760));
        // A buffer of nothing holds one record, since one without bytes cannot be bound.
        assert_eq!(device.buffer::<[u32; 3]>("none", 0).unwrap().bytes(), 12);
    };
    check(&Device::cpu());
    if gpu().is_some() {
        check(&own_gpu());
    }
}

/// A GPU for a test that looks at the accounts, which it must have to itself.
fn own_gpu() -> Device {
    let named = std::env::var("CAUSTIC_TEST_GPU");
    let choice: DeviceChoice = named.as_deref().unwrap_or("gpu").parse().unwrap();
    Device::open(&choice).unwrap().0
}

#[test]
fn stage_times_are_recorded_by_scope_and_name() {
    let check = |device: &Device| {
        let (scan, sums) = scan_plan(device);
        assert!(device.stage_times().is_empty());
        device.run(&scan).unwrap();
        device.run(&scan).unwrap();
        let times = device.stage_times();
        assert_eq!(times.len(), 1);
        assert_eq!((times[0].stage.as_str(), times[0].runs), ("scan_rows", 2));
        // More than nothing, and less than a second for a hundred additions: units are ms on every device.
        assert!(times[0].ms > 0.0 && times[0].ms < 1e3, "{} ms", times[0].ms);
        device.reset_stage_times();
        assert!(device.stage_times().is_empty());

        let mut scoped = Plan::new();
        let params = device.upload("params", &[ScanParams { count: 1, row_length: 1 }]).unwrap();
        let totals = device.buffer::<u32>("totals", 1).unwrap();
        let out = device.buffer::<u32>("out", 1).unwrap();
        for scope in ["global", "caustic", "global", ""] {
            scoped.scope(scope);
            scoped.groups(Kernel::ScanRows, 1, &[&params, &sums, &out, &totals]);
        }
        device.run(&scoped).unwrap();
        let times: Vec<_> = device.stage_times().iter().map(|time| (time.stage.clone(), time.runs)).collect();
        let expected = [("global/scan_rows", 2), ("caustic/scan_rows", 1), ("scan_rows", 1)];
        assert_eq!(times, expected.map(|(stage, runs)| (stage.to_string(), runs)));
    };
    check(&Device::cpu());
    if gpu().is_some() {
        check(&own_gpu());
    }
}

#[test]
fn a_buffer_beyond_the_gpus_limit_is_an_error_with_all_numbers() {
    if gpu().is_none() {
        return;
    }
    let gpu = own_gpu();
    let limits: Vec<_> = adapters().iter().map(|adapter| adapter.max_buffer_bytes).collect();
    let words = limits.iter().max().unwrap() / 4 + 1;
    for (name, flag) in [
        ("photons", "--photons or --caustic-photons"),
        ("map: cell begins", "the number of cells: use --hash teschner"),
        ("film", "--size"),
    ] {
        let error = gpu.buffer::<u32>(name, words).err().unwrap();
        let Error::BufferTooLarge { buffer, device, needed, available, flag: named } = &error else {
            panic!("{error}");
        };
        assert_eq!((buffer.as_str(), *needed, *named), (name, 4 * words, flag));
        assert_eq!(*device, gpu.name());
        assert!(limits.contains(available) && available < needed, "{available} of {limits:?}");
        let text = error.to_string();
        for part in [name, flag, &needed.to_string(), &available.to_string(), device] {
            assert!(text.contains(part), "`{part}` is not in: {text}");
        }
    }
    assert_eq!(gpu.total_bytes(), (0, 0), "what was refused is not counted");
    // The device is as good as before.
    let (plan, sums) = scan_plan(&gpu);
    gpu.run(&plan).unwrap();
    assert_eq!(gpu.read::<u32>(&sums, 100).unwrap()[99], 98 * 99 / 2);
}

#[test]
fn a_buffer_beyond_the_hosts_memory_is_an_error_with_all_numbers() {
    let cpu = Device::cpu();
    // 2⁵⁰ bytes: a thousand times what machines have.
    let error = cpu.buffer::<u32>("photons", 1 << 48).err().unwrap();
    let Error::OutOfMemory { buffer, needed, flag, .. } = &error else { panic!("{error}") };
    assert_eq!((buffer.as_str(), *needed, *flag), ("photons", 1 << 50, "--photons or --caustic-photons"));
    let text = error.to_string();
    assert!(text.contains(&(1u64 << 50).to_string()) && text.contains("available"), "{text}");
    assert_eq!(cpu.total_bytes(), (0, 0));
}

/// Buffers are as they were left: zero at first, then what was written, then what a plan did in its order.
fn check_contents(device: &Device) {
    let zero = vec![0u32; 1000];
    let buffer = device.buffer::<u32>("words", 1000).unwrap();
    assert_same_words("new", &zero, &device.read(&buffer, 1000).unwrap());
    let words: Vec<u32> = (0..1000).map(|i| i * 0x0101_0101).collect();
    device.write(&buffer, &words);
    assert_same_words("written", &words, &device.read(&buffer, 1000).unwrap());
    device.write(&buffer, &[5u32, 6]);
    let start: Vec<u32> = device.read(&buffer, 3).unwrap();
    assert_eq!(start, [5, 6, words[2]], "a shorter write leaves the rest");
    let mut plan = Plan::new();
    plan.clear(&buffer);
    assert_same_words("not run yet", &words[2..], &device.read::<u32>(&buffer, 1000).unwrap()[2..]);
    device.run(&plan).unwrap();
    assert_same_words("cleared", &zero, &device.read(&buffer, 1000).unwrap());

    // Clearing in the middle of a plan: between the stage that wrote a buffer and the one that reads it, and after all.
    let (mut plan, sums) = scan_plan(device);
    let params = device.upload("params", &[ScanParams { count: 100, row_length: 100 }]).unwrap();
    let [again, total, other_total] = ["again", "total", "other"].map(|name| device.buffer::<u32>(name, 100).unwrap());
    let before = device.buffer::<u32>("before", 100).unwrap();
    plan.groups(Kernel::ScanRows, 1, &[&params, &sums, &before, &total]);
    plan.clear(&sums);
    plan.groups(Kernel::ScanRows, 1, &[&params, &sums, &again, &other_total]);
    device.run(&plan).unwrap();
    // The sum of the first n triangular numbers is C(n + 1, 3): here over 0, 0, 1, 3, 6, … up to the 100th.
    assert_eq!(device.read::<u32>(&total, 1).unwrap(), [100 * 99 * 98 / 6]);
    assert_same_words("cleared in the middle", &zero[..100], &device.read(&again, 100).unwrap());
    assert_eq!(device.read::<u32>(&other_total, 1).unwrap(), [0]);
}

#[test]
fn buffers_hold_what_they_were_given() {
    check_contents(&Device::cpu());
    check_contents(&Device::cpu_with_order(LaneOrder::Shuffled(1)));
    if let Some(gpu) = gpu() {
        check_contents(gpu);
    }
}

#[test]
fn reading_past_the_end_panics() {
    let cpu = Device::cpu();
    let buffer = cpu.buffer::<u32>("words", 10).unwrap();
    assert!(catch_unwind(AssertUnwindSafe(|| cpu.read::<u32>(&buffer, 11))).is_err());
    assert!(catch_unwind(AssertUnwindSafe(|| cpu.write(&buffer, &[0u32; 11]))).is_err());
}

#[test]
fn an_empty_plan_does_nothing() {
    for device in [Some(&Device::cpu()), gpu()].into_iter().flatten() {
        device.run(&Plan::new()).unwrap();
    }
}

#[test]
fn choices_are_parsed() {
    let parse = |text: &str| text.parse::<DeviceChoice>();
    assert_eq!(parse("auto"), Ok(DeviceChoice::Auto));
    assert_eq!(parse("cpu"), Ok(DeviceChoice::Cpu));
    assert_eq!(parse("gpu"), Ok(DeviceChoice::Gpu(None)));
    assert_eq!(parse("gpu:llvmpipe"), Ok(DeviceChoice::Gpu(Some("llvmpipe".to_string()))));
    assert_eq!(parse("gpu:0"), Ok(DeviceChoice::Gpu(Some("0".to_string()))));
    assert_eq!(DeviceChoice::default(), DeviceChoice::Auto);
    for bad in ["", "GPU", "gpu:", "gpus", "cuda", "cpu:0", " cpu"] {
        let text = parse(bad).unwrap_err();
        assert!(text.contains("auto, cpu, gpu or gpu:NAME_OR_INDEX"), "{bad}: {text}");
    }
}

#[test]
fn a_gpu_that_is_not_there_is_an_error_that_lists_those_that_are() {
    for wanted in ["nonsense", "99"] {
        let error = Device::open(&DeviceChoice::Gpu(Some(wanted.to_string()))).err().unwrap();
        assert!(matches!(error, Error::NoSuchDevice { .. }), "{error}");
        let text = error.to_string();
        assert!(text.contains(&format!("`gpu:{wanted}`")) && text.contains("--device cpu"), "{text}");
        let adapters = adapters();
        for adapter in &adapters {
            assert!(text.contains(&format!("gpu:{} {}", adapter.index, adapter.name)), "{text}");
        }
        assert!(!adapters.is_empty() || text.contains("this machine has none"), "{text}");
    }
}

#[test]
fn a_gpu_is_found_by_index_and_by_a_part_of_its_name_in_any_case() {
    for adapter in adapters().iter().filter(|adapter| adapter.exact) {
        let part = adapter.name.split_whitespace().next().unwrap();
        for wanted in [adapter.index.to_string(), part.to_lowercase(), part.to_uppercase()] {
            let (device, line) = Device::open(&DeviceChoice::Gpu(Some(wanted.clone()))).unwrap();
            assert!(device.is_gpu());
            assert!(device.name().to_lowercase().contains(&part.to_lowercase()), "{wanted}: {}", device.name());
            assert!(line.contains(&device.name()) && line.contains("asked for"), "{line}");
        }
    }
}

#[test]
fn auto_takes_no_software_gpu() {
    let hardware = adapters().iter().any(|adapter| adapter.exact && adapter.kind != "software");
    let (device, line) = Device::open(&DeviceChoice::Auto).unwrap();
    assert_eq!(device.is_gpu(), hardware, "{line}");
    assert!(line.starts_with(&format!("device: {} (", device.name())), "{line}");
    let (device, line) = Device::open(&DeviceChoice::Cpu).unwrap();
    assert!(!device.is_gpu() && line.contains("asked for"), "{line}");
}

#[test]
fn a_buffer_whose_size_overflows_is_refused() {
    let error = Device::cpu().buffer::<[u32; 8]>("photons", 1 << 60).err();
    let text = error.map(|error| error.to_string()).unwrap_or_default();
    assert!(text.contains("`photons`") && text.contains("--photons"), "{text}");
}
