//! What a picture's file is made of, on the command line.

use caustic_renderer::output::{Display, Format, LayerKind, MAX_EXPOSURE, OutputError, ToneMap};
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

/// How light becomes the colours of a PNG.
#[derive(Args)]
pub struct DisplayArguments {
    /// Exposure of a PNG in EV, from -64 to 64: each step doubles the light.
    #[arg(long, value_name = "EV", value_parser = exposure, allow_hyphen_values = true)]
    pub exposure: Option<f32>,
    /// How a PNG shows light that is brighter than a display.
    #[arg(long, value_enum)]
    pub tone_map: Option<ToneArgument>,
}

impl DisplayArguments {
    /// How a picture at `path` is to be shown: given for a PNG only, since all other formats keep the light as it is.
    pub fn of(&self, path: &Path) -> Result<Display, OutputError> {
        let exposure = self.exposure.unwrap_or_default();
        let tone = self.tone_map.unwrap_or_default().into();
        let asked = self.exposure.is_some() || self.tone_map.is_some();
        if asked && Format::of(path)? != Format::Png {
            return Err(OutputError::NotShown { path: path.to_path_buf() });
        }
        Ok(Display { exposure, tone })
    }
}

#[derive(Clone, Copy, Default, ValueEnum)]
pub enum ToneArgument {
    /// Not at all: what is brighter than 1 is 1.
    #[default]
    None,
    /// L/(1 + L) of the luminance (Reinhard et al. 2002).
    Reinhard,
    /// The film-like curve of ACES for sRGB (fit by Hill).
    Aces,
    /// Troy Sobotka's AgX: bright colours fade to white (fit by Wrensch).
    Agx,
}

impl From<ToneArgument> for ToneMap {
    fn from(tone: ToneArgument) -> Self {
        match tone {
            ToneArgument::None => Self::None,
            ToneArgument::Reinhard => Self::Reinhard,
            ToneArgument::Aces => Self::Aces,
            ToneArgument::Agx => Self::Agx,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LayerArgument {
    /// All of them but the variance, which one pass does not have.
    All,
    /// Light seen straight or straight from a light; direct + global + caustic is the picture, bit for bit.
    Direct,
    /// Light from the global map.
    Global,
    /// Light from the caustic map.
    Caustic,
    /// Radius of the estimates from each map, m; takes a second search.
    Radius,
    /// Photons in the estimates from each map.
    Photons,
    /// Normal of what is seen.
    Normal,
    /// Reflectance of what is seen.
    Albedo,
    /// Length of the path to what is seen, m.
    Depth,
    /// Variance of the picture, from how its passes differ; not in `all`.
    Variance,
    /// Estimate of how much too bright the picture is, from half of each disc; takes a second estimate.
    Bias,
}

/// The layers that are asked for, each once.
pub fn layers(asked: &[LayerArgument]) -> Vec<LayerKind> {
    let kind = |layer: &LayerArgument| match layer {
        LayerArgument::All => LayerKind::OF_PHOTON_MAPS.to_vec(),
        LayerArgument::Direct => vec![LayerKind::Direct],
        LayerArgument::Global => vec![LayerKind::Global],
        LayerArgument::Caustic => vec![LayerKind::Caustic],
        LayerArgument::Radius => vec![LayerKind::Radius],
        LayerArgument::Photons => vec![LayerKind::Photons],
        LayerArgument::Normal => vec![LayerKind::Normal],
        LayerArgument::Albedo => vec![LayerKind::Albedo],
        LayerArgument::Depth => vec![LayerKind::Depth],
        LayerArgument::Variance => vec![LayerKind::Variance],
        LayerArgument::Bias => vec![LayerKind::Bias],
    };
    let mut kinds: Vec<_> = asked.iter().flat_map(kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    kinds
}

#[derive(Args)]
#[command(after_help = "Examples:\n  \
    caustic tonemap box.exr -o box.png --tone-map agx --exposure 1.5\n  \
    caustic tonemap box.exr -o box.hdr")]
pub struct TonemapArguments {
    /// The picture: .exr, .hdr or .png.
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Where to: .png, .exr or .hdr.
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    #[command(flatten)]
    pub display: DisplayArguments,
}

fn exposure(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|stops| stops.abs() <= MAX_EXPOSURE);
    number.ok_or_else(|| format!("it must be a number of EV from -{MAX_EXPOSURE} to {MAX_EXPOSURE}"))
}
