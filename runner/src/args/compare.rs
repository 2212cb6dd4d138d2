//! The command line of `caustic compare`.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

#[derive(Args)]
#[command(
    after_help = "Without --threshold, differences are reported and the exit code is 0. With it, the exit code is 3 if one is \
        exceeded.\n\n\
        Examples:\n  \
        caustic compare now.png before.png --metric yee --threshold 0\n  \
        caustic compare now.exr reference.exr --threshold flip=0.05 --threshold relmse=0.01\n  \
        caustic compare now.exr reference.exr --metric relmse --diff where.png --json"
)]
pub struct CompareArguments {
    /// The picture in question: .png (sRGB, 8 or 16 bits), .exr or .hdr (linear).
    #[arg(value_name = "A")]
    pub picture: PathBuf,
    /// The reference, what the picture should be: relmse divides by it, and it says which exposures FLIP looks at.
    #[arg(value_name = "B")]
    pub reference: PathBuf,
    /// How to compare; several with commas between them.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "all")]
    pub metric: Vec<MetricArgument>,
    /// The most that a metric may say, such as 0.01 of one metric or flip=0.05 of several; can be given several times.
    #[arg(long, value_name = "[METRIC=]T", value_parser = threshold, allow_hyphen_values = true)]
    pub threshold: Vec<Threshold>,
    /// Writes where they differ: a heat map (.png) of the metric, or of the first of several; black where nothing differs.
    #[arg(long, value_name = "OUT.png")]
    pub diff: Option<PathBuf>,
    /// FLIP: pixels in a degree of the visual field, 1 to 1000 [default: 67.02, a monitor 0.7 m wide with 3840 pixels a row, 0.7 m away].
    #[arg(long, value_name = "N", value_parser = number(1.0, 1000.0), allow_hyphen_values = true)]
    pub pixels_per_degree: Option<f64>,
    /// Yee: degrees that a row of the picture spans, 0.1 to 170.
    #[arg(long, value_name = "DEGREES", default_value = "45", value_parser = number(0.1, 170.0), allow_hyphen_values = true)]
    pub field_of_view: f64,
    /// Yee: luminance of white in cd/m², 0.01 to 1e6.
    #[arg(long, value_name = "CD/M2", default_value = "100", value_parser = number(0.01, 1e6), allow_hyphen_values = true)]
    pub white: f64,
    /// Prints a JSON object instead of lines.
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MetricArgument {
    /// All of them.
    All,
    /// FLIP: what is seen when the pictures alternate, 0 to 1; HDR-FLIP unless one is a PNG.
    Flip,
    /// Yee's perceptual metric: the number of pixels that differ visibly.
    Yee,
    /// Mean of the square errors over the reference's squares (and 0.01).
    Relmse,
    /// Root of the mean square error, in linear light.
    Rmse,
}

/// The most that a metric may say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    /// Which metric; none where only one is asked for.
    pub metric: Option<MetricArgument>,
    /// In the metric's unit.
    pub most: f64,
}

fn threshold(text: &str) -> Result<Threshold, String> {
    let (metric, number) = match text.split_once('=') {
        Some((name, number)) => (Some(MetricArgument::from_str(name, false)), number),
        None => (None, text),
    };
    let most = number.parse::<f64>().ok().filter(|most| most.is_finite() && *most >= 0.0);
    match (metric.transpose(), most) {
        (Ok(metric), Some(most)) if metric != Some(MetricArgument::All) => Ok(Threshold { metric, most }),
        _ => {
            Err("it must be a number from 0, such as 0.01, or a metric with one, such as flip=0.05, yee=0".to_string())
        }
    }
}

fn number(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse::<f64>().ok().filter(|number| (least..=most).contains(number));
        number.ok_or_else(|| format!("it must be a number from {least} to {most}"))
    }
}
