//! The command line of `caustic merge`.

use super::{DisplayArguments, LayerArgument};
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
#[command(after_help = "Example, on any machines and in any order:\n  \
    caustic render cornell --integrator progressive --passes 64 --part 1/2 -o a.caustic\n  \
    caustic render cornell --integrator progressive --passes 64 --part 2/2 -o b.caustic\n  \
    caustic merge a.caustic b.caustic -o box.exr\n\n\
    Parts of parts, with the same bytes in the end:\n  \
    caustic merge a.caustic b.caustic -o ab.caustic\n  \
    caustic merge ab.caustic c.caustic -o box.exr")]
pub struct MergeArguments {
    /// The parts: what `caustic render --part I/N -o FILE`, or `caustic merge` itself, wrote, in any order.
    #[arg(value_name = "PART", required = true)]
    pub parts: Vec<PathBuf>,
    /// The image: .png, .exr or .hdr; or .caustic for a part that has what these have, which need not be all.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Layers of an EXR beside the picture, of those that the parts were rendered with [default: all of these].
    #[arg(long, value_enum, value_name = "LAYERS", value_delimiter = ',')]
    pub aov: Vec<LayerArgument>,
    #[command(flatten)]
    pub display: DisplayArguments,
    /// Prints nothing but errors.
    #[arg(long)]
    pub quiet: bool,
}
