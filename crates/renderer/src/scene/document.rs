//! The text of a scene file: where its fields are, and from which field a place in it is.

use super::error::{Place, SceneError};
use super::file::SceneFile;
use super::text::{nearest, one_line};
use serde::Deserialize;
use std::fmt;
use std::ops::Range;
use std::path::{Path as FilePath, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A step from a value to one in it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    /// Into a table.
    Key(String),
    /// Into an array, counted from 0.
    Index(usize),
    /// Nowhere: the name of the item that was stepped into.
    Name(String),
}

/// The way from the top of the file to a value.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Path(Vec<Step>);

impl Path {
    /// The field `key` of this table.
    pub fn key(&self, key: &str) -> Self {
        self.then(Step::Key(key.to_string()))
    }

    /// Item `index` of this array, counted from 0.
    pub fn index(&self, index: usize) -> Self {
        self.then(Step::Index(index))
    }

    /// This item, called `name`.
    pub fn named(&self, name: &str) -> Self {
        self.then(Step::Name(name.to_string()))
    }

    fn then(&self, step: Step) -> Self {
        let mut steps = self.0.clone();
        steps.push(step);
        Self(steps)
    }
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return write!(f, "the scene");
        }
        let mut text = String::new();
        for step in &self.0 {
            match step {
                Step::Key(key) if text.is_empty() => text = one_line(key),
                Step::Key(key) => text = format!("{text}.{}", one_line(key)),
                Step::Index(index) => text = format!("{text}[{index}]"),
                Step::Name(_) => {}
            }
        }
        write!(f, "`{text}`")?;
        match self.0.iter().find(|step| matches!(step, Step::Name(_))) {
            Some(Step::Name(name)) => write!(f, " ({})", one_line(name)),
            _ => Ok(()),
        }
    }
}

/// A scene file that is TOML.
pub(super) struct Document<'a> {
    name: &'a str,
    text: &'a str,
    root: Spanned<DeTable<'a>>,
}

impl<'a> Document<'a> {
    /// Parses the text of the file that is called `name`.
    pub fn parse(name: &'a str, text: &'a str) -> Result<Self, SceneError> {
        match DeTable::parse(text) {
            Ok(root) => Ok(Self { name, text, root }),
            Err(error) => {
                let start = error.span().map_or(text.len(), |span| span.start);
                Err(SceneError::Syntax { place: place(name, text, start), problem: one_line(error.message()) })
            }
        }
    }

    /// The folder that other files are looked for in.
    pub fn folder(&self) -> PathBuf {
        FilePath::new(self.name).parent().map(FilePath::to_path_buf).unwrap_or_default()
    }

    /// The file's fields.
    pub fn fields(&self) -> Result<SceneFile, SceneError> {
        SceneFile::deserialize(toml::de::Deserializer::from(self.root.clone())).map_err(|error| {
            let start = error.span().map_or(0, |span| span.start);
            let path = self.path_at(start);
            self.error(start, &path, reworded(error.message()))
        })
    }

    /// An error about the field at `path`.
    pub fn field_error(&self, path: &Path, problem: impl Into<String>) -> SceneError {
        let mut start = 0;
        let mut value: Option<&DeValue<'_>> = None;
        for step in &path.0 {
            let next = match (step, value) {
                (Step::Key(key), None) => self.root.get_ref().get(key.as_str()),
                (Step::Key(key), Some(DeValue::Table(table))) => table.get(key.as_str()),
                (Step::Index(index), Some(DeValue::Array(array))) => array.get(*index),
                (Step::Name(_), _) => continue,
                _ => None,
            };
            let Some(next) = next else { break };
            start = next.span().start;
            value = Some(next.get_ref());
        }
        self.error(start, path, problem.into())
    }

    fn error(&self, start: usize, path: &Path, problem: String) -> SceneError {
        SceneError::Field { place: place(self.name, self.text, start), field: path.to_string(), problem }
    }

    /// The innermost value or key that holds byte `at`.
    fn path_at(&self, at: usize) -> Path {
        let mut best = (usize::MAX, Path::default());
        search_table(self.root.get_ref(), at, &Path::default(), &mut best);
        best.1
    }
}

fn search_table(table: &DeTable<'_>, at: usize, path: &Path, best: &mut (usize, Path)) {
    for (key, value) in table {
        let path = path.key(key.get_ref());
        consider(key.span(), at, &path, best);
        search_value(value, at, &path, best);
    }
}

fn search_value(value: &Spanned<DeValue<'_>>, at: usize, path: &Path, best: &mut (usize, Path)) {
    consider(value.span(), at, path, best);
    match value.get_ref() {
        DeValue::Table(table) => search_table(table, at, path, best),
        DeValue::Array(array) => {
            for (index, item) in array.iter().enumerate() {
                search_value(item, at, &path.index(index), best);
            }
        }
        _ => {}
    }
}

fn consider(span: Range<usize>, at: usize, path: &Path, best: &mut (usize, Path)) {
    if span.contains(&at) && span.len() < best.0 {
        *best = (span.len(), path.clone());
    }
}

/// Line and column of byte `at`.
fn place(name: &str, text: &str, at: usize) -> Place {
    let at = text.floor_char_boundary(at);
    let before = &text[..at];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    Place {
        file: one_line(name),
        line: before.matches('\n').count() + 1,
        column: before[line_start..].chars().count() + 1,
    }
}

/// Serde's message as the end of a sentence that begins with the field.
fn reworded(message: &str) -> String {
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let known = quoted.iter().skip(1).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let meant = quoted.first().and_then(|name| nearest(name, quoted.iter().skip(1).copied()));
    let meant = meant.map_or(String::new(), |name| format!(" (did you mean `{name}`?)"));
    if message.starts_with("unknown field") {
        return format!("is not a known field{meant}; the fields here are {known}");
    }
    if message.starts_with("unknown variant") {
        let unknown = one_line(quoted.first().unwrap_or(&""));
        return format!("cannot be \"{unknown}\"{meant}; it must be one of {known}");
    }
    if message.starts_with("missing field") {
        let missing = quoted.first().unwrap_or(&"");
        return format!("lacks the field `{missing}`; add {}", example(missing));
    }
    let plain =
        message.replace("f64", "a number").replace("i64", "a whole number").replace("borrowed string", "a string");
    format!("has the wrong type: {}", one_line(&plain))
}

/// How a required field may look.
fn example(field: &str) -> &'static str {
    match field {
        "position" => "`position = [x, y, z]`, in metres",
        "target" => "`target = [x, y, z]`, the point the camera looks at, in metres",
        "vertical_fov_degrees" => "for example `vertical_fov_degrees = 35`",
        "kind" => "for example `kind = \"lambertian\"` to a material or `kind = \"point\"` to a light",
        "corner" => "`corner = [x, y, z]`, in metres",
        "edge_u" | "edge_v" => "the two edges that leave the corner, in metres, for example `edge_u = [1, 0, 0]`",
        "centre" => "`centre = [x, y, z]`, in metres",
        "radius" => "for example `radius = 0.5`, in metres",
        "normal" => "the direction the front looks to, for example `normal = [0, 1, 0]`",
        "mesh" => "the name of a [[meshes]]",
        "place" => "for example `place = { translate = [1, 0, 0] }`",
        "material" => "the name of a material, for example `material = \"white\"`",
        "intensity" => "`intensity = [r, g, b]`, in W/sr",
        _ => "it",
    }
}
