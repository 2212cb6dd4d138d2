//! Whether a GPU computes what the CPU computes: every kernel on random inputs, and small renders.

use crate::crowd::{CROWD, crowd};
use crate::output::LayerKind;
use crate::scene::{BUILT_IN, Scene};
use crate::{Integrator, Keep, Progress, RenderError, Settings, Show, render};
use caustic_device::{Buffer, Device, Difference, FirstDifference, Kernel, Plan, StageComparison};
use caustic_kernels::layout::{Photon, Query, Site};
use caustic_kernels::num::{pcg4d, u32_to_unit};
use caustic_kernels::probe::{Arithmetic, ArithmeticParams, LAYOUT_WORDS, LAYOUTS};
use caustic_photon_map::{
    DensityStreamed, Filter, Gather, Hash, LargestPower, MapOptions, Nearest, PhotonMap, RadixSort, Surface,
};
use caustic_rivals::{Photons, Technique};
use serde::Serialize;

/// Pairs of operands of the arithmetic probe.
const PAIRS: u32 = 1 << 18;
/// Photons of the synthetic maps: so few that a sorted list of them stays within the 65,535 steps that llvmpipe allows.
const PHOTONS: u32 = 2500;
/// Photons that other techniques search: insertion sort of all their distances takes many steps.
const PHOTONS_OF_RIVALS: u32 = 320;
/// Queries of the synthetic maps.
const QUERIES: u32 = 400;
/// Photons sought: one number for each compiled capacity.
const KS: [u32; 4] = [10, 50, 100, 270];
/// A float whose bits number the words of a record: normal, so that no device flushes it.
const NUMBERED: u32 = 0x3f80_0000;

/// The picture of one scene from both devices.
#[derive(Clone, Debug, Serialize)]
pub struct ImageComparison {
    /// The scene.
    pub scene: &'static str,
    /// Floats compared and what was found.
    #[serde(flatten)]
    pub difference: Difference,
    /// SHA-256 of the CPU's floats.
    pub cpu_sha256: String,
    /// SHA-256 of the GPU's floats.
    pub gpu_sha256: String,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Verification {
    /// The GPU.
    pub device: String,
    /// Whether it is meant to be exact.
    pub exact: bool,
    /// Seed of the random inputs.
    pub seed: u32,
    /// A row a kernel.
    pub stages: Vec<StageComparison>,
    /// A row a scene, unless stages were told to go on with the GPU's own results.
    pub images: Vec<ImageComparison>,
    /// Records whose fields the GPU and the CPU look for in different places, or not where the host puts them.
    pub layouts_wrong: Vec<String>,
}

impl Verification {
    /// Whether no word differs, no float is NaN and every record has one layout.
    #[must_use]
    pub fn same(&self) -> bool {
        self.layouts_wrong.is_empty()
            && self.stages.iter().all(|row| row.difference.is_none())
            && self.images.iter().all(|row| row.difference.is_none())
    }

    /// The first difference of all, by stages, then by pictures.
    #[must_use]
    pub fn first(&self) -> Option<(&str, &FirstDifference)> {
        let stages = self.stages.iter().map(|row| (row.stage, &row.difference));
        let images = self.images.iter().map(|row| (row.scene, &row.difference));
        stages.chain(images).find_map(|(name, difference)| Some((name, difference.first.as_ref()?)))
    }
}

/// Runs every kernel on the CPU and on `gpu`, each stage with the same inputs, and renders each built-in scene and one
/// of many random surfaces on both. With
/// `gpu_from`, the GPU goes on with its own results from that stage on, and pictures are compared as the film's stage.
///
/// `progress` is told what is done, and stops the work by returning false.
///
/// # Errors
/// [`RenderError::Interrupted`], and what devices and maps report.
pub fn verify(
    gpu: &Device,
    gpu_from: Option<Kernel>,
    seed: u32,
    progress: &mut dyn FnMut(Progress) -> bool,
) -> Result<Verification, RenderError> {
    let total = 8 + BUILT_IN.len() as u64;
    let mut done = 0;
    let mut tick = |phase| {
        let goes_on = progress(Progress { phase, done, total });
        done += 1;
        if goes_on { Ok(()) } else { Err(RenderError::Interrupted) }
    };
    let twin = gpu.twin(gpu_from);
    tick("arithmetic")?;
    arithmetic(&twin, seed)?;
    tick("layouts")?;
    let layouts_wrong = layouts(&twin, gpu)?;
    tick("sort")?;
    let keys: Vec<u32> = (0..100_000).map(|i| pcg4d([seed, i, 1, 0])[0]).collect();
    let keys = twin.upload("keys", &keys)?;
    let mut plan = Plan::new();
    RadixSort::plan(&twin, &mut plan, &keys, 100_000, 32)?;
    RadixSort::plan_plain(&twin, &mut plan, &keys, 100_000, 32)?;
    let quads = twin.buffer::<Site>("quads", 25_000)?;
    plan.each(Kernel::CopyQuads, 25_000, &[&keys, &quads]);
    twin.run(&plan)?;
    for (hash, phase) in [(Hash::Linear, "linear map"), (Hash::Teschner, "Teschner map"), (Hash::Morton, "Morton map")]
    {
        tick(phase)?;
        map(&twin, hash, seed)?;
    }
    tick("other techniques")?;
    rivals(&twin, seed)?;
    let mut images = Vec::new();
    let built_in = BUILT_IN.iter().map(|built_in| {
        let Ok(scene) = Scene::parse(built_in.name, built_in.text) else { unreachable!("built-in scenes are tested") };
        (built_in.name, scene)
    });
    let scenes = built_in.chain(std::iter::once_with(|| (CROWD, crowd(seed))));
    for ((name, scene), hash) in scenes.zip([Hash::Linear, Hash::Teschner, Hash::Morton].into_iter().cycle()) {
        tick(name)?;
        let settings = small(&scene, hash, seed);
        for other in other_ways(&settings) {
            render(&scene, &other, &twin, &mut |_| true)?;
        }
        let expected = render(&scene, &settings, &twin, &mut |_| true)?.image;
        if gpu_from.is_none() {
            let found = render(&scene, &settings, gpu, &mut |_| true)?.image;
            images.push(ImageComparison {
                scene: name,
                difference: Difference::of::<f32>("image", expected.rgb.as_flattened(), found.rgb.as_flattened()),
                cpu_sha256: expected.sha256(),
                gpu_sha256: found.sha256(),
            });
        }
    }
    Ok(Verification {
        device: gpu.name(),
        exact: gpu.is_exact(),
        seed,
        stages: twin.comparisons(),
        images,
        layouts_wrong,
    })
}

/// Settings under which a scene shows all its parts in a second.
fn small(scene: &Scene, hash: Hash, seed: u32) -> Settings {
    let defaults = Settings::of(scene);
    Settings {
        size: [40, 30],
        photons: 20_000,
        caustic_photons: 10_000,
        k: 60,
        spp: 2,
        hash,
        gather: Gather::Auto,
        seed,
        show: Show::Beauty,
        keep: Keep::Visible,
        layers: LayerKind::OF_PHOTON_MAPS.to_vec(),
        ..defaults
    }
}

/// The same scene by stages that those settings leave out.
fn other_ways(settings: &Settings) -> [Settings; 5] {
    let smaller = Settings { size: [20, 15], photons: 5000, caustic_photons: 2000, k: 30, ..settings.clone() };
    // Neither has all of the layers.
    let smaller = Settings { layers: Vec::new(), keep: Keep::All, ..smaller };
    let paths = Settings { integrator: Integrator::Path, ..smaller.clone() };
    let (filter, surface) = (Filter::Gaussian, Surface::Own);
    let roughly = Settings { thin: 2, nearest: Nearest::Approximate, interpolate: 3, ..smaller.clone() };
    let compact = Settings { compact: true, ..smaller.clone() };
    let compact_roughly = Settings { compact: true, ..roughly.clone() };
    [paths, roughly, compact, compact_roughly, Settings { filter, surface, final_gather: 2, ..smaller }]
}

fn arithmetic(twin: &Device, seed: u32) -> Result<(), RenderError> {
    let params = twin.upload("probe: params", &[ArithmeticParams { first: seed, count: PAIRS, seed }])?;
    let results = twin.buffer::<Arithmetic>("probe: results", u64::from(PAIRS))?;
    let mut plan = Plan::new();
    plan.each(Kernel::ProbeArithmetic, PAIRS, &[&params, &results]);
    Ok(twin.run(&plan)?)
}

/// The kernels that write down where they find fields.
const LAYOUT_KERNELS: [Kernel; 9] = [
    Kernel::LayoutMap,
    Kernel::LayoutGrid,
    Kernel::LayoutRivals,
    Kernel::LayoutKd,
    Kernel::LayoutSort,
    Kernel::LayoutScene,
    Kernel::LayoutSurface,
    Kernel::LayoutLedger,
    Kernel::LayoutFilm,
];

/// Runs the layout kernels, and names the records that are not laid out as the host lays them out, on either device.
fn layouts(twin: &Device, gpu: &Device) -> Result<Vec<String>, RenderError> {
    let mut wrong = Vec::new();
    for kernel in LAYOUT_KERNELS {
        for device in [twin, gpu] {
            wrong.extend(misplaced(kernel, &layout_words(device, kernel)?));
        }
    }
    wrong.sort();
    wrong.dedup();
    Ok(wrong)
}

/// The records whose size or fields a kernel found elsewhere than the host has them.
fn misplaced(kernel: Kernel, found: &[u32]) -> Vec<String> {
    let records = LAYOUTS.iter().find(|(name, _)| *name == kernel.entry_point()).map_or(&[][..], |row| row.1);
    let mut wrong = Vec::new();
    let mut at = 0;
    for &(record, words) in records {
        // Its size, then its fields one after another.
        let expected = std::iter::once(words).chain(0..words).map(|word| NUMBERED + word as u32);
        if !expected.eq(found[at..].iter().take(words + 1).copied()) {
            wrong.push(record.to_string());
        }
        at += words + 1;
    }
    wrong
}

fn layout_words(device: &Device, kernel: Kernel) -> Result<Vec<u32>, RenderError> {
    let words = device.buffer::<u32>("probe: layout", u64::from(LAYOUT_WORDS))?;
    let mut buffers = Vec::new();
    let bindings = kernel.bindings();
    for binding in &bindings[..bindings.len() - 1] {
        let numbered: Vec<u32> = (0..2 * binding.record_bytes / 4).map(|word| NUMBERED + word).collect();
        buffers.push(device.upload("probe: numbered words", &numbered)?);
    }
    let mut all: Vec<&Buffer> = buffers.iter().collect();
    all.push(&words);
    let mut plan = Plan::new();
    plan.each(kernel, 1, &all);
    device.run(&plan)?;
    Ok(device.read(&words, u64::from(LAYOUT_WORDS))?)
}

/// Random photons, some of them crowded, and places to look for them, one of which does not look. The crowd is not so dense that cells become as
/// narrow as they may, a 32nd of the radius: there, lanes of llvmpipe, which wait for each other, together came to its 65,535 turns for a seed in
/// twenty.
fn photons_and_queries(seed: u32, of: u32, photons: u32) -> (Vec<Photon>, Vec<Query>) {
    let unit = |i: u32, stream: u32| {
        let random = pcg4d([seed, i, stream, of]);
        [random[0], random[1], random[2]].map(u32_to_unit)
    };
    let place = |i: u32, stream: u32| {
        let [x, y, z] = unit(i, stream);
        if i.is_multiple_of(16) { [0.4 + 0.1 * x, 0.5 + 0.1 * y, 0.5] } else { [x - 0.5, y, 3.0 * z] }
    };
    let photons = (0..photons)
        .map(|i| Photon { position: place(i, 2), power: unit(i, 3).map(|u| u * u), direction: i, primitive: i % 7 })
        .collect();
    let mut queries: Vec<Query> = (0..QUERIES).map(|i| Query { position: place(i, 4), active: 1 }).collect();
    queries[1].active = 0;
    (photons, queries)
}

/// Builds a map and searches it in every way.
fn map(twin: &Device, hash: Hash, seed: u32) -> Result<(), RenderError> {
    let (photons, queries) = photons_and_queries(seed, hash.code(), PHOTONS);
    let options = MapOptions { radius: 0.28, hash, table: None, cell: None };
    let map = PhotonMap::build(twin, &photons, &options)?;
    for k in KS {
        for gather in [Gather::Histogram, Gather::Heap, Gather::List] {
            map.irradiance(twin, &queries, k, gather)?;
            map.k_nearest(twin, &queries, k, gather)?;
        }
    }
    map.density(twin, &queries)?;
    let mut largest = LargestPower::default();
    largest.see(&photons);
    let mut streamed = DensityStreamed::new(twin, &queries, largest, &options)?;
    for chunk in photons.chunks(photons.len() / 2 + 1) {
        streamed.add(chunk)?;
    }
    Ok(())
}

/// Has every technique find photons.
fn rivals(twin: &Device, seed: u32) -> Result<(), RenderError> {
    let (photons, queries) = photons_and_queries(seed, 3, PHOTONS_OF_RIVALS);
    let photons = Photons::upload(twin, &photons)?;
    for technique in Technique::ALL.iter().filter(|technique| technique.runs_on(twin)) {
        let index = technique.build(twin, &photons, 0.28)?;
        for k in KS {
            caustic_rivals::irradiance(twin, index.as_ref(), &photons, 0.28, &queries, k)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_record_lies_where_the_host_has_it_and_a_moved_one_is_named() {
        let mut records = 0;
        for kernel in LAYOUT_KERNELS {
            let found = layout_words(&Device::cpu(), kernel).unwrap();
            assert_eq!(misplaced(kernel, &found), [""; 0]);
            let all = LAYOUTS.iter().find(|(name, _)| *name == kernel.entry_point()).unwrap().1;
            let mut at = 0;
            for &(record, words) in all {
                // Another size; two fields that changed places; a field that is not there.
                let mut size = found.clone();
                size[at] += 1;
                let mut swapped = found.clone();
                swapped.swap(at + 1, at + words);
                let mut missing = found.clone();
                missing[at + words] = 0;
                // A record of one word has no two fields.
                let faults = [Some(size), Some(missing), Some(swapped).filter(|_| words > 1)];
                for faulty in faults.into_iter().flatten() {
                    assert_eq!(misplaced(kernel, &faulty), [record], "{record}");
                }
                at += words + 1;
                records += 1;
            }
            assert!(at <= LAYOUT_WORDS as usize, "{}: no room for all words", kernel.entry_point());
        }
        assert_eq!(records, 41);
    }
}
