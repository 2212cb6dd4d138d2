//! `cargo xtask shaders`: compile, post-process, check, reflect, write; or compare with what is committed.

use crate::arithmetic::Arithmetic;
use crate::compile::Compiler;
use crate::reflect::{EntryPoint, Interface, Manifest};
use crate::{check, compile, postprocess, reflect, sources, verify};
use anyhow::{Context, Result, bail};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Where the committed files are, relative to the workspace root: an exact module an entry point, a fast one in the
/// subfolder, and the manifest.
const FOLDER: &str = "crates/device/shaders";
/// The manifest's name.
const MANIFEST: &str = "manifest.json";
/// What to do about every difference.
const REMEDY: &str = "run `cargo xtask shaders` and commit crates/device/shaders";

/// Options of the task.
#[derive(clap::Args)]
pub struct Options {
    /// Write nothing; fail if the committed files are not what the sources give.
    #[arg(long)]
    check: bool,
    /// With --check: fail where no rust-gpu compiler is at hand, instead of comparing hashes of the sources.
    #[arg(long, requires = "check")]
    require_rebuild: bool,
}

/// Runs the task.
pub fn run(options: &Options) -> Result<()> {
    let root = workspace_root()?;
    match (compile::find(), options.check) {
        (Ok(compiler), false) => write(&root, &compiler),
        (Ok(compiler), true) => compare(&root, &compiler),
        (Err(compile::Missing::Nowhere(_)), true) if !options.require_rebuild => compare_hashes(&root),
        (Err(missing), _) => bail!(missing),
    }
}

/// The files of [`FOLDER`], by path below it, as the sources give them.
type Files = BTreeMap<String, Vec<u8>>;

/// From sources to files, in memory.
fn build(root: &Path, compiler: &Compiler) -> Result<Files> {
    let mut files = Files::new();
    let exact = build_set(root, compiler, Arithmetic::Exact, &mut files)?;
    let fast = build_set(root, compiler, Arithmetic::Fast, &mut files)?;
    let entry_points = pair(exact, fast)?;
    let manifest = Manifest { sources_sha256: sources::hash(root)?, compiler: compile::NAME.into(), entry_points };
    let mut json = serde_json::to_vec_pretty(&manifest)?;
    json.push(b'\n');
    files.insert(MANIFEST.into(), json);
    Ok(files)
}

/// A kernel's module in one of the sets.
struct Built {
    name: String,
    sha256: String,
    interface: Interface,
}

/// Adds the modules of one set to `files`.
fn build_set(root: &Path, compiler: &Compiler, arithmetic: Arithmetic, files: &mut Files) -> Result<Vec<Built>> {
    let start = Instant::now();
    let set = arithmetic.name();
    let raw = compiler.build(root, arithmetic)?;
    println!("shaders: {set}: compiled in {:.1} s, {} bytes", start.elapsed().as_secs_f32(), raw.len() * 4);
    let mut built = Vec::new();
    let mut warnings = BTreeSet::new();
    let mut capabilities = BTreeSet::new();
    let mut validated = String::new();
    let mut float_operations = 0;
    let mut size = 0;
    for kernel in postprocess::process(&raw, &compile::private_paths(root), arithmetic)? {
        let context = || format!("{set} {}", kernel.name);
        let bytes: Vec<u8> = kernel.words.iter().flat_map(|word| word.to_le_bytes()).collect();
        warnings.extend(check::structure(&kernel.module, arithmetic).with_context(context)?);
        capabilities.extend(check::capabilities(&kernel.module));
        validated = verify::spirv_val(&bytes).with_context(context)?;
        float_operations += verify::float_ops(&kernel.words)?.len();
        size += bytes.len();
        let interface = reflect::interface(&kernel.module)?;
        built.push(Built { sha256: sources::sha256(&bytes), interface, name: kernel.name.clone() });
        files.insert(arithmetic.file(&kernel.name), bytes);
    }
    for warning in warnings {
        println!("shaders: {set}: warning: {warning}");
    }
    println!("shaders: {set}: {validated}");
    println!(
        "shaders: {set}: {} entry points, {size} bytes, {float_operations} float operations, {}, capabilities {}",
        built.len(),
        if arithmetic == Arithmetic::Exact { "none to be contracted" } else { "contracted as the driver likes" },
        capabilities.into_iter().collect::<Vec<_>>().join(" ")
    );
    Ok(built)
}

/// Both sets' kernels as one list. They must have the same interfaces: whoever dispatches one may dispatch the other.
fn pair(exact: Vec<Built>, fast: Vec<Built>) -> Result<Vec<EntryPoint>> {
    let names = |set: &[Built]| set.iter().map(|kernel| kernel.name.clone()).collect::<Vec<_>>();
    if names(&exact) != names(&fast) {
        bail!("the feature `fast` adds or removes kernels");
    }
    let pair = |(exact, fast): (Built, Built)| {
        if exact.interface != fast.interface {
            bail!("the feature `fast` changes the workgroup size or the buffers of {}", exact.name);
        }
        let Built { name, sha256, interface } = exact;
        Ok(EntryPoint { name, spirv_sha256: sha256, fast_sha256: fast.sha256, interface })
    };
    exact.into_iter().zip(fast).map(pair).collect()
}

fn write(root: &Path, compiler: &Compiler) -> Result<()> {
    let start = Instant::now();
    let files = build(root, compiler)?;
    let folder = root.join(FOLDER);
    for (name, bytes) in &files {
        replace(&folder.join(name), bytes)?;
    }
    for stale in committed(root)?.keys().filter(|name| !files.contains_key(*name)) {
        fs::remove_file(folder.join(stale)).with_context(|| format!("cannot remove {FOLDER}/{stale}"))?;
    }
    println!("shaders: wrote {} files to {FOLDER} in {:.1} s", files.len(), start.elapsed().as_secs_f32());
    Ok(())
}

fn compare(root: &Path, compiler: &Compiler) -> Result<()> {
    let committed = committed(root)?;
    let built = build(root, compiler)?;
    let names: BTreeSet<&String> = committed.keys().chain(built.keys()).collect();
    for name in names {
        match (committed.get(name), built.get(name)) {
            (Some(old), Some(new)) if old == new => {}
            (Some(_), Some(_)) => bail!("{FOLDER}/{name} is not what the sources give: {REMEDY}"),
            (Some(_), None) => bail!("{FOLDER}/{name} belongs to no entry point: {REMEDY}"),
            (None, _) => bail!("{FOLDER}/{name} is missing: {REMEDY}"),
        }
    }
    println!("shaders: rebuilt with {} and compared {} files: identical", compiler.describe(), built.len());
    Ok(())
}

fn compare_hashes(root: &Path) -> Result<()> {
    let committed = committed(root)?;
    let manifest = committed.get(MANIFEST).with_context(|| format!("{FOLDER}/{MANIFEST} is missing: {REMEDY}"))?;
    let manifest: Manifest =
        serde_json::from_slice(manifest).with_context(|| format!("cannot parse {FOLDER}/{MANIFEST}"))?;
    for entry in &manifest.entry_points {
        for (arithmetic, sha256) in [(Arithmetic::Exact, &entry.spirv_sha256), (Arithmetic::Fast, &entry.fast_sha256)] {
            let name = arithmetic.file(&entry.name);
            if committed.get(&name).is_none_or(|module| sources::sha256(module) != *sha256) {
                bail!("{FOLDER}/{name} is not the file that {MANIFEST} describes: {REMEDY}");
            }
        }
    }
    if committed.len() != Arithmetic::ALL.len() * manifest.entry_points.len() + 1 {
        bail!("{FOLDER} holds files that {MANIFEST} does not describe: {REMEDY}");
    }
    if manifest.sources_sha256 != sources::hash(root)? {
        bail!("the shaders' sources changed since {FOLDER} was built: {REMEDY}");
    }
    println!(
        "shaders: no rust-gpu compiler here; checked by source hash only: {} entry points, current",
        manifest.entry_points.len()
    );
    Ok(())
}

/// The committed files. A checkout may have turned the manifest's line ends; modules are binary.
fn committed(root: &Path) -> Result<Files> {
    let mut files = Files::new();
    let folder = root.join(FOLDER);
    for subfolder in Arithmetic::ALL.map(Arithmetic::folder) {
        // Without the folder all of its files are missing, which is for the caller to say.
        let Ok(entries) = fs::read_dir(folder.join(subfolder)) else { continue };
        for entry in entries {
            let path = entry?.path();
            let Some(name) = path.file_name().and_then(|name| name.to_str()) else { continue };
            if path.is_dir() {
                continue;
            }
            let name = format!("{subfolder}{name}");
            let bytes = fs::read(&path).with_context(|| format!("cannot read {FOLDER}/{name}"))?;
            files.insert(name.clone(), if name == MANIFEST { sources::normalised(&bytes) } else { bytes });
        }
    }
    Ok(files)
}

/// Writes beside `path`, then renames: a reader never sees half a file.
fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    let temporary = path.with_extension(format!("{}.tmp", std::process::id()));
    let folder = path.parent().context("no parent folder")?;
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(&temporary, bytes))
        .and_then(|()| fs::rename(&temporary, path))
        .with_context(|| format!("cannot write {}", path.display()))
}

/// The nearest folder upwards that holds `shaders-crate`.
pub(crate) fn workspace_root() -> Result<PathBuf> {
    let here = std::env::current_dir().context("cannot tell the current folder")?;
    let found = here.ancestors().find(|dir| dir.join("shaders-crate/Cargo.toml").is_file());
    Ok(found.context("`cargo xtask` must run inside the caustic workspace")?.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn built(name: &str, lanes: u32) -> Vec<Built> {
        let interface = Interface { local_size: [lanes, 1, 1], bindings: Vec::new() };
        vec![Built { name: name.into(), sha256: format!("{name} {lanes}"), interface }]
    }

    #[test]
    fn the_sets_pair_by_name_and_interface() {
        let mut fast = built("sort", 64);
        fast[0].sha256 = "other".into();
        let entry = pair(built("sort", 64), fast).unwrap().remove(0);
        assert_eq!((entry.spirv_sha256.as_str(), entry.fast_sha256.as_str()), ("sort 64", "other"));
        assert!(pair(built("sort", 64), built("sort", 32)).is_err());
        assert!(pair(built("sort", 64), built("scan", 64)).is_err());
        assert!(pair(built("sort", 64), Vec::new()).is_err());
    }
}
