//! What commands that measure many cases share.

use caustic_renderer::Part;
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
pub struct CasesArguments {
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
