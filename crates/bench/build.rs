//! Notes down which compiler and which commit this is, for the records.

use std::process::Command;

fn main() {
    let rustc = std::env::var("RUSTC").unwrap_or("rustc".to_string());
    println!("cargo::rustc-env=CAUSTIC_RUSTC={}", output(&rustc, &["--version"]).unwrap_or_default());
    // Empty where there is no repository, as in a package.
    println!(
        "cargo::rustc-env=CAUSTIC_COMMIT={}",
        output("git", &["rev-parse", "--short=12", "HEAD"]).unwrap_or_default()
    );
    // A commit moves HEAD or the branch that it names; the log of HEAD grows with both.
    for path in ["HEAD", "logs/HEAD"] {
        if let Some(path) = output("git", &["rev-parse", "--git-path", path]) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    println!("cargo::rerun-if-changed=build.rs");
}

fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_string()).filter(|text| !text.is_empty())
}
