//! `caustic tradeoff`.

use super::{CasesArguments, ShowArgument};
use caustic_device::DeviceChoice;
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
#[command(after_help = "Examples:\n  \
    caustic tradeoff cornell --quick\n  \
    caustic tradeoff my_scene.toml -o sweep --reference truth.exr\n\n\
    Shared out, on any machines of one kind and in any order:\n  \
    caustic tradeoff cornell --part 1/2 -o a\n  \
    caustic tradeoff cornell --part 2/2 -o b --reference a/reference.exr\n  \
    caustic tradeoff cornell --merge a b -o sweep")]
pub struct TradeoffArguments {
    /// A built-in scene, a scene file or a model.
    pub scene: String,
    /// Part of the light that is swept.
    #[arg(long, value_enum, default_value_t)]
    pub show: ShowArgument,
    /// Folder of the results, the reference and the report; results that are there are not measured again.
    #[arg(short, long, value_name = "DIR", default_value = "tradeoff")]
    pub output: PathBuf,
    /// Where to run: auto, cpu, gpu, or gpu:NAME_OR_INDEX (see `caustic info`).
    #[arg(long, value_name = "D", default_value = "auto")]
    pub device: DeviceChoice,
    /// The picture that errors are measured against: an EXR of 192x192 pixels, 96x96 with --quick, or of the scene's shape and as many; or
    /// auto, which renders one and keeps it in the folder.
    #[arg(long, value_name = "FILE|auto", default_value = "auto")]
    pub reference: String,
    /// Fewer points and smaller pictures: under three minutes on two cores.
    #[arg(long)]
    pub quick: bool,
    #[command(flatten)]
    pub cases: CasesArguments,
}
