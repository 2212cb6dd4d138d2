//! Which device the user wants, and how exact.

use std::str::FromStr;

/// `auto`, `cpu`, `gpu` or `gpu:NAME_OR_INDEX`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum DeviceChoice {
    /// A hardware GPU if there is one that can run the exact kernels, else the CPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// The first GPU, or the one with this index or with this text in its name (case does not matter).
    Gpu(Option<String>),
}

/// How exactly a GPU computes. The CPU is always exact: its own division and root are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// Every result has the bits that the CPU gives.
    #[default]
    Exact,
    /// The driver may contract products and sums, and its own division, square root, sine and cosine are used.
    Fast,
}

impl FromStr for DeviceChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "cpu" => Ok(Self::Cpu),
            "gpu" => Ok(Self::Gpu(None)),
            _ => match text.strip_prefix("gpu:") {
                Some(wanted) if !wanted.is_empty() => Ok(Self::Gpu(Some(wanted.to_string()))),
                _ => {
                    Err("it must be auto, cpu, gpu or gpu:NAME_OR_INDEX (`caustic info` lists the devices)".to_string())
                }
            },
        }
    }
}
