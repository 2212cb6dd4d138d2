//! The TOML format, field by field. docs/scene-format.md is its reference for users.

use super::RenderTable;
use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use std::collections::BTreeMap;
use std::fmt;

/// A scene file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    /// What the scene shows, in one line.
    #[serde(default)]
    pub description: String,
    /// Where the picture is taken from.
    pub camera: CameraTable,
    /// Defaults for the settings of a render.
    #[serde(default)]
    pub render: RenderTable,
    /// Materials by name.
    #[serde(default)]
    pub materials: BTreeMap<String, MaterialTable>,
    /// Parallelograms, those that emit among them.
    #[serde(default)]
    pub quads: Vec<QuadTable>,
    /// Spheres.
    #[serde(default)]
    pub spheres: Vec<SphereTable>,
    /// Lights that are no surfaces.
    #[serde(default)]
    pub lights: Vec<LightTable>,
}
