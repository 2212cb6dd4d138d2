//! Surveys and rehearsals, which are kept in the user's folder for caches: a file each, named by what it depends on.

use crate::rehearsal::Rehearsal;
use crate::scout::Scout;
use crate::survey::Survey;
use caustic_renderer::{RenderError, Settings, Stop};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Version of the files.
const FORMAT: u32 = 7;

/// How long a GPU works until it has reached its clock.
const WARM: Duration = Duration::from_millis(100);

#[derive(Serialize, Deserialize)]
struct File<T> {
    /// What it depends on, for people and against accidents.
    of: String,
    found: T,
}

/// Who surveys and rehearses, and knows what is kept.
pub struct Surveyor<'a> {
    scout: Scout<'a>,
    folder: Option<PathBuf>,
    /// Whether anything had to be rendered.
    rendered: bool,
}

impl<'a> Surveyor<'a> {
    /// Keeps what is found in `folder`, if there is one. Whether it could be kept does not matter.
    #[must_use]
    pub fn new(scout: Scout<'a>, folder: Option<PathBuf>) -> Self {
        Self { scout, folder, rendered: false }
    }

    /// The survey of the scene near some settings.
    ///
    /// # Errors
    /// Those of [`Survey::take`].
    pub fn survey(&mut self, near: &Settings) -> Result<Survey, RenderError> {
        // Where passes end, how many samples there are, and whether photons come in chunks, it does not depend on.
        let near = Settings { spp: 0, stop: Stop::default(), chunk: None, ..near.clone() };
        self.kept("survey", &near, Survey::take)
    }

    /// The rehearsal of some settings.
    ///
    /// # Errors
    /// Those of [`Rehearsal::take`].
    pub fn rehearsal(&mut self, settings: &Settings) -> Result<Rehearsal, RenderError> {
        self.kept("rehearsal", &Settings { stop: Stop::default(), ..settings.clone() }, Rehearsal::take)
    }

    /// Renders a few pixels with `settings`, if nothing that was asked for was rendered: a render's time is foreseen for kernels that are loaded, for
    /// threads and memory that are there, and for a GPU that has reached its clock.
    ///
    /// # Errors
    /// Those of renders.
    pub fn warm_up(&mut self, settings: &Settings) -> Result<(), RenderError> {
        let begun = Instant::now();
        let few = Settings { size: [8, 8], ..settings.clone() };
        while !self.rendered {
            self.scout.plain(&few, 1)?;
            self.rendered = !self.scout.device.is_gpu() || begun.elapsed() > WARM;
        }
        Ok(())
    }

    /// What is kept of some settings, or what `take` finds.
    fn kept<T: Serialize + DeserializeOwned>(
        &mut self,
        what: &str,
        settings: &Settings,
        take: fn(&mut Scout<'a>, &Settings) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let of = format!("{what} {}", identity(&self.scout, settings));
        let path = self.folder.as_deref().map(|folder| file(folder, &of));
        if let Some(found) = path.as_deref().and_then(|path| read(path, &of)) {
            return Ok(found);
        }
        self.rendered = true;
        let found = take(&mut self.scout, settings)?;
        if let Some(path) = path {
            keep(&path, &of, &found);
        }
        Ok(found)
    }
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

/// What is kept. What cannot be read is as good as nothing.
fn read<T: DeserializeOwned>(path: &Path, of: &str) -> Option<T> {
    let file: File<T> = serde_json::from_str(&fs::read_to_string(path).ok()?).ok()?;
    (file.of == of).then_some(file.found)
}

fn keep<T: Serialize>(path: &Path, of: &str, found: &T) {
    let file = File { of: of.to_string(), found };
    let Ok(text) = serde_json::to_string(&file) else { return };
    let kept = path.parent().map(fs::create_dir_all).transpose();
    // A cache that cannot be written is no cache, and no harm.
    let _ = kept.map_err(|error| error.to_string()).and_then(|_| caustic_bench::record::write(path, &text));
}

/// Everything that what is found depends on.
fn identity(scout: &Scout<'_>, settings: &Settings) -> String {
    let Scout { scene, device, costs, .. } = *scout;
    let [width, height] = settings.size;
    let digest = |bytes: &[u8]| Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let near = Settings { seed: 0, layers: Vec::new(), health: false, ..settings.clone() };
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
    use crate::scout::Costs;
    use caustic_device::Device;
    use caustic_renderer::scene::Scene;

    #[test]
    fn what_is_found_is_kept_for_what_it_depends_on_and_for_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let found = Rehearsal { first_s: 0.25, pass_s: 0.125, photon_noise: 0.1, blur: 0.01, step: 4.0 };
        let path = file(&folder.path().join("new"), "this");
        assert_eq!(read::<Rehearsal>(&path, "this"), None);
        keep(&path, "this", &found);
        assert_eq!(read(&path, "this"), Some(found));
        assert_eq!(read::<Rehearsal>(&path, "that"), None);
        fs::write(&path, "rubbish").unwrap();
        assert_eq!(read::<Rehearsal>(&path, "this"), None);

        let (scene, device) = (Scene::load("plane").unwrap(), Device::cpu());
        let settings = Settings::of(&scene);
        let of = |settings: &Settings, costs| identity(&Scout::new(&scene, &device, costs, &mut || true), settings);
        let first = of(&settings, Costs::Measured);
        assert_eq!(first, of(&Settings { seed: 7, ..settings.clone() }, Costs::Measured));
        assert_ne!(first, of(&Settings { k: 7, ..settings.clone() }, Costs::Measured));
        assert_ne!(first, of(&settings, Costs::BuiltIn));
    }

    #[test]
    fn a_survey_does_not_depend_on_samples_and_a_rehearsal_does() {
        let folder = tempfile::tempdir().unwrap();
        let (scene, device) = (Scene::load("plane").unwrap(), Device::cpu());
        let files = || fs::read_dir(folder.path()).unwrap().count();
        let mut go_on = || true;
        let scout = Scout::new(&scene, &device, Costs::BuiltIn, &mut go_on);
        let mut surveyor = Surveyor::new(scout, Some(folder.path().to_path_buf()));
        let settings = Settings { size: [16, 12], ..Settings::of(&scene) };
        let more = Settings { spp: settings.spp + 1, ..settings.clone() };
        assert_eq!(surveyor.survey(&settings).unwrap(), surveyor.survey(&more).unwrap());
        assert_eq!(files(), 1);
        surveyor.rehearsal(&settings).unwrap();
        surveyor.rehearsal(&more).unwrap();
        surveyor.rehearsal(&more).unwrap();
        assert_eq!(files(), 3);
    }
}
