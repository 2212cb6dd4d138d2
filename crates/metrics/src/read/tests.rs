use crate::{Image, MetricsError, Range, from_srgb};
use exr::prelude::WritableImage;
use image::{ExtendedColorType, ImageEncoder};
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

const WIDTH: usize = 9;
const HEIGHT: usize = 8;

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn write(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    path
}

fn png(codes: &[u8], kind: ExtendedColorType) -> Vec<u8> {
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes).write_image(codes, WIDTH as u32, HEIGHT as u32, kind).unwrap();
    bytes
}

fn light(i: usize) -> [f32; 3] {
    [i as f32 * 0.125, 1.0, 1e-3 * i as f32]
}

fn exr(alpha: Option<f32>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let at = |at: exr::prelude::Vec2<usize>| light(at.y() * WIDTH + at.x());
    let cursor = std::io::Cursor::new(&mut bytes);
    match alpha {
        None => exr::prelude::Image::from_channels(
            (WIDTH, HEIGHT),
            exr::prelude::SpecificChannels::rgb(|p: exr::prelude::Vec2<usize>| (at(p)[0], at(p)[1], at(p)[2])),
        )
        .write()
        .to_buffered(cursor),
        Some(alpha) => exr::prelude::Image::from_channels(
            (WIDTH, HEIGHT),
            exr::prelude::SpecificChannels::rgba(move |p: exr::prelude::Vec2<usize>| {
                (at(p)[0], at(p)[1], at(p)[2], alpha)
            }),
        )
        .write()
        .to_buffered(cursor),
    }
    .unwrap();
    bytes
}

fn hdr() -> Vec<u8> {
    let pixels: Vec<_> = (0..WIDTH * HEIGHT).map(|i| image::Rgb(light(i))).collect();
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&pixels, WIDTH, HEIGHT).unwrap();
    bytes
}

#[test]
fn pngs_are_srgb_of_8_and_16_bits() {
    let folder = folder();
    let codes: Vec<u8> = (0..3 * WIDTH * HEIGHT).map(|i| (i * 5 % 256) as u8).collect();
    let path = write(&folder, "a.png", &png(&codes, ExtendedColorType::Rgb8));
    let found = Image::read(&path).unwrap();
    let triples: Vec<[u8; 3]> = codes.chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
    let expected = Image::from_srgb8(WIDTH, HEIGHT, &triples).unwrap().named(found.name());
    assert_eq!(found, expected);
    assert_eq!(found.range(), Range::Display);

    // 16 bits: PNG's are big-endian, the encoder takes the machine's.
    let codes: Vec<u16> = (0..3 * WIDTH * HEIGHT).map(|i| (i * 301) as u16).collect();
    let bytes: Vec<u8> = codes.iter().flat_map(|code| code.to_ne_bytes()).collect();
    let found = Image::read(&write(&folder, "b.PNG", &png(&bytes, ExtendedColorType::Rgb16))).unwrap();
    for (value, &code) in found.rgb().as_flattened().iter().zip(&codes) {
        assert_eq!(*value, from_srgb(f64::from(code) / 65_535.0) as f32, "{code}");
    }
    let grey: Vec<u8> = (0..WIDTH * HEIGHT).map(|i| i as u8).collect();
    let found = Image::read(&write(&folder, "c.png", &png(&grey, ExtendedColorType::L8))).unwrap();
    assert_eq!(found.rgb()[40], [from_srgb(40.0 / 255.0) as f32; 3]);
}

#[test]
fn what_is_behind_a_png_is_not_guessed() {
    let folder = folder();
    let mut codes = vec![255u8; 4 * WIDTH * HEIGHT];
    assert!(Image::read(&write(&folder, "opaque.png", &png(&codes, ExtendedColorType::Rgba8))).is_ok());
    codes[4 * (3 * WIDTH + 2) + 3] = 254;
    let error =
        Image::read(&write(&folder, "glass.png", &png(&codes, ExtendedColorType::Rgba8))).unwrap_err().to_string();
    assert!(error.contains("glass.png` is transparent at pixel (2, 3)") && error.contains("flatten"), "{error}");
}

#[test]
fn exrs_keep_their_numbers() {
    let folder = folder();
    let expected: Vec<_> = (0..WIDTH * HEIGHT).map(light).collect();
    for (name, alpha) in [("a.exr", None), ("b.exr", Some(0.5))] {
        let found = Image::read(&write(&folder, name, &exr(alpha))).unwrap();
        assert_eq!((found.rgb(), found.range()), (&expected[..], Range::Scene));
        assert_eq!((found.width(), found.height()), (WIDTH, HEIGHT));
    }
}

#[test]
fn radiances_pictures_are_read_to_their_precision() {
    let folder = folder();
    let plain = Image::read(&write(&folder, "a.hdr", &hdr())).unwrap();
    assert_eq!((plain.width(), plain.height(), plain.range()), (WIDTH, HEIGHT, Range::Scene));
    for (i, found) in plain.rgb().iter().enumerate() {
        // One exponent for three channels of eight bits.
        let most = light(i).into_iter().fold(0.0, f32::max);
        assert!(found.iter().zip(light(i)).all(|(a, b)| (a - b).abs() <= most / 128.0), "{found:?} of {:?}", light(i));
    }
    // An exposure in the header is divided out.
    let text = hdr();
    let end = text.windows(2).position(|pair| pair == b"\n\n").unwrap();
    let exposed = [&text[..end], b"\nEXPOSURE=4.0\nCOLORCORR=1.0 2.0 1.0", &text[end..]].concat();
    let exposed = Image::read(&write(&folder, "b.hdr", &exposed)).unwrap();
    for (plain, exposed) in plain.rgb().iter().zip(exposed.rgb()) {
        assert_eq!([exposed[0] * 4.0, exposed[1] * 8.0, exposed[2] * 4.0], *plain);
    }
    let other = [b"#?RGBE", text.strip_prefix(b"#?RADIANCE").unwrap()].concat();
    assert_eq!(Image::read(&write(&folder, "d.hdr", &other)).unwrap().rgb(), plain.rgb());
    let xyz = [&text[..end], b"\nFORMAT=32-bit_rle_xyze", &text[end..]].concat();
    let error = Image::read(&write(&folder, "c.hdr", &xyz)).unwrap_err().to_string();
    assert!(error.contains("32-bit_rle_xyze"), "{error}");
}

/// One line that names the file, whatever is in it.
#[track_caller]
fn refused(folder: &TempDir, name: &str, bytes: &[u8], words: &str) {
    let error = Image::read(&write(folder, name, bytes)).map(|image| image.rgb().len()).unwrap_err().to_string();
    assert!(error.contains(name) && error.contains(words), "{error}");
    assert!(!error.contains('\n') && error.contains("; "), "{error:?}");
}

#[test]
fn damaged_files_are_one_sentence() {
    let folder = folder();
    let whole =
        [("a.png", png(&[7; 3 * WIDTH * HEIGHT], ExtendedColorType::Rgb8)), ("a.exr", exr(None)), ("a.hdr", hdr())];
    for (name, bytes) in &whole {
        refused(&folder, name, b"", "is empty");
        refused(&folder, name, b"not a picture", "does not begin as");
        for (other, bytes) in &whole {
            if other != name {
                refused(&folder, name, bytes, "give it the ending of what it holds");
            }
        }
        for length in (1..bytes.len()).step_by(7) {
            // A file can lack what a decoder need not read, such as PNG's last chunk, and is whole then.
            if let Ok(image) = Image::read(&write(&folder, name, &bytes[..length])) {
                assert_eq!(image, Image::read(&write(&folder, name, bytes)).unwrap(), "{name} of {length} bytes");
                continue;
            }
            refused(&folder, name, &bytes[..length], "");
        }
        // Bytes of chance after a right beginning, and single wrong ones: an error or a picture, never a panic.
        for seed in 0..400usize {
            let mut bytes = bytes.clone();
            let at = 4 + seed * 2_654_435_761 % (bytes.len() - 4);
            bytes[at] = (seed * 97 + 13) as u8;
            if let Err(error) = Image::read(&write(&folder, name, &bytes)) {
                assert!(error.to_string().contains(name), "{error}");
            }
        }
    }
    let header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4000000000 +X 4000000000\n";
    refused(&folder, "huge.hdr", header, "4000000000x4000000000");
    refused(&folder, "large.hdr", b"#?RADIANCE\n\n-Y 40000 +X 40000\n", "40000 × 40000 pixels");
    refused(&folder, "none.hdr", b"#?RADIANCE\n\n-Y 0 +X 7\n", "");
    for name in ["a.jpg", "png", "a"] {
        let error = Image::read(&folder.path().join(name)).unwrap_err();
        assert!(matches!(error, MetricsError::UnknownEnding { .. }), "{error}");
    }
    let missing = Image::read(&folder.path().join("missing.exr")).unwrap_err().to_string();
    assert!(missing.contains("missing.exr") && missing.contains("No such file"), "{missing}");
    fs::create_dir(folder.path().join("folder.exr")).unwrap();
    let error = Image::read(&folder.path().join("folder.exr")).unwrap_err().to_string();
    assert!(error.contains("it is a folder"), "{error}");
}

#[test]
fn a_file_with_a_nan_is_named_with_pixel_and_channel() {
    let folder = folder();
    let pixel = |p: exr::prelude::Vec2<usize>| (1.0f32, 1.0f32, if (p.x(), p.y()) == (4, 2) { f32::NAN } else { 0.5 });
    let path = folder.path().join("bad.exr");
    exr::prelude::Image::from_channels((WIDTH, HEIGHT), exr::prelude::SpecificChannels::rgb(pixel))
        .write()
        .to_file(&path)
        .unwrap();
    let error = Image::read(&path).unwrap_err().to_string();
    assert!(error.contains("bad.exr` holds NaN in the blue channel of pixel (4, 2)"), "{error}");
}
