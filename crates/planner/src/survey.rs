//! Small renders of a scene that tell of large ones.
//!
//! A small render has fewer photons, and discs that are larger by as much: an estimate then sums as many photons, so it costs as much and is
//! as noisy. Three numbers of photons in a disc, a factor of four apart, say how time, noise and bias depend on it; seeds tell noise
//! from bias; a render of an eighth the size tells what does not depend on size.

use crate::pilot::{Pilot, pilot};
use caustic_device::Device;
use caustic_photon_map::{Hash, MAX_K, RADII, most_entries};
use caustic_renderer::scene::Scene;
use caustic_renderer::scene::limits::MAX_SIDE;
use caustic_renderer::{Integrator, PhotonFile, RenderError, Settings, Show};
use serde::{Deserialize, Serialize};

pub use crate::pilot::Costs;

/// Photons of a small render for both maps together.
const CPU_PHOTONS: f64 = 49_152.0;
const GPU_PHOTONS: f64 = 1_048_576.0;
/// Pixels of a small render.
const CPU_PIXELS: f64 = 3072.0;
const GPU_PIXELS: f64 = 131_072.0;
/// Camera samples of its pixels.
const SPP: u32 = 4;
/// Camera samples of what is not from photons, where it has to be known well.
const MANY: u32 = 64;
/// How much smaller the smallest render is.
const TINY: f64 = 8.0;
/// Positions of photons that are kept of a map.
const POSITIONS: usize = 1024;
/// Ratio of the numbers of photons in a disc.
const STEP: u32 = 4;
/// Seeds of small renders: of no picture that anyone asks for.
const SEEDS: [u32; 3] = [0x51de_0001, 0x51de_0002, 0x51de_0003];

/// The same render with each seed.
type Seeds = [Pilot; 3];

/// Work that takes `fixed` seconds and `each` seconds for each item.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Work {
    /// s.
    pub fixed: f64,
    /// s.
    pub each: f64,
}

impl Work {
    /// Through two measurements of items and seconds, neither part below 0.
    fn through((few, few_s): (f64, f64), (many, many_s): (f64, f64)) -> Self {
        if many <= few || many <= 0.0 {
            return Self { fixed: many_s.max(0.0), each: 0.0 };
        }
        let each = ((many_s - few_s) / (many - few)).clamp(0.0, many_s.max(0.0) / many);
        Self { fixed: (many_s - each * many).max(0.0), each }
    }

    /// Seconds for so many items.
    #[must_use]
    pub fn of(&self, items: f64) -> f64 {
        self.fixed + self.each * items
    }
}

/// What small renders of a scene say of larger ones on a device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Survey {
    /// Photons emitted for the global and for the caustic map; 0 if there is no such map.
    pub emitted: [f64; 2],
    /// Photons stored for each that is emitted.
    pub stored: [f64; 2],
    /// Where some photons of each map lie, m: how they crowd says how large a table is.
    pub positions: [Vec<[f32; 3]>; 2],
    /// The three numbers of photons in a disc.
    pub k: [f64; 3],
    /// Largest radius of the middle one, m.
    pub radius: f64,
    /// Until the first photon, s.
    pub setup_s: f64,
    /// Photons of the global and of the caustic map: traced, and built into a map but for its table.
    pub photons: [Work; 2],
    /// An entry of a table, s.
    pub entry_s: f64,
    /// What an image takes however small it is, s.
    pub image_s: f64,
    /// A camera sample with each number of photons in a disc, s.
    pub sample_s: [f64; 3],
    /// relMSE of one pass from all but the photons, with one camera sample a pixel and with four.
    pub sample_noise: [f64; 2],
    /// relMSE from photons, with each number of them in a disc.
    pub photon_noise: [f64; 3],
    /// Mean square of how much pictures of neighbouring numbers of photons in a disc differ but for noise, as relMSE.
    pub blur: [f64; 2],
}

impl Survey {
    /// Surveys a scene near `settings`: their ratio of photons for the two maps, their k, and their largest radius, or one that suffices
    /// if it is automatic.
    ///
    /// # Errors
    /// Those of renders; [`RenderError::Interrupted`] if `go_on` returns false.
    pub fn take(
        scene: &Scene,
        settings: &Settings,
        device: &Device,
        costs: Costs,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Self, RenderError> {
        let mut small = reduced(settings, device.is_gpu());
        let discs = discs(settings.k);
        let shrunk = f64::from(settings.photons.max(1)) / f64::from(small.photons.max(1));
        small.k = discs[1];
        if settings.automatic_radius {
            small.radius = enough(scene, &small, device, go_on)?;
        } else {
            // As many photons within it, and as many more as the middle disc has.
            let wider = (shrunk * f64::from(discs[1]) / f64::from(settings.k.max(1))).sqrt();
            small.radius = within(f64::from(settings.radius) * wider);
        }
        small.automatic_radius = false;
        // Cells that are as wide beside a disc: the full tables' limit, of cells as many times wider along three axes.
        let photons = u64::from(settings.photons.max(settings.caustic_photons));
        let most = f64::from(settings.table.unwrap_or(most_entries(photons)));
        let cells = |shrunk: f64| Some((most / shrunk.powf(1.5)).clamp(1.0, most) as u32);
        let scatters = settings.hash != Hash::Auto && settings.hash != Hash::Linear;
        small.table = if scatters { settings.table } else { cells(shrunk) };
        let tiny = {
            let scale = |photons: u32| (f64::from(photons) / TINY).ceil() as u32;
            let size = small.size.map(|side| ((f64::from(side) / TINY.sqrt()) as u32).max(1));
            let radius = within(f64::from(small.radius) * TINY.sqrt());
            let (photons, caustic_photons) = (scale(small.photons).max(1), scale(small.caustic_photons));
            let table = if scatters { settings.table } else { cells(shrunk * TINY) };
            Settings { photons, caustic_photons, size, radius, table, ..small.clone() }
        };
        let positions = positions(scene, &small, device, go_on)?;
        // The first one waits for the driver to compile, and for memory.
        pilot(scene, &Settings { seed: SEEDS[0], ..tiny.clone() }, device, costs, go_on)?;
        let few = pilot(scene, &Settings { seed: SEEDS[1], ..tiny.clone() }, device, costs, go_on)?;
        let mut seeds = |settings: &Settings| -> Result<Seeds, RenderError> {
            let [a, b, c] =
                SEEDS.map(|seed| pilot(scene, &Settings { seed, ..settings.clone() }, device, costs, go_on));
            Ok([a?, b?, c?])
        };
        let mut pilots = Vec::new();
        for (i, k) in discs.into_iter().enumerate() {
            let radius = within(f64::from(small.radius) * f64::from(STEP).sqrt().powi(i as i32 - 1));
            pilots.push(seeds(&Settings { k, radius, ..small.clone() })?);
        }
        let single = seeds(&Settings { spp: 1, ..small.clone() })?;
        let of_maps = matches!(settings.integrator, Integrator::Photon | Integrator::Progressive);
        let direct = Settings { show: Show::Direct, spp: MANY, seed: SEEDS[0], ..small.clone() };
        let many = (of_maps && settings.show == Show::Beauty).then(|| pilot(scene, &direct, device, costs, go_on));
        let many = many.transpose()?;
        Ok(conclude(&few, &pilots, &single, many.as_ref(), [&tiny, &small], discs, positions))
    }
}

/// Where the first photons of each map lie.
fn positions(
    scene: &Scene,
    small: &Settings,
    device: &Device,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<[Vec<[f32; 3]>; 2], RenderError> {
    let mut positions = [Vec::new(), Vec::new()];
    if matches!(small.integrator, Integrator::Photon | Integrator::Progressive) {
        let traced = PhotonFile::trace(scene, small, device, &mut |_| go_on())?;
        for (map, photons) in traced.header.maps.iter().zip(&traced.photons) {
            let of = usize::from(map.map == "caustic");
            positions[of] = photons.iter().take(POSITIONS).map(|photon| photon.position).collect();
        }
    }
    Ok(positions)
}

/// The settings of the small renders.
fn reduced(settings: &Settings, gpu: bool) -> Settings {
    let all = f64::from(settings.photons) + f64::from(settings.caustic_photons);
    let most = if gpu { GPU_PHOTONS } else { CPU_PHOTONS };
    let share = (most / all.max(1.0)).min(1.0);
    let fewer = |photons: u32| (f64::from(photons) * share).ceil() as u32;
    let [width, height] = settings.size.map(f64::from);
    let pixels = if gpu { GPU_PIXELS } else { CPU_PIXELS };
    // No larger than what is asked for: edges, which are most of the noise of few samples, are a larger part of a small picture.
    let scale = (pixels / (width * height)).sqrt().min(1.0);
    let side = |length: f64| ((length * scale).round() as u32).clamp(1, MAX_SIDE);
    Settings {
        size: [side(width), side(height)],
        photons: fewer(settings.photons).max(1),
        caustic_photons: fewer(settings.caustic_photons),
        spp: SPP,
        chunk: None,
        ..settings.clone()
    }
}

/// Three numbers of photons in a disc, around `k`.
fn discs(k: u32) -> [u32; 3] {
    let least = 2;
    let middle = k.clamp(least * STEP, MAX_K / STEP);
    [middle / STEP, middle, middle * STEP]
}

/// A radius within which estimates of small renders find their photons; the scene's own if that cannot be found.
fn enough(
    scene: &Scene,
    small: &Settings,
    device: &Device,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<f32, RenderError> {
    let found = pilot(scene, &Settings { automatic_radius: true, ..small.clone() }, device, Costs::BuiltIn, go_on);
    match found {
        Ok(found) => Ok(found.report.radius_m),
        Err(RenderError::NoRadius { .. }) => Ok(small.radius),
        Err(error) => Err(error),
    }
}

/// The nearest radius that a map can have, m.
pub(crate) fn within(radius: f64) -> f32 {
    (radius as f32).clamp(*RADII.start(), *RADII.end())
}

/// What is to be learnt from small renders: one of `tiny` settings, and `small` ones for each number of photons in a disc, and
/// those of a `single` sample a pixel; `many` samples say what is not from photons.
fn conclude(
    few: &Pilot,
    pilots: &[Seeds],
    single: &Seeds,
    many: Option<&Pilot>,
    [tiny, small]: [&Settings; 2],
    discs: [u32; 3],
    positions: [Vec<[f32; 3]>; 2],
) -> Survey {
    let all = || pilots.iter().flatten();
    let middle = |of: &dyn Fn(&Pilot) -> f64| median(all().map(of).collect());
    let samples =
        |settings: &Settings| f64::from(settings.size[0]) * f64::from(settings.size[1]) * f64::from(settings.spp);
    let map = |pilot: &Pilot, of: usize| {
        let name = ["global", "caustic"][of];
        let map = pilot.report.maps.iter().find(|map| map.map == name);
        map.map_or([0.0; 3], |map| [map.photons_emitted, map.photons_stored, map.table_entries].map(f64::from))
    };
    let first = &pilots[1][0];
    let maps = [0, 1].map(|of| map(first, of));
    let photons = [0, 1].map(|of| {
        let small_s = middle(&|pilot| pilot.map_s[of]);
        Work::through((map(few, of)[0], few.map_s[of]), (maps[of][0], small_s))
    });
    let entries = maps[0][2] + maps[1][2];
    let image = |i: usize| pilots[i].iter().map(|pilot| pilot.image_s).fold(f64::INFINITY, f64::min);
    let image_s = Work::through((samples(tiny), few.image_s), (samples(small), image(1))).fixed;
    let expected = expected(&pilots[2], many);
    let noise = [0, 1, 2].map(|i| noise(&pilots[i], &expected));
    let direct = noise.iter().map(|[all, photons]| (all - photons).max(0.0)).sum::<f64>() / 3.0;
    let [all, photons_alone] = self::noise(single, &expected);
    Survey {
        emitted: maps.map(|map| map[0]),
        stored: maps.map(|[emitted, stored, _]| if emitted > 0.0 { stored / emitted } else { 0.0 }),
        positions,
        k: discs.map(f64::from),
        radius: f64::from(small.radius),
        setup_s: middle(&|pilot| pilot.setup_s),
        photons,
        entry_s: if entries > 0.0 { middle(&|pilot| pilot.tables_s) / entries } else { 0.0 },
        image_s,
        sample_s: [0, 1, 2].map(|i| (image(i) - image_s).max(0.0) / samples(small)),
        sample_noise: [(all - photons_alone).max(direct), direct],
        photon_noise: noise.map(|[_, photons]| photons),
        blur: [0, 1].map(|step| blur([&pilots[step], &pilots[step + 1]], &expected)),
    }
}

/// Two seeds that differ.
const PAIRS: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// A channel of a pixel, and the part of it that is from photon maps.
fn values(pilot: &Pilot, i: usize) -> [f64; 2] {
    [pilot.image.rgb.as_flattened()[i], pilot.indirect.as_flattened()[i]].map(f64::from)
}

/// What each channel of each pixel is expected to be: the mean light of the largest discs, the least noisy, and the rest by many camera samples. By a
/// picture's own noise, a bright speck would be set against itself, and count little.
fn expected(largest: &Seeds, many: Option<&Pilot>) -> Vec<f64> {
    let mean = |i: usize, part: usize| largest.iter().map(|pilot| values(pilot, i)[part]).sum::<f64>() / 3.0;
    let channel = |i: usize| match many {
        Some(many) => values(many, i)[0] + mean(i, 1),
        None => mean(i, 0),
    };
    (0..3 * largest[0].image.rgb.len()).map(channel).collect()
}

/// The mean of `of` two seeds and a channel over all, relative to the square of what is expected, as in [`caustic_metrics::relmse`].
fn relative(expected: &[f64], of: impl Fn([usize; 2], usize) -> f64) -> f64 {
    let one = |(i, expected): (usize, &f64)| {
        let sum: f64 = PAIRS.iter().map(|pair| of(*pair, i)).sum();
        sum / (expected * expected + caustic_metrics::EPSILON)
    };
    expected.iter().enumerate().map(one).sum::<f64>() / (3 * expected.len()) as f64
}

/// relMSE of one picture from noise, and the part of it from photon maps: half the mean square difference of two seeds.
fn noise(seeds: &Seeds, expected: &[f64]) -> [f64; 2] {
    [0, 1].map(|part| {
        relative(expected, |[a, b], i| (values(&seeds[a], i)[part] - values(&seeds[b], i)[part]).powi(2) / 2.0)
    })
}

/// Mean product of the differences that two seeds see between neighbouring discs: noise of two seeds is independent, so that it has no part
/// in it.
fn blur([less, more]: [&Seeds; 2], expected: &[f64]) -> f64 {
    let differs = |seed: usize, i: usize| values(&more[seed], i)[1] - values(&less[seed], i)[1];
    relative(expected, |[a, b], i| differs(a, i) * differs(b, i))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_a_line_with_parts_that_are_not_negative() {
        let work = Work::through((10.0, 2.0), (110.0, 4.0));
        assert!((work.fixed - 1.8).abs() < 1e-12 && (work.each - 0.02).abs() < 1e-12);
        assert!((work.of(1000.0) - 21.8).abs() < 1e-9);
        // Faster for more, and faster than in proportion.
        assert_eq!(Work::through((10.0, 2.0), (110.0, 1.0)), Work { fixed: 1.0, each: 0.0 });
        assert_eq!(Work::through((10.0, 0.0), (100.0, 5.0)), Work { fixed: 0.0, each: 0.05 });
        assert_eq!(Work::through((0.0, 0.0), (0.0, 0.0)), Work::default());
    }

    #[test]
    fn discs_are_four_times_apart_and_within_what_kernels_know() {
        for k in [1, 7, 8, 50, 150, 256, 1024] {
            let [a, b, c] = discs(k);
            assert!(a >= 2 && b == a * 4 + b % 4 && c == 4 * b && c <= MAX_K, "{a} {b} {c}");
        }
    }
}
