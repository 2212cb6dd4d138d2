//! The environment: its picture, and the tables by which the kernels draw directions from it.

use super::check::LARGEST;
use super::meshes::Assembly;
use super::text::one_line;
use caustic_kernels::trace::{Texel, Texture, WRAP_CLAMP, WRAP_REPEAT};
use caustic_metrics::Image;
use glam::DVec3;
use half::f16;
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// Most pixels along a side.
const MAX_SIDE: usize = 8192;
/// The smallest chance of a row or a pixel times what it would be if all were equally bright: what is dark is drawn, too, since bilinear
/// mixing may let it shine, and no photon has more than eight times the power of its fellows for it.
const LEAST: f64 = 1.0 / 8.0;
/// Chances are multiples of 1 / STEPS, as the kernels' random numbers are.
const STEPS: f64 = 16_777_216.0;
/// Brightest texel, as a power of two: halves reach beyond it and 29 powers of two below.
const BRIGHTEST: i32 = 15;

/// Radiance by longitude and latitude, as a file has it.
#[derive(Clone, Debug)]
pub(super) struct Panorama {
    pub width: usize,
    pub height: usize,
    /// Row by row, the zenith first.
    pub rgb: Vec<[f32; 3]>,
    /// What it was read from.
    pub name: String,
}

/// An environment.
#[derive(Clone, Debug)]
pub(super) struct Sky {
    /// Index of its picture.
    pub texture: u32,
    /// What texels are multiplied with.
    pub emission: DVec3,
    /// The angle by which it is turned about y, radians.
    pub turned: f64,
    /// ∫ L dω, W·m⁻².
    pub fluence: DVec3,
    /// What it was read from.
    pub name: String,
}

impl Panorama {
    /// The same radiance everywhere: what it is multiplied with.
    pub fn even() -> Self {
        Self { width: 1, height: 1, rgb: vec![[1.0; 3]], name: "even".to_string() }
    }

    /// Reads an EXR, HDR or PNG file.
    pub fn read(path: &Path) -> Result<Self, String> {
        let name = one_line(&path.to_string_lossy());
        let image = Image::read(path).map_err(|error| {
            format!("names a picture that cannot be used: {}; give an EXR or HDR file", one_line(&error.to_string()))
        })?;
        let (width, height) = (image.width(), image.height());
        if width > MAX_SIDE || height > MAX_SIDE {
            return Err(format!(
                "is `{name}`, which has {width} × {height} pixels, but an environment may have {MAX_SIDE} along a side; scale it down"
            ));
        }
        let rgb = image.rgb().to_vec();
        if let Some(at) = rgb.iter().position(|pixel| pixel.iter().any(|&x| x < 0.0)) {
            let (x, y) = (at % width, at / width);
            return Err(format!(
                "is `{name}`, whose pixel ({x}, {y}) is negative, and radiance is not; export it again without such pixels"
            ));
        }
        Ok(Self { width, height, rgb, name })
    }
}

impl Assembly {
    /// Adds an environment whose panorama is multiplied with `factor` and turned by `turned` radians about y.
    pub fn add_sky(&mut self, panorama: &Panorama, factor: DVec3, turned: f64) -> Result<Sky, String> {
        let Panorama { width, height, ref rgb, ref name } = *panorama;
        let brightest = rgb.as_flattened().iter().copied().fold(0f32, f32::max);
        if brightest < f32::MIN_POSITIVE {
            return Err("is a picture that is black, so it would not shine; remove it".to_string());
        }
        if f64::from(brightest) * factor.max_element() > LARGEST {
            return Err(format!("makes a radiance above {LARGEST} W/sr/m², the most there may be; make it darker"));
        }
        // A power of two, which changes no digit of what stays a normal half.
        let unit = 2f64.powi(BRIGHTEST - 1 - f64::from(brightest).log2().floor() as i32);
        let half = |x: f32| u32::from(f16::from_f64(f64::from(x) * unit).to_bits());
        let texels: Vec<Texel> =
            rgb.iter().map(|&[r, g, b]| Texel { rg: half(r) | half(g) << 16, ba: half(b) }).collect();
        let radiance: Vec<DVec3> = texels.iter().map(colour).collect();
        let Tables { rows, columns, fluence } = tables(&radiance, width, height);
        let first = self.add_texels(texels.into_iter().chain(rows).chain(columns))?;
        let wrap = WRAP_REPEAT + 4 * WRAP_CLAMP;
        self.textures.push(Texture { first, width: width as u32, height: height as u32, wrap });
        let emission = factor / unit;
        Ok(Sky {
            texture: self.textures.len() as u32 - 1,
            emission,
            turned,
            fluence: fluence * emission,
            name: name.clone(),
        })
    }
}

/// The colour of a texel, without its alpha.
fn colour(texel: &Texel) -> DVec3 {
    let half = |bits: u32| f64::from(f16::from_bits(bits as u16).to_f32());
    DVec3::new(half(texel.rg), half(texel.rg >> 16), half(texel.ba))
}

/// The tables of a picture, as kernels have them.
struct Tables {
    /// An entry a row.
    rows: Vec<Texel>,
    /// An entry a pixel, row by row.
    columns: Vec<Texel>,
    /// ∫ L dω.
    fluence: DVec3,
}

fn tables(radiance: &[DVec3], width: usize, height: usize) -> Tables {
    // The mean over a pixel of what is bilinear between the middles of pixels: ⅛, ¾ and ⅛ along each side.
    let mean_of = |x: usize, y: usize| {
        let across = [(x + width - 1) % width, x, (x + 1) % width];
        let down = [y.saturating_sub(1), y, (y + 1).min(height - 1)];
        let share = [0.125, 0.75, 0.125];
        let mut mean = DVec3::ZERO;
        for (row, share_of_row) in down.into_iter().zip(share) {
            for (column, share_of_column) in across.into_iter().zip(share) {
                mean += radiance[row * width + column] * (share_of_row * share_of_column);
            }
        }
        mean
    };
    let (mut rows, mut columns, mut fluence) = (Vec::new(), Vec::with_capacity(radiance.len()), DVec3::ZERO);
    let mut even = Vec::new();
    for y in 0..height {
        let angle = |edge: usize| PI * edge as f64 / height as f64;
        let middle = (angle(y) + angle(y + 1)) / 2.0;
        // Solid angle of a pixel.
        let pixel = TAU / width as f64 * 2.0 * middle.sin() * (angle(1) / 2.0).sin();
        let means: Vec<DVec3> = (0..width).map(|x| mean_of(x, y)).collect();
        let brightness: Vec<f64> = means.iter().map(|mean| mean.element_sum()).collect();
        columns.extend(entries(&brightness, &vec![1.0; width]));
        fluence += means.iter().sum::<DVec3>() * pixel;
        rows.push(brightness.iter().sum::<f64>() * pixel);
        even.push(pixel);
    }
    Tables { rows: entries(&rows, &even), columns, fluence }
}

/// Sums of chances and chances in proportion to `weights`, and none less than [`LEAST`] of what `even` makes it.
fn entries(weights: &[f64], even: &[f64]) -> Vec<Texel> {
    let (all, of_even) = (weights.iter().sum::<f64>(), even.iter().sum::<f64>());
    let wanted: Vec<f64> = weights
        .iter()
        .zip(even)
        .map(|(weight, even)| if all > 0.0 { weight / all } else { 0.0 }.max(LEAST * even / of_even))
        .collect();
    let total: f64 = wanted.iter().sum();
    let (mut sum, mut before) = (0.0, 0.0);
    let count = wanted.len();
    let entry = |(i, wanted): (usize, f64)| {
        sum += wanted;
        // Each has one step at least, and leaves as many as there are entries after it.
        let left = (count - 1 - i) as f64;
        let end = if left == 0.0 { STEPS } else { (sum / total * STEPS).round().max(before + 1.0).min(STEPS - left) };
        let steps = end - before;
        before = end;
        Texel { rg: ((end / STEPS) as f32).to_bits(), ba: ((steps / STEPS) as f32).to_bits() }
    };
    wanted.into_iter().enumerate().map(entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chances_are_steps_that_add_up_and_none_is_nought() {
        let mut weights = vec![0.0; 5000];
        weights[17] = 1e6;
        weights[4999] = 1.0;
        let even: Vec<f64> = (0..5000).map(|i| if i < 10 { 1e-9 } else { 1.0 }).collect();
        let mut before = 0.0;
        for entry in entries(&weights, &even) {
            let (sum, chance) = (f32::from_bits(entry.rg), f32::from_bits(entry.ba));
            assert!(chance > 0.0 && f64::from(chance) * STEPS % 1.0 == 0.0);
            assert_eq!(f64::from(sum), before + f64::from(chance));
            before = f64::from(sum);
        }
        assert_eq!(before, 1.0);
        let chance = |i: usize| f32::from_bits(entries(&weights, &even)[i].ba);
        assert!(chance(17) > 0.88 && chance(100) > 2e-5, "{} {}", chance(17), chance(100));
    }

    /// ∫ L dω of an even sky is 4π L, of one that is L above and 0 below 2π L, but for the row at the horizon, which is mixed.
    #[test]
    fn fluence_is_the_integral_over_the_sphere() {
        let fluence = |bright: fn(usize) -> f32| {
            let rgb = (0..64 * 32).map(|i| [bright(i / 64), 0.5, 0.0]).collect();
            let panorama = Panorama { width: 64, height: 32, rgb, name: String::new() };
            let sky = Assembly::default().add_sky(&panorama, DVec3::new(3.0, 3.0, 3.0), 0.0).unwrap();
            sky.fluence
        };
        let even = fluence(|_| 2.0);
        assert!((even - DVec3::new(24.0, 6.0, 0.0) * PI).abs().max_element() < 1e-9, "{even}");
        let half = fluence(|row| if row < 16 { 2.0 } else { 0.0 });
        assert!((half.x - 12.0 * PI).abs() < 1e-9, "{half}");
    }

    #[test]
    fn a_black_sky_is_refused() {
        let panorama = Panorama { width: 2, height: 1, rgb: vec![[0.0; 3]; 2], name: String::new() };
        assert!(Assembly::default().add_sky(&panorama, DVec3::ONE, 0.0).unwrap_err().contains("black"));
    }
}
