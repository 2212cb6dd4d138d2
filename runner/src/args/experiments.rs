//! `caustic experiments`.

use super::CasesArguments;
use caustic_device::DeviceChoice;
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
pub struct ExperimentsArguments {
    /// Folder of the results and of the report; results that are there are not measured again.
    #[arg(short, long, value_name = "DIR", default_value = "experiments")]
    pub output: PathBuf,
    /// Smaller ranges: under three minutes on two cores.
    #[arg(long)]
    pub quick: bool,
    /// These figures only, such as fig16,table3 (see --list).
    #[arg(long, value_name = "FIGURES", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Where to run: auto, cpu, gpu, or gpu:NAME_OR_INDEX (see `caustic info`).
    #[arg(long, value_name = "D", default_value = "auto")]
    pub device: DeviceChoice,
    /// Longest that a single run of a case may take, in seconds: cases that are expected to take longer, by those before them, are left
    /// out, and the report lists them. 60 if not given, and 10 with --quick.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub patience: Option<f64>,
    #[command(flatten)]
    pub cases: CasesArguments,
    /// Lists the figures.
    #[arg(long)]
    pub list: bool,
}
