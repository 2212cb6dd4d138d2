//! Case files: TOML, field by field, before anything is checked. docs/benchmarks/README.md is their reference.

use super::check::check;
use super::{Case, CaseError, Target};
use crate::points::Distribution;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Most bytes of a case file.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// The kinds of cases.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum KindName {
    Sort,
    Build,
    Gather,
    Trace,
    Frame,
}

/// What a query of a gather gives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Output {
    /// An estimate of irradiance from its k nearest photons.
    #[default]
    Estimate,
    /// Its k nearest photons and their distances.
    Neighbours,
    /// An estimate from all photons within the radius.
    Density,
}

/// Hash functions, as case files call them.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum HashName {
    #[default]
    Linear,
    Teschner,
    Morton,
}

/// Ways to find the nearest, as case files call them.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum GatherName {
    #[default]
    Auto,
    Histogram,
    Heap,
    List,
}

/// A case file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CaseFile {
    pub name: String,
    pub description: String,
    pub kind: KindName,
    pub sizes: Vec<i64>,
    pub output: Option<Output>,
    pub distribution: Option<Distribution>,
    pub bits: Option<i64>,
    pub pairs: Option<bool>,
    pub queries: Option<i64>,
    pub k: Option<i64>,
    pub radius: Option<f64>,
    pub hash: Option<HashName>,
    pub gather: Option<GatherName>,
    pub scene: Option<String>,
    pub size: Option<[i64; 2]>,
    pub spp: Option<i64>,
    #[serde(default)]
    pub targets: Vec<Target>,
    #[serde(default)]
    pub expected: BTreeMap<String, String>,
}

/// Reads the case in the text of the file that is called `file`.
///
/// # Errors
/// If the text is not a case: the error says where and what to change.
pub fn parse(file: &str, text: &str) -> Result<Case, CaseError> {
    let fields: CaseFile = toml::from_str(text).map_err(|error| {
        let start = error.span().map_or(text.len(), |span| span.start);
        // serde names Rust's types.
        let words = [("expected i64", "expected a whole number"), ("expected f64", "expected a number")];
        let problem = words.iter().fold(error.message().to_string(), |text, (from, to)| text.replace(from, to));
        CaseError::at(file, text, start, &problem)
    })?;
    check(file, text, &fields)
}

/// Reads the case file at `path`.
///
/// # Errors
/// If it cannot be read or is not a case.
pub fn load(path: &Path) -> Result<Case, CaseError> {
    let file = path.display().to_string();
    let unreadable = |reason: String| CaseError::Unreadable { file: file.clone(), reason };
    let size = std::fs::metadata(path).map_err(|error| unreadable(error.to_string()))?;
    if size.is_dir() {
        return Err(unreadable("it is a folder; --cases takes one".to_string()));
    }
    if size.len() > MAX_FILE_BYTES {
        return Err(unreadable(format!("it is larger than {MAX_FILE_BYTES} bytes, the most a case may have")));
    }
    let text = std::fs::read_to_string(path).map_err(|error| unreadable(error.to_string()))?;
    Ok(Case { path: Some(path.to_path_buf()), ..parse(&file, &text)? })
}

/// Reads all case files (`*.toml`) in a folder, in the order of their names.
///
/// # Errors
/// If there are none, or one of them is not a case.
pub fn load_folder(folder: &Path) -> Result<Vec<Case>, CaseError> {
    let unreadable = |reason: String| CaseError::Unreadable { file: folder.display().to_string(), reason };
    let entries = std::fs::read_dir(folder).map_err(|error| unreadable(error.to_string()))?;
    let mut paths: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "toml"));
    paths.sort();
    if paths.is_empty() {
        return Err(unreadable("it holds no .toml file".to_string()));
    }
    paths.iter().map(|path| load(path)).collect()
}
