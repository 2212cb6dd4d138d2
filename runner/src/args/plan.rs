//! Arguments that leave decisions to the planner, or take them from it.

use super::numbers::bytes;
use caustic_planner::{Costs, Quality};
use caustic_renderer::Feature;
use clap::{Args, ValueEnum};

#[derive(Args)]
pub struct PlanArguments {
    /// Says what is modelled and with which settings, and why, a line each.
    #[arg(long)]
    pub explain: bool,
    /// Models what the scene does not need: the picture is the same, and takes longer. Several with commas between them.
    #[arg(long, value_enum, value_name = "FEATURES", value_delimiter = ',')]
    pub force: Vec<FeatureArgument>,
    /// Chooses photons, k, radius, samples and passes for an error (relMSE) of the picture; those that are given stay. --time and --error
    /// choose them too, for the best picture in this time, or the fastest one with this error.
    #[arg(long, value_enum, value_name = "Q", conflicts_with = "error")]
    pub quality: Option<QualityArgument>,
    /// Whose costs are foreseen: those of this device, measured, or constants, with which the same settings are chosen on every machine.
    #[arg(long, value_enum, default_value_t)]
    pub costs: CostsArgument,
    /// Most memory that the render may take for what is on its device and for photons on the host, such as 512MB or 2GiB: what is chosen stays below.
    /// Where --photons is given, or the integrator is progressive, nothing is chosen, and maps that do not fit come in chunks: the same image,
    /// in more time.
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub memory: Option<u64>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FeatureArgument {
    /// The caustic map.
    CausticMap,
    /// The global map.
    GlobalMap,
    /// A tree over the surfaces.
    Tree,
    /// Pictures on surfaces, in kernels.
    Textures,
    /// Rough lobes and coats, in kernels.
    Gloss,
    /// The insides of dielectrics, in kernels.
    Media,
    /// An environment, in kernels.
    Sky,
    /// Triangles and discs, in kernels.
    Meshes,
    /// Lights that are neither quads nor points, in kernels.
    Lamps,
}

impl From<FeatureArgument> for Feature {
    fn from(feature: FeatureArgument) -> Self {
        match feature {
            FeatureArgument::CausticMap => Self::CausticMap,
            FeatureArgument::GlobalMap => Self::GlobalMap,
            FeatureArgument::Tree => Self::Tree,
            FeatureArgument::Textures => Self::Textures,
            FeatureArgument::Gloss => Self::Gloss,
            FeatureArgument::Media => Self::Media,
            FeatureArgument::Sky => Self::Sky,
            FeatureArgument::Meshes => Self::Meshes,
            FeatureArgument::Lamps => Self::Lamps,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum QualityArgument {
    /// relMSE 0.1: where things are.
    Draft,
    /// relMSE 0.02: what it will look like.
    Preview,
    /// relMSE 0.005: to be shown.
    Final,
    /// relMSE 0.0005: to compare others with.
    Reference,
}

impl From<QualityArgument> for Quality {
    fn from(quality: QualityArgument) -> Self {
        match quality {
            QualityArgument::Draft => Self::Draft,
            QualityArgument::Preview => Self::Preview,
            QualityArgument::Final => Self::Final,
            QualityArgument::Reference => Self::Reference,
        }
    }
}

#[derive(Clone, Copy, Default, ValueEnum)]
pub enum CostsArgument {
    /// By small renders on this device, which are kept in the user's folder for caches.
    #[default]
    Measured,
    /// Constants times what small renders count.
    BuiltIn,
}

impl From<CostsArgument> for Costs {
    fn from(costs: CostsArgument) -> Self {
        match costs {
            CostsArgument::Measured => Self::Measured,
            CostsArgument::BuiltIn => Self::BuiltIn,
        }
    }
}
