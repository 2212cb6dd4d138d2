use super::*;

const WIDTH: usize = 48;
const HEIGHT: usize = 32;

/// Codes from 0 to 252 that change from pixel to pixel; `shift` changes two of three tiles.
fn codes(shift: usize) -> Vec<[u8; 3]> {
    let pixel = |i: usize| {
        let (x, y) = (i % WIDTH, i / WIDTH);
        std::array::from_fn(|c| ((x * 7 + y * 13 + c * 29 + shift * ((x / 8 + y / 8) % 3)) % 64 * 4) as u8)
    };
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

fn display(shift: usize) -> Image {
    Image::from_srgb8(WIDTH, HEIGHT, &codes(shift)).unwrap()
}

fn scene(shift: usize) -> Image {
    let light = |code: u8| (f32::from(code) / 16.0).powi(2) / 4.0;
    Image::from_linear(WIDTH, HEIGHT, codes(shift).iter().map(|rgb| rgb.map(light)).collect()).unwrap()
}

#[track_caller]
fn same(found: &(f64, Vec<f32>), mean: f64, pixels: [f32; 3]) {
    let at = [0, 10 * WIDTH + 17, 31 * WIDTH + 47].map(|i| found.1[i]);
    assert!((found.0 - mean).abs() < 2e-6, "mean {} instead of {mean}", found.0);
    for (found, expected) in at.iter().zip(pixels) {
        assert!((found - expected).abs() < 1e-5, "{at:?} instead of {pixels:?}");
    }
}

/// What the authors' own program says of the same pictures: `flip_evaluator.evaluate` of PyPI's flip-evaluator 1.7.
#[test]
fn the_authors_program_says_the_same() {
    let [test, reference] = [5, 0].map(display);
    let by_default = flip(&test, &reference, &FlipOptions::default()).unwrap();
    same(&by_default, 0.266_059_309, [0.002_105_256, 0.106_809_735, 0.791_025_46]);
    let near = flip(&test, &reference, &FlipOptions { pixels_per_degree: 20.0 }).unwrap();
    same(&near, 0.473_529_667, [0.0, 0.045_364_8, 0.980_413_85]);
    let [test, reference] = [5, 0].map(scene);
    let hdr = flip(&test, &reference, &FlipOptions::default()).unwrap();
    same(&hdr, 0.274_856_985, [0.008_180_123, 0.055_400_953, 0.951_904_83]);
}

#[test]
fn scale_does_not_show_in_scenes() {
    let [test, reference] = [5, 0].map(scene);
    let times = |image: &Image, factor: f32| {
        let rgb = image.rgb().iter().map(|rgb| rgb.map(|value| value * factor)).collect();
        Image::from_linear(WIDTH, HEIGHT, rgb).unwrap()
    };
    let expected = flip(&test, &reference, &FlipOptions::default()).unwrap().0;
    for power in [-60, -30, -10, 10, 20] {
        let factor = 2f32.powi(power);
        let found = flip(&times(&test, factor), &times(&reference, factor), &FlipOptions::default()).unwrap().0;
        assert!((found - expected).abs() < 1e-5, "2^{power}: {found} instead of {expected}");
    }
}

#[test]
fn black_pictures_have_an_answer() {
    let options = FlipOptions::default();
    for width in [1, 7] {
        let flat = |value: f32| Image::from_linear(width, 1, vec![[value; 3]; width]).unwrap();
        assert_eq!(flip(&flat(0.0), &flat(0.0), &options).unwrap(), (0.0, vec![0.0; width]));
        assert_eq!(flip(&flat(-1.0), &flat(0.0), &options).unwrap().0, 0.0);
        for value in [1e-30, 1e-6, 1.0, 1e30, f32::MAX] {
            let found = flip(&flat(value), &flat(0.0), &options).unwrap().0;
            let swapped = flip(&flat(0.0), &flat(value), &options).unwrap().0;
            assert!(found > 0.5 && found == swapped, "{value}: {found} {swapped}");
        }
    }
}

#[test]
fn what_it_cannot_do_is_said() {
    let image = display(0);
    for pixels_per_degree in [0.0, -1.0, f32::NAN, f32::INFINITY, 1001.0] {
        let error = flip(&image, &image, &FlipOptions { pixels_per_degree }).unwrap_err().to_string();
        assert!(error.contains("pixels per degree") && error.contains("from 1 to 1000"), "{error}");
    }
}
