use super::*;
use std::fs;
use std::path::PathBuf;

/// An empty folder that goes when it is dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("caustic-output-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn files(&self) -> usize {
        fs::read_dir(&self.0).unwrap().count()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn picture() -> Image {
    let odd = [0.0, -0.0, 1.0, -1.5, 1e-42, f32::MIN_POSITIVE, f32::MAX, f32::INFINITY, f32::NEG_INFINITY];
    let (width, height) = (37, 41);
    let value = |i: u32| odd.get(i as usize).copied().unwrap_or(i as f32 * 0.001);
    let rgb = (0..width * height).map(|i| [value(3 * i), value(3 * i + 1), value(3 * i + 2)]).collect();
    Image { width, height, rgb }
}

fn metadata() -> Metadata {
    Metadata {
        version: "0.1.0".to_string(),
        scene: "cornell".to_string(),
        seed: 7,
        settings: vec![("k".to_string(), "150".to_string()), ("radius".to_string(), "0.15 m, größer → ∞".to_string())],
    }
}

fn bits(image: &Image) -> Vec<[u32; 3]> {
    image.rgb.iter().map(|rgb| rgb.map(f32::to_bits)).collect()
}

#[test]
fn an_exr_keeps_every_bit() {
    let folder = Folder::new("bits");
    let path = folder.0.join("a.exr");
    let mut image = picture();
    image.rgb[20] = [f32::from_bits(0x7fc0_1234), f32::NAN, -f32::NAN];
    write(&path, &image, &metadata()).unwrap();
    let back = read(&path).unwrap();
    assert_eq!((back.width, back.height), (37, 41));
    assert_eq!(bits(&back), bits(&image));
    assert_eq!(folder.files(), 1);
}

#[test]
fn an_exr_says_how_it_was_made_and_is_the_same_every_time() {
    let first = exr_file::encode(&picture(), &[], &metadata()).unwrap();
    for _ in 0..16 {
        assert!(exr_file::encode(&picture(), &[], &metadata()).unwrap() == first);
    }
    let header = exr::meta::MetaData::read_from_buffered(first.as_slice(), true).unwrap().headers[0].clone();
    let attribute = |name: &str| {
        let name = exr::prelude::Text::from(format!("caustic.{name}").as_str());
        match header.own_attributes.other.get(&name).or(header.shared_attributes.other.get(&name)) {
            Some(exr::prelude::attribute::AttributeValue::Text(text)) => text.to_string(),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(attribute("version"), "0.1.0");
    assert_eq!(attribute("scene"), "cornell");
    assert_eq!(attribute("seed"), "7");
    assert_eq!(attribute("settings"), "k=150\nradius=0.15 m, größer ? ?");
}

#[test]
fn srgb_codes_are_those_of_the_standard() {
    // 12.92·x below 0.0031308; 0.5 → 187.5 → 188; middle grey 0.18 → 117.6 → 118.
    for (linear, code) in [(0.0, 0), (0.001, 3), (0.003_130_8, 10), (0.18, 118), (0.5, 188), (1.0, 255)] {
        assert_eq!(to_srgb8(linear), code, "{linear}");
    }
    for (linear, code) in [(-1.0, 0), (f32::NAN, 0), (f32::NEG_INFINITY, 0), (2.0, 255), (f32::INFINITY, 255)] {
        assert_eq!(to_srgb8(linear), code, "{linear}");
    }
    for code in 0..=255 {
        assert_eq!(to_srgb8(from_srgb8(code)), code);
    }
}

#[test]
fn a_png_keeps_every_code_in_its_place() {
    let folder = Folder::new("png");
    let path = folder.0.join("a.PNG");
    let image = picture();
    write(&path, &image, &metadata()).unwrap();
    let back = read(&path).unwrap();
    assert_eq!((back.width, back.height), (37, 41));
    let codes = |image: &Image| image.rgb.iter().map(|rgb| rgb.map(to_srgb8)).collect::<Vec<_>>();
    assert_eq!(codes(&back), codes(&image));
    let bytes = fs::read(&path).unwrap();
    write(&path, &image, &metadata()).unwrap();
    assert!(fs::read(&path).unwrap() == bytes);
}

#[test]
fn errors_say_what_to_do_and_leave_no_file() {
    let folder = Folder::new("errors");
    let inside = |name: &str| folder.0.join(name);
    fs::create_dir(inside("folder.png")).unwrap();
    fs::write(inside("file"), "").unwrap();
    let before = folder.files();
    let long = format!("{}.png", "x".repeat(300));
    for (path, part) in [
        (inside("a.jpg"), ".png, .exr or .hdr"),
        (inside("png"), ".png, .exr or .hdr"),
        (PathBuf::new(), ".png, .exr or .hdr"),
        (inside("none/a.png"), "does not exist"),
        (inside("file/a.png"), "not a folder"),
        (inside("folder.png"), "is a folder"),
        (inside(&long), "cannot write"),
    ] {
        let checked = check_path(&path).unwrap_err();
        assert!(checked.to_string().contains(part), "{checked}");
        assert_eq!(write(&path, &picture(), &metadata()).unwrap_err(), checked);
    }
    for (width, height) in [(0, 0), (37, 42), (u32::MAX, u32::MAX)] {
        let wrong = Image { width, height, ..picture() };
        assert!(matches!(write(&inside("a.exr"), &wrong, &metadata()), Err(OutputError::Shape { .. })));
    }
    assert_eq!(folder.files(), before);
    check_path(&inside("new.exr")).unwrap();
    check_path(std::path::Path::new("new.exr")).unwrap();
    assert_eq!(folder.files(), before, "checking leaves nothing behind");
}

#[test]
fn damaged_files_are_errors() {
    let folder = Folder::new("damaged");
    for name in ["a.exr", "a.png", "a.hdr"] {
        let path = folder.0.join(name);
        assert!(read(&path).is_err());
        write(&path, &picture(), &metadata()).unwrap();
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        assert!(read(&path).is_err(), "{name} cut short");
        fs::write(&path, "not a picture").unwrap();
        assert!(read(&path).is_err());
    }
}

/// A layer of each kind, all floats different.
fn layers(pixels: usize) -> Vec<Layer> {
    let kinds = std::iter::once(LayerKind::Variance).chain(LayerKind::OF_PHOTON_MAPS);
    let layer = |(n, kind): (usize, LayerKind)| {
        let values = (0..pixels * kind.channels().len()).map(|i| (i + 100_000 * n) as f32).collect();
        Layer { kind, values }
    };
    kinds.enumerate().map(layer).collect()
}

#[test]
fn an_exr_keeps_every_bit_of_its_layers() {
    use exr::prelude::{ReadChannels, ReadLayers};
    let (folder, image) = (Folder::new("layers"), picture());
    let layers = layers(image.rgb.len());
    let path = folder.0.join("a.exr");
    write_with(&path, &image, &metadata(), &Extras { layers: &layers, ..Extras::default() }).unwrap();
    assert_eq!(bits(&read(&path).unwrap()), bits(&image), "the picture is read beside layers");
    let file = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    let file = file.all_attributes().non_parallel().from_file(&path).unwrap();
    let channels = &file.layer_data.channel_data.list;
    assert_eq!(channels.len(), 3 + layers.iter().map(|layer| layer.kind.channels().len()).sum::<usize>());
    for layer in &layers {
        let names = layer.kind.channels();
        for (c, name) in names.iter().enumerate() {
            let name = format!("{}.{name}", layer.kind.name());
            let found = channels.iter().find(|channel| channel.name.to_string() == name).expect("a channel");
            let found: Vec<f32> = found.sample_data.values_as_f32().collect();
            let expected: Vec<f32> = layer.values.iter().skip(c).step_by(names.len()).copied().collect();
            assert_eq!(found, expected, "{name}");
        }
    }
}

#[test]
fn layers_that_do_not_fit_are_refused() {
    let (folder, image) = (Folder::new("no-layers"), picture());
    let layers = layers(image.rgb.len());
    let extras = Extras { layers: &layers, ..Extras::default() };
    for name in ["a.png", "a.hdr"] {
        let error = write_with(&folder.0.join(name), &image, &metadata(), &extras).unwrap_err();
        assert!(error.to_string().contains(".exr"), "{error}");
    }
    let short = [Layer { kind: LayerKind::Depth, values: vec![0.0; image.rgb.len() - 1] }];
    let error = write_with(&folder.0.join("a.exr"), &image, &metadata(), &Extras { layers: &short, ..extras });
    assert!(matches!(error, Err(OutputError::Shape { pixels: 1516, .. })), "{error:?}");
    assert_eq!(folder.files(), 0);
}

#[test]
fn an_hdr_keeps_the_brightest_channel_to_a_hundredth() {
    let folder = Folder::new("hdr");
    let path = folder.0.join("a.hdr");
    let rgb: Vec<[f32; 3]> =
        (0..40 * 30).map(|i| [0.001, 0.5, 1.0].map(|x| x * (i as f32 * 0.03 - 15.0).exp2())).collect();
    let image = Image { width: 40, height: 30, rgb };
    write(&path, &image, &metadata()).unwrap();
    let bytes = fs::read(&path).unwrap();
    write(&path, &image, &metadata()).unwrap();
    assert!(fs::read(&path).unwrap() == bytes);
    let back = read(&path).unwrap();
    assert_eq!((back.width, back.height), (40, 30));
    for (a, b) in image.rgb.iter().zip(&back.rgb) {
        for c in 0..3 {
            // A step is 1/128 of the brightest at the least.
            assert!((a[c] - b[c]).abs() <= a[2] / 128.0, "{a:?} {b:?}");
        }
    }
    let odd = Image { width: 3, height: 1, rgb: vec![[f32::NAN, -1.0, f32::INFINITY], [0.0; 3], [f32::MAX; 3]] };
    write(&path, &odd, &metadata()).unwrap();
    assert!(read(&path).unwrap().rgb.iter().flatten().all(|value| value.is_finite() && *value >= 0.0));
}

#[test]
fn a_file_that_fails_midway_leaves_what_was_there() {
    let folder = Folder::new("midway");
    let path = folder.0.join("a.bin");
    replace(&path, b"old").unwrap();
    let failing = replace_with(&path, |file| {
        file.write_all(b"new")?;
        Err(std::io::Error::other("a fault"))
    });
    assert!(failing.unwrap_err().to_string().contains("a fault"));
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(folder.files(), 1);
}
