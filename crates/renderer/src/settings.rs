//! What a user can choose.

use crate::output::LayerKind;
use crate::scene::Scene;
use crate::scene::limits::{MAX_K, MAX_PHOTONS, MAX_SIDE, MAX_SPP};
use crate::{Chunk, Feature, RenderError};
use caustic_kernels::trace::{PART_CAUSTIC, PART_DIRECT, PART_GLOBAL, PART_PATHS};
use caustic_photon_map::{Estimate, Filter, Gather, Hash, MAX_TABLE, Nearest, RADII, Surface};

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
    /// Its name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Beauty => "beauty",
            Self::Direct => "direct",
            Self::Global => "global",
            Self::Caustic => "caustic",
            Self::MapGlobal => "map-global",
            Self::MapCaustic => "map-caustic",
        }
    }

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

/// How a picture comes about. All of them repeat passes whose mean is the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrator {
    /// Photon maps with k-nearest estimates (Jensen 1996): biased, and done in one pass.
    #[default]
    Photon,
    /// Photon maps anew in each pass, with estimates of a radius that shrinks from pass to pass (Hachisuka et al. 2008; Knaus and Zwicker
    /// 2011): the mean converges to the truth.
    Progressive,
    /// Unbiased paths without photons: slow where light comes through glass, and right.
    Path,
    /// Light straight from the lights, and what mirrors and glass show of it.
    Direct,
}

/// Which photons a map keeps. The picture has the same bits with either.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Keep {
    /// All that are stored.
    #[default]
    All,
    /// Those near enough to something that the camera sees, which is looked at once more for that: a smaller map, built and
    /// searched faster.
    Visible,
}

/// When a render has enough passes: as soon as one of these is reached. Without any, a progressive render has
/// [`DEFAULT_PASSES`] and every other one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stop {
    /// Passes.
    pub passes: Option<u32>,
    /// Time of this run, s. The pass in flight is finished.
    pub seconds: Option<f64>,
    /// Photons emitted in all passes.
    pub photons: Option<u64>,
    /// [`ProgressState::noise`](crate::ProgressState::noise).
    pub error: Option<f64>,
}

/// Passes of a progressive render that is not told when to stop.
pub const DEFAULT_PASSES: u32 = 64;
/// Most passes of a render.
pub const MAX_PASSES: u32 = 1 << 24;
/// Most rays of a final gather for all samples of a pixel: they are traced at once.
const MAX_GATHER_RAYS: u32 = 1 << 20;
/// Most rays of a final gather.
pub const MAX_FINAL_GATHER: u32 = 4096;

/// Most photons of which one is stored.
pub const MAX_THIN: u32 = 1 << 16;
/// Most pixels between two points of an interpolation.
pub const MAX_INTERPOLATE: u32 = 64;

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
    /// Most entries of a map's table, if the hash is linear, or how many, a power of two; chosen from the photons if not given.
    pub table: Option<u32>,
    /// How the gather finds the nearest photons.
    pub gather: Gather,
    /// Camera samples a pixel.
    pub spp: u32,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Part of the light.
    pub show: Show,
    /// How the picture comes about.
    pub integrator: Integrator,
    /// How much a photon counts, by its distance.
    pub filter: Filter,
    /// Which photons count.
    pub surface: Surface,
    /// Whether the radius is found from how densely photons lie where the camera looks; `radius` is then not used.
    pub automatic_radius: bool,
    /// α of progressive radii, between 0 and 1: less shrinks them faster, for less bias and more noise.
    pub alpha: f32,
    /// Rays of a final gather for each camera sample; 0 looks at the estimate of the global map itself.
    pub final_gather: u32,
    /// Which photons are kept.
    pub keep: Keep,
    /// One photon in so many is stored, with the power of all of them.
    pub thin: u32,
    /// Whether photons are kept in 16 bytes each, which rounds their positions and powers.
    pub compact: bool,
    /// Whether an estimate is from the k nearest photons or from about as many.
    pub nearest: Nearest,
    /// Pixels between the points at which light of the global map is estimated; samples between them take the mean of those around that
    /// lie on their surface. 0 estimates it at each sample.
    pub interpolate: u32,
    /// When there are enough passes.
    pub stop: Stop,
    /// Layers to make beside the picture, each once.
    pub layers: Vec<LayerKind>,
    /// What to model though the scene does not need it: the picture is the same, and takes longer.
    pub forced: Vec<Feature>,
    /// How photons come in chunks; all at once if not given. The picture has the same bits.
    pub chunk: Option<Chunk>,
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
            hash: Hash::Auto,
            table: None,
            gather: Gather::Auto,
            spp: defaults.spp.unwrap_or(16),
            seed: 0,
            show: Show::Beauty,
            integrator: Integrator::Photon,
            filter: Filter::Constant,
            surface: Surface::Any,
            automatic_radius: false,
            alpha: 2.0 / 3.0,
            final_gather: 0,
            keep: Keep::All,
            thin: 1,
            compact: false,
            nearest: Nearest::Exact,
            interpolate: 0,
            stop: Stop::default(),
            layers: Vec::new(),
            forced: Vec::new(),
            chunk: None,
            health: false,
        }
    }

    /// Parts of the light that the film adds up.
    pub(crate) fn parts(&self) -> u32 {
        match self.integrator {
            Integrator::Photon | Integrator::Progressive => self.show.parts(),
            Integrator::Path => PART_PATHS,
            Integrator::Direct => PART_DIRECT,
        }
    }

    /// How irradiance is estimated from a map: progressive passes have one radius everywhere.
    pub(crate) fn estimate(&self) -> Estimate {
        let k = (self.integrator != Integrator::Progressive).then_some(self.k);
        Estimate { filter: self.filter, surface: self.surface, k, gather: self.gather, nearest: self.nearest }
    }

    /// [`Stop::passes`], or how many there are if nothing ends the render; nothing if something else does.
    #[must_use]
    pub fn passes(&self) -> Option<u32> {
        if self.stop != Stop::default() {
            return self.stop.passes;
        }
        Some(if self.integrator == Integrator::Progressive { DEFAULT_PASSES } else { 1 })
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
        whole("table", self.table.unwrap_or(1), 1, MAX_TABLE)?;
        whole("spp", self.spp, 1, MAX_SPP)?;
        whole("final-gather", self.final_gather, 0, MAX_FINAL_GATHER)?;
        if u64::from(self.spp) * u64::from(self.final_gather) > u64::from(MAX_GATHER_RAYS) {
            let range = format!("at most {} at {} samples a pixel", MAX_GATHER_RAYS / self.spp, self.spp);
            return Err(RenderError::Setting { name: "final-gather", value: self.final_gather.to_string(), range });
        }
        let farther = [
            (self.final_gather > 0, "all with --final-gather, whose rays look at the global map everywhere"),
            (self.interpolate > 0, "all with --interpolate, which looks at the global map between the samples"),
            (
                self.nearest == Nearest::Approximate,
                "all with --nearest approximate, which counts whole cells of photons",
            ),
        ];
        if let Some((_, range)) = farther.iter().find(|(looks, _)| *looks && self.keep == Keep::Visible) {
            let (value, range) = ("visible".to_string(), range.to_string());
            return Err(RenderError::Setting { name: "keep", value, range });
        }
        whole("thin", self.thin, 1, MAX_THIN)?;
        whole("interpolate", self.interpolate, 0, MAX_INTERPOLATE)?;
        if self.compact && self.surface != Surface::Any {
            let (value, range) = (format!("{:?}", self.surface).to_lowercase(), "any with --compact".to_string());
            return Err(RenderError::Setting { name: "surface", value, range });
        }
        self.chunk.map_or(Ok(()), |chunk| chunk.check(self))?;
        whole("passes", self.stop.passes.unwrap_or(1), 1, MAX_PASSES)?;
        let number = |name, value: f64, fine: bool, range: &str| {
            if fine {
                Ok(())
            } else {
                Err(RenderError::Setting { name, value: value.to_string(), range: range.to_string() })
            }
        };
        let alpha = f64::from(self.alpha);
        number("alpha", alpha, alpha > 0.0 && alpha < 1.0, "a number between 0 and 1")?;
        let seconds = self.stop.seconds.unwrap_or(1.0);
        number("time", seconds, seconds > 0.0 && seconds.is_finite(), "a number of seconds above 0")?;
        let error = self.stop.error.unwrap_or(1.0);
        number("error", error, error > 0.0 && error.is_finite(), "a number above 0")?;
        let without_photons = self.parts() & (PART_GLOBAL | PART_CAUSTIC) == 0;
        if let Some(photons) = self.stop.photons.filter(|&photons| photons == 0 || without_photons) {
            let range = "at least 1, where there are photons to count; use --passes or --time".to_string();
            return Err(RenderError::Setting { name: "total-photons", value: photons.to_string(), range });
        }
        let wrong = match self.integrator {
            Integrator::Path => self.show != Show::Beauty,
            Integrator::Direct => !matches!(self.show, Show::Beauty | Show::Direct),
            Integrator::Photon | Integrator::Progressive => false,
        };
        if wrong {
            let range = "beauty with --integrator path or direct, which know no photon maps".to_string();
            return Err(RenderError::Setting { name: "show", value: format!("{:?}", self.show).to_lowercase(), range });
        }
        if !RADII.contains(&self.radius) {
            return Err(RenderError::Setting {
                name: "radius",
                value: self.radius.to_string(),
                range: "a number of metres from 1e-9 to 1e18".to_string(),
            });
        }
        Ok(())
    }

    /// Whether pixels have layers of their own.
    pub(crate) fn needs_layers(&self) -> bool {
        self.layers.iter().any(|layer| LayerKind::OF_PHOTON_MAPS.contains(layer))
    }

    fn check_layer(&self, layer: LayerKind) -> Result<(), RenderError> {
        let part = match layer {
            LayerKind::Direct => PART_DIRECT,
            LayerKind::Global => PART_GLOBAL,
            LayerKind::Caustic => PART_CAUSTIC,
            LayerKind::Radius | LayerKind::Photons | LayerKind::Bias => PART_GLOBAL | PART_CAUSTIC,
            _ => u32::MAX,
        };
        let reason = if layer == LayerKind::Variance {
            if self.passes() != Some(1) {
                return Ok(());
            }
            "one pass does not know how much passes differ; use --passes 2 or more, or --integrator progressive"
        } else if self.integrator == Integrator::Path {
            "the path tracer knows no more than its picture and its variance; use another integrator"
        } else if self.parts() & part == 0 {
            "the picture leaves out the light that it would tell of; use --show beauty and photon maps"
        } else if self.final_gather > 0 && matches!(layer, LayerKind::Radius | LayerKind::Photons | LayerKind::Bias) {
            "a final gather does not look at the global map where the camera looks; leave out --final-gather"
        } else if self.interpolate > 0 && matches!(layer, LayerKind::Radius | LayerKind::Photons | LayerKind::Bias) {
            "interpolated light has no photons of its own; leave out --interpolate"
        } else if layer == LayerKind::Bias && self.k < 3 && self.estimate().k.is_some() {
            "it compares estimates from all and from half of k photons; use --k 3 or more"
        } else {
            return Ok(());
        };
        Err(RenderError::NoLayer { layer: layer.name(), reason })
    }
}
