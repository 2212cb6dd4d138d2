//! The command-line program: parse, validate, run, report.

mod args;
mod bench;
mod command;
mod compare;
mod experiments;
mod info;
mod map;
mod merge;
mod photons;
mod plan;
mod progress;
mod ranks;
mod render;
mod scene;
mod starter;
mod tonemap;
mod tradeoff;
mod verify;

use args::{Arguments, Command};
use clap::Parser;
use clap::error::ErrorKind;
use std::process::ExitCode;

/// An error with the exit code it ends the program with.
#[derive(Clone)]
pub struct Failure {
    code: u8,
    message: String,
}

impl Failure {
    /// The input was wrong: exit code 2.
    pub fn input(message: impl ToString) -> Self {
        Self { code: 2, message: message.to_string() }
    }

    /// The machine failed: exit code 1.
    pub fn machine(message: impl ToString) -> Self {
        Self { code: 1, message: message.to_string() }
    }

    /// Pictures differ by more than they may: exit code 3. Nothing failed, so a script can tell this answer from no answer.
    pub fn differs(message: impl ToString) -> Self {
        Self { code: 3, message: message.to_string() }
    }

    /// The same with more to its message.
    pub fn with_remark(self, remark: &str) -> Self {
        Self { message: format!("{}; {remark}", self.message), ..self }
    }

    /// The same, which another process tells of.
    pub fn silent(&self) -> Self {
        Self { code: self.code, message: String::new() }
    }

    /// Tells the user.
    pub fn tell(&self) {
        if !self.message.is_empty() {
            eprintln!("error: {}", self.message);
        }
    }

    /// The exit code.
    pub fn code(&self) -> u8 {
        self.code
    }

    /// What went wrong, in one sentence.
    #[cfg(test)]
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The user stopped the program before there was anything to keep: exit code 130.
    pub fn interrupted_before_image() -> Self {
        Self { code: 130, message: "interrupted; nothing was written".to_string() }
    }

    /// The user stopped a benchmark: exit code 130.
    pub fn interrupted_bench(rows: usize) -> Self {
        Self { code: 130, message: format!("interrupted; {rows} rows were finished and written") }
    }

    /// The user stopped experiments: exit code 130.
    pub fn interrupted_experiments(cases: usize) -> Self {
        let message = format!("interrupted; {cases} cases were finished, and the same command goes on from there");
        Self { code: 130, message }
    }

    /// The user stopped a sweep: exit code 130.
    pub fn interrupted_sweep(points: usize) -> Self {
        let message = format!("interrupted; {points} points were finished, and the same command goes on from there");
        Self { code: 130, message }
    }

    /// The user stopped the program and what there was is in the file: exit code 130.
    pub fn interrupted(output: &std::path::Path, passes: u32) -> Self {
        let output = output.display();
        let message = match passes {
            0 => format!("interrupted; {output} holds the rows that were finished, the rest is black"),
            passes => format!("interrupted; {output} holds the {passes} passes that were finished"),
        };
        Self { code: 130, message }
    }
}

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            // Nobody to read the help is no error.
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
        // `caustic scene`: all that clap would print is the help.
        Err(error) if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            return fail(&Failure::input("a command is missing, such as `caustic scene list` (see `caustic --help`)"));
        }
        Err(error) => return fail(&Failure::input(first_sentence(&error))),
    };
    let result = match arguments.command.unwrap_or_default() {
        Command::Render(arguments) => render::run(&arguments),
        Command::Merge(arguments) => merge::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Tradeoff(arguments) => tradeoff::run(&arguments),
        Command::Photons(arguments) => photons::run(&arguments),
        Command::Tonemap(arguments) => tonemap::run(&arguments),
        Command::Map(arguments) => map::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Verify(arguments) => verify::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Experiments(arguments) => experiments::run(&arguments),
        Command::Init { file } => starter::init(&file),
        Command::Completions { shell } => starter::completions(shell),
        Command::Man { output } => starter::man(output.as_deref()),
        Command::Info { json } => info::devices(json),
        Command::Scene { command } => scene::run(&command),
    };
    result.map_or_else(|failure| fail(&failure), |()| ExitCode::SUCCESS)
}

fn fail(failure: &Failure) -> ExitCode {
    failure.tell();
    ExitCode::from(failure.code)
}

/// clap's message without its usage lines: what is wrong and what would be right, in one line.
fn first_sentence(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let lines = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
    let kept: Vec<_> = lines.filter(|line| !line.is_empty() && !line.starts_with("For more information")).collect();
    let sentence = kept.join("; ").replace(":; ", ": ").replace("; [", " [");
    format!("{} (see `caustic --help`)", sentence.trim_start_matches("error: "))
}
