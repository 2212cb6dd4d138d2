//! Developer tasks, run as `cargo xtask TASK`.
//!
//! `gallery` renders the pictures of docs/GALLERY.md, `predictions` what the planner foresees. `shaders` is there because everything else in the workspace builds with stable Rust alone: the
//! SPIR-V that rust-gpu's compiler makes of `shaders-crate/` is committed, together with a manifest that says what it
//! was made from. `cargo xtask shaders` makes it anew; `cargo xtask shaders --check` proves that it is current.

mod arithmetic;
mod canonical;
mod check;
mod compile;
mod forward;
mod gallery;
mod large_arrays;
mod memory_model;
mod postprocess;
mod predictions;
mod program;
mod reflect;
mod shaders;
mod sources;
#[cfg(test)]
mod testing;
mod verify;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Developer tasks of caustic.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Cli {
    /// What to do.
    #[command(subcommand)]
    task: Task,
}

/// The tasks.
#[derive(Subcommand)]
enum Task {
    /// Build shaders-crate/ into crates/device/shaders: a module a kernel, the fast ones in fast/, and manifest.json.
    ///
    /// Needs rust-gpu 0.10.0: either `RUST_GPU_TOOLCHAIN` and `RUSTC_CODEGEN_SPIRV`, or what cargo-gpu installs.
    Shaders(shaders::Options),
    /// Render every built-in scene into docs/gallery/ and docs/GALLERY.md, with the command and the time of each.
    Gallery(gallery::Arguments),
    /// Render every built-in scene as the planner chooses, and write down what it foresaw and what came, in docs/predictions/.
    Predictions(predictions::Arguments),
}

fn main() -> ExitCode {
    let done = match Cli::try_parse() {
        Ok(Cli { task: Task::Shaders(options) }) => shaders::run(&options),
        Ok(Cli { task: Task::Gallery(arguments) }) => gallery::run(&arguments),
        Ok(Cli { task: Task::Predictions(arguments) }) => predictions::run(&arguments),
        Err(error) => return usage(&error),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Help goes to stdout with 0; a usage problem is one sentence on stderr and 2.
fn usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    let text = error.to_string();
    // The first paragraph: what follows is clap's usage summary.
    let lines: Vec<&str> = text.lines().map(str::trim).take_while(|line| !line.is_empty()).collect();
    let sentence = if text.starts_with("error: ") { lines.join(" ") } else { "error: no task given".into() };
    eprintln!("{sentence}; see `cargo xtask --help`");
    ExitCode::from(2)
}
