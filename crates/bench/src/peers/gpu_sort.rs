//! lampshade's sort on the adapter that caustic runs on, in the same process, through its own wgpu device.

use crate::measure::{Policy, Spread, repeat};
use crate::row::Peer;
use lampshade::KeyValueSoaSorter;
use pollster::block_on;
use std::time::Instant;
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BufferUsages, Features};

/// Sorts keys with their indices. lampshade has no passes for fewer bits in its separate-buffer sort: it sorts all 32.
pub(super) fn lampshade(
    device_name: &str,
    keys: &[u32],
    sorted: &[u32],
    policy: Policy,
    goes_on: &mut dyn FnMut() -> bool,
) -> Peer {
    let peer = Peer {
        name: "lampshade".to_string(),
        version: "0.13".to_string(),
        runs: 0,
        wall_ms: None,
        stages_ms: None,
        parts: Vec::new(),
        over_ours: None,
        agree: 0,
        compared: sorted.len(),
        note: String::new(),
    };
    match time(device_name, keys, policy, goes_on) {
        Ok(timed) => {
            let of = |time: fn(&[f64; 2]) -> f64| Spread::of(&timed.times.iter().map(time).collect::<Vec<_>>());
            let ran = !timed.times.is_empty();
            Peer {
                runs: timed.times.len(),
                wall_ms: ran.then(|| of(|time| time[0])),
                stages_ms: (ran && timed.stamped).then(|| of(|time| time[1])),
                agree: timed.keys.iter().zip(sorted).filter(|(a, b)| a == b).count(),
                note: timed.note,
                ..peer
            }
        }
        Err(reason) => Peer { note: format!("did not run: {reason}"), ..peer },
    }
}

struct Timed {
    /// Wall clock and time stamps of each run, ms.
    times: Vec<[f64; 2]>,
    stamped: bool,
    keys: Vec<u32>,
    note: String,
}

fn time(device_name: &str, keys: &[u32], policy: Policy, goes_on: &mut dyn FnMut() -> bool) -> Result<Timed, String> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapters = block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN));
    let same = |adapter: &wgpu::Adapter| device_name.starts_with(&adapter.get_info().name);
    let adapter = adapters.into_iter().find(same).ok_or("its adapter was not found again")?;
    let needs = KeyValueSoaSorter::requirements(&adapter);
    let stamps = Features::TIMESTAMP_QUERY | Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
    let stamped = adapter.features().contains(stamps);
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("lampshade"),
        required_features: needs.features(if stamped { stamps } else { Features::empty() }),
        required_limits: needs.limits(adapter.limits()),
        ..Default::default()
    };
    let (device, queue) = block_on(adapter.request_device(&descriptor)).map_err(|error| error.to_string())?;
    let indices: Vec<u32> = (0..keys.len() as u32).collect();
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
    let upload = |data: &[u32]| {
        let contents = bytemuck::cast_slice(data);
        device.create_buffer_init(&BufferInitDescriptor { label: Some("peer"), contents, usage })
    };
    let [from_keys, from_values, work_keys, work_values] =
        [upload(keys), upload(&indices), upload(keys), upload(&indices)];
    let bytes = 4 * keys.len() as u64;
    let mut sorter = KeyValueSoaSorter::new(&device, &queue);
    let count = keys.len() as u32;
    sorter.prepare_sort(&work_keys, &work_values, count).map_err(|error| error.to_string())?;
    let set = stamped.then(|| {
        let label = Some("stamps");
        device.create_query_set(&wgpu::QuerySetDescriptor { label, ty: wgpu::QueryType::Timestamp, count: 2 })
    });
    let wait = || device.poll(wgpu::PollType::wait_indefinitely()).map(drop).map_err(|error| error.to_string());
    let read = |buffer: &wgpu::Buffer, bytes: u64| -> Result<Vec<u8>, String> {
        let staging = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: bytes,
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes);
        queue.submit([encoder.finish()]);
        staging.map_async(wgpu::MapMode::Read, .., |_| {});
        wait()?;
        Ok(staging.get_mapped_range(..).map_err(|error| error.to_string())?.to_vec())
    };
    let stamp_buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("stamps"),
        size: 16,
        usage: BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let times = repeat(policy, goes_on, || -> Result<[f64; 2], String> {
        // It sorts in place, so the input is copied back first, outside the time.
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(&from_keys, 0, &work_keys, 0, bytes);
        encoder.copy_buffer_to_buffer(&from_values, 0, &work_values, 0, bytes);
        queue.submit([encoder.finish()]);
        wait()?;
        let start = Instant::now();
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if let Some(set) = &set {
            encoder.write_timestamp(set, 0);
        }
        let recorded = sorter.record_reserved_sort(&mut encoder, &work_keys, &work_values, count);
        recorded.map_err(|error| error.to_string())?;
        if let Some(set) = &set {
            encoder.write_timestamp(set, 1);
            encoder.resolve_query_set(set, 0..2, &stamp_buffer, 0);
        }
        queue.submit([encoder.finish()]);
        wait()?;
        let wall = start.elapsed().as_secs_f64() * 1e3;
        if !stamped {
            return Ok([wall, 0.0]);
        }
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&read(&stamp_buffer, 16)?);
        let period = f64::from(queue.get_timestamp_period());
        Ok([wall, ticks[1].wrapping_sub(ticks[0]) as f64 * period * 1e-6])
    })?;
    let keys = bytemuck::pod_collect_to_vec(&read(&work_keys, bytes)?);
    let path = if sorter.is_accelerated() { "its native path" } else { "its portable path" };
    let clock = if stamped { "its own time stamps, gaps between dispatches included" } else { "wall clock alone" };
    Ok(Timed { times, stamped, keys, note: format!("{path}, all 32 bits, {clock}") })
}
