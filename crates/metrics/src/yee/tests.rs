use super::*;

/// White is 1 cd/m², so numbers are luminances, and 64 pixels are a degree.
const OPTIONS: YeeOptions = YeeOptions { field_of_view: 1.0, white: 1.0 };
const SIDE: usize = 64;

fn picture(value: impl Fn(usize, usize) -> f64) -> Image {
    let rgb = (0..SIDE * SIDE).map(|i| [value(i % SIDE, i / SIDE) as f32; 3]).collect();
    Image::from_linear(SIDE, SIDE, rgb).unwrap()
}

fn flat(value: f64) -> Image {
    picture(|_, _| value)
}

/// Columns of a grating of a contrast and a period in pixels, 64 over the period cycles a degree.
fn grating(contrast: f64, period: f64, x: usize) -> f64 {
    contrast * (std::f64::consts::TAU * (x as f64 + 0.5) / period).sin()
}

fn visible(a: &Image, b: &Image) -> usize {
    yee(a, b, &OPTIONS).unwrap().0
}

#[test]
fn the_same_picture_does_not_differ() {
    let noise = picture(|x, y| ((x * 7919 + y * 104_729) % 97) as f64);
    assert_eq!(yee(&noise, &noise, &OPTIONS).unwrap(), (0, vec![0.0; SIDE * SIDE]));
    assert_eq!(visible(&flat(0.0), &flat(0.0)), 0);
}

/// Of even fields, the threshold at the mean of both decides, which is computed by hand here from Ward Larson's table.
#[test]
fn even_fields_differ_by_the_threshold() {
    for (luminance, threshold) in
        [(0.01, 5.472e-3), (0.1, 4.027e-2), (1.0, 0.391_3), (10.0, 1.072), (100.0, 5.559), (1e4, 555.9)]
    {
        let fields = |difference: f64| [flat(luminance - difference / 2.0), flat(luminance + difference / 2.0)];
        let [a, b] = fields(0.95 * threshold);
        assert_eq!(visible(&a, &b), 0, "{luminance}");
        let [a, b] = fields(1.05 * threshold);
        assert_eq!(visible(&a, &b), SIDE * SIDE, "{luminance}");
        // The map is the difference over the threshold.
        let map = yee(&a, &b, &OPTIONS).unwrap().1;
        assert!(map.iter().all(|times| (times - 1.05).abs() < 1e-3), "{luminance}: {}", map[0]);
    }
    // In the dark nothing below 10^−2.86 is seen.
    assert_eq!(visible(&flat(0.0), &flat(1.3e-3)), 0);
    assert_eq!(visible(&flat(0.0), &flat(1.0e-2)), SIDE * SIDE);
}

#[test]
fn a_texture_of_both_hides_a_difference_and_one_of_a_single_picture_does_not() {
    let texture = |x: usize, y: usize| grating(40.0, 16.0, x) + grating(40.0, 16.0, y);
    let offset = 8.0;
    assert_eq!(visible(&flat(100.0), &flat(100.0 + offset)), SIDE * SIDE);
    let [a, b] = [0.0, offset].map(|offset| picture(|x, y| 100.0 + offset + texture(x, y)));
    // But for a few pixels between crests, where there is no contrast.
    assert!(visible(&a, &b) < SIDE * SIDE / 50, "{}", visible(&a, &b));
    // The texture alone against none is no mask of itself.
    let alone = visible(&a, &flat(100.0));
    assert!(alone > SIDE * SIDE / 2, "{alone}");
    // A texture over half of both hides a difference there, and less the farther from it.
    let half = |offset: f64| picture(|x, y| 100.0 + offset + if x < SIDE / 2 { texture(x, y) } else { 0.0 });
    let map = yee(&half(0.0), &half(16.0), &OPTIONS).unwrap().1;
    let row = &map[SIDE * SIDE / 2..][..SIDE];
    assert!(
        row[..SIDE / 2].iter().all(|&times| times < 1.0) && row[SIDE - 4..].iter().all(|&times| times > 1.0),
        "{row:?}"
    );
}

#[test]
fn fine_gratings_are_seen_less_than_coarser_ones() {
    let seen = |period: f64| visible(&flat(100.0), &picture(|x, _| 100.0 + grating(40.0, period, x)));
    println!("DBG {:?}", [2.0, 4.0, 8.0, 16.0, 32.0].map(seen));
    // 32, 16 and 4 cycles a degree: the last, where sensitivity is highest, at all but its zeros.
    let [finest, fine, middle] = [2.0, 4.0, 16.0].map(seen);
    assert_eq!(finest, 0);
    assert!(fine < middle && middle > SIDE * SIDE / 2, "{fine} {middle}");
    // Seen from nearer, 3.2 cycles a degree, the finest is not fine any more.
    let near = YeeOptions { field_of_view: 10.0, ..OPTIONS };
    let stripes = picture(|x, _| 100.0 + grating(40.0, 2.0, x));
    assert_eq!(yee(&flat(100.0), &stripes, &near).unwrap().0, SIDE * SIDE);
}

#[test]
fn colour_is_seen_in_light_and_not_in_the_dark() {
    // Equal luminance: 0.2126 · 0.1 = 0.7152 · 0.0297.
    let colour = |red: f32, green: f32| Image::from_linear(SIDE, SIDE, vec![[red, green, 0.5]; SIDE * SIDE]).unwrap();
    let (a, b) = (colour(0.5, 0.5), colour(0.6, 0.5 - 0.1 * 0.2126 / 0.7152));
    let at = |white: f64| yee(&a, &b, &YeeOptions { white, ..OPTIONS }).unwrap().0;
    assert_eq!((at(100.0), at(0.015)), (SIDE * SIDE, 0));
    // Less than a unit of CIELAB is not seen.
    let near = colour(0.502, 0.5 - 0.002 * 0.2126 / 0.7152);
    assert_eq!(yee(&a, &near, &YeeOptions { white: 100.0, ..OPTIONS }).unwrap().0, 0);
}

#[test]
fn neither_picture_is_the_reference() {
    let a = picture(|x, y| ((x / 8 * 31 + y / 8 * 17) % 23) as f64 * 3.0);
    let b = picture(|x, y| ((x / 8 * 13 + y / 8 * 29) % 31) as f64 * 2.0);
    let found = yee(&a, &b, &OPTIONS).unwrap();
    assert_eq!(found, yee(&b, &a, &OPTIONS).unwrap());
    assert!(found.0 > 0);
}

#[test]
fn moving_both_moves_the_result() {
    let a = |x: usize, y: usize| 50.0 + ((x * 31 + y * 17) % 23) as f64;
    let b = |x: usize, y: usize| a(x, y) + if x == 30 && y == 33 { 300.0 } else { 0.0 };
    let whole = yee(&picture(a), &picture(b), &OPTIONS).unwrap().1;
    let moved = yee(&picture(|x, y| a(x + 1, y)), &picture(|x, y| b(x + 1, y)), &OPTIONS).unwrap().1;
    let (at, before) = (whole[33 * SIDE + 30], moved[33 * SIDE + 29]);
    assert!(at > 1.0 && (at / before - 1.0).abs() < 0.05, "{at} {before}");
}

#[test]
fn narrow_pictures_have_an_answer() {
    for (width, height) in [(1, 1), (1, 9), (9, 1), (2, 2)] {
        let flat = |value: f32| Image::from_linear(width, height, vec![[value; 3]; width * height]).unwrap();
        for field_of_view in [0.1, 45.0, 170.0] {
            let options = YeeOptions { field_of_view, white: 100.0 };
            assert_eq!(yee(&flat(0.5), &flat(0.5), &options).unwrap().0, 0);
            assert_eq!(yee(&flat(0.0), &flat(1.0), &options).unwrap().0, width * height, "{width} × {height}");
            assert_eq!(yee(&flat(-1.0), &flat(0.0), &options).unwrap().0, 0, "negative light is black");
            let bright = yee(&flat(f32::MAX), &flat(0.0), &options).unwrap();
            assert!(bright.0 == width * height && bright.1[0].is_finite());
        }
    }
}

#[test]
fn parameters_are_checked() {
    let bad = [(0.0, 100.0), (171.0, 100.0), (f64::NAN, 100.0), (45.0, 0.0), (45.0, f64::INFINITY), (45.0, f64::NAN)];
    for (field_of_view, white) in bad {
        let error = yee(&flat(1.0), &flat(1.0), &YeeOptions { field_of_view, white }).unwrap_err().to_string();
        assert!(error.contains("but must be from 0."), "{error}");
    }
    // 512 pixels over 45°: 10.79 a degree at the middle.
    assert!((YeeOptions::default().pixels_per_degree(512) - 10.787).abs() < 1e-3);
}

/// What tests/reference/yee.py says of the same pictures: the formulas again, in another language and by direct sums.
#[test]
fn direct_sums_say_the_same() {
    const WIDTH: usize = 48;
    const HEIGHT: usize = 32;
    let picture = |shift: usize| {
        let pixel = |i: usize| {
            let (x, y) = (i % WIDTH, i / WIDTH);
            let tile = (x / 8 + y / 8) % 3;
            std::array::from_fn(|c| ((x / 3 * 7 + y / 2 * 13 + c * 29 + shift * tile) % 64 * 4) as u8)
        };
        Image::from_srgb8(WIDTH, HEIGHT, &(0..WIDTH * HEIGHT).map(pixel).collect::<Vec<[u8; 3]>>()).unwrap()
    };
    let options = YeeOptions { field_of_view: 2.0, white: 100.0 };
    let (pixels, map) = yee(&picture(5), &picture(0), &options).unwrap();
    assert_eq!(pixels, 326);
    for (at, expected) in [(9, 0.2865005), (505, 0.1854576), (1535, 0.4785676)] {
        assert!((f64::from(map[at]) / expected - 1.0).abs() < 1e-4, "{at}: {} instead of {expected}", map[at]);
    }
    let sum: f64 = map.iter().map(|&times| f64::from(times)).sum();
    assert!((sum / 2333.125 - 1.0).abs() < 1e-5, "{sum}");
}
