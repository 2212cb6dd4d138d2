//! The claims and what became of them, as Markdown and in a line.

use super::Made;
use crate::claim::Verdict;
use crate::store::Store;
use std::fmt::Write;

/// A table of all claims.
#[must_use]
pub fn claims(store: &Store, made: &[Made]) -> String {
    let title = store.header.machine.title();
    let mut text = format!(
        "# The thesis's claims on {title}, {}\n\n| figure | claim | here |\n| --- | --- | --- |\n",
        store.header.date
    );
    for made in made {
        for claim in &made.page.claims {
            let cell = |text: &str| text.replace('|', "\\|");
            let _ = writeln!(
                text,
                "| {} | {} | **{}**: {} |",
                made.figure.id,
                cell(claim.says),
                claim.verdict.name(),
                cell(&claim.because)
            );
        }
    }
    text
}

/// How many claims hold.
#[must_use]
pub fn verdicts(made: &[Made]) -> String {
    let count =
        |verdict| made.iter().flat_map(|made| &made.page.claims).filter(|claim| claim.verdict == verdict).count();
    let all = [Verdict::Holds, Verdict::Partly, Verdict::Fails, Verdict::Unmeasured];
    let parts: Vec<String> = all.iter().map(|&verdict| format!("{} {}", count(verdict), verdict.name())).collect();
    format!("claims of the thesis: {}", parts.join(", "))
}
