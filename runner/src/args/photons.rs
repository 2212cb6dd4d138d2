//! The command line of `caustic photons`.

use super::numbers::{radius, whole};
use super::{HashArgument, PrecisionArgument, ShowArgument};
use caustic_device::DeviceChoice;
use caustic_renderer::scene::limits::MAX_PHOTONS;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

#[derive(Args)]
#[command(after_help = "Examples:\n  \
    caustic photons cornell -o cornell.caustic\n  \
    caustic render cornell -o a.exr --load-map cornell.caustic\n  \
    caustic photons cornell.caustic --dump stats\n  \
    caustic photons cornell.caustic --dump ply -o photons.ply\n  \
    caustic photons cornell --show map-caustic --dump csv -o photons.csv")]
pub struct PhotonsArguments {
    /// A scene, whose photons are traced, or a photon map that this command wrote.
    #[arg(value_name = "SCENE|FILE")]
    pub input: String,
    /// The file: a photon map for `render --load-map`, or what --dump asks for; without it a dump goes to standard output.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Tells of the photons instead of saving them.
    #[arg(long, value_enum)]
    pub dump: Option<DumpArgument>,
    /// Photons emitted for the global map.
    #[arg(long, value_name = "N", value_parser = whole(1, MAX_PHOTONS), allow_negative_numbers = true)]
    pub photons: Option<u32>,
    /// Photons emitted at mirrors and glass for the caustic map.
    #[arg(long, value_name = "N", value_parser = whole(0, MAX_PHOTONS), allow_negative_numbers = true)]
    pub caustic_photons: Option<u32>,
    /// Seed of the random numbers [default: 0].
    #[arg(long, value_name = "S", value_parser = whole(0, u32::MAX), allow_negative_numbers = true)]
    pub seed: Option<u32>,
    /// The picture that the photons are for: one that shows a map by itself needs other photons than one of all light [default: beauty].
    #[arg(long, value_enum)]
    pub show: Option<ShowArgument>,
    /// Of --dump stats: largest radius of a search in metres [default: the scene's].
    #[arg(long, value_name = "R", value_parser = radius, allow_hyphen_values = true)]
    pub radius: Option<f32>,
    /// Of --dump stats: the hash whose health is told.
    #[arg(long, value_enum, default_value_t)]
    pub hash: HashArgument,
    /// Whether a GPU gives the CPU's bits, or is free to be faster.
    #[arg(long, value_enum, default_value_t)]
    pub precision: PrecisionArgument,
    /// Where to run: auto, cpu, gpu, or gpu:NAME_OR_INDEX (see `caustic info`).
    #[arg(long, value_name = "D", default_value = "auto")]
    pub device: DeviceChoice,
    /// Prints --dump stats as JSON.
    #[arg(long)]
    pub json: bool,
    /// Prints nothing but errors.
    #[arg(long)]
    pub quiet: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DumpArgument {
    /// A point cloud for MeshLab, CloudCompare or Blender: binary PLY with direction, power, colour, map and surface.
    Ply,
    /// A line a photon: map, position (m), direction of travel, power (W), surface.
    Csv,
    /// Numbers, power, extent and the health of the hash of each map.
    Stats,
}
