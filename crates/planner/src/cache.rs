//! Surveys that are kept, in the user's folder for caches: a file each, named by what it depends on.

use crate::survey::{Costs, Survey};
use caustic_device::Device;
use caustic_renderer::scene::Scene;
use caustic_renderer::{RenderError, Settings};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};

/// Version of the files.
const FORMAT: u32 = 4;

#[derive(Serialize, Deserialize)]
struct File {
    /// What it depends on, for people and against accidents.
    of: String,
    survey: Survey,
}

/// The survey of a scene near some settings: a kept one, or a new one that is kept. Whether it could be kept does not matter.
///
/// # Errors
/// Those of [`Survey::take`].
pub fn survey(
    scene: &Scene,
    settings: &Settings,
    device: &Device,
    costs: Costs,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<Survey, RenderError> {
    let of = identity(scene, settings, device, costs);
    let path = folder().map(|folder| file(&folder, &of));
    if let Some(survey) = path.as_deref().and_then(|path| read(path, &of)) {
        return Ok(survey);
    }
    let survey = Survey::take(scene, settings, device, costs, go_on)?;
    if let Some(path) = path {
        keep(&path, &of, &survey);
    }
    Ok(survey)
}

/// Where surveys are kept; nowhere if the system has no folder for it.
#[must_use]
pub fn folder() -> Option<PathBuf> {
    Some(dirs::cache_dir()?.join("caustic").join("surveys"))
}

fn file(folder: &Path, of: &str) -> PathBuf {
    let digest = Sha256::digest(of);
    let name: String = digest.iter().take(16).map(|byte| format!("{byte:02x}")).collect();
    folder.join(format!("{name}.json"))
}

/// A kept survey. What cannot be read is as good as none.
fn read(path: &Path, of: &str) -> Option<Survey> {
    let file: File = serde_json::from_str(&fs::read_to_string(path).ok()?).ok()?;
    (file.of == of).then_some(file.survey)
}

fn keep(path: &Path, of: &str, survey: &Survey) {
    let file = File { of: of.to_string(), survey: survey.clone() };
    let Ok(text) = serde_json::to_string(&file) else { return };
    let kept = path.parent().map(fs::create_dir_all).transpose();
    // A cache that cannot be written is no cache, and no harm.
    let _ = kept.map_err(|error| error.to_string()).and_then(|_| caustic_bench::record::write(path, &text));
}

/// Everything that a survey depends on.
fn identity(scene: &Scene, settings: &Settings, device: &Device, costs: Costs) -> String {
    let [width, height] = settings.size;
    let digest = |bytes: &[u8]| Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let near = Settings {
        seed: 0,
        spp: 0,
        layers: Vec::new(),
        stop: Default::default(),
        health: false,
        chunk: None,
        ..settings.clone()
    };
    format!(
        "{FORMAT} caustic {} {} exact {} threads {} {costs:?} scene {} camera {} {near:?}",
        env!("CARGO_PKG_VERSION"),
        device.name(),
        device.is_exact(),
        std::thread::available_parallelism().map_or(1, usize::from),
        scene.compile().sha256(),
        digest(bytemuck::bytes_of(&scene.camera(width, height))),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_survey_is_kept_for_what_it_depends_on_and_for_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let survey = Survey {
            emitted: [1.0, 2.0],
            stored: [0.5; 2],
            positions: [vec![[0.1, 0.2, 0.3]], Vec::new()],
            k: [1.0, 4.0, 16.0],
            radius: 0.1,
            setup_s: 0.25,
            photons: Default::default(),
            entry_s: 1e-9,
            image_s: 0.125,
            sample_s: [1e-6; 3],
            sample_noise: [0.5, 0.25],
            photon_noise: [0.1, 0.2, 0.3],
            blur: [1e-5, 2e-5],
        };
        let path = file(&folder.path().join("new"), "this");
        assert_eq!(read(&path, "this"), None);
        keep(&path, "this", &survey);
        assert_eq!(read(&path, "this"), Some(survey));
        assert_eq!(read(&path, "that"), None);
        fs::write(&path, "rubbish").unwrap();
        assert_eq!(read(&path, "this"), None);

        let (scene, device) = (Scene::load("plane").unwrap(), Device::cpu());
        let settings = Settings::of(&scene);
        let of = |settings: &Settings, costs| identity(&scene, settings, &device, costs);
        let first = of(&settings, Costs::Measured);
        assert_eq!(first, of(&Settings { seed: 7, ..settings.clone() }, Costs::Measured));
        assert_ne!(first, of(&Settings { k: 7, ..settings.clone() }, Costs::Measured));
        assert_ne!(first, of(&settings, Costs::BuiltIn));
    }
}
