//! Settings for a budget of time, error or memory.

use crate::cache::Surveyor;
use crate::predict::Prediction;
use crate::rehearsal::Rehearsal;
use crate::survey::{Survey, within};
use caustic_device::Device;
use caustic_photon_map::Hash;
use caustic_renderer::scene::CompiledScene;
use caustic_renderer::scene::limits::{MAX_K, MAX_PHOTONS};
use caustic_renderer::{ExpectedMap, RenderError, Settings, Stop};

/// How good a picture shall be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// Where things are.
    Draft,
    /// What it will look like.
    Preview,
    /// To be shown.
    Final,
    /// To compare others with.
    Reference,
}

impl Quality {
    /// The relMSE that it stands for.
    #[must_use]
    pub fn error(self) -> f64 {
        match self {
            Self::Draft => 0.1,
            Self::Preview => 0.02,
            Self::Final => 0.005,
            Self::Reference => 0.0005,
        }
    }
}

/// What a render may take, and what it has to reach.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Budget {
    /// relMSE.
    pub error: Option<f64>,
    /// Time, s.
    pub seconds: Option<f64>,
    /// Bytes on the device.
    pub bytes: Option<u64>,
}

impl Budget {
    /// Memory alone asks for a picture as good as it gets in the time that the settings would take without it.
    fn with_time(&self, survey: &Survey, scene: &CompiledScene, settings: &Settings, device: &Device) -> Self {
        if self.error.is_some() || self.seconds.is_some() {
            return *self;
        }
        let passes = settings.stop.passes.unwrap_or(1);
        Self { seconds: Some(survey.predict(scene, settings, passes, device).seconds), ..*self }
    }
}

/// Which settings are not to be chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Given {
    /// Photons of the global map.
    pub photons: bool,
    /// Those of the caustic map.
    pub caustic_photons: bool,
    /// Photons in an estimate.
    pub k: bool,
    /// Its largest radius.
    pub radius: bool,
    /// Camera samples a pixel.
    pub spp: bool,
}

/// Settings for a budget.
#[derive(Clone, Debug)]
pub struct Choice {
    /// The settings, with [`Stop::passes`] for as many as are foreseen.
    pub settings: Settings,
    /// What they are expected to take and to give.
    pub prediction: Prediction,
    /// Whether that is within the budget; if not, they are the nearest to it.
    pub met: bool,
}

/// Most passes that are foreseen.
const MAX_PASSES: f64 = 4096.0;
/// Numbers of photons in a disc that are tried.
const DISCS: [u32; 13] = [8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512];
/// Camera samples a pixel that are tried.
const SAMPLES: [u32; 6] = [1, 2, 4, 8, 16, 32];

/// Entries of a small table: less memory, built at once, and searched more slowly.
const SMALL_TABLE: u32 = 1 << 16;

/// The settings with the least error within the time and memory, or those that reach the error in the least time. All combinations of half
/// powers of two of photons, of numbers of neighbours and of samples, and of two sizes of tables are tried, each with as many passes as fit or are needed.
#[must_use]
pub fn choose(
    survey: &Survey,
    scene: &CompiledScene,
    settings: &Settings,
    given: Given,
    budget: &Budget,
    device: &Device,
) -> Choice {
    let photons: Vec<u32> =
        (24..=54).map(|i| 2f64.powf(f64::from(i) / 2.0) as u32).filter(|&n| n <= MAX_PHOTONS).collect();
    let pick = |is_given: bool, value: u32, all: &[u32]| if is_given { vec![value] } else { all.to_vec() };
    let ratio = f64::from(settings.caustic_photons) / f64::from(settings.photons.max(1));
    let budget = budget.with_time(survey, scene, settings, device);
    let linear = matches!(settings.hash, Hash::Auto | Hash::Linear);
    let small = if linear && settings.table.is_none() { Some(SMALL_TABLE) } else { settings.table };
    let mut best: Option<Choice> = None;
    for photons in pick(given.photons, settings.photons, &photons) {
        let caustic = ((f64::from(photons) * ratio) as u32).min(MAX_PHOTONS);
        let caustic_photons = if given.caustic_photons { settings.caustic_photons } else { caustic };
        for k in pick(given.k, settings.k, &DISCS).into_iter().filter(|&k| k <= MAX_K) {
            let radius = if given.radius { settings.radius } else { within(survey.radius_for(k, photons)) };
            let tried = Settings { photons, caustic_photons, k, radius, automatic_radius: false, ..settings.clone() };
            // How large tables are takes as long to say as all the rest; a small one is no larger than it may be.
            let whole = survey.maps(scene, &tried);
            let held_back = whole.map(|map| ExpectedMap { table: map.table.min(f64::from(SMALL_TABLE)), ..map });
            for (table, maps) in [(settings.table, whole), (small, held_back)] {
                let tried = Settings { table, ..tried.clone() };
                for spp in pick(given.spp, settings.spp, &SAMPLES) {
                    let tried = Settings { spp, ..tried.clone() };
                    let choice = with_passes(survey, scene, tried, &budget, device, maps);
                    if best.as_ref().is_none_or(|best| better(&choice, best, &budget)) {
                        best = Some(choice);
                    }
                }
            }
        }
    }
    match best {
        Some(best) => best,
        None => unreachable!("something is always tried"),
    }
}

/// Surveys until what is chosen is near what was surveyed.
const ROUNDS: usize = 4;
/// Rehearsals until what is chosen is what was rehearsed, at the most.
const REHEARSALS: usize = 4;

/// [`choose`] with surveys near what is chosen: the first one is near `settings`, of automatic radius unless it is given. What is chosen is rehearsed if
/// that does not take long, and chosen again by what came. Returns the last survey and what is chosen by it.
///
/// # Errors
/// Those of renders.
pub fn settle(
    surveyor: &mut Surveyor<'_>,
    scene: &CompiledScene,
    settings: &Settings,
    given: Given,
    budget: &Budget,
    device: &Device,
) -> Result<(Survey, Choice), RenderError> {
    let automatic_radius = !given.radius;
    let mut near = Settings { automatic_radius, ..settings.clone() };
    let mut found = surveyor.survey(&near)?;
    let pick = |survey: &Survey| choose(survey, scene, settings, given, budget, device);
    let mut choice = pick(&found);
    for _ in 1..ROUNDS {
        if found.knows(&choice.settings) {
            break;
        }
        let Settings { photons, caustic_photons, k, .. } = choice.settings;
        near = Settings { photons, caustic_photons, k, ..near };
        found = surveyor.survey(&near)?;
        choice = pick(&found);
    }
    let mut best: Option<(Survey, Choice)> = None;
    for _ in 0..REHEARSALS {
        let Prediction { seconds, pass_seconds, .. } = choice.prediction;
        if !Rehearsal::is_worth_it(seconds, pass_seconds) {
            break;
        }
        let rehearsal = surveyor.rehearsal(&choice.settings)?;
        let corrected = found.corrected(scene, &choice.settings, &rehearsal, device);
        let whole = budget.with_time(&corrected, scene, settings, device);
        let same = Settings { stop: settings.stop, ..choice.settings.clone() };
        let maps = corrected.maps(scene, &same);
        let rehearsed = with_passes(&corrected, scene, same, &whole, device, maps);
        choice = pick(&corrected);
        let of_passes = |choice: &Choice| Settings { stop: settings.stop, ..choice.settings.clone() };
        let settled = of_passes(&choice) == of_passes(&rehearsed);
        if best.as_ref().is_none_or(|(_, best)| better(&rehearsed, best, &whole)) {
            best = Some((corrected, rehearsed));
        }
        if settled {
            break;
        }
    }
    // What was rehearsed is known best.
    let (found, choice) = best.unwrap_or((found, choice));
    surveyor.warm_up(&choice.settings)?;
    Ok((found, choice))
}

/// A survey near settings that are not to be chosen, corrected by a rehearsal if that does not take long.
///
/// # Errors
/// Those of renders.
pub fn foresee(
    surveyor: &mut Surveyor<'_>,
    scene: &CompiledScene,
    settings: &Settings,
    passes: u32,
    device: &Device,
) -> Result<Survey, RenderError> {
    let found = surveyor.survey(settings)?;
    let Prediction { seconds, pass_seconds, .. } = found.predict(scene, settings, passes, device);
    if !Rehearsal::is_worth_it(seconds, pass_seconds) {
        surveyor.warm_up(settings)?;
        return Ok(found);
    }
    let rehearsal = surveyor.rehearsal(settings)?;
    surveyor.warm_up(settings)?;
    Ok(found.corrected(scene, settings, &rehearsal, device))
}

/// With as many passes as the budget allows or needs.
fn with_passes(
    survey: &Survey,
    scene: &CompiledScene,
    settings: Settings,
    budget: &Budget,
    device: &Device,
    maps: [ExpectedMap; 2],
) -> Choice {
    let one = survey.predict_with(scene, &settings, 1, device, maps);
    let fit = budget.seconds.map(|seconds| ((seconds - (one.seconds - one.pass_seconds)) / one.pass_seconds).floor());
    let needed = budget.error.map(|error| (one.noise / (error - one.bias).max(f64::MIN_POSITIVE)).ceil());
    let passes = match (settings.stop.passes, needed, fit) {
        (Some(passes), ..) => passes,
        (None, Some(needed), _) => needed.clamp(1.0, MAX_PASSES) as u32,
        (None, None, fit) => fit.unwrap_or(1.0).clamp(1.0, MAX_PASSES) as u32,
    };
    let prediction = survey.predict_with(scene, &settings, passes, device, maps);
    let met = budget.seconds.is_none_or(|seconds| prediction.seconds <= seconds)
        && budget.error.is_none_or(|error| prediction.error() <= error)
        && budget.bytes.is_none_or(|bytes| prediction.bytes <= bytes);
    let stop = Stop { passes: Some(passes), ..settings.stop };
    Choice { settings: Settings { stop, ..settings }, prediction, met }
}

/// Whether one is better than another: within the budget, then what it leaves open; outside, nearer to it.
fn better(one: &Choice, other: &Choice, budget: &Budget) -> bool {
    let (a, b) = (&one.prediction, &other.prediction);
    if one.met != other.met {
        return one.met;
    }
    if !one.met {
        return excess(a, budget) < excess(b, budget);
    }
    if budget.error.is_some() { a.seconds < b.seconds } else { a.error() < b.error() }
}

/// By how much a prediction is beyond the budget, as a sum of logarithms.
fn excess(prediction: &Prediction, budget: &Budget) -> f64 {
    let over = |value: f64, most: Option<f64>| most.map_or(0.0, |most| (value / most).ln().max(0.0));
    over(prediction.seconds, budget.seconds)
        + over(prediction.error(), budget.error)
        // Who has no more memory cannot render at all.
        + 100.0 * over(prediction.bytes as f64, budget.bytes.map(|bytes| bytes as f64))
}
