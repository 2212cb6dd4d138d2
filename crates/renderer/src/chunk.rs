//! How much of a pass is in memory at once, and what has to be whole.

use crate::output::LayerKind;
use crate::{Integrator, Keep, RenderError, Settings};
use caustic_kernels::layout::{Irradiance, PowerSum, Query};
use caustic_kernels::trace::{PART_CAUSTIC, PART_GLOBAL};
use caustic_photon_map::{Filter, MAX_K_IN_CHUNKS, Nearest, NearestPower, Surface};

/// How much of a pass is in memory at once, where its maps are larger than that: a map of each chunk of photons is searched for a batch of camera
/// samples, and the photons are traced again for the next batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// Photons of a chunk, emitted for each map.
    pub photons: u32,
    /// Camera samples of a batch, rounded to whole pixels.
    pub samples: u32,
}

impl Chunk {
    /// Bytes of a batch if nothing else is said.
    pub const BATCH_BYTES: u64 = 1 << 30;

    /// Chunks of so many photons, and a batch of [`Chunk::BATCH_BYTES`].
    #[must_use]
    pub fn of(photons: u32, settings: &Settings) -> Self {
        let samples = Self::BATCH_BYTES / Self::bytes_a_sample(settings);
        Self { photons, samples: samples.clamp(1, u64::from(u32::MAX)) as u32 }
    }

    /// Bytes that a sample of a batch takes while chunks come: its query, what was found for it, and its estimates.
    #[must_use]
    pub fn bytes_a_sample(settings: &Settings) -> u64 {
        let found = match settings.integrator {
            Integrator::Progressive => size_of::<PowerSum>() as u64,
            _ => NearestPower::bytes_a_point(settings.k),
        };
        size_of::<(Query, Irradiance, Irradiance)>() as u64 + found
    }

    /// Into how many chunks so many photons are cut, and the size of each: alike, so that the memory of one serves the next.
    #[must_use]
    pub fn cut(&self, emitted: u32) -> (u32, u32) {
        let chunks = emitted.div_ceil(self.photons);
        (chunks, emitted.div_ceil(chunks.max(1)))
    }

    /// Batches of a pass.
    #[must_use]
    pub fn batches(&self, settings: &Settings) -> u32 {
        (settings.size[0] * settings.size[1]).div_ceil(self.pixels(settings))
    }

    /// Pixels of a batch.
    pub(crate) fn pixels(&self, settings: &Settings) -> u32 {
        (self.samples / settings.spp).max(1)
    }

    /// Refuses what chunks cannot give the bits of whole maps for.
    pub(crate) fn check(&self, settings: &Settings) -> Result<(), RenderError> {
        if settings.parts() & (PART_GLOBAL | PART_CAUSTIC) == 0 {
            let range = "left out: this integrator, or what it shows, has no photon maps".to_string();
            return Err(RenderError::Setting { name: "chunk", value: self.photons.to_string(), range });
        }
        let name = |value: &dyn std::fmt::Debug| format!("{value:?}").to_lowercase();
        let nearest = settings.estimate().k.is_some();
        let cases = [
            ("chunk", self.photons.min(self.samples) == 0, "0".to_string(), "1 or more"),
            ("filter", settings.filter != Filter::Constant, name(&settings.filter), "constant"),
            ("surface", settings.surface != Surface::Any, name(&settings.surface), "any"),
            ("nearest", nearest && settings.nearest != Nearest::Exact, name(&settings.nearest), "exact"),
            ("k", nearest && settings.k > MAX_K_IN_CHUNKS, settings.k.to_string(), "1 to 1023"),
            ("radius", settings.automatic_radius, "auto".to_string(), "a number of metres"),
            ("keep", settings.keep != Keep::All, name(&settings.keep), "all"),
            ("compact", settings.compact, "given".to_string(), "left out"),
            ("final-gather", settings.final_gather > 0, settings.final_gather.to_string(), "0"),
            ("interpolate", settings.interpolate > 0, settings.interpolate.to_string(), "0"),
        ];
        if let Some((name, _, value, range)) = cases.into_iter().find(|(_, wrong, ..)| *wrong) {
            let range = format!("{range} with photons in chunks (--chunk, or --memory that whole maps do not fit)");
            return Err(RenderError::Setting { name, value, range });
        }
        match settings.layers.iter().find(|layer| matches!(layer, LayerKind::Radius | LayerKind::Bias)) {
            Some(layer) => Err(RenderError::NoLayer {
                layer: layer.name(),
                reason: "it takes more searches of whole maps; leave it out, or --chunk and --memory",
            }),
            None => Ok(()),
        }
    }
}

const _: () = assert!(MAX_K_IN_CHUNKS == 1023);
