//! One hash over everything that the SPIR-V is made from.

use anyhow::{Context, Result};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Files and folders that go in: the kernels, their entry points, and the code that post-processes the result.
const INPUTS: [&str; 5] = [
    "crates/kernels/Cargo.toml",
    "crates/kernels/src",
    "crates/xtask/src",
    "shaders-crate/Cargo.toml",
    "shaders-crate/src",
];
/// The package whose locked dependencies go in.
const SHADERS: &str = "caustic-shaders";
/// Packages that shape the result from outside: they go in by version, without their own dependencies.
const TOOLS: [&str; 2] = ["spirv-builder", "rspirv"];

/// SHA-256 in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// `\r\n` as `\n`: what a checkout on Windows may have done to text.
pub fn normalised(bytes: &[u8]) -> Vec<u8> {
    let end = |i: usize| bytes[i] == b'\r' && bytes.get(i + 1) == Some(&b'\n');
    (0..bytes.len()).filter(|&i| !end(i)).map(|i| bytes[i]).collect()
}

/// The hash of all sources below the workspace root.
pub fn hash(root: &Path) -> Result<String> {
    let mut parts = BTreeMap::new();
    for input in INPUTS {
        collect(root, input, &mut parts)?;
    }
    let lock = fs::read_to_string(root.join("Cargo.lock")).context("cannot read Cargo.lock")?;
    let packages = locked(&lock)?;
    parts.insert("Cargo.lock".into(), packages.iter().cloned().collect::<String>().into_bytes());
    let workspace = fs::read_to_string(root.join("Cargo.toml")).context("cannot read Cargo.toml")?;
    parts.insert("Cargo.toml".into(), settings(&workspace, &packages)?.into_bytes());
    Ok(digest(&parts))
}

/// Hashes names and contents, each with its length, so that nothing can move from one to the next unnoticed.
fn digest(parts: &BTreeMap<String, Vec<u8>>) -> String {
    let mut all = Vec::new();
    for (name, bytes) in parts {
        for field in [name.as_bytes(), bytes] {
            all.extend((field.len() as u64).to_le_bytes());
            all.extend(field);
        }
    }
    sha256(&all)
}

/// Reads a file, or a folder's files, by paths with `/` relative to the root.
fn collect(root: &Path, relative: &str, parts: &mut BTreeMap<String, Vec<u8>>) -> Result<()> {
    let path = root.join(relative);
    let context = || format!("cannot read {relative}");
    if path.is_dir() {
        for entry in fs::read_dir(&path).with_context(context)? {
            let name = entry.with_context(context)?.file_name();
            collect(root, &format!("{relative}/{}", name.to_string_lossy()), parts)?;
        }
    } else {
        parts.insert(relative.into(), normalised(&fs::read(&path).with_context(context)?));
    }
    Ok(())
}

/// `name version checksum` of every package the shaders are locked to, one a line.
fn locked(lock: &str) -> Result<BTreeSet<String>> {
    let lock: toml::Table = lock.parse().context("cannot parse Cargo.lock")?;
    let packages = lock.get("package").and_then(toml::Value::as_array).context("Cargo.lock lists no packages")?;
    let text = |package: &toml::Value, key: &str| package.get(key).and_then(toml::Value::as_str).map(str::to_owned);
    let mut lines = BTreeSet::new();
    let mut queue = vec![SHADERS.to_owned()];
    queue.extend(TOOLS.map(str::to_owned));
    while let Some(wanted) = queue.pop() {
        // A dependency is written `name`, or `name version` where several versions are locked.
        let mut words = wanted.split(' ');
        let (name, version) = (words.next().unwrap_or_default(), words.next());
        for package in packages.iter().filter(|package| text(package, "name").as_deref() == Some(name)) {
            let locked = text(package, "version").unwrap_or_default();
            if version.is_some_and(|version| version != locked) {
                continue;
            }
            let checksum = text(package, "checksum").unwrap_or_default();
            if lines.insert(format!("{name} {locked} {checksum}\n")) && !TOOLS.contains(&name) {
                let dependencies = package.get("dependencies").and_then(toml::Value::as_array);
                queue.extend(dependencies.into_iter().flatten().filter_map(|d| d.as_str().map(str::to_owned)));
            }
        }
    }
    Ok(lines)
}

/// The root Cargo.toml's settings that reach the compiler: features of those packages, and the release profile.
fn settings(workspace: &str, packages: &BTreeSet<String>) -> Result<String> {
    let workspace: toml::Table = workspace.parse().context("cannot parse Cargo.toml")?;
    let mut kept = BTreeMap::new();
    let dependencies = workspace.get("workspace").and_then(|w| w.get("dependencies")).and_then(toml::Value::as_table);
    for (name, value) in dependencies.into_iter().flatten() {
        if packages.iter().any(|line| line.split(' ').next() == Some(name)) {
            kept.insert(name.clone(), value.to_string());
        }
    }
    let release = workspace.get("profile").and_then(|profile| profile.get("release"));
    kept.insert("profile.release".into(), release.map(toml::Value::to_string).unwrap_or_default());
    Ok(format!("{kept:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(text: &str) -> BTreeMap<String, Vec<u8>> {
        BTreeMap::from([("a.rs".to_owned(), normalised(text.as_bytes()))])
    }

    #[test]
    fn one_byte_changes_the_hash_and_a_line_end_does_not() {
        assert_ne!(digest(&parts("let a = 1;\n")), digest(&parts("let a = 2;\n")));
        assert_eq!(digest(&parts("let a = 1;\r\n")), digest(&parts("let a = 1;\n")));
    }

    #[test]
    fn bytes_cannot_move_between_files() {
        let split = |a: &str, b: &str| BTreeMap::from([(a.to_owned(), b.as_bytes().to_vec())]);
        assert_ne!(digest(&split("ab", "c")), digest(&split("a", "bc")));
    }

    #[test]
    fn only_the_shaders_dependencies_count() {
        let lock = |glam: &str, wgpu: &str| {
            locked(&format!(
                "[[package]]\nname = 'caustic-shaders'\nversion = '1'\ndependencies = ['glam']\n\
                 [[package]]\nname = 'glam'\nversion = '{glam}'\n[[package]]\nname = 'wgpu'\nversion = '{wgpu}'\n"
            ))
            .unwrap()
        };
        assert_eq!(lock("1", "1"), lock("1", "2"));
        assert_ne!(lock("1", "1"), lock("2", "1"));
    }
}
