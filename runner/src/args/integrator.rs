//! Arguments that say how a picture comes about, and when it is finished.

use super::numbers::whole;
use caustic_photon_map::{Filter, Nearest, RADII, Surface};
use caustic_renderer::scene::limits::MAX_PHOTONS;
use caustic_renderer::{Integrator, Keep, MAX_FINAL_GATHER, MAX_INTERPOLATE, MAX_PASSES, MAX_THIN, Part, Stop};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

#[derive(Args)]
pub struct IntegratorArguments {
    /// How the picture comes about; each repeats passes, whose mean is the picture.
    #[arg(long, value_enum, default_value_t)]
    pub integrator: IntegratorArgument,
    /// How much a photon counts by its distance: narrower filters blur less and are noisier.
    #[arg(long, value_enum, default_value_t)]
    pub filter: FilterArgument,
    /// Which photons around a point count.
    #[arg(long, value_enum, default_value_t)]
    pub surface: SurfaceArgument,
    /// How slowly the radius of progressive passes shrinks, between 0 and 1: less is sharper and noisier.
    #[arg(long, value_name = "A", default_value = "0.6666667", value_parser = alpha, allow_negative_numbers = true)]
    pub alpha: f32,
    /// Looks at the global map through N rays from each sample instead of at the sample itself: no blotches, for N times the work.
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0, MAX_FINAL_GATHER), allow_negative_numbers = true)]
    pub final_gather: u32,
    /// Which photons a map keeps: the image does not depend on it.
    #[arg(long, value_enum, default_value_t)]
    pub keep: KeepArgument,
    /// Stores one photon in N, with the power of all: a map of a part of the size, searched faster, and noisier.
    #[arg(long, value_name = "N", default_value = "1", value_parser = whole(1, MAX_THIN), allow_negative_numbers = true)]
    pub thin: u32,
    /// Keeps photons in 16 bytes instead of 64: positions and powers are rounded, and photons know no surface.
    #[arg(long)]
    pub compact: bool,
    /// Whether an estimate is from the k nearest photons, or from about as many, which are found sooner.
    #[arg(long, value_enum, default_value_t)]
    pub nearest: NearestArgument,
    /// Estimates light of the global map every N pixels, and between them where surfaces end: much faster, and soft shadows lose detail. 0 does
    /// it at each sample.
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0, MAX_INTERPOLATE), allow_negative_numbers = true)]
    pub interpolate: u32,
    /// Photons of which a map is made at once, emitted for each of the two maps: maps of chunks after one another, where a whole one is larger than
    /// the memory or a buffer of the device. The image does not depend on it. Photons are traced again for each GiB of what is known of camera samples.
    #[arg(long, value_name = "N", value_parser = whole(1, MAX_PHOTONS), allow_negative_numbers = true, conflicts_with = "load_map")]
    pub chunk: Option<u32>,
    /// Ends after so many passes. Without a stop, a progressive render has 64 and every other 1.
    #[arg(long, value_name = "N", value_parser = whole(1, MAX_PASSES), allow_negative_numbers = true)]
    pub passes: Option<u32>,
    /// Ends with the pass in which so many seconds are over.
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_negative_numbers = true)]
    pub time: Option<f64>,
    /// Ends with the pass in which so many photons have been emitted, for both maps together.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub total_photons: Option<u64>,
    /// Ends with the pass in which the relMSE that is noise is estimated, from how passes differ, to be no more than this.
    #[arg(long, value_name = "E", value_parser = positive, allow_negative_numbers = true)]
    pub error: Option<f64>,
    /// Keeps the passes in a file after each, so that a render that was stopped or killed can go on.
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Goes on from the checkpoint: the picture has the bits of one that was never stopped.
    #[arg(long, requires = "checkpoint")]
    pub resume: bool,
    /// Computes part I of N, such as 3/8, for `caustic merge`; -o then names a .caustic file. Parts need not be on one machine: docs/farm.md.
    #[arg(long, value_name = "I/N", conflicts_with_all = ["denoise", "exposure", "tone_map"], allow_hyphen_values = true)]
    pub part: Option<Part>,
}

impl IntegratorArguments {
    pub fn stop(&self) -> Stop {
        Stop { passes: self.passes, seconds: self.time, photons: self.total_photons, error: self.error }
    }
}

#[derive(Clone, Copy, Default, ValueEnum)]
pub enum IntegratorArgument {
    /// Photon maps, k nearest photons an estimate.
    #[default]
    Photon,
    /// Photon maps anew in each pass, with a radius that shrinks: converges.
    Progressive,
    /// Unbiased paths without photons, the reference.
    Path,
    /// Light straight from the lights alone.
    Direct,
}

impl From<IntegratorArgument> for Integrator {
    fn from(integrator: IntegratorArgument) -> Self {
        match integrator {
            IntegratorArgument::Photon => Self::Photon,
            IntegratorArgument::Progressive => Self::Progressive,
            IntegratorArgument::Path => Self::Path,
            IntegratorArgument::Direct => Self::Direct,
        }
    }
}

#[derive(Clone, Copy, Default, ValueEnum)]
pub enum FilterArgument {
    /// All alike.
    #[default]
    Constant,
    /// 1 − d/r.
    Cone,
    /// Jensen's Gaussian.
    Gaussian,
    /// 1 − d²/r².
    Epanechnikov,
}

impl From<FilterArgument> for Filter {
    fn from(filter: FilterArgument) -> Self {
        match filter {
            FilterArgument::Constant => Self::Constant,
            FilterArgument::Cone => Self::Cone,
            FilterArgument::Gaussian => Self::Gaussian,
            FilterArgument::Epanechnikov => Self::Epanechnikov,
        }
    }
}

#[derive(Clone, Copy, Default, ValueEnum)]
pub enum SurfaceArgument {
    /// All within the radius.
    #[default]
    Any,
    /// Those on the side that is seen of surfaces that face alike.
    Facing,
    /// Those on the side that is seen of the same quad or sphere, over the part of the disc on it: edges keep their brightness.
    Own,
}

impl From<SurfaceArgument> for Surface {
    fn from(surface: SurfaceArgument) -> Self {
        match surface {
            SurfaceArgument::Any => Self::Any,
            SurfaceArgument::Facing => Self::Facing,
            SurfaceArgument::Own => Self::Own,
        }
    }
}

/// A radius, or that it is to be found.
#[derive(Clone, Copy)]
pub enum RadiusArgument {
    Auto,
    Metres(f32),
}

pub fn radius(text: &str) -> Result<RadiusArgument, String> {
    if text == "auto" {
        return Ok(RadiusArgument::Auto);
    }
    let number = text.parse::<f32>().ok().filter(|radius| RADII.contains(radius));
    number
        .map(RadiusArgument::Metres)
        .ok_or_else(|| "it must be a number of metres from 1e-9 to 1e18, or auto".to_string())
}

fn alpha(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|alpha| *alpha > 0.0 && *alpha < 1.0);
    number.ok_or_else(|| "it must be a number between 0 and 1, such as 0.7".to_string())
}

fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| *number > 0.0 && number.is_finite());
    number.ok_or_else(|| "it must be a number above 0".to_string())
}

#[derive(Clone, Copy, Default, ValueEnum)]
pub enum KeepArgument {
    /// All that are stored.
    #[default]
    All,
    /// Those near enough to what the camera sees: a smaller map, for a second look through the camera.
    Visible,
}

impl From<KeepArgument> for Keep {
    fn from(keep: KeepArgument) -> Self {
        match keep {
            KeepArgument::All => Self::All,
            KeepArgument::Visible => Self::Visible,
        }
    }
}

#[derive(Clone, Copy, Default, ValueEnum)]
pub enum NearestArgument {
    /// The k nearest.
    #[default]
    Exact,
    /// All within a radius that probably holds k, as the number of photons in the cells around says.
    Approximate,
}

impl From<NearestArgument> for Nearest {
    fn from(nearest: NearestArgument) -> Self {
        match nearest {
            NearestArgument::Exact => Self::Exact,
            NearestArgument::Approximate => Self::Approximate,
        }
    }
}
