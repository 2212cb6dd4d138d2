//! The cases that come with the program: files like any other, embedded.

use super::{Case, CaseError, parse};
use caustic_renderer::scene::suggestion;

macro_rules! cases {
    ($($name:literal),* $(,)?) => {
        /// All of them: name and text.
        pub const BUILT_IN: &[(&str, &str)] = &[$(($name, include_str!(concat!("../../cases/", $name, ".toml")))),*];
    };
}

cases!(
    "sort-pairs-24",
    "sort-pairs-32",
    "sort-keys-32",
    "build-U",
    "build-S",
    "gather-U-k10",
    "gather-U-k50",
    "gather-U-k100",
    "gather-S-k50",
    "gather-U-k50-neighbours",
    "density-S-m200",
    "gather-C-k50",
    "gather-X-k50",
    "cpu-gather-U-k10",
    "cpu-gather-U-k50",
    "trace-cornell",
    "frame-cornell",
);

/// The built-in case of this name, or all for none.
///
/// # Errors
/// If there is none of that name.
pub fn built_in(name: Option<&str>) -> Result<Vec<Case>, CaseError> {
    let wanted = |case: &&(&str, &str)| name.is_none_or(|name| name == case.0);
    let cases: Result<Vec<_>, _> =
        BUILT_IN.iter().filter(wanted).map(|(name, text)| parse(&format!("{name}.toml"), text)).collect();
    match (name, cases) {
        (Some(name), Ok(cases)) if cases.is_empty() => {
            let known: Vec<_> = BUILT_IN.iter().map(|case| case.0).collect();
            let suggestion = suggestion(name, known.iter().copied());
            Err(CaseError::Unknown { name: name.to_string(), suggestion, known: known.join(", ") })
        }
        (_, cases) => cases,
    }
}
