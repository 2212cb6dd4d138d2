//! Models that others made, from Debian's `assimp-testmodels` where it is installed: each gives a scene or one clear sentence, soon and without a
//! panic, and what real tools exported is rendered with equal bits by every device.

use caustic_device::Device;
use caustic_renderer::Settings;
use caustic_renderer::scene::Scene;
use caustic_tests::gpu;
use caustic_tests::renders::*;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;

const MODELS: &str = "/usr/share/assimp/models";

/// Longest that a model may take to read. The largest, of 2 MB, take a tenth of a second.
const PATIENCE: Duration = Duration::from_secs(20);

/// The folder of the models, or a line that says that they are skipped.
fn models() -> Option<&'static Path> {
    let folder = Path::new(MODELS);
    if !folder.is_dir() {
        println!("SKIPPED: {MODELS} is not there; install assimp-testmodels");
        return None;
    }
    Some(folder)
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        if path.is_dir() {
            files(&path, found);
        } else if ["ply", "obj", "gltf", "glb"].iter().any(|known| ending.as_deref() == Some(known)) {
            found.push(path);
        }
    }
}

#[test]
fn every_model_gives_a_scene_or_a_sentence() {
    let Some(folder) = models() else { return };
    let mut found = Vec::new();
    files(folder, &mut found);
    found.sort();
    let (mut scenes, mut refused) = (0, 0);
    for path in &found {
        let (send, receive) = mpsc::channel();
        let name = path.to_string_lossy().into_owned();
        let thread = {
            let name = name.clone();
            std::thread::spawn(move || {
                let read = Scene::load(&name).map(|scene| scene.inspect());
                send.send(read.map_err(|error| error.to_string())).unwrap();
            })
        };
        match receive.recv_timeout(PATIENCE) {
            Ok(Ok(inspection)) => {
                assert!(inspection.triangles > 0, "{name}");
                scenes += 1;
            }
            Ok(Err(sentence)) => {
                assert!(sentence.contains(&name) && !sentence.contains('\n'), "{name}: {sentence}");
                refused += 1;
            }
            Err(mpsc::RecvTimeoutError::Timeout) => panic!("{name} takes more than {PATIENCE:?}"),
            Err(mpsc::RecvTimeoutError::Disconnected) => panic!("{name} makes the reader panic"),
        }
        thread.join().unwrap();
    }
    println!("{scenes} scenes, {refused} sentences");
    assert!(scenes > 30 && refused > 5, "{scenes} scenes and {refused} sentences: is {MODELS} whole?");
}

/// With textures, nodes, transforms of texture coordinates, and 2 MB of an engine.
#[test]
fn exported_models_have_the_same_bits_on_a_gpu() {
    let (Some(folder), Some(gpu)) = (models(), gpu()) else { return };
    for name in [
        "BoxTextured-glTF-Binary/BoxTextured.glb",
        "2CylinderEngine-glTF-Binary/2CylinderEngine.glb",
        "textureTransform/TextureTransformTest.gltf",
    ] {
        let scene = Scene::load(&folder.join("glTF2").join(name).to_string_lossy()).unwrap();
        let settings =
            Settings { size: [24, 18], photons: 2000, caustic_photons: 1000, spp: 1, ..Settings::of(&scene) };
        let (ours, theirs) = (image(&scene, &settings, &Device::cpu()), image(&scene, &settings, gpu));
        assert_eq!(ours.sha256(), theirs.sha256(), "{name}");
        assert!(mean_rgb(&ours).iter().all(|&mean| mean > 1e-3), "{name} is dark: {:?}", mean_rgb(&ours));
    }
}
