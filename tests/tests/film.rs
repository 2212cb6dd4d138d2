//! The film's sum: its bound over twelve decades, and the same bits on every device.

use caustic_device::{Device, Kernel, LaneOrder, Plan};
use caustic_kernels::gather::CUT_SHORT;
use caustic_kernels::layout::Irradiance;
use caustic_kernels::num::{pcg4d, u32_to_unit};
use caustic_kernels::trace::{FilmTile, LOST, MISS, PART_DIRECT, Pixel, Vertex};
use caustic_tests::{assert_same_words, gpu};

const PIXELS: u32 = 200;
const SAMPLES: u32 = 4096;

/// Radiances over twelve decades, the small ones first, last or mixed.
fn radiance(pixel: u32, sample: u32) -> f32 {
    let unit = u32_to_unit(pcg4d([pixel, sample, 0xf11f, 0])[0]);
    let place = sample as f32 / SAMPLES as f32;
    let decade = match pixel % 3 {
        0 => 12.0 * place,
        1 => 12.0 * (1.0 - place),
        _ => 12.0 * u32_to_unit(pcg4d([pixel, sample, 0xf11f, 1])[0]),
    };
    (1.0 + unit) * 10f32.powf(decade - 6.0)
}

fn vertices() -> Vec<Vertex> {
    (0..PIXELS * SAMPLES)
        .map(|i| Vertex { primitive: 3, emitted: [radiance(i / SAMPLES, i % SAMPLES); 3], ..Vertex::default() })
        .collect()
}

fn develop(device: &Device, vertices: &[Vertex], direct: &[Irradiance], samples: u32) -> Vec<Pixel> {
    let pixels = vertices.len() as u32 / samples;
    let tile = FilmTile { first_pixel: 0, pixels, samples, parts: PART_DIRECT, radius: 1.0 };
    let tile = device.upload("tile", &[tile]).unwrap();
    let vertices = device.upload("vertices", vertices).unwrap();
    let direct = device.upload("direct", direct).unwrap();
    let none = device.buffer::<Irradiance>("none", 0).unwrap();
    let film = device.buffer::<Pixel>("film", u64::from(pixels)).unwrap();
    let mut plan = Plan::new();
    plan.each(Kernel::DevelopFilm, pixels, &[&tile, &vertices, &direct, &none, &none, &film]);
    device.run(&plan).unwrap();
    device.read(&film, u64::from(pixels)).unwrap()
}

/// Largest relative error of the means against f64, whose own error over 4096 terms is a ten-thousandth of the bound.
fn worst(means: impl Iterator<Item = f32>) -> f64 {
    let error = |(pixel, mean): (u32, f32)| {
        let exact: f64 =
            (0..SAMPLES).map(|sample| f64::from(radiance(pixel, sample))).sum::<f64>() / f64::from(SAMPLES);
        (f64::from(mean) / exact - 1.0).abs()
    };
    (0..).zip(means).map(error).fold(0.0, f64::max)
}

#[test]
fn a_mean_over_twelve_decades_is_within_its_bound() {
    // 2⁻²³ + O(n·2⁻⁴⁸) for the compensated sum, with 8 for the constant that the O hides, and 2⁻²⁴ for the quotient.
    let bound = 2f64.powi(-23) + 8.0 * f64::from(SAMPLES) * 2f64.powi(-48) + 2f64.powi(-24);
    let dark = vec![Irradiance::default(); (PIXELS * SAMPLES) as usize];
    let film = develop(&Device::cpu(), &vertices(), &dark, SAMPLES);
    let found = worst(film.iter().map(|pixel| pixel.rgb[1]));
    assert!(found <= bound, "{found:e}");
    // Plain addition, which this is not, misses it by far: the bound can be missed.
    let plain =
        (0..PIXELS).map(|pixel| (0..SAMPLES).map(|sample| radiance(pixel, sample)).sum::<f32>() / SAMPLES as f32);
    let missed = worst(plain);
    assert!(missed > 4.0 * bound, "{missed:e}");
    println!("compensated {found:.2e}, bound {bound:.2e}, plain {missed:.2e}");
}

#[test]
fn the_film_has_the_same_bits_everywhere() {
    let dark = vec![Irradiance::default(); (PIXELS * SAMPLES) as usize];
    let vertices = vertices();
    let expected = develop(&Device::cpu(), &vertices, &dark, SAMPLES);
    let shuffled = Device::cpu_with_order(LaneOrder::Shuffled(3));
    assert_same_words("shuffled", &expected, &develop(&shuffled, &vertices, &dark, SAMPLES));
    if let Some(gpu) = gpu() {
        assert_same_words("film", &expected, &develop(gpu, &vertices, &dark, SAMPLES));
    }
}

/// What is wrong with a sample is counted, and never spreads over the pixel.
#[test]
fn bad_samples_are_left_out_and_counted() {
    let with = |emitted: f32, primitive| Vertex { primitive, emitted: [emitted; 3], ..Vertex::default() };
    let lit = |photons| Irradiance { photons, ..Irradiance::default() };
    let vertices = [
        [with(1.0, 0), with(f32::NAN, 0), with(f32::INFINITY, 1), with(3.0, MISS)],
        // Each is finite, their sum is not.
        [with(f32::MAX, 0), with(f32::MAX, 0), with(2.0, LOST), with(0.0, LOST)],
    ];
    let direct = [lit(0), lit(0), lit(0), lit(0), lit(CUT_SHORT), lit(0), lit(CUT_SHORT), lit(0)];
    for device in [Some(&Device::cpu()), gpu()].into_iter().flatten() {
        let film = develop(device, vertices.as_flattened(), &direct, 4);
        let first = Pixel { rgb: [1.0; 3], covered: 3, not_finite: 2, lost: 0, cut_short: 0, rays: 0 };
        let second = Pixel { rgb: [f32::MAX / 4.0; 3], covered: 2, not_finite: 1, lost: 2, cut_short: 2, rays: 2 };
        assert_same_words(&device.name(), &[first, second], &film);
    }
}
