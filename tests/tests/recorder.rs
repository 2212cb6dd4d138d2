//! The access recorder: counts in closed form, the same results as without it, and planted faults.

use caustic_device::{Access, Device, Kernel, Observed, Observer, Plan};
use caustic_kernels::gather::GatherParams;
use caustic_kernels::grid::{Grid, Row};
use caustic_kernels::layout::{Arrival, Irradiance, Photon, Query, Site};
use caustic_kernels::sort::ScanParams;
use caustic_photon_map::{Filter, Gather, Hash, MapOptions, Nearest, PhotonMap, RadixSort, Surface};
use caustic_recorder::{Counts, Recorder, StageAccesses};
use caustic_renderer::output::LayerKind;
use caustic_renderer::{Integrator, Keep, Settings};
use caustic_rivals::{Photons, Technique, k_nearest};
use caustic_tests::points::sets;
use caustic_tests::renders;
use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What one stage accesses.
fn record(recorder: &Recorder, plan: impl FnOnce(&Device, &mut Plan)) -> StageAccesses {
    recorder.reset();
    let device = recorder.device();
    let mut stages = Plan::new();
    plan(&device, &mut stages);
    device.run(&stages).unwrap();
    recorder.report().remove(0)
}

fn counts(stage: &StageAccesses, buffer: &str) -> Counts {
    stage.buffers.iter().find(|row| row.name == buffer).unwrap().counts
}

fn copy(recorder: &Recorder, quads: u32) -> StageAccesses {
    record(recorder, |device, plan| {
        let input = device.upload("input", &vec![Site::new([1.0; 3], 2); quads as usize]).unwrap();
        let output = device.buffer::<Site>("output", quads.into()).unwrap();
        plan.each(Kernel::CopyQuads, quads, &[&input, &output]);
    })
}

#[test]
fn a_copy_is_coalesced_to_the_last_warp_which_is_not_full() {
    for (warp, quads, warps) in [(32, 1024, 32), (32, 1000, 32), (32, 1, 1), (32, 33, 2), (8, 33, 5), (48, 300, 7)] {
        let copied = copy(&Recorder::new(warp), quads);
        let bytes = 16 * u64::from(quads);
        for counted in [copied.reads(), copied.writes()] {
            // Half a sector is one. In workgroups of 256 lanes, warps of 48 begin anew at the second.
            assert_eq!((counted.requests, counted.bytes, counted.sectors), (warps, bytes, bytes.div_ceil(32)));
            assert_eq!((counted.minimum, counted.excess, counted.uncoalesced_requests), (counted.sectors, 0, 0));
        }
        assert_eq!((copied.kernel, copied.runs, copied.local_loads), ("copy_quads", 1, 0));
    }
}

#[test]
fn one_workgroup_of_several_is_a_share_of_the_counts() {
    let all = copy(&Recorder::new(32), 1024);
    let some = copy(&Recorder::every(32, 3), 1024);
    assert_eq!((all.groups, all.recorded_groups, some.groups, some.recorded_groups), (4, 4, 4, 2));
    assert_eq!(2 * some.total.sectors, all.total.sectors);
}

/// A lane of a scan has 16 elements beside each other, so that the lanes of a warp access words that are 64 bytes apart.
#[test]
fn strides_of_two_sectors_cost_a_sector_a_lane() {
    let scanned = record(&Recorder::new(32), |device, plan| {
        let params = device.upload("params", &[ScanParams { count: 4096, row_length: 4096 }]).unwrap();
        let input = device.upload("input", &[3u32; 4096]).unwrap();
        let sums = device.buffer::<u32>("sums", 4096).unwrap();
        let totals = device.buffer::<u32>("totals", 1).unwrap();
        plan.groups(Kernel::ScanRows, 1, &[&params, &input, &sums, &totals]);
    });
    // 8 warps, 16 elements a lane. 32 words of 4 bytes fit 4 sectors.
    let of = |requests: u64| Counts {
        requests,
        sectors: 32 * requests,
        minimum: 4 * requests,
        excess: 28 * requests,
        uncoalesced_requests: requests,
        bytes: 128 * requests,
    };
    assert_eq!(counts(&scanned, "input"), of(8 * 16));
    assert_eq!(counts(&scanned, "sums"), of(8 * 16));
    // One lane writes one word.
    let one = Counts { requests: 1, sectors: 1, minimum: 1, excess: 0, uncoalesced_requests: 0, bytes: 4 };
    assert_eq!(counts(&scanned, "totals"), one);
}

/// A kernel that does nothing for its queries, but reads them and writes results in a given order: 16 bytes each.
fn in_order(order: impl Fn(u32) -> u32) -> StageAccesses {
    record(&Recorder::new(32), |device, plan| {
        let order: Vec<u32> = (0..1024).map(order).collect();
        let params = device.upload("params", &[GatherParams { queries: 1024, k: 1, guess: 1.0 }]).unwrap();
        let grid = device.upload("grid", &[Grid::default()]).unwrap();
        let rows = device.buffer::<Row>("rows", 1).unwrap();
        let queries = device.buffer::<Query>("queries", 1024).unwrap();
        let order = device.upload("order", &order).unwrap();
        let sites = device.buffer::<Site>("sites", 1).unwrap();
        let arrivals = device.buffer::<Arrival>("arrivals", 1).unwrap();
        let begins = device.buffer::<u32>("begins", 1).unwrap();
        let power = device.buffer::<u32>("power", 3).unwrap();
        let out = device.buffer::<Irradiance>("irradiance", 1024).unwrap();
        let buffers = [&params, &grid, &rows, &queries, &order, &sites, &arrivals, &begins, &power, &out];
        plan.each(Kernel::IrradianceDensity, 1024, &buffers);
    })
}

#[test]
fn a_permutation_of_half_sectors_costs_twice_as_many() {
    let identity = in_order(|i| i);
    assert_eq!((identity.total.requests, identity.total.excess), (3 * 32, 0));
    let reversed = in_order(|i| 1023 - i);
    assert_eq!(reversed.total, identity.total, "within its sectors a warp may have any order");
    // The lanes of a warp are 512 bytes apart.
    let transposed = in_order(|i| (i % 32) * 32 + i / 32);
    assert_eq!(counts(&transposed, "query_order"), counts(&identity, "query_order"));
    for buffer in ["queries", "irradiance"] {
        let (near, far) = (counts(&identity, buffer), counts(&transposed, buffer));
        assert_eq!((near.requests, near.sectors, near.minimum, near.excess), (32, 16 * 32, 16 * 32, 0));
        assert_eq!((far.requests, far.sectors, far.minimum, far.excess), (32, 32 * 32, 16 * 32, 16 * 32));
    }
}

/// A photon is a sector: in this model of memory it costs nothing to read them in any order.
#[test]
fn photons_are_reordered_by_whole_sectors() {
    let reorder = |order: &[u32]| {
        record(&Recorder::new(32), |device, plan| {
            let n = order.len() as u64;
            let grid = device.upload("grid", &[Grid { photons: n as u32, ..Grid::default() }]).unwrap();
            let order = device.upload("order", order).unwrap();
            let photons = device.buffer::<Photon>("photons", n).unwrap();
            let power = device.buffer::<u32>("power", 3).unwrap();
            let sites = device.buffer::<Site>("sites", n).unwrap();
            let arrivals = device.buffer::<Arrival>("arrivals", n).unwrap();
            plan.each(Kernel::ReorderPhotons, n as u32, &[&grid, &order, &photons, &power, &sites, &arrivals]);
        })
    };
    let identity: Vec<u32> = (0..1000).collect();
    let permutation: Vec<u32> = (0..1000).map(|i| i * 377 % 1000).collect();
    for order in [identity, permutation] {
        let reordered = reorder(&order);
        let sectors = |buffer| counts(&reordered, buffer).sectors;
        assert_eq!(["order", "photons", "sites", "arrivals"].map(sectors), [125, 1000, 500, 1500]);
        // All lanes read the same three words.
        assert_eq!((counts(&reordered, "power").requests, sectors("power")), (3 * 32, 3 * 32));
        assert_eq!(reordered.total.excess, 0);
    }
}

/// The recorder panics if a recorded kernel writes other words.
#[test]
fn recorded_kernels_write_what_the_fast_ones_write() {
    let recorder = Recorder::new(32);
    let (device, cpu) = (recorder.device(), Device::cpu());
    let set = sets(300).into_iter().find(|set| set.photons.len() > 200).unwrap();
    for technique in Technique::ALL.iter().filter(|technique| technique.runs_on(&device)) {
        let found = |device: &Device, k| {
            let photons = Photons::upload(device, &set.photons).unwrap();
            let index = technique.build(device, &photons, set.radius).unwrap();
            caustic_rivals::irradiance(device, index.as_ref(), &photons, set.radius, &set.queries, k).unwrap();
            k_nearest(device, index.as_ref(), &set.queries, k).unwrap()
        };
        for k in [10, 60, 250, 1000] {
            assert_eq!(found(&device, k), found(&cpu, k), "{technique:?}, k = {k}");
        }
    }
    for hash in [Hash::Linear, Hash::Morton] {
        let options = MapOptions { radius: set.radius, hash, table: None, cell: None };
        let map = PhotonMap::build(&device, &set.photons, &options).unwrap();
        map.density(&device, &set.queries).unwrap();
        for gather in [Gather::List, Gather::Heap, Gather::Histogram] {
            for k in [10, 60, 250, 1000] {
                map.irradiance(&device, &set.queries, k, gather).unwrap();
            }
        }
    }
    // All kinds of pictures: of a scene that asks little of kernels and of one that asks more.
    for name in ["cornell", "cornell-glossy"] {
        let scene = renders::load(name);
        let small = Settings { size: [12, 9], ..renders::small(&scene) };
        let layers = LayerKind::OF_PHOTON_MAPS.to_vec();
        renders::image(&scene, &Settings { layers, keep: Keep::Visible, ..small.clone() }, &device);
        renders::image(&scene, &Settings { integrator: Integrator::Path, ..small.clone() }, &device);
        for hash in [Hash::Linear, Hash::Morton] {
            let (surface, filter) = (Surface::Own, Filter::Gaussian);
            let other = Settings { hash, surface, filter, automatic_radius: true, final_gather: 2, ..small.clone() };
            renders::image(&scene, &other, &device);
            let (nearest, interpolate) = (Nearest::Approximate, 2);
            let rough = Settings { hash, nearest, interpolate, ..small.clone() };
            renders::image(&scene, &rough, &device);
            renders::image(&scene, &Settings { compact: true, ..rough }, &device);
            renders::image(&scene, &Settings { hash, compact: true, ..small.clone() }, &device);
        }
    }
    let keys = device.upload("keys", &(0..9000u32).rev().collect::<Vec<_>>()).unwrap();
    let mut plan = Plan::new();
    RadixSort::plan_plain(&device, &mut plan, &keys, 9000, 16).unwrap();
    device.run(&plan).unwrap();
    // Left are those for subgroups of 8 lanes, which differ in their number of lanes only, and the probes.
    let recorded: HashSet<_> = recorder.report().iter().map(|row| row.kernel).collect();
    let left = Kernel::ALL.iter().map(|kernel| kernel.entry_point()).filter(|name| !recorded.contains(name));
    let expected = |name: &str| name.ends_with("_narrow") || name.starts_with("layout_") || name == "probe_arithmetic";
    let in_place = |name: &str| {
        Kernel::named(name).is_some_and(|kernel| kernel.bindings().iter().any(|b| b.access == Access::InOut))
    };
    let left: Vec<_> = left.filter(|name| !expected(name) && !in_place(name) && *name != "copy_quads").collect();
    assert!(left.is_empty(), "not recorded: {left:?}");
}

#[test]
fn an_output_that_is_not_the_recorded_kernels_is_refused() {
    let input: Vec<u32> = (0..400).collect();
    let observe = |output: &[u32]| {
        let buffers = [input.as_slice(), output];
        let stage = Observed { stage: "copy", kernel: Kernel::CopyQuads, known: 0, groups: 1, buffers: &buffers };
        catch_unwind(AssertUnwindSafe(|| Recorder::new(32).observe(&stage)))
    };
    assert!(observe(&input).is_ok());
    for word in [0, 217, 399] {
        let mut wrong = input.clone();
        wrong[word] ^= 1 << 31;
        let panic = observe(&wrong).unwrap_err();
        assert_eq!(
            panic.downcast_ref::<String>().unwrap(),
            "copy: the recorded kernel writes something else to `output`"
        );
    }
}
