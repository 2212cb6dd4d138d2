//! What can be wrong with a scene, each in one sentence with the remedy.

use std::fmt;

/// A place in a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file, as it was named.
    pub file: String,
    /// Line, counted from 1.
    pub line: usize,
    /// Column in characters, counted from 1.
    pub column: usize,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// Why a scene cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Neither a built-in scene nor a file.
    #[error(
        "there is no scene `{name}`{suggestion}: give one of the built-in scenes {known} or the path of a .toml, .ply, .obj, .gltf or .glb file"
    )]
    Unknown {
        /// What was asked for.
        name: String,
        /// The nearest name, as part of the sentence; or empty.
        suggestion: String,
        /// The built-in scenes.
        known: String,
    },
    /// The file cannot be read.
    #[error(
        "cannot read the scene file `{path}`: {reason}; give the path of a readable .toml file or one of the built-in scenes {known}"
    )]
    Unreadable {
        /// The file.
        path: String,
        /// The system's words.
        reason: String,
        /// The built-in scenes.
        known: String,
    },
    /// The file is too large to be a scene.
    #[error("the scene file `{path}` is larger than {limit} bytes, the most a scene may have; is it another file?")]
    TooLarge {
        /// The file.
        path: String,
        /// Bytes allowed.
        limit: u64,
    },
    /// The file is not UTF-8.
    #[error(
        "`{path}` is not a text file (byte {offset} is not UTF-8): a scene is a TOML file, see docs/scene-format.md"
    )]
    NotText {
        /// The file.
        path: String,
        /// Where the first wrong byte is, counted from 0.
        offset: usize,
    },
    /// A model cannot be used.
    #[error("the model `{path}` {problem}")]
    Model {
        /// The file.
        path: String,
        /// What is wrong with it, with the remedy.
        problem: String,
    },
    /// A scene cannot be converted to a file of this ending.
    #[error("`{path}` ends neither in .toml nor in .ply, so it is not clear what to write; give one of these endings")]
    Ending {
        /// The file.
        path: String,
    },
    /// A scene file shall become one.
    #[error("`{path}` is a scene file already; convert it to .ply, or give a model (.ply, .obj, .gltf, .glb)")]
    AlreadyToml {
        /// The file.
        path: String,
    },
    /// The file says nothing.
    #[error("`{path}` is empty: a scene needs at least a [camera], a surface and a light, see docs/scene-format.md")]
    Empty {
        /// The file.
        path: String,
    },
    /// The file is not TOML.
    #[error("{place}: this is not valid TOML: {problem}; docs/scene-format.md has an example")]
    Syntax {
        /// Where.
        place: Place,
        /// The parser's words.
        problem: String,
    },
    /// The file is TOML, but a field is missing, unknown, of the wrong type or out of its bounds.
    #[error("{place}: {field} {problem}")]
    Field {
        /// Where.
        place: Place,
        /// The field, such as `` `quads[3].edge_u` ``, or `the scene`.
        field: String,
        /// What is wrong with it, with the bound and the remedy.
        problem: String,
    },
}
