//! Maps as pictures.

use crate::from_srgb;

/// The colours of a map in linear light: black for 0, then through purple and orange to pale yellow for `full_scale` and more (magma,
/// by Smith and van der Walt for matplotlib, as FLIP's authors show its maps).
///
/// All is black if `full_scale` is 0 or less.
#[must_use]
pub fn heat(map: &[f32], full_scale: f32) -> Vec<[f32; 3]> {
    let colours: Vec<[f32; 3]> = flip_rs::MAGMA.iter().map(|rgb| rgb.map(|c| from_srgb(f64::from(c)) as f32)).collect();
    // `as` makes 0 of what is not a number.
    let index = |value: f32| (f64::from(value) / f64::from(full_scale) * 255.0 + 0.5).clamp(0.0, 255.0) as usize;
    map.iter().map(|&value| colours[if full_scale > 0.0 { index(value) } else { 0 }]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_is_brighter() {
        let colours = heat(&[0.0, 0.5, 1.0, 1.5, 2.0, 9.0], 2.0);
        let light = |rgb: [f32; 3]| rgb.iter().sum::<f32>();
        assert!(colours.windows(2).take(4).all(|pair| light(pair[1]) > light(pair[0])), "{colours:?}");
        assert_eq!(colours[4], colours[5]);
        assert!(light(colours[0]) < 0.01 && light(colours[4]) > 2.0);
        assert_eq!(heat(&[0.0, 3.0], 0.0), [colours[0]; 2]);
    }
}
