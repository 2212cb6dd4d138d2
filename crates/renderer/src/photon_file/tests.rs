use super::*;
use crate::{Given, RenderError, Rendered, Show, render, render_on};
use std::fs;

fn scene(name: &str) -> Scene {
    Scene::load(name).unwrap()
}

fn settings(scene: &Scene) -> Settings {
    Settings { size: [20, 15], photons: 3000, caustic_photons: 1500, k: 40, spp: 2, seed: 5, ..Settings::of(scene) }
}

fn traced(name: &str) -> PhotonFile {
    let scene = scene(name);
    PhotonFile::trace(&scene, &settings(&scene), &Device::cpu(), &mut |_| true).unwrap()
}

fn from_file(scene: &Scene, settings: &Settings, device: &Device, file: &PhotonFile) -> Result<Rendered, RenderError> {
    let given = Given { photons: Some(file), ..Given::default() };
    render_on(scene, settings, device, given, &mut |_| true, &mut |_| Ok(()))
}

fn bits(image: &crate::output::Image) -> Vec<u32> {
    image.rgb.as_flattened().iter().map(|x| x.to_bits()).collect()
}

#[test]
fn a_render_from_a_file_has_the_bits_of_a_render_without() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.caustic");
    let (scene, device) = (scene("cornell"), Device::cpu());
    let settings = settings(&scene);
    traced("cornell").write(&path).unwrap();
    let file = PhotonFile::read(&path).unwrap();
    assert_eq!(PhotonFile { source: "cornell".to_string(), ..file.clone() }, traced("cornell"));
    let direct = render(&scene, &settings, &device, &mut |_| true).unwrap();
    let loaded = from_file(&scene, &settings, &device, &file).unwrap();
    assert_eq!(bits(&direct.image), bits(&loaded.image));
    let counts = |report: &crate::RenderReport| -> Vec<_> {
        report.maps.iter().map(|map| (map.map, map.photons_emitted, map.photons_stored, map.segments)).collect()
    };
    assert_eq!(counts(&direct.report), counts(&loaded.report));
    // It is the file's photons that are seen: those of another seed make another picture.
    let other = Settings { seed: 6, ..settings.clone() };
    let other = PhotonFile::trace(&scene, &other, &device, &mut |_| true).unwrap();
    let other = from_file(&scene, &settings, &device, &other).unwrap();
    assert_ne!(bits(&direct.image), bits(&other.image));
}

#[test]
fn photons_of_another_scene_or_another_kind_are_refused() {
    let file = traced("cornell");
    assert!(file.check_scene(&scene("cornell")).is_ok());
    let error = file.check_scene(&scene("plane")).unwrap_err().to_string();
    assert!(error.contains("`cornell`") && error.contains("`plane`"), "{error}");
    let cornell = scene("cornell");
    let shown = Settings { show: Show::MapGlobal, ..settings(&cornell) };
    let refused = from_file(&cornell, &shown, &Device::cpu(), &file);
    assert!(matches!(refused, Err(RenderError::NotInFile { map: "global", .. })));
    let refused = from_file(&scene("plane"), &settings(&cornell), &Device::cpu(), &file);
    assert!(matches!(refused, Err(RenderError::PhotonFile(PhotonFileError::OtherScene { .. }))));
}

/// Every byte counts: whichever is changed or missing, the file is refused in one sentence.
#[test]
fn a_damaged_file_is_refused_wherever_it_is_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.caustic");
    let plane = scene("plane");
    let few = Settings { photons: 20, caustic_photons: 10, ..settings(&plane) };
    let few = PhotonFile::trace(&plane, &few, &Device::cpu(), &mut |_| true);
    // With so few photons there may be none to store.
    let file = few.unwrap_or_else(|_| traced("plane"));
    file.write(&path).unwrap();
    let whole = fs::read(&path).unwrap();
    let step = whole.len().div_ceil(700);
    for at in (0..whole.len()).step_by(step).chain(whole.len() - 33..whole.len()) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        fs::write(&path, &bytes).unwrap();
        let error = PhotonFile::read(&path).expect_err("a byte was changed").to_string();
        assert!(!error.contains('\n') && error.contains("a.caustic"), "{at}: {error}");
        fs::write(&path, &whole[..at]).unwrap();
        assert!(PhotonFile::read(&path).is_err(), "{at} bytes of {}", whole.len());
    }
    fs::write(&path, [&whole[..], b"x"].concat()).unwrap();
    assert!(PhotonFile::read(&path).is_err());
    let mut newer = whole.clone();
    newer[8] = 9;
    fs::write(&path, &newer).unwrap();
    assert!(matches!(PhotonFile::read(&path), Err(PhotonFileError::Version { found: 9, .. })));
    fs::write(&path, "a text").unwrap();
    assert!(matches!(PhotonFile::read(&path), Err(PhotonFileError::NotOne { .. })));
    assert!(matches!(PhotonFile::read(folder.path()), Err(PhotonFileError::Unreadable { .. })));
    assert!(matches!(PhotonFile::read(&folder.path().join("none")), Err(PhotonFileError::Unreadable { .. })));
    fs::write(&path, &whole).unwrap();
    assert_eq!(PhotonFile::read(&path).unwrap().photons, file.photons);
}

/// More photons than a window has, in two maps: whichever are asked for come, as they were written.
#[test]
fn any_photons_of_a_saved_file_are_read_where_they_lie() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.caustic");
    let mut file = traced("cornell");
    let photon = |i: u32| Photon { position: [i as f32, 0.5, -1.0], power: [1.0, 2.0, i as f32], ..Photon::default() };
    file.photons = vec![(0..700_000).map(photon).collect(), (700_000..1_100_000).map(photon).collect()];
    for (header, photons) in file.header.maps.iter_mut().zip(&file.photons) {
        header.stored = photons.len() as u32;
    }
    file.write(&path).unwrap();
    let saved = SavedPhotons::open(&path).unwrap();
    assert_eq!((saved.count(), saved.largest_power()), (1_100_000, [1.0, 2.0, 1_099_999.0]));
    let per_window = window::WINDOW / 32;
    assert!(saved.count() > 2 * per_window);
    for range in [0..5, 0..1_100_000, per_window - 3..per_window + 3, 699_998..700_002, 1_099_999..1_200_000, 7..7] {
        let expected: Vec<Photon> = (range.start as u32..(range.end as u32).min(1_100_000)).map(photon).collect();
        assert!(saved.read(range.clone()).unwrap() == expected, "{range:?}");
    }
    assert!(PhotonFile::read(&path).unwrap().photons == file.photons);
    // A file that becomes shorter after it was looked through is an error, not the end of the program.
    fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(20_000_000).unwrap();
    assert!(matches!(saved.read(1_000_000..1_000_001), Err(PhotonFileError::Unreadable { .. })));
    assert!(matches!(SavedPhotons::open(&path), Err(PhotonFileError::Damaged { .. })));
}

#[test]
fn photons_that_are_no_numbers_are_refused_in_spite_of_a_checksum() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.caustic");
    let mut file = traced("cornell");
    file.photons[0][7].power[1] = f32::NAN;
    file.write(&path).unwrap();
    let error = PhotonFile::read(&path).expect_err("a power is NaN");
    assert!(matches!(&error, PhotonFileError::Damaged { reason, .. } if reason.contains("photon 7 ")), "{error}");
}
