//! How numbers of the command line are read.

use caustic_photon_map::{MAX_TABLE, RADII};
use caustic_renderer::scene::limits::MAX_SIDE;

/// Entries of a table.
pub fn table(text: &str) -> Result<u32, String> {
    let number = whole(1, MAX_TABLE)(text)?;
    if number.is_power_of_two() { Ok(number) } else { Err("it must be a power of two".to_string()) }
}

/// A whole number within limits.
pub fn whole(least: u32, most: u32) -> impl Fn(&str) -> Result<u32, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse::<u32>().ok().filter(|number| (least..=most).contains(number));
        number.ok_or_else(|| format!("it must be a whole number from {least} to {most}"))
    }
}

/// A number of bytes with a unit.
pub fn bytes(text: &str) -> Result<u64, String> {
    const UNITS: [(&str, f64); 9] = [
        ("kib", 1024.0),
        ("mib", 1_048_576.0),
        ("gib", 1_073_741_824.0),
        ("tib", 1_099_511_627_776.0),
        ("kb", 1e3),
        ("mb", 1e6),
        ("gb", 1e9),
        ("tb", 1e12),
        ("b", 1.0),
    ];
    let lower = text.to_ascii_lowercase();
    let digits = |number: &str| number.chars().all(|c| c.is_ascii_digit() || c == '.');
    let parsed = UNITS.iter().find_map(|(unit, size)| {
        let number = lower.strip_suffix(unit)?.trim_end();
        Some(number.parse::<f64>().ok().filter(|_| digits(number))? * size)
    });
    let bytes = parsed.filter(|bytes| (1.0..=1e18).contains(bytes));
    bytes
        .map(|bytes| bytes as u64)
        .ok_or_else(|| "it must be a number of bytes with a unit, such as 512MB or 2GiB".to_string())
}

/// A radius, m.
pub fn radius(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|radius| RADII.contains(radius));
    number.ok_or_else(|| "it must be a number of metres from 1e-9 to 1e18".to_string())
}

/// The size of a picture, pixels.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let parse = |side: &str| side.parse::<u32>().ok().filter(|side| (1..=MAX_SIDE).contains(side));
    let sides = text.split_once(['x', 'X']).and_then(|(width, height)| Some([parse(width)?, parse(height)?]));
    sides.ok_or_else(|| format!("it must be WIDTHxHEIGHT, each from 1 to {MAX_SIDE}, for example 640x480"))
}

#[cfg(test)]
mod tests {
    use super::bytes;

    #[test]
    fn bytes_have_units() {
        assert_eq!(bytes("512MB"), Ok(512_000_000));
        assert_eq!(bytes("1.5GiB"), Ok(1_610_612_736));
        assert_eq!(bytes("3 kib"), Ok(3072));
        for wrong in ["512", "MB", "-1MB", "1e9", "0MB", "1XB", "", "1.2.3GB", "infGB", "nanMB", "2e9TB"] {
            assert!(bytes(wrong).is_err(), "{wrong}");
        }
    }
}
