//! Finds rust-gpu's compiler and has it build `shaders-crate/`.

use crate::arithmetic::Arithmetic;
use anyhow::{Context, Result, bail};
use spirv_builder::{Capability, ModuleResult, ShaderPanicStrategy, SpirvBuilder};
use std::env;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The compiler, as the manifest names it. The `=` versions in the root Cargo.toml belong to it.
pub const NAME: &str = "rust-gpu 0.10.0";
/// The toolchain rust-gpu 0.10.0 is made for.
const TOOLCHAIN: &str = "nightly-2026-07-03";
/// Vulkan 1.2 has SPIR-V 1.5, in which an entry point lists all its buffers; `memory_model` undoes the rest.
const TARGET: &str = "spirv-unknown-vulkan1.2";
/// Where cargo-gpu keeps the compiler of rust-gpu 0.10.0, below the user's cache folder: `SpirvSource::install_dir` of
/// cargo-gpu-install joins `codegen` and the version with every dot made an underscore.
const CARGO_GPU_DIR: &str = "rust-gpu/codegen/0_10_0";
/// Without spirv-opt, which folds floats (`x / c` to `x * (1 / c)`, `(a - b) + b` to `a`).
const CODEGEN_ARGS: &str = "--no-spirv-opt";
/// Subgroup operations must be asked for; `postprocess` drops what the module turns out not to use.
const CAPABILITIES: [Capability; 4] = [
    Capability::GroupNonUniform,
    Capability::GroupNonUniformVote,
    Capability::GroupNonUniformBallot,
    Capability::GroupNonUniformArithmetic,
];

/// A rust-gpu compiler on this machine.
pub struct Compiler {
    toolchain: String,
    dylib: PathBuf,
}

/// Why there is no compiler.
#[derive(Debug)]
pub enum Missing {
    /// No variable is set and cargo-gpu has installed none.
    Nowhere(PathBuf),
    /// A variable is set, and wrong.
    Wrong(String),
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nowhere(path) => write!(
                f,
                "no {NAME} compiler here: set RUST_GPU_TOOLCHAIN and RUSTC_CODEGEN_SPIRV, or run `cargo gpu install`, \
                 which makes the toolchain {TOOLCHAIN} and {}",
                path.display()
            ),
            Self::Wrong(what) => f.write_str(what),
        }
    }
}

impl std::error::Error for Missing {}

/// Finds the compiler: by the two variables, each falling back to where cargo-gpu puts its half.
pub fn find() -> Result<Compiler, Missing> {
    let toolchain = env::var("RUST_GPU_TOOLCHAIN").ok();
    let dylib = env::var_os("RUSTC_CODEGEN_SPIRV").map(PathBuf::from);
    let set = toolchain.is_some() || dylib.is_some();
    let toolchain = toolchain.unwrap_or_else(|| TOOLCHAIN.into());
    let dylib = dylib.unwrap_or_else(|| {
        let name = format!("{}rustc_codegen_spirv{}", env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX);
        user_cache().unwrap_or_default().join(CARGO_GPU_DIR).join(name)
    });
    if dylib.is_file() && has_toolchain(&toolchain) {
        Ok(Compiler { toolchain, dylib })
    } else if set {
        let what = if dylib.is_file() { format!("toolchain {toolchain}") } else { dylib.display().to_string() };
        Err(Missing::Wrong(format!(
            "RUST_GPU_TOOLCHAIN or RUSTC_CODEGEN_SPIRV is set, but there is no {what} on this machine"
        )))
    } else {
        Err(Missing::Nowhere(dylib))
    }
}

impl Compiler {
    /// Which compiler this is, for messages.
    pub fn describe(&self) -> String {
        format!("{NAME} (toolchain {})", self.toolchain)
    }

    /// Builds the module of all entry points; returns its words as the compiler wrote them.
    pub fn build(&self, root: &Path, arithmetic: Arithmetic) -> Result<Vec<u32>> {
        for variable in ["RUSTGPU_CODEGEN_ARGS", "RUSTGPU_RUSTFLAGS", "RUSTGPU_CARGOFLAGS"] {
            if env::var_os(variable).is_some() {
                bail!("{variable} would change what the compiler does: unset it");
            }
        }
        let mut builder = SpirvBuilder::new(root.join("shaders-crate"), TARGET);
        builder.toolchain_overwrite = Some(self.toolchain.clone());
        builder.rustc_codegen_spirv_location = Some(self.dylib.clone());
        builder.build_script.defaults = false;
        builder.extra_args = vec![CODEGEN_ARGS.into()];
        // No checks of indices: a quarter of a sort's time on an H100, a sixth of a search's. The CPU runs the same bodies with all of
        // them, its bits are compared with a GPU's, and what leaves a buffer there is caught by the driver (robustBufferAccess).
        builder.shader_panic_strategy = ShaderPanicStrategy::UNSOUND_DO_NOT_USE_UndefinedBehaviorViaUnreachable;
        builder.capabilities = CAPABILITIES.to_vec();
        builder.shader_crate_features.features = arithmetic.features().iter().map(ToString::to_string).collect();
        let target = target_dir(root)?;
        forget_own_crates(&target)?;
        builder.target_dir_path = Some(target);
        let result = builder.build().map_err(|error| anyhow::anyhow!("rust-gpu: {error}"))?;
        let ModuleResult::SingleModule(path) = result.module else {
            bail!("rust-gpu wrote several modules where one was asked for");
        };
        let bytes = std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let (words, []) = bytes.as_chunks::<4>() else {
            bail!("{} is no whole number of words", path.display());
        };
        Ok(words.iter().map(|word| u32::from_le_bytes(*word)).collect())
    }
}

/// Where spirv-builder would build by itself, as an absolute path.
fn target_dir(root: &Path) -> Result<PathBuf> {
    let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    Ok(std::path::absolute(target).context("cannot tell the current folder")?.join("spirv-builder"))
}

/// Has cargo compile the workspace's own crates again.
///
/// Cargo trusts times of files, and two checkouts that share a target folder have the same crate hashes in it: it would
/// then hand over the other's module as fresh, and the manifest would vouch for the wrong sources. `core` and the
/// packages of the registry stay built.
fn forget_own_crates(target: &Path) -> Result<()> {
    let folder = target.join(TARGET).join("release/.fingerprint");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        return Ok(());
    };
    for entry in entries {
        let entry = entry.with_context(|| format!("cannot read {}", folder.display()))?;
        if entry.file_name().to_string_lossy().starts_with("caustic-") {
            let path = entry.path();
            std::fs::remove_dir_all(&path).with_context(|| format!("cannot remove {}", path.display()))?;
        }
    }
    Ok(())
}

/// Paths that must not be found in the module: of this checkout, of this user, of rustc's sources.
pub fn private_paths(root: &Path) -> Vec<String> {
    let home = env::home_dir().unwrap_or_default();
    let mut paths = vec![root.display().to_string(), home.display().to_string(), "/rustc/".into()];
    paths.retain(|path| path.len() > 1);
    paths
}

/// Asks rustup, without letting it install anything.
fn has_toolchain(name: &str) -> bool {
    let Ok(output) = Command::new("rustup").args(["toolchain", "list"]).output() else {
        return false;
    };
    let list = String::from_utf8_lossy(&output.stdout);
    list.lines()
        .filter_map(|line| line.split_whitespace().next())
        .any(|known| known == name || known.strip_prefix(name).is_some_and(|host| host.starts_with('-')))
}

/// The user's cache folder, as the `directories` crate, and so cargo-gpu, has it.
fn user_cache() -> Option<PathBuf> {
    if cfg!(windows) {
        return env::var_os("LOCALAPPDATA").map(PathBuf::from);
    }
    let home = env::home_dir()?;
    if cfg!(target_os = "macos") {
        return Some(home.join("Library/Caches"));
    }
    let xdg = env::var_os("XDG_CACHE_HOME").map(PathBuf::from).filter(|path| path.is_absolute());
    Some(xdg.unwrap_or_else(|| home.join(".cache")))
}
