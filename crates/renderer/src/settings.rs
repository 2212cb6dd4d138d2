//! What a user can choose.

use crate::RenderError;
use crate::output::LayerKind;
use crate::scene::Scene;
use crate::scene::limits::{MAX_K, MAX_PHOTONS, MAX_SIDE, MAX_SPP};
use caustic_kernels::trace::{PART_CAUSTIC, PART_DIRECT, PART_GLOBAL};
use caustic_photon_map::{Gather, Hash, RADII};

/// Which part of the light is rendered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Show {
    /// All of it.
    #[default]
    Beauty,
    /// Emitted light that is seen, and light straight from the lights, by shadow rays.
    Direct,
    /// Light that was diffusely reflected before, from the global map.
    Global,
    /// Light through mirrors and glass alone, from the caustic map.
    Caustic,
    /// Direct visualisation of a global map of all photons (thesis, figure 29).
    MapGlobal,
    /// Direct visualisation of the caustic map (thesis, figure 30).
    MapCaustic,
}

impl Show {
    /// The parts that the film adds up.
    pub(crate) fn parts(self) -> u32 {
        match self {
            Self::Beauty => PART_DIRECT | PART_GLOBAL | PART_CAUSTIC,
            Self::Direct => PART_DIRECT,
            Self::Global | Self::MapGlobal => PART_GLOBAL,
            Self::Caustic | Self::MapCaustic => PART_CAUSTIC,
        }
    }
}

/// How to render a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Pixels in a row and in a column.
    pub size: [u32; 2],
    /// Photons emitted for the global map.
    pub photons: u32,
    /// Photons emitted for the caustic map.
    pub caustic_photons: u32,
    /// Photons in an estimate.
    pub k: u32,
    /// Largest radius of an estimate, m.
    pub radius: f32,
    /// Hash function of the maps.
    pub hash: Hash,
    /// How the gather finds the nearest photons.
    pub gather: Gather,
    /// Camera samples a pixel.
    pub spp: u32,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Part of the light.
    pub show: Show,
    /// Layers to make beside the picture, each once.
    pub layers: Vec<LayerKind>,
    /// Whether to look at how the photons lie in the maps' tables ([`MapReport::health`](crate::MapReport::health)): that reads them back.
    pub health: bool,
}

/// Most pixels of an image.
pub const MAX_PIXELS: u64 = 1 << 28;

impl Settings {
    /// The defaults of a scene, and caustic's own where the scene has none.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let defaults = &scene.defaults;
        Self {
            size: defaults.size.unwrap_or([512, 512]),
            photons: defaults.photons.unwrap_or(1_000_000),
            caustic_photons: defaults.caustic_photons.unwrap_or(500_000),
            k: defaults.k.unwrap_or(150),
            radius: defaults.radius.unwrap_or(0.15),
            hash: Hash::Linear,
            gather: Gather::Auto,
            spp: defaults.spp.unwrap_or(16),
            seed: 0,
            show: Show::Beauty,
            layers: Vec::new(),
            health: false,
        }
    }

    /// Checks every setting against its range.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for the first that is outside.
    pub fn validate(&self) -> Result<(), RenderError> {
        let whole = |name, value: u32, least: u32, most: u32| {
            if (least..=most).contains(&value) {
                return Ok(());
            }
            Err(RenderError::Setting { name, value: value.to_string(), range: format!("{least} to {most}") })
        };
        let [width, height] = self.size;
        let pixels = u64::from(width) * u64::from(height);
        if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) || pixels > MAX_PIXELS {
            return Err(RenderError::Setting {
                name: "size",
                value: format!("{width}x{height}"),
                range: format!("1x1 to {MAX_SIDE}x{MAX_SIDE} with at most {MAX_PIXELS} pixels"),
            });
        }
        for &layer in &self.layers {
            self.check_layer(layer)?;
        }
        whole("photons", self.photons, 1, MAX_PHOTONS)?;
        whole("caustic-photons", self.caustic_photons, 0, MAX_PHOTONS)?;
        whole("k", self.k, 1, MAX_K)?;
        whole("spp", self.spp, 1, MAX_SPP)?;
        if !RADII.contains(&self.radius) {
            return Err(RenderError::Setting {
                name: "radius",
                value: self.radius.to_string(),
                range: "a number of metres from 1e-9 to 1e18".to_string(),
            });
        }
        Ok(())
    }

    fn check_layer(&self, layer: LayerKind) -> Result<(), RenderError> {
        let part = match layer {
            LayerKind::Direct => PART_DIRECT,
            LayerKind::Global => PART_GLOBAL,
            LayerKind::Caustic => PART_CAUSTIC,
            LayerKind::Radius | LayerKind::Photons => PART_GLOBAL | PART_CAUSTIC,
            _ => u32::MAX,
        };
        let reason = if !LayerKind::OF_PHOTON_MAPS.contains(&layer) {
            "a photon-mapped picture does not know it; ask for other layers"
        } else if self.show.parts() & part == 0 {
            "--show leaves out the light that it would tell of; use --show beauty"
        } else {
            return Ok(());
        };
        Err(RenderError::NoLayer { layer: layer.name(), reason })
    }
}
