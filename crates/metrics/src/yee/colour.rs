//! Luminance and CIELAB of linear sRGB.

/// XYZ of linear red, green and blue with the primaries of sRGB (IEC 61966-2-1:1999).
const XYZ: [[f64; 3]; 3] = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];

/// Luminance, 1 for white: Y = 0.2126 R + 0.7152 G + 0.0722 B.
pub(super) fn luminance(rgb: [f32; 3]) -> f64 {
    row(XYZ[1], rgb)
}

/// Distance of two colours in a* and b* of CIELAB (CIE 15:2004, section 8.2.1), without their lightness: √(Δa*² + Δb*²).
pub(super) fn chroma_difference(a: [f32; 3], b: [f32; 3]) -> f64 {
    let ([a1, b1], [a2, b2]) = (chroma(a), chroma(b));
    (a1 - a2).hypot(b1 - b2)
}

/// a* and b*. White is linear (1, 1, 1), so that greys have none.
fn chroma(rgb: [f32; 3]) -> [f64; 2] {
    let [x, y, z] = XYZ.map(|weights| curve(row(weights, rgb) / weights.iter().sum::<f64>()));
    [500.0 * (x - y), 200.0 * (y - z)]
}

/// CIELAB's cube root, with its straight end below (6/29)³.
fn curve(t: f64) -> f64 {
    const END: f64 = 6.0 / 29.0;
    if t > END * END * END { t.cbrt() } else { t / (3.0 * END * END) + 4.0 / 29.0 }
}

/// Negative light is black.
fn row(weights: [f64; 3], rgb: [f32; 3]) -> f64 {
    weights.iter().zip(rgb).map(|(weight, value)| weight * f64::from(value.max(0.0))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn primaries_are_where_tables_have_them() {
        // Lindbloom's calculator, sRGB primaries, D65: red 80.1, 67.2; green −86.2, 83.2; blue 79.2, −107.9.
        for (rgb, a, b) in
            [([1.0, 0.0, 0.0], 80.1, 67.2), ([0.0, 1.0, 0.0], -86.2, 83.2), ([0.0, 0.0, 1.0], 79.2, -107.9)]
        {
            let found = chroma(rgb);
            assert!((found[0] - a).abs() < 0.2 && (found[1] - b).abs() < 0.2, "{rgb:?}: {found:?}");
        }
    }

    #[test]
    fn greys_have_no_colour() {
        for value in [0.0, 0.001, 0.18, 1.0, 50.0, -1.0] {
            assert!(chroma_difference([value; 3], [1.0; 3]) < 1e-10, "{value}");
        }
        assert!(chroma_difference([0.5, 0.5, 0.5], [0.52, 0.5, 0.5]) > 1.0);
    }
}
