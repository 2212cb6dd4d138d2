//! From a survey to the time, memory, noise and bias of a render.

use crate::survey::{Survey, within};
use caustic_device::Device;
use caustic_photon_map::{MapOptions, plan_grid};
use caustic_renderer::scene::CompiledScene;
use caustic_renderer::{ExpectedMap, Feature, Integrator, Settings, decide, peak_bytes};
use serde::Serialize;

/// What a search costs more where a table of 2¹⁶ entries makes cells wider (cornell, a million photons, two CPU cores: 1.13 to 1.2).
const COARSE_CELLS: f64 = 1.2;

/// What a render is expected to take and to be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// Passes.
    pub passes: u32,
    /// Time, s, of [`RenderReport::seconds`](caustic_renderer::RenderReport::seconds).
    pub seconds: f64,
    /// Time of a pass, s.
    pub pass_seconds: f64,
    /// Most bytes of all buffers, as [`RenderReport::peak_bytes`](caustic_renderer::RenderReport::peak_bytes) counts them.
    pub bytes: u64,
    /// relMSE from noise, that of photons and that of camera samples together.
    pub noise: f64,
    /// The part of it that is of camera samples: more of them make it smaller, more photons do not.
    pub sample_noise: f64,
    /// relMSE from blur: what stays however many passes there are.
    pub bias: f64,
}

impl Prediction {
    /// relMSE in all.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.noise + self.bias
    }
}

impl Survey {
    /// The radius within which k photons of so many lie, if [`Survey::radius`] is enough for its own, m.
    #[must_use]
    pub fn radius_for(&self, k: u32, photons: u32) -> f64 {
        let density = f64::from(photons.max(1)) / self.emitted_all();
        self.radius * (f64::from(k) / self.k[1] / density).sqrt()
    }

    /// Whether settings are near enough to what was surveyed to be foretold. Many photons are like few with larger discs; fewer than those of the small
    /// renders are not, since discs are then as large as what they look at.
    #[must_use]
    pub fn knows(&self, settings: &Settings) -> bool {
        let of = usize::from(self.emitted[0] == 0.0);
        let photons = f64::from([settings.photons, settings.caustic_photons][of]);
        let k = f64::from(settings.k);
        photons >= 0.7 * self.emitted[of] && k >= 0.5 * self.k[0] && k <= 2.0 * self.k[2]
    }

    /// Photons of the map that tells how dense they are.
    fn emitted_all(&self) -> f64 {
        if self.emitted[0] > 0.0 { self.emitted[0] } else { self.emitted[1].max(1.0) }
    }

    /// Predicts a render of the scene that was surveyed, with `passes` passes.
    #[must_use]
    pub fn predict(&self, scene: &CompiledScene, settings: &Settings, passes: u32, device: &Device) -> Prediction {
        self.predict_with(scene, settings, passes, device, self.maps(scene, settings))
    }

    /// [`predict`](Self::predict) for maps that are known.
    pub(crate) fn predict_with(
        &self,
        scene: &CompiledScene,
        settings: &Settings,
        passes: u32,
        device: &Device,
        maps: [ExpectedMap; 2],
    ) -> Prediction {
        let samples = f64::from(settings.size[0]) * f64::from(settings.size[1]) * f64::from(settings.spp);
        let (batches, chunks) = self.times(settings, &maps);
        let fixed = self.image_s
            + batches
                * (0..2)
                    .map(|of| if maps[of].emitted > 0.0 { self.photons[of].of(maps[of].emitted) } else { 0.0 })
                    .sum::<f64>()
            + batches * chunks * self.entry_s * (maps[0].table + maps[1].table);
        let k = f64::from(settings.k);
        // Photons in a disc beside those in one of the survey, where all have as many to choose from.
        let of = usize::from(self.emitted[0] == 0.0);
        let dense = (maps[of].emitted.max(1.0) / self.emitted[of].max(1.0)).max(1e-9);
        let correction = &self.correction;
        let setup_s = (self.setup_s + correction.setup_s).max(0.0);
        let (mut seconds, mut noise, mut sample_noise, mut blur) = (setup_s, 0.0, 0.0, 0.0);
        let n = f64::from(passes.max(1));
        let held_back = |map: &ExpectedMap| settings.table.is_some_and(|most| map.table > 0.5 * f64::from(most));
        let search = if maps.iter().any(held_back) { COARSE_CELLS } else { 1.0 };
        for pass in 0..passes.max(1) {
            let disc = k * self.shrink(settings, pass);
            // The k nearest are sought in each chunk; a disc's photons are shared among them.
            let again = if settings.integrator == Integrator::Progressive { 0.0 } else { chunks - 1.0 };
            let searched = self.sample_s(disc) + again * (self.sample_s(disc) - self.sample_s(0.0));
            seconds += correction.pass * (fixed + samples * searched * search);
            sample_noise += self.sample_noise(settings.spp);
            noise += correction.photon_noise * self.photon_noise(disc);
            blur += (correction.blur * self.blur(disc / dense)).sqrt();
        }
        Prediction {
            passes,
            seconds,
            pass_seconds: (seconds - setup_s) / n,
            bytes: peak_bytes(scene, settings, maps, device),
            noise: (noise + sample_noise) / (n * n),
            sample_noise: sample_noise / (n * n),
            bias: (blur / n).powi(2),
        }
    }

    /// The maps that such a render has.
    #[must_use]
    pub fn maps(&self, scene: &CompiledScene, settings: &Settings) -> [ExpectedMap; 2] {
        let decisions = decide(scene, settings);
        let modelled = |feature| decisions.iter().any(|one| one.feature == feature && one.modelled);
        let of = [(Feature::GlobalMap, settings.photons), (Feature::CausticMap, settings.caustic_photons)];
        [0, 1].map(|i| {
            let (feature, photons) = of[i];
            if !modelled(feature) {
                return ExpectedMap::default();
            }
            let emitted = f64::from(photons);
            let stored = emitted * self.stored[i];
            // Those of a chunk have a table each.
            let chunks = settings.chunk.map_or(1, |chunk| chunk.cut(photons).0);
            ExpectedMap { emitted, stored, table: self.table(i, stored / f64::from(chunks), scene, settings) }
        })
    }

    /// How often photons are traced, and how often samples search.
    fn times(&self, settings: &Settings, maps: &[ExpectedMap; 2]) -> (f64, f64) {
        let emitted = maps.iter().fold(0.0, |most: f64, map| most.max(map.emitted)) as u32;
        let (batches, chunks) = settings.chunk.map_or((1, 1), |chunk| (chunk.batches(settings), chunk.cut(emitted).0));
        (f64::from(batches), f64::from(chunks))
    }

    /// Entries of a table for so many photons: those of the grid that a map would have.
    fn table(&self, i: usize, stored: f64, scene: &CompiledScene, settings: &Settings) -> f64 {
        let (low, high) = scene.diffuse_bounds;
        let radius = match settings.automatic_radius {
            true => within(self.radius_for(settings.k, settings.photons)),
            false => settings.radius,
        };
        let options = MapOptions { radius, hash: settings.hash, table: settings.table, cell: None };
        // What cannot be a grid cannot be rendered, and the render says why.
        let grid = plan_grid(low, high, stored as u64, &self.positions[i], &options);
        grid.map_or(0.0, |grid| f64::from(grid.table))
    }

    /// The part of a first disc that a pass has: those of progressive passes shrink (Knaus and Zwicker 2011, equation 15).
    fn shrink(&self, settings: &Settings, pass: u32) -> f64 {
        if settings.integrator != Integrator::Progressive {
            return 1.0;
        }
        let alpha = f64::from(settings.alpha);
        (1..=pass).map(|i| (f64::from(i) + alpha) / (f64::from(i) + 1.0)).product()
    }

    /// Time of a camera sample, by the number of photons in its discs: a straight line between those measured, and on from them.
    fn sample_s(&self, disc: f64) -> f64 {
        let side = usize::from(disc > self.k[1]);
        let (near, far) = (self.k[side], self.k[side + 1]);
        let (from, to) = (self.sample_s[side], self.sample_s[side + 1]);
        let slope = ((to - from) / (far - near)).max(0.0);
        (from + slope * (disc - near)).max(0.25 * self.sample_s[0])
    }

    /// Noise of all but photons: a line between the logarithms of what was measured, since stratified samples lose it faster than as one over
    /// their number, but rare bright ones do not; as one over their number beyond.
    fn sample_noise(&self, spp: u32) -> f64 {
        let [first, second, last] = self.sample_noise;
        let (n, [least, middle, most]) = (f64::from(spp), self.samples);
        if last <= 0.0 || n >= most {
            return last * most / n;
        }
        let (from, to, [a, b]) =
            if n < middle { (least, middle, [first, second]) } else { (middle, most, [second, last]) };
        if a <= 0.0 || b <= 0.0 {
            return a.max(b);
        }
        a * (b / a).powf((n / from).ln() / (to / from).ln())
    }

    /// Noise from photons: a/k + b through what was measured by least squares of relative errors. b is what photons have no part in, such as
    /// edges.
    fn photon_noise(&self, disc: f64) -> f64 {
        let points = self.k.iter().zip(&self.photon_noise).filter(|(_, noise)| **noise > 0.0);
        let (mut xx, mut x1, mut one, mut xy, mut y1) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (k, noise) in points {
            let (x, w) = (1.0 / k, 1.0 / (noise * noise));
            xx += w * x * x;
            x1 += w * x;
            one += w;
            xy += w * x * noise;
            y1 += w * noise;
        }
        let determinant = xx * one - x1 * x1;
        if determinant <= 0.0 {
            return 0.0;
        }
        let (a, b) = ((xy * one - y1 * x1) / determinant, (xx * y1 - x1 * xy) / determinant);
        match (a < 0.0, b < 0.0) {
            (true, _) => y1 / one,
            (_, true) => xy / xx / disc,
            _ => a / disc + b,
        }
    }

    /// The power of its photons with which a disc's blur grows: 1 where the irradiance is curved, and a quarter at edges, whose blurred border grows as
    /// the disc's radius. Less than that is a survey's noise.
    pub(crate) fn blur_power(&self) -> f64 {
        let [less, more] = self.blur.map(|blur| blur.max(0.0));
        let step = self.k[2] / self.k[1];
        if less > 0.0 && more > 0.0 { ((more / less).ln() / (2.0 * step.ln())).clamp(0.25, 1.0) } else { 0.5 }
    }

    /// relMSE from blur with discs of so many photons among those of the survey.
    fn blur(&self, disc: f64) -> f64 {
        let more = self.blur[1].max(0.0);
        if more == 0.0 {
            return 0.0;
        }
        let (step, power) = (self.k[2] / self.k[1], self.blur_power());
        // Of the largest disc: what it differs by from the middle one, and that from none.
        let largest = more / (1.0 - step.powf(-power)).powi(2);
        largest * (disc / self.k[2]).powf(2.0 * power)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::{Correction, Work};
    use caustic_renderer::scene::Scene;

    fn survey() -> Survey {
        Survey {
            emitted: [1e4, 0.0],
            stored: [1.0, 0.0],
            positions: [Vec::new(), Vec::new()],
            k: [10.0, 40.0, 160.0],
            radius: 0.1,
            setup_s: 0.5,
            photons: [Work { fixed: 0.1, each: 1e-6 }, Work::default()],
            entry_s: 0.0,
            image_s: 0.2,
            sample_s: [1e-6, 2e-6, 4e-6],
            samples: [1.0, 4.0, 32.0],
            sample_noise: [0.8, 0.1, 0.01],
            photon_noise: [0.11, 0.035, 0.01625],
            blur: [1e-6, 1e-6 * 16.0],
            correction: Correction::default(),
        }
    }

    /// Numbers that follow the laws of the model come out as the laws have them.
    #[test]
    fn a_survey_of_known_laws_predicts_by_them() {
        let scene = Scene::load("furnace").unwrap();
        let compiled = scene.compile();
        let settings = Settings { size: [10, 10], photons: 100_000, k: 40, spp: 4, ..Settings::of(&scene) };
        let one = survey().predict(&compiled, &settings, 1, &Device::cpu());
        assert!((one.seconds - (0.5 + 0.1 + 0.1 + 0.2 + 400.0 * 2e-6)).abs() < 1e-9, "{one:?}");
        // a = 1, b = 0.01, and a tenth of a sample's noise each.
        assert!((one.noise - (0.1 + 1.0 / 40.0 + 0.01)).abs() < 1e-9, "{one:?}");
        // The difference is four times as large one step on: its power is 1, and it falls as (k/N)².
        let expected = 1.6e-5 / 0.75f64.powi(2) * (4.0f64 / 160.0).powi(2);
        assert!((one.bias - expected).abs() < 1e-12, "{one:?}");
        let four = survey().predict(&compiled, &settings, 4, &Device::cpu());
        assert!((four.noise - one.noise / 4.0).abs() < 1e-12 && (four.bias - one.bias).abs() < 1e-12, "{four:?}");
        let radius = survey().radius_for(160, 40_000);
        assert!((radius - 0.1).abs() < 1e-12, "{radius}");
        // Progressive passes lose bias, and noise more slowly.
        let settings = Settings { integrator: Integrator::Progressive, ..settings };
        let shrinking = survey().predict(&compiled, &settings, 4, &Device::cpu());
        assert!(shrinking.bias < four.bias && shrinking.noise > four.noise, "{shrinking:?}");
    }
}
