//! Arguments of `caustic map`.

use super::numbers::{bytes, radius, whole};
use super::{GatherArgument, HashArgument, PrecisionArgument};
use caustic_device::DeviceChoice;
use caustic_renderer::scene::limits::MAX_K;
use clap::{Args, ValueEnum};

/// What is asked of the photons around each query.
#[derive(Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum EstimateArgument {
    /// The K nearest within the radius, and the irradiance of the disc that they fill.
    #[default]
    Nearest,
    /// The irradiance of all within the radius.
    Density,
}

impl EstimateArgument {
    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Density => "density",
        }
    }

    /// What a query finds.
    pub fn sentence(self, k: u32) -> String {
        match self {
            Self::Nearest => format!("k = {k}"),
            Self::Density => "all within the radius".to_string(),
        }
    }
}

#[derive(Args)]
pub struct MapArguments {
    /// uniform:N, surface:N, clustered:N or cell:N for synthetic photons in a unit cube; a file of `caustic photons`; or a text file with `x y z` a
    /// line.
    #[arg(long, value_name = "FILE|KIND:N", default_value = "uniform:1000000")]
    pub photons: String,
    /// Number of queries, drawn like the photons, or where photons of a file are.
    #[arg(long, value_name = "N", default_value = "300000", value_parser = whole(1, 1 << 26), allow_negative_numbers = true)]
    pub queries: u32,
    /// What is asked of the photons around each query.
    #[arg(long, value_enum, default_value_t)]
    pub estimate: EstimateArgument,
    /// Neighbours of each query.
    #[arg(long, value_name = "K", default_value = "50", value_parser = whole(1, MAX_K), allow_negative_numbers = true)]
    pub k: u32,
    /// Largest distance of a neighbour; if not given, one within which 2·K photons are expected, or the one that a file's photons were traced for.
    #[arg(long, value_name = "R", value_parser = radius, allow_hyphen_values = true)]
    pub radius: Option<f32>,
    /// Hash function.
    #[arg(long, value_enum, default_value_t)]
    pub hash: HashArgument,
    /// Container that collects the nearest photons.
    #[arg(long, value_enum, default_value_t)]
    pub gather: GatherArgument,
    /// Whether a GPU gives the CPU's bits, or is free to be faster.
    #[arg(long, value_enum, default_value_t)]
    pub precision: PrecisionArgument,
    /// Where to run: auto, cpu, gpu, or gpu:NAME_OR_INDEX (see `caustic info`).
    #[arg(long, value_name = "D", default_value = "auto")]
    pub device: DeviceChoice,
    /// Memory to stay within, such as 4GB or 900MiB: photons are drawn or read, mapped and searched in chunks that fit, with the same
    /// neighbours and estimates. The time is then that of all of it, once.
    #[arg(long, value_name = "BYTES", value_parser = bytes, conflicts_with = "repeat")]
    pub memory: Option<u64>,
    /// Times to repeat; the median counts.
    #[arg(long, value_name = "N", default_value = "5", value_parser = whole(1, 1000), allow_negative_numbers = true)]
    pub repeat: u32,
    /// Prints JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}
