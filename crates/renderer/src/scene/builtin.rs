//! The scenes that come with the program: files like any other, embedded.

use super::Scene;

/// A scene file that is part of the program.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// The name to ask for.
    pub name: &'static str,
    /// The file's text.
    pub text: &'static str,
}

/// All of them; the first is what the program renders when it is told nothing.
pub const BUILT_IN: &[BuiltIn] = &[
    BuiltIn { name: "cornell", text: include_str!("../../scenes/cornell.toml") },
    BuiltIn { name: "cornell-coated", text: include_str!("../../scenes/cornell-coated.toml") },
    BuiltIn { name: "cornell-glossy", text: include_str!("../../scenes/cornell-glossy.toml") },
    BuiltIn { name: "courtyard", text: include_str!("../../scenes/courtyard.toml") },
    BuiltIn { name: "furnace", text: include_str!("../../scenes/furnace.toml") },
    BuiltIn { name: "hall", text: include_str!("../../scenes/hall.toml") },
    BuiltIn { name: "lamps", text: include_str!("../../scenes/lamps.toml") },
    BuiltIn { name: "landscape", text: include_str!("../../scenes/landscape.toml") },
    BuiltIn { name: "micro", text: include_str!("../../scenes/micro.toml") },
    BuiltIn { name: "plane", text: include_str!("../../scenes/plane.toml") },
    BuiltIn { name: "ring", text: include_str!("../../scenes/ring.toml") },
    BuiltIn { name: "pool", text: include_str!("../../scenes/pool.toml") },
    BuiltIn { name: "water", text: include_str!("../../scenes/water.toml") },
];

impl BuiltIn {
    /// What it shows, in one line.
    #[must_use]
    pub fn description(&self) -> String {
        Scene::parse(self.name, self.text).map_or_else(|error| error.to_string(), |scene| scene.description)
    }
}

/// The names, for messages: `` `cornell`, `furnace`, `plane` ``.
pub(super) fn names() -> String {
    let quoted: Vec<String> = BUILT_IN.iter().map(|scene| format!("`{}`", scene.name)).collect();
    quoted.join(", ")
}
