//! Rendering a whole picture.

use super::{Trouble, Units, Work};
use crate::digest::Digest;
use crate::row::Sample;
use caustic_device::Device;
use caustic_renderer::output::Image;
use caustic_renderer::scene::Scene;
use caustic_renderer::{Settings, render};
use std::time::Instant;

pub(super) struct Frame<'a> {
    device: &'a Device,
    scene: Scene,
    settings: Settings,
    image: Option<Image>,
}

impl<'a> Frame<'a> {
    pub(super) fn new(
        device: &'a Device,
        n: u32,
        scene: &str,
        size: [u32; 2],
        spp: u32,
        k: u32,
    ) -> Result<Self, Trouble> {
        let scene = Scene::load(scene).map_err(|error| Trouble::Fail(error.to_string()))?;
        let settings = Settings { size, photons: n, caustic_photons: n, k, spp, ..Settings::of(&scene) };
        settings.validate()?;
        Ok(Self { device, scene, settings, image: None })
    }
}

impl Work for Frame<'_> {
    fn run(&mut self) -> Result<Sample, Trouble> {
        self.device.reset_stage_times();
        let start = Instant::now();
        let rendered = render(&self.scene, &self.settings, self.device, &mut |_| true)?;
        let sample = Sample { wall_ms: start.elapsed().as_secs_f64() * 1e3, stages: rendered.report.stages };
        self.image = Some(rendered.image);
        Ok(sample)
    }

    fn digest(&mut self) -> Result<String, Trouble> {
        let mut digest = Digest::default();
        if let Some(image) = &self.image {
            digest.add(&image.rgb);
        }
        Ok(digest.hex())
    }

    /// A picture has no brute force here (tests/reference has one made without this program): its floats are finite.
    fn check(&mut self) -> Result<(usize, usize), Trouble> {
        let pixels = self.image.as_ref().map_or(&[][..], |image| &image.rgb);
        let wrong = pixels.iter().filter(|rgb| !rgb.iter().all(|value| value.is_finite() && *value >= 0.0));
        Ok((pixels.len(), wrong.count()))
    }

    fn units(&self) -> Units {
        let [width, height] = self.settings.size;
        Units { count: f64::from(width) * f64::from(height), name: "pixels", parts: &[] }
    }

    /// Its kinds of work are too different for one model.
    fn bytes(&self) -> Option<u64> {
        None
    }
}
