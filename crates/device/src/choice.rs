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

/// Devices that work together: choices with a comma or a plus between them, or `gpu:all`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DeviceChoices {
    /// These.
    These(Vec<DeviceChoice>),
    /// Every hardware GPU that can run the kernels; software ones if there is no other.
    AllGpus,
}

impl FromStr for DeviceChoices {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "gpu:all" {
            return Ok(Self::AllGpus);
        }
        let choices: Vec<DeviceChoice> = text.split([',', '+']).map(str::parse).collect::<Result<_, _>>().map_err(|_| {
            "it must be auto, cpu, gpu, gpu:NAME_OR_INDEX, gpu:all, or several such as gpu:0,gpu:1 or cpu+gpu:0 (`caustic info` lists the devices)"
        })?;
        if choices.len() > 1 && choices.contains(&DeviceChoice::Auto) {
            return Err("auto is one device; name several, such as gpu:0,gpu:1, or give gpu:all".to_string());
        }
        Ok(Self::These(choices))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_are_named_one_by_one_or_all() {
        let gpu = |name: &str| DeviceChoice::Gpu(Some(name.to_string()));
        assert_eq!("gpu:all".parse(), Ok(DeviceChoices::AllGpus));
        assert_eq!("auto".parse(), Ok(DeviceChoices::These(vec![DeviceChoice::Auto])));
        assert_eq!("gpu:0,gpu:h100".parse(), Ok(DeviceChoices::These(vec![gpu("0"), gpu("h100")])));
        assert_eq!("cpu+gpu:1".parse(), Ok(DeviceChoices::These(vec![DeviceChoice::Cpu, gpu("1")])));
        for wrong in ["", "gpu:", "cpu,", "auto,cpu", "gpu:0 gpu:1x,tpu"] {
            assert!(wrong.parse::<DeviceChoices>().is_err(), "{wrong}");
        }
    }
}
