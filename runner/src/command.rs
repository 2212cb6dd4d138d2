//! The command that a record names.

/// This program's command line, without the places that outputs go to: a record is for others, who have other folders.
pub fn line() -> String {
    without_places(std::env::args().skip(1))
}

fn without_places(mut words: impl Iterator<Item = String>) -> String {
    const PLACES: [&str; 7] = ["-o", "--output", "--json", "--csv", "--markdown", "--svg", "--record"];
    let mut command = "caustic".to_string();
    while let Some(word) = words.next() {
        if PLACES.contains(&word.as_str()) {
            words.next();
        } else if !PLACES.iter().any(|place| word.strip_prefix(place).is_some_and(|rest| rest.starts_with('='))) {
            command += &format!(" {word}");
        }
    }
    command
}

#[cfg(test)]
mod tests {
    use super::without_places;

    #[test]
    fn a_record_names_the_command_and_no_places() {
        let of = |line: &str| without_places(line.split(' ').map(str::to_string));
        assert_eq!(of("bench --json a.json --max-n 5 --svg=plots --quick"), "caustic bench --max-n 5 --quick");
        assert_eq!(of("experiments -o out --device cpu"), "caustic experiments --device cpu");
        assert_eq!(of("bench --record"), "caustic bench");
    }
}
