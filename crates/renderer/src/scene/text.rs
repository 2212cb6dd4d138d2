//! Helpers for messages.

/// Longest piece of a file that a message repeats, in characters.
const LONGEST: usize = 160;

/// `text` on one line, without control characters and not too long.
pub(super) fn one_line(text: &str) -> String {
    let mut line: String = text.trim().chars().take(LONGEST).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.trim().chars().nth(LONGEST).is_some() {
        line.push('…');
    }
    line
}

/// The one of `known` that `name` was probably meant to be.
pub(super) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > LONGEST {
        return None;
    }
    let name = name.to_lowercase();
    let allowed = (name.chars().count() / 3).max(1);
    known
        .into_iter()
        .filter(|candidate| candidate.len() <= LONGEST)
        .map(|candidate| (distance(&name, &candidate.to_lowercase()), candidate))
        .filter(|(distance, _)| *distance <= allowed)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// The name of `known` that `name` was probably meant to be, as part of a sentence: `` (did you mean `cornell`?)``, or nothing.
#[must_use]
pub fn suggestion<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(name, known).map_or(String::new(), |name| format!(" (did you mean `{name}`?)"))
}

/// Letters to insert, remove or replace to turn `a` into `b` (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_the_one_with_a_slip() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(nearest("cornel", ["plane", "cornell"]), Some("cornell"));
        assert_eq!(nearest("Glas", ["white", "glass"]), Some("glass"));
        assert_eq!(nearest("teapot", ["plane", "cornell"]), None);
    }

    #[test]
    fn messages_stay_on_one_short_line() {
        assert_eq!(one_line("a\nb\u{1b}c "), "a b c");
        assert_eq!(one_line(&"x".repeat(1000)).chars().count(), LONGEST + 1);
    }
}
