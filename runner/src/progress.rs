//! Progress with an estimate of the time left, and Ctrl-C.

use caustic_renderer::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Whether the user wants to stop. There is one flag, however many bars are shown after each other: only the first handler counts.
static STOP: AtomicBool = AtomicBool::new(false);
/// What to say at once when that is so.
static LAST_WORDS: OnceLock<String> = OnceLock::new();

/// Has `words` said as soon as the program is told to stop. Who tells it may not wait for what it would say at its end: Open MPI kills a second later.
pub fn say_when_stopped(words: String) {
    // There is one render a program.
    let _ = LAST_WORDS.set(words);
}

/// Has Ctrl-C set the flag; the second one ends the program at once.
fn stop_on_signal() {
    // Without a handler Ctrl-C ends the program at once, which also leaves no file behind. An error says that there is one already.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Relaxed) {
            std::process::exit(130);
        }
        if let Some(words) = LAST_WORDS.get() {
            eprintln!("error: {words}");
        }
    });
}

/// A progress bar that also knows whether the user wants to stop.
pub struct Monitor {
    bar: ProgressBar,
    phase: &'static str,
}

impl Monitor {
    /// A bar on standard error, hidden if `quiet` or if that is no terminal.
    pub fn new(quiet: bool) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(1) };
        let style = ProgressStyle::with_template("{msg:16} [{bar:40}] {percent:>3} %  {elapsed} elapsed, {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        stop_on_signal();
        Self { bar, phase: "" }
    }

    /// Shows how far the work is. Returns whether it should go on.
    pub fn show(&mut self, progress: Progress) -> bool {
        if progress.phase != self.phase {
            self.phase = progress.phase;
            self.bar.reset();
            self.bar.set_message(progress.phase);
        }
        self.bar.set_length(progress.total);
        self.bar.set_position(progress.done);
        !STOP.load(Relaxed)
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Steps of the bar of a benchmark, whose work is a share of all.
const STEPS: f64 = 10_000.0;

/// A progress bar below the rows of a benchmark.
pub struct BenchMonitor {
    bar: ProgressBar,
}

impl BenchMonitor {
    /// A bar on standard error, hidden if that is no terminal.
    pub fn new() -> Self {
        let bar = ProgressBar::new(STEPS as u64);
        let style = ProgressStyle::with_template("{msg:32} [{bar:30}] {percent:>3} %  {elapsed} elapsed, {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        stop_on_signal();
        Self { bar }
    }

    /// Says what begins, and how much of all is done.
    pub fn begin(&self, what: &str, done: f64) {
        self.bar.set_message(what.to_string());
        self.bar.set_position((done * STEPS) as u64);
    }

    /// Prints a finished line to standard output.
    pub fn print(&self, line: &str) {
        self.bar.suspend(|| println!("{line}"));
    }

    /// Whether the user has not stopped it.
    pub fn goes_on(&self) -> bool {
        !STOP.load(Relaxed)
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
