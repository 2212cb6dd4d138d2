//! Finds a scene by name or path.

use super::builtin::{BUILT_IN, names};
use super::error::SceneError;
use super::import;
use super::limits::MAX_FILE_BYTES;
use super::model::is_model;
use super::text::{nearest, one_line};
use super::{BuiltIn, Scene};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Loads the built-in scene `spec`, or else the file of this path.
pub(super) fn load(spec: &str) -> Result<Scene, SceneError> {
    if let Some(found) = BUILT_IN.iter().find(|scene: &&BuiltIn| scene.name == spec) {
        return Scene::parse(found.name, found.text);
    }
    let path = Path::new(spec);
    let names_a_file = path.extension().is_some() || path.components().count() > 1 || path.exists();
    if !names_a_file {
        let meant = nearest(spec, BUILT_IN.iter().map(|scene| scene.name));
        return Err(SceneError::Unknown {
            name: one_line(spec),
            suggestion: meant.map_or(String::new(), |name| format!(" (did you mean `{name}`?)")),
            known: names(),
        });
    }
    if is_model(path) {
        return import::scene(path);
    }
    let bytes = read(path).map_err(|error| SceneError::Unreadable {
        path: one_line(spec),
        reason: if path.is_dir() { "it is a folder".to_string() } else { error.to_string() },
        known: names(),
    })?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(SceneError::TooLarge { path: one_line(spec), limit: MAX_FILE_BYTES });
    }
    match std::str::from_utf8(&bytes) {
        Ok(text) => Scene::parse(spec, text),
        Err(error) => Err(SceneError::NotText { path: one_line(spec), offset: error.valid_up_to() }),
    }
}

/// The text of a file, or why there is none.
pub(super) fn text(path: &Path) -> Result<String, String> {
    let bytes = read(path).map_err(|error| error.to_string())?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(format!("it is larger than {MAX_FILE_BYTES} bytes"));
    }
    String::from_utf8(bytes).map_err(|_| "it is not a text file".to_string())
}

/// The file's bytes, up to one more than a scene may have.
fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The file's name without folder and ending.
pub(super) fn stem(file_name: &str) -> String {
    let stem = Path::new(file_name).file_stem().map_or(file_name.into(), |stem| stem.to_string_lossy());
    one_line(&stem)
}
