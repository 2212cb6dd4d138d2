//! Writing what came out into a case file, as what has to come out.

use super::{Case, CaseError, load};
use crate::files;
use std::collections::BTreeMap;
use std::fmt::Write as _;

const HEADER: &str = "[expected]";

/// Writes `hashes`, by N, into the file of a case, beside those it has for other sizes. The rest of the file stays as it is.
///
/// # Errors
/// If the case is not from a file, or the file cannot be written.
pub fn bless(case: &Case, hashes: &BTreeMap<u32, String>) -> Result<(), CaseError> {
    let Some(path) = &case.path else {
        let reason = "it is built in; give its folder with --cases".to_string();
        return Err(CaseError::Unwritable { file: case.name.clone(), reason });
    };
    // Read again: it may have changed since the measurement began, which can take an hour.
    let mut all = load(path)?.expected;
    all.extend(hashes.iter().map(|(&n, hash)| (n, hash.clone())));
    let unwritable =
        |error: std::io::Error| CaseError::Unwritable { file: path.display().to_string(), reason: error.to_string() };
    let text = std::fs::read_to_string(path).map_err(unwritable)?;
    files::replace(path, blessed(&text, &all).as_bytes()).map_err(unwritable)
}

/// The text of a case file with these hashes in its `[expected]` table, which comes last.
fn blessed(text: &str, hashes: &BTreeMap<u32, String>) -> String {
    let mut kept = String::new();
    let mut inside = false;
    for line in text.split_inclusive('\n') {
        if line.trim_start().starts_with('[') {
            inside = line.trim() == HEADER;
        }
        if !inside {
            kept.push_str(line);
        }
    }
    let mut text = format!("{}\n\n{HEADER}\n", kept.trim_end());
    for (n, hash) in hashes {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{n} = \"{hash}\"");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_take_the_place_of_hashes_and_of_nothing_else() {
        let one = BTreeMap::from([(1, "aa".to_string())]);
        let with = "# why\nname = \"x\"\n\n[expected]\n1 = \"aa\"\n";
        assert_eq!(blessed("# why\nname = \"x\"\n", &one), with);
        assert_eq!(blessed(with, &one), with);
        let between = "name = \"x\"\n[expected]\n1 = \"bb\"\n2 = \"cc\"\n[[targets]]\nn = 1\n";
        assert_eq!(blessed(between, &one), "name = \"x\"\n[[targets]]\nn = 1\n\n[expected]\n1 = \"aa\"\n");
    }
}
