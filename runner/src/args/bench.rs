//! The command line of `caustic bench`.

use super::numbers::whole;
use caustic_bench::case::MAX_N;
use caustic_device::DeviceChoice;
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
pub struct BenchArguments {
    /// A built-in case (see --list) or a case file (.toml); can be given several times. All built-in cases if none is given.
    #[arg(long, value_name = "NAME|FILE")]
    pub case: Vec<String>,
    /// All case files in this folder, in place of the built-in cases.
    #[arg(long, value_name = "DIR", conflicts_with = "case")]
    pub cases: Option<PathBuf>,
    /// Only cases with this text in their names.
    #[arg(long, value_name = "TEXT")]
    pub filter: Option<String>,
    /// Lists the cases and their sizes, and measures nothing.
    #[arg(long)]
    pub list: bool,
    /// Where to run: auto, cpu, gpu, or gpu:NAME_OR_INDEX (see `caustic info`).
    #[arg(long, value_name = "D", default_value = "auto")]
    pub device: DeviceChoice,
    /// The largest N; without it, 10 M on a CPU and whatever fits on a GPU.
    #[arg(long, value_name = "N", value_parser = whole(1, MAX_N), allow_negative_numbers = true)]
    pub max_n: Option<u32>,
    /// The smallest size of each case and few runs: all cases in a minute on two cores.
    #[arg(long)]
    pub quick: bool,
    /// Runs of each row after the warm-up; the median counts.
    #[arg(long, value_name = "N", default_value = "21", value_parser = whole(1, 10_000), allow_negative_numbers = true)]
    pub repeat: u32,
    /// Seconds after which five runs of a row are enough; 10 if not given, and 1 with --quick.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub budget: Option<f64>,
    /// Leaves other libraries out, where they are compiled in (cargo feature `peers`).
    #[arg(long)]
    pub no_peers: bool,
    /// Writes the hashes that come out into the case files, as what has to come out.
    #[arg(long)]
    pub bless: bool,
    /// Writes all figures as JSON.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Writes the rows as comma-separated values.
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Writes the rows as a Markdown table.
    #[arg(long, value_name = "FILE")]
    pub markdown: Option<PathBuf>,
    /// Writes a plot of time over N for each case.
    #[arg(long, value_name = "DIR")]
    pub svg: Option<PathBuf>,
    /// Writes a record, named by date and device, into this folder.
    #[arg(long, value_name = "DIR")]
    pub record: Option<PathBuf>,
    /// Makes the table of performance of these records, and measures nothing.
    #[arg(long, value_name = "RECORD", num_args = 1.., conflicts_with_all = ["list", "quick", "bless"])]
    pub table: Vec<PathBuf>,
    /// Puts the table between the markers of this file.
    #[arg(long, value_name = "FILE", requires = "table")]
    pub into: Option<PathBuf>,
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|seconds| (0.0..=3600.0).contains(seconds));
    number.ok_or_else(|| "it must be a number of seconds from 0 to 3600".to_string())
}
