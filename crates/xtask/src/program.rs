//! The program, as tasks run it.

use crate::shaders::workspace_root;
use anyhow::{Result, bail, ensure};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Builds the program. Returns the workspace's folder and the program's place.
pub fn program() -> Result<(PathBuf, PathBuf)> {
    let root = workspace_root()?;
    let status =
        Command::new("cargo").args(["build", "--release", "--workspace", "--bins"]).current_dir(&root).status()?;
    ensure!(status.success(), "the program could not be built");
    let program = root.join("target/release/caustic");
    Ok((root, program))
}

/// The object that a command prints.
pub fn report(program: &Path, arguments: &[&str], root: &Path) -> Result<Value> {
    let run = Command::new(program).args(arguments).current_dir(root).output()?;
    ensure!(run.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&run.stderr).trim());
    Ok(serde_json::from_slice(&run.stdout)?)
}

/// The built-in scenes.
pub struct Scenes {
    /// All of them, as `caustic scene list --json` has them.
    pub listed: Vec<Value>,
    /// Their names.
    pub names: Vec<String>,
    /// Those that were asked for, or all.
    pub wanted: Vec<String>,
}

impl Scenes {
    /// Asks the program for them.
    pub fn list(program: &Path, root: &Path, asked: &[String]) -> Result<Self> {
        let listed: Vec<Value> = serde_json::from_value(report(program, &["scene", "list", "--json"], root)?)?;
        let names: Vec<String> =
            listed.iter().map(|scene| scene["name"].as_str().unwrap_or_default().to_string()).collect();
        if let Some(unknown) = asked.iter().find(|scene| !names.contains(scene)) {
            bail!("there is no scene `{unknown}`; there are {}", names.join(", "));
        }
        let wanted = names.iter().filter(|name| asked.is_empty() || asked.contains(name)).cloned().collect();
        Ok(Self { listed, names, wanted })
    }
}
