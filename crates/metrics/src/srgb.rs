//! The transfer function of sRGB (IEC 61966-2-1:1999), for codes of any depth.

/// The linear light, 0 to 1, of an sRGB code that was divided by the largest code.
#[must_use]
pub fn from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB code, from 0 to 1, of linear light from 0 to 1.
#[must_use]
pub fn to_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_come_back() {
        // Middle grey: linear 0.2140 is half of full code.
        assert!((from_srgb(0.5) - 0.214_041).abs() < 1e-6);
        for code in 0..=65_535 {
            let encoded = f64::from(code) / 65_535.0;
            assert!((to_srgb(from_srgb(encoded)) - encoded).abs() < 1e-7, "{code}");
        }
    }
}
