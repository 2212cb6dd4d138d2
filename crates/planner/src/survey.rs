//! Small renders of a scene that tell of large ones.
//!
//! A small render has fewer photons, and discs that are larger by as much: an estimate then sums as many photons, so it costs as much and is
//! as noisy. Three numbers of photons in a disc, a factor of four apart, say how time, noise and bias depend on it; seeds tell noise
//! from bias; a render of an eighth the size tells what does not depend on size. Light that is not from photons is looked at in pixels as small as
//! those of the picture, since edges, which are most of its noise, are a larger part of a small one.

mod noise;

use crate::scout::{Pilot, Scout, of_maps};
use caustic_photon_map::{Hash, MAX_K, RADII, most_entries};
use caustic_renderer::scene::limits::MAX_SIDE;
use caustic_renderer::{Integrator, RenderError, Settings, Show};
use noise::Expected;
use serde::{Deserialize, Serialize};

pub(crate) use noise::{Seeds, noise_and_blur};

/// Photons of a small render for both maps together.
const CPU_PHOTONS: f64 = 49_152.0;
const GPU_PHOTONS: f64 = 1_048_576.0;
/// Pixels of a small render.
const CPU_PIXELS: f64 = 3072.0;
const GPU_PIXELS: f64 = 131_072.0;
/// Pixels of what is not from photons, at the most.
const CPU_DIRECT_PIXELS: f64 = 20_480.0;
/// Camera samples of a small render's pixels.
const SPP: u32 = 4;
/// Numbers of camera samples whose noise is looked at. The last shows rare bright samples that few do not meet.
const CPU_SAMPLES: [u32; 3] = [1, 4, 32];
const GPU_SAMPLES: [u32; 3] = [1, 4, 256];
/// How far a CPU's many samples are believed about rare bright ones: they are so few that one speck may be such as hardly any picture has, and believed in
/// full makes a preview of the courtyard take 30 s instead of 8.
const CPU_TRUST: f64 = 0.5;
/// How much smaller the smallest render is.
const TINY: f64 = 8.0;
/// Positions of photons that are kept of a map.
const POSITIONS: usize = 1024;
/// Ratio of the numbers of photons in a disc.
pub(crate) const STEP: u32 = 4;
/// Seeds of small renders: of no picture that anyone asks for.
pub(crate) const SEEDS: [u32; 3] = [0x51de_0001, 0x51de_0002, 0x51de_0003];

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
    /// Three numbers of camera samples.
    pub samples: [f64; 3],
    /// relMSE of one pass from all but the photons, with each of them.
    pub sample_noise: [f64; 3],
    /// relMSE from photons, with each number of them in a disc.
    pub photon_noise: [f64; 3],
    /// Mean square of how much pictures of neighbouring numbers of photons in a disc differ but for noise, as relMSE.
    pub blur: [f64; 2],
    /// How far all this is off where a render was rehearsed.
    pub correction: Correction,
}

/// What a rehearsal says of a survey.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Correction {
    /// More time until the first photon, s; it may be less than none.
    pub setup_s: f64,
    /// Factor of the time of a pass.
    pub pass: f64,
    /// Factor of the noise of photons.
    pub photon_noise: f64,
    /// Factor of the relMSE from blur.
    pub blur: f64,
}

impl Default for Correction {
    fn default() -> Self {
        Self { setup_s: 0.0, pass: 1.0, photon_noise: 1.0, blur: 1.0 }
    }
}

impl Survey {
    /// Surveys a scene near `settings`: their ratio of photons for the two maps, their k, and their largest radius, or one that suffices
    /// if it is automatic.
    ///
    /// # Errors
    /// Those of renders; [`RenderError::Interrupted`] if the scout is not to go on.
    pub fn take(scout: &mut Scout<'_>, settings: &Settings) -> Result<Self, RenderError> {
        let gpu = scout.device.is_gpu();
        let mut small = reduced(settings, gpu);
        let discs = discs(settings.k);
        let shrunk = f64::from(settings.photons.max(1)) / f64::from(small.photons.max(1));
        small.k = discs[1];
        if settings.automatic_radius {
            small.radius = enough(scout, &small)?;
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
        let positions = scout.positions(&small, POSITIONS)?;
        // The first one waits for the driver to compile, and for memory.
        scout.pilot(&Settings { seed: SEEDS[0], ..tiny.clone() })?;
        let few = scout.pilot(&Settings { seed: SEEDS[1], ..tiny.clone() })?;
        let mut pilots = Vec::new();
        for (i, k) in discs.into_iter().enumerate() {
            let radius = within(f64::from(small.radius) * f64::from(STEP).sqrt().powi(i as i32 - 1));
            pilots.push(seeds(scout, &Settings { k, radius, ..small.clone() })?);
        }
        let direct = of_samples(scout, settings, &small)?;
        Ok(conclude(&few, &pilots, direct.as_deref(), [&tiny, &small], discs, gpu, positions))
    }
}

/// Numbers of camera samples whose noise is looked at.
fn samples(gpu: bool) -> [u32; 3] {
    if gpu { GPU_SAMPLES } else { CPU_SAMPLES }
}

/// The same render with each seed.
pub(crate) fn seeds(scout: &mut Scout<'_>, settings: &Settings) -> Result<Seeds, RenderError> {
    let [a, b, c] = SEEDS.map(|seed| scout.pilot(&Settings { seed, ..settings.clone() }));
    Ok([a?, b?, c?])
}

/// Two seeds of what is not from photons for each of three numbers of camera samples, with pixels as small as those of the picture; none if all is from photons.
fn of_samples(
    scout: &mut Scout<'_>,
    settings: &Settings,
    small: &Settings,
) -> Result<Option<Vec<[Pilot; 2]>>, RenderError> {
    let of_maps = of_maps(settings);
    if of_maps && !matches!(settings.show, Show::Beauty | Show::Direct) {
        return Ok(None);
    }
    // Paths take too long for more than a small picture.
    let most = match (of_maps || settings.integrator == Integrator::Direct, scout.device.is_gpu()) {
        (_, true) => GPU_PIXELS,
        (true, false) => CPU_DIRECT_PIXELS,
        (false, false) => CPU_PIXELS,
    };
    let show = if of_maps { Show::Direct } else { settings.show };
    let direct = Settings { size: scaled(settings.size, most), show, ..small.clone() };
    let numbers = samples(scout.device.is_gpu());
    let of = |spp| -> Result<[Pilot; 2], RenderError> {
        let [a, b] = [SEEDS[0], SEEDS[1]].map(|seed| scout.pilot(&Settings { spp, seed, ..direct.clone() }));
        Ok([a?, b?])
    };
    numbers.into_iter().map(of).collect::<Result<_, _>>().map(Some)
}

/// The settings of the small renders.
fn reduced(settings: &Settings, gpu: bool) -> Settings {
    let all = f64::from(settings.photons) + f64::from(settings.caustic_photons);
    let most = if gpu { GPU_PHOTONS } else { CPU_PHOTONS };
    let share = (most / all.max(1.0)).min(1.0);
    let fewer = |photons: u32| (f64::from(photons) * share).ceil() as u32;
    Settings {
        size: scaled(settings.size, if gpu { GPU_PIXELS } else { CPU_PIXELS }),
        photons: fewer(settings.photons).max(1),
        caustic_photons: fewer(settings.caustic_photons),
        spp: SPP,
        chunk: None,
        ..settings.clone()
    }
}

/// A picture's size, with at most so many pixels.
fn scaled(size: [u32; 2], most: f64) -> [u32; 2] {
    let [width, height] = size.map(f64::from);
    let scale = (most / (width * height)).sqrt().min(1.0);
    [width, height].map(|length| ((length * scale).round() as u32).clamp(1, MAX_SIDE))
}

/// Three numbers of photons in a disc, around `k`.
fn discs(k: u32) -> [u32; 3] {
    let least = 2;
    let middle = k.clamp(least * STEP, MAX_K / STEP);
    [middle / STEP, middle, middle * STEP]
}

/// A radius within which estimates of small renders find their photons; the scene's own if that cannot be found.
fn enough(scout: &mut Scout<'_>, small: &Settings) -> Result<f32, RenderError> {
    match scout.plain(&Settings { automatic_radius: true, ..small.clone() }, 1) {
        Ok(found) => Ok(found.report.radius_m),
        Err(RenderError::NoRadius { .. }) => Ok(small.radius),
        Err(error) => Err(error),
    }
}

/// The nearest radius that a map can have, m.
pub(crate) fn within(radius: f64) -> f32 {
    (radius as f32).clamp(*RADII.start(), *RADII.end())
}

/// What is to be learnt from small renders: one of `tiny` settings, `small` ones for each number of photons in a disc, and those of what is
/// not from photons.
fn conclude(
    few: &Pilot,
    pilots: &[Seeds],
    direct: Option<&[[Pilot; 2]]>,
    [tiny, small]: [&Settings; 2],
    discs: [u32; 3],
    gpu: bool,
    positions: [Vec<[f32; 3]>; 2],
) -> Survey {
    let spp = samples(gpu);
    let all = || pilots.iter().flatten();
    let middle = |of: &dyn Fn(&Pilot) -> f64| median(all().map(of).collect());
    let rays =
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
    let image_s = Work::through((rays(tiny), few.image_s), (rays(small), image(1))).fixed;
    // Light of the largest discs is the least noisy.
    let of_maps = Expected::mean(&pilots[2], true);
    let (expected, sample_noise) = match direct {
        Some(direct) => {
            let light = Expected::of_two(&direct[2]);
            let image = &direct[0][0].image;
            let all = of_maps.resized([image.width, image.height]).plus(&light);
            (light.resized(small.size).plus(&of_maps), [0, 1, 2].map(|i| all.noise_of_two(&direct[i])))
        }
        None => (of_maps, [0.0; 3]),
    };
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
        sample_s: [0, 1, 2].map(|i| (image(i) - image_s).max(0.0) / rays(small)),
        samples: spp.map(f64::from),
        sample_noise: by_more_samples(spp, sample_noise, if gpu { 1.0 } else { CPU_TRUST }),
        photon_noise: [0, 1, 2].map(|i| expected.noise_of_maps(&pilots[i])),
        blur: [0, 1].map(|step| expected.blur([&pilots[step], &pilots[step + 1]])),
        correction: Correction::default(),
    }
}

/// Noise of few samples is that of many, times how many fewer they are, or more, since samples are stratified: many of them know better of rare
/// bright ones. They are believed as far as the power `trust` of the ratio goes.
fn by_more_samples(samples: [u32; 3], [first, second, last]: [f64; 3], trust: f64) -> [f64; 3] {
    let [a, b, c] = samples.map(f64::from);
    let raised = |few: f64, by_many: f64| {
        if by_many > few && few > 0.0 { few * (by_many / few).powf(trust) } else { few.max(by_many) }
    };
    let second = raised(second, last * c / b);
    [raised(first, second * b / a), second, last]
}

pub(crate) fn median(mut values: Vec<f64>) -> f64 {
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
    fn rare_bright_samples_count_for_few_samples_too() {
        let by_many = |noise, trust| by_more_samples([1, 4, 64], noise, trust);
        assert_eq!(by_many([0.9, 0.1, 1e-3], 1.0), [0.9, 0.1, 1e-3]);
        assert_eq!(by_many([0.1, 0.125, 0.125], 1.0), [8.0, 2.0, 0.125]);
        assert_eq!(by_many([2.0, 0.125, 0.125], 0.5), [2.0, 0.5, 0.125]);
        assert_eq!(by_many([0.0, 0.0, 0.125], 0.5), [8.0, 2.0, 0.125]);
    }

    #[test]
    fn discs_are_four_times_apart_and_within_what_kernels_know() {
        for k in [1, 7, 8, 50, 150, 256, 1024] {
            let [a, b, c] = discs(k);
            assert!(a >= 2 && b == a * 4 + b % 4 && c == 4 * b && c <= MAX_K, "{a} {b} {c}");
        }
    }
}
