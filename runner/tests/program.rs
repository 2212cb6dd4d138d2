//! Cargo builds a package's programs for its own integration tests, and so for all of `cargo test --workspace`: the tests of
//! the command line are in `tests/tests/cli.rs`.

use std::process::Command;

#[test]
fn the_program_starts() {
    let output = Command::new(env!("CARGO_BIN_EXE_caustic")).arg("--version").output().expect("the program starts");
    assert!(output.status.success());
    assert_eq!(String::from_utf8_lossy(&output.stdout), format!("caustic {}\n", env!("CARGO_PKG_VERSION")));
}
