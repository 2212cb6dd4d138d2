//! From light to what a display shows: exposure, tone mapping, sRGB. Nothing is dithered, so the same light gives the same code.

use super::png_file::{code, encode_srgb};

/// How light is brought into the range of a display.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Not at all: what is brighter than 1 is 1.
    #[default]
    None,
    /// L / (1 + L) of the luminance, colours kept (Reinhard et al., "Photographic Tone Reproduction for Digital Images", 2002, eq. 3).
    Reinhard,
    /// The reference rendering and output transform of ACES for sRGB displays, as fitted by Stephen Hill (`BakingLab`, ACES.hlsl, 2016).
    Aces,
    /// Troy Sobotka's `AgX` with its default look, its curve as fitted by Benjamin Wrensch ("Minimal AgX Implementation", 2024: a polynomial
    /// of degree 6, mean square error 3.7·10⁻⁶).
    Agx,
}

/// How a picture is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// Exposure, EV: light is multiplied by 2 to this power first.
    pub exposure: f32,
    /// What is done to light after that.
    pub tone: ToneMap,
}

/// Largest exposure, EV, up or down: beyond, floats end.
pub const MAX_EXPOSURE: f32 = 64.0;

impl Display {
    /// The sRGB codes, 0 to 255, of linear light. What is negative or not a number counts as 0.
    #[must_use]
    pub fn codes(&self, rgb: [f32; 3]) -> [u8; 3] {
        let gain = f64::from(self.exposure).exp2();
        // What is not a number is not above 0.
        let light = rgb.map(|x| if x > 0.0 { (f64::from(x) * gain).min(f64::from(f32::MAX)) } else { 0.0 });
        match self.tone {
            ToneMap::None => light.map(encode_srgb),
            ToneMap::Reinhard => reinhard(light).map(encode_srgb),
            ToneMap::Aces => aces(light).map(encode_srgb),
            // Its curve ends in the display's own encoding.
            ToneMap::Agx => agx(light),
        }
        .map(code)
    }
}

/// Relative luminance of linear sRGB (IEC 61966-2-1).
fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

fn reinhard(light: [f64; 3]) -> [f64; 3] {
    let luminance = luminance(light);
    light.map(|x| x / (1.0 + luminance))
}

type Matrix = [[f64; 3]; 3];

fn times(rows: &Matrix, [x, y, z]: [f64; 3]) -> [f64; 3] {
    rows.map(|[a, b, c]| a * x + b * y + c * z)
}

fn aces(light: [f64; 3]) -> [f64; 3] {
    /// sRGB to AP1, with the desaturation of the reference rendering transform.
    const IN: Matrix = [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    /// Back, with the desaturation of the output transform.
    const OUT: Matrix = [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    let curve = |x: f64| (x * (x + 0.024_578_6) - 0.000_090_537) / (x * (0.983_729 * x + 0.432_951) + 0.238_081);
    times(&OUT, times(&IN, light).map(curve))
}

fn agx(light: [f64; 3]) -> [f64; 3] {
    const INSET: Matrix = [
        [0.842_479_062_253_094, 0.078_433_599_999_999_2, 0.079_223_745_147_764_3],
        [0.042_328_242_261_012_3, 0.878_468_636_469_772, 0.079_166_127_460_543_4],
        [0.042_375_654_905_705_1, 0.078_433_6, 0.879_142_973_793_104],
    ];
    const OUTSET: Matrix = [
        [1.196_879_005_120_17, -0.098_020_881_140_136_8, -0.099_029_744_079_720_5],
        [-0.052_896_851_757_456_2, 1.151_903_129_904_17, -0.098_961_176_844_843_3],
        [-0.052_971_635_514_443_8, -0.098_043_450_117_124_1, 1.151_073_672_641_16],
    ];
    /// Ten stops below middle grey, 0.18, to six and a half above it, EV.
    const RANGE: [f64; 2] = [-12.473_93, 4.026_069];
    const CURVE: [f64; 7] = [-0.002_32, 0.119_1, 0.429_8, -6.868, 31.96, -40.14, 15.5];
    let curve = |x: f64| {
        let stop = x.log2().clamp(RANGE[0], RANGE[1]);
        let x = (stop - RANGE[0]) / (RANGE[1] - RANGE[0]);
        CURVE.iter().rev().fold(0.0, |sum, factor| sum * x + factor)
    };
    times(&OUTSET, times(&INSET, light).map(curve))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> [ToneMap; 4] {
        [ToneMap::None, ToneMap::Reinhard, ToneMap::Aces, ToneMap::Agx]
    }

    fn grey(tone: ToneMap, x: f32) -> u8 {
        let [r, g, b] = Display { exposure: 0.0, tone }.codes([x; 3]);
        // The outset of AgX and the matrices of ACES keep greys only to their printed digits.
        assert!(r.abs_diff(g) <= 1 && g.abs_diff(b) <= 1, "{tone:?} of {x}: {r} {g} {b}");
        g
    }

    #[test]
    fn greys_are_those_of_the_formulas() {
        // By hand: 0.18/1.18 = 0.1525 → 0.4281 → 109; 1/2 → 0.7354 → 188. ACES of 0.18: (0.0367374)/(0.3478785) = 0.10560 → 0.3598 → 92;
        // of 1: 1.0244881/1.654761 = 0.61911 → 0.8087 → 206. AgX of 0.18: 10 of 16.5 stops = 0.60606, where the
        // polynomial is 0.49673 of the display → 127.
        for (tone, x, expected) in [
            (ToneMap::None, 0.18, 118),
            (ToneMap::None, 7.0, 255),
            (ToneMap::Reinhard, 0.18, 109),
            (ToneMap::Reinhard, 1.0, 188),
            (ToneMap::Aces, 0.18, 92),
            (ToneMap::Aces, 1.0, 206),
            (ToneMap::Agx, 0.18, 127),
        ] {
            assert!(grey(tone, x).abs_diff(expected) <= 1, "{tone:?} of {x}: {} and not {expected}", grey(tone, x));
        }
    }

    #[test]
    fn more_light_is_never_darker_and_the_ends_are_black_and_white() {
        for tone in all() {
            let codes: Vec<u8> = (0..600).map(|i| grey(tone, (0.05 * (i as f32 - 300.0)).exp2())).collect();
            assert!(codes.is_sorted(), "{tone:?}: {codes:?}");
            assert!(codes[0] <= 2 && codes[599] >= 250, "{tone:?}: {} {}", codes[0], codes[599]);
        }
    }

    #[test]
    fn an_exposure_is_a_factor() {
        for tone in all() {
            for stops in [-3.0, -1.0, 1.0, 4.0] {
                let display = Display { exposure: stops, tone };
                let [r, g, b] = [0.03f32, 0.2, 0.11];
                let gain = stops.exp2();
                assert_eq!(
                    display.codes([r, g, b]),
                    Display { exposure: 0.0, tone }.codes([r * gain, g * gain, b * gain])
                );
            }
        }
    }

    #[test]
    fn whatever_a_pixel_holds_has_a_code() {
        let odd = [0.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN_POSITIVE, 1e-42];
        for tone in all() {
            for exposure in [-MAX_EXPOSURE, 0.0, MAX_EXPOSURE] {
                let display = Display { exposure, tone };
                for x in odd {
                    assert_eq!(display.codes([x; 3]), display.codes([x; 3]));
                }
                assert_eq!(display.codes([f32::NAN, -1.0, 0.0]), display.codes([0.0; 3]), "{tone:?}");
                assert!(display.codes([f32::INFINITY; 3]).iter().all(|&code| code >= 250), "{tone:?}");
            }
        }
    }
}
