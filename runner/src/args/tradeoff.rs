//! `caustic tradeoff`.

use super::ShowArgument;
use caustic_device::DeviceChoice;
use caustic_renderer::Part;
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
    /// Measures part I of N, such as 3/8, into a folder of its own, on any machine of one kind: docs/farm.md.
    #[arg(long, value_name = "I/N", conflicts_with = "report_only")]
    pub part: Option<Part>,
    /// Merges these folders, parts that were measured with otherwise the same arguments, into -o with the report, and measures nothing.
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["report_only", "part"])]
    pub merge: Vec<PathBuf>,
    /// Makes the report of the results that are there, and measures nothing.
    #[arg(long)]
    pub report_only: bool,
}
