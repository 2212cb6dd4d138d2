//! `cargo xtask shaders`: compile, post-process, check, reflect, write; or compare with what is committed.

use crate::compile::Compiler;
use crate::reflect::Manifest;
use crate::{check, compile, postprocess, sources, verify};
use anyhow::{Context, Result, bail};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The committed module, relative to the workspace root.
const MODULE: &str = "crates/device/shaders/caustic.spv";
/// The committed manifest, relative to the workspace root.
const MANIFEST: &str = "crates/device/shaders/manifest.json";
/// What to do about every difference.
const REMEDY: &str = "run `cargo xtask shaders` and commit both files";

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
        (Err(compile::Missing::Nowhere(_)), true) if !options.require_rebuild => {
            compare_hashes(&root)
        }
        (Err(missing), _) => bail!(missing),
    }
}

/// Both files' bytes, as the sources give them.
struct Built {
    module: Vec<u8>,
    manifest: Vec<u8>,
    entry_points: usize,
}

/// From sources to bytes, in memory.
fn build(root: &Path, compiler: &Compiler) -> Result<Built> {
    let start = Instant::now();
    let raw = compiler.build(root)?;
    println!(
        "shaders: compiled in {:.1} s, {} bytes",
        start.elapsed().as_secs_f32(),
        raw.len() * 4
    );
    let (module, words) = postprocess::process(&raw, &compile::private_paths(root))?;
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    for warning in check::structure(&module)? {
        println!("shaders: warning: {warning}");
    }
    println!("shaders: {}", verify::spirv_val(&bytes)?);
    let manifest = Manifest {
        spirv_sha256: sources::sha256(&bytes),
        sources_sha256: sources::hash(root)?,
        compiler: compile::NAME.into(),
        entry_points: crate::reflect::entry_points(&module)?,
    };
    let mut json = serde_json::to_vec_pretty(&manifest)?;
    json.push(b'\n');
    println!(
        "shaders: {} entry points, {} bytes, {} float operations kept uncontracted, capabilities {}",
        manifest.entry_points.len(),
        bytes.len(),
        verify::float_ops(&words)?.len(),
        check::capabilities(&module).join(" ")
    );
    Ok(Built {
        module: bytes,
        manifest: json,
        entry_points: manifest.entry_points.len(),
    })
}

fn write(root: &Path, compiler: &Compiler) -> Result<()> {
    let start = Instant::now();
    let built = build(root, compiler)?;
    replace(&root.join(MODULE), &built.module)?;
    replace(&root.join(MANIFEST), &built.manifest)?;
    let seconds = start.elapsed().as_secs_f32();
    println!(
        "shaders: wrote {MODULE} and {MANIFEST} ({} entry points) in {seconds:.1} s",
        built.entry_points
    );
    Ok(())
}

fn compare(root: &Path, compiler: &Compiler) -> Result<()> {
    let (module, manifest) = (read(root, MODULE)?, read(root, MANIFEST)?);
    let built = build(root, compiler)?;
    // A checkout may have turned the manifest's line ends; the module is binary.
    let manifest = sources::normalised(&manifest);
    match (module == built.module, manifest == built.manifest) {
        (true, true) => {
            println!(
                "shaders: rebuilt with {} and compared: identical",
                compiler.describe()
            );
            Ok(())
        }
        (true, false) => {
            bail!("{MANIFEST} is not what the sources give, though the SPIR-V is: {REMEDY}")
        }
        (false, _) => bail!(
            "{MODULE} ({} bytes) is not what the sources give ({} bytes): {REMEDY}",
            module.len(),
            built.module.len()
        ),
    }
}

fn compare_hashes(root: &Path) -> Result<()> {
    let module = read(root, MODULE)?;
    let manifest: Manifest = serde_json::from_slice(&read(root, MANIFEST)?)
        .with_context(|| format!("cannot parse {MANIFEST}"))?;
    if manifest.spirv_sha256 != sources::sha256(&module) {
        bail!("{MODULE} is not the file that {MANIFEST} describes: {REMEDY}");
    }
    if manifest.sources_sha256 != sources::hash(root)? {
        bail!("the shaders' sources changed since {MODULE} was built: {REMEDY}");
    }
    println!(
        "shaders: no rust-gpu compiler here; checked by source hash only: {} entry points, {} bytes, current",
        manifest.entry_points.len(),
        module.len()
    );
    Ok(())
}

fn read(root: &Path, path: &str) -> Result<Vec<u8>> {
    fs::read(root.join(path)).with_context(|| format!("cannot read {path}: {REMEDY}"))
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
fn workspace_root() -> Result<PathBuf> {
    let here = std::env::current_dir().context("cannot tell the current folder")?;
    let found = here
        .ancestors()
        .find(|dir| dir.join("shaders-crate/Cargo.toml").is_file());
    Ok(found
        .context("`cargo xtask` must run inside the caustic workspace")?
        .to_owned())
}
