//! Scenes: files in a TOML format of our own (docs/scene-format.md), checked field by field, and the kernels' records
//! that they become.
//!
//! ```
//! # fn main() -> Result<(), caustic_renderer::scene::SceneError> {
//! use caustic_renderer::scene::Scene;
//! let scene = Scene::load("cornell")?;
//! let camera = scene.camera(512, 512);
//! let records = scene.compile();
//! assert_eq!(records.info.primitives, 8);
//! # Ok(())
//! # }
//! ```

mod builtin;
pub(crate) mod bvh;
mod camera;
mod check;
mod compile;
mod content;
mod convert;
mod digest;
mod document;
mod error;
mod file;
mod generated;
mod import;
mod inspect;
mod lamps;
mod lights;
pub mod limits;
mod load;
mod meshes;
mod model;
mod needs;
mod place;
mod reference;
mod sky;
mod substances;
mod surfaces;
mod targets;
mod text;
mod validate;
mod view;

#[cfg(test)]
mod tests;

pub use builtin::{BUILT_IN, BuiltIn};
pub use compile::CompiledScene;
pub use convert::Target as ConvertTarget;
pub(crate) use digest::hex;
pub use error::{Place, SceneError};
pub use inspect::Inspection;
pub use text::suggestion;

use crate::Feature;
use caustic_kernels::trace::Camera;
use content::Content;
use document::Document;

/// A scene that has been read and checked.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name of the built-in scene, or the file's name without folder and ending.
    pub name: String,
    /// What it shows, in one line; empty if the file does not say.
    pub description: String,
    /// The file's defaults for the settings of a render.
    pub defaults: RenderDefaults,
    /// What was left out of its files or added to them.
    pub notes: Vec<String>,
    content: Content,
}

/// A scene's defaults for the settings of a render; what is `None`, the scene leaves to the program.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderDefaults {
    /// Width and height of the picture, pixels.
    pub size: Option<[u32; 2]>,
    /// Photons emitted for the global map.
    pub photons: Option<u32>,
    /// Photons emitted for the caustic map.
    pub caustic_photons: Option<u32>,
    /// Photons in an estimate, at most.
    pub k: Option<u32>,
    /// Radius within which an estimate looks for photons, m.
    pub radius: Option<f32>,
    /// Samples a pixel.
    pub spp: Option<u32>,
}

impl Scene {
    /// Loads the built-in scene of this name or else the scene file or model (.ply, .obj, .gltf, .glb) at this path.
    ///
    /// # Errors
    /// If there is neither, or the file is not a scene.
    pub fn load(spec: &str) -> Result<Self, SceneError> {
        load::load(spec)
    }

    /// Reads a scene from the text of the file that is called `file_name`.
    ///
    /// # Errors
    /// If the text is not a scene: the error says where and what to change.
    pub fn parse(file_name: &str, text: &str) -> Result<Self, SceneError> {
        if text.trim_start_matches('\u{feff}').trim().is_empty() {
            return Err(SceneError::Empty { path: file_name.to_string() });
        }
        let document = Document::parse(file_name, text)?;
        let file = document.fields()?;
        let (defaults, content, notes) = validate::validate(&document, &file)?;
        Ok(Self {
            name: load::stem(file_name),
            description: text::one_line(&file.description),
            defaults,
            notes,
            content,
        })
    }

    /// The JSON schema of scene files, made from the types that read them: docs/scene.schema.json.
    #[must_use]
    pub fn schema() -> String {
        format!("{:#}\n", schemars::schema_for!(file::SceneFile).to_value())
    }

    /// The page that has every field of scene files, made from the same types: docs/scene-reference.md.
    #[must_use]
    pub fn reference() -> String {
        reference::page()
    }

    /// The camera for a picture of `width` × `height` pixels, each at least 1.
    #[must_use]
    pub fn camera(&self, width: u32, height: u32) -> Camera {
        camera::camera(&self.content.camera, width, height)
    }

    /// Where the origin of the kernels' coordinates, and so of photons, lies in the file's, m. It is 0 unless the scene is farther from its
    /// origin than it is large.
    #[must_use]
    pub fn origin(&self) -> [f64; 3] {
        self.content.origin.to_array()
    }

    /// What it holds, and what in it is worth a look.
    #[must_use]
    pub fn inspect(&self) -> Inspection {
        inspect::inspect(self)
    }

    /// This scene, which was loaded from `input`, as the bytes of a file at `output`.
    ///
    /// # Errors
    /// If it is a scene file already and shall become one.
    pub fn convert(&self, input: &str, output: &std::path::Path, target: ConvertTarget) -> Result<Vec<u8>, SceneError> {
        convert::convert(self, input, output, target)
    }

    /// The kernels' records.
    #[must_use]
    pub fn compile(&self) -> CompiledScene {
        self.compile_with(&[])
    }

    /// The kernels' records, with features that the scene does not need.
    #[must_use]
    pub fn compile_with(&self, forced: &[Feature]) -> CompiledScene {
        compile::compile(&self.content, forced)
    }
}
