//! What can be wrong with a case, each in one sentence with the remedy.

/// Longest piece of a file that a message repeats, in characters.
const LONGEST: usize = 200;

/// Why a case cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CaseError {
    /// The file cannot be read.
    #[error(
        "cannot read the case file `{file}`: {reason}; give the path of a .toml file or the name of a built-in case"
    )]
    Unreadable {
        /// The file.
        file: String,
        /// The system's words.
        reason: String,
    },
    /// The file is no case.
    #[error("{file}:{line}:{column}: {problem} (docs/benchmarks/README.md lists the fields of a case)")]
    Field {
        /// The file.
        file: String,
        /// Line, counted from 1.
        line: usize,
        /// Column in characters, counted from 1.
        column: usize,
        /// What is wrong and what would be right.
        problem: String,
    },
    /// There is no such case.
    #[error("there is no case `{name}`{suggestion}: the built-in ones are {known}; or give the path of a .toml file")]
    Unknown {
        /// What was asked for.
        name: String,
        /// The nearest name, as part of the sentence; or empty.
        suggestion: String,
        /// What there is.
        known: String,
    },
    /// The file cannot be written.
    #[error("cannot write `{file}`: {reason}")]
    Unwritable {
        /// The file.
        file: String,
        /// The system's words.
        reason: String,
    },
}

impl CaseError {
    /// A problem at byte `start` of the text of `file`.
    pub(super) fn at(file: &str, text: &str, start: usize, problem: &str) -> Self {
        // A parser may point behind the text, never into a letter.
        let before = text.get(..start).unwrap_or(text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        Self::Field { file: file.to_string(), line, column, problem: one_line(problem) }
    }

    /// A problem with a field of a file that is TOML.
    pub(super) fn field(file: &str, text: &str, field: &str, problem: &str) -> Self {
        let is_field = |line: &str| {
            let rest = line.trim_start().trim_start_matches(['[', '"']).strip_prefix(field);
            rest.is_some_and(|rest| rest.trim_start().starts_with(['=', ']', '"']))
        };
        let mut start = 0;
        for line in text.split_inclusive('\n') {
            if is_field(line) {
                return Self::at(file, text, start, &format!("`{field}` {problem}"));
            }
            start += line.len();
        }
        Self::at(file, text, 0, &format!("`{field}` {problem}"))
    }
}

/// `text` on one line, without control characters and not too long.
fn one_line(text: &str) -> String {
    let mut line: String = text.trim().chars().take(LONGEST).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.trim().chars().nth(LONGEST).is_some() {
        line.push('…');
    }
    line
}
