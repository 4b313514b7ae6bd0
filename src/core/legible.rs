//! Text that may hold names from a log, as a terminal can show it.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// Longer lines are cut, characters.
const LONGEST: usize = 4000;

/// The text without what would steer a terminal, and without lines that bury all others.
///
/// Control characters are written as TOML writes them (`\u001b`), line ends excepted.
pub fn legible(text: &str) -> Cow<'_, str> {
    let is_long = |line: &str| line.chars().nth(LONGEST).is_some();
    if !text.chars().any(steers) && !text.lines().any(is_long) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::new();
    for line in text.split_inclusive('\n') {
        let (line, end) = line.strip_suffix('\n').map_or((line, ""), |l| (l, "\n"));
        for character in line.chars().take(LONGEST) {
            if steers(character) {
                // Writing into a string cannot fail.
                let _ = write!(shown, "\\u{:04x}", u32::from(character));
            } else {
                shown.push(character);
            }
        }
        let more = line.chars().skip(LONGEST).count();
        if more > 0 {
            let _ = write!(shown, "... and {more} more characters");
        }
        shown.push_str(end);
    }
    Cow::Owned(shown)
}

/// One line of a text that is printed where commands are looked for.
///
/// Line ends are written as other control characters are. A line that begins with `::`, or holds `##`,
/// is a command to the runners of CI services: these two are written so that it is none.
pub fn inert_line(text: &str) -> String {
    let text = text.replace('\n', "\\u000a").replace("##", "\\u0023#");
    let begins = text.trim_start().strip_prefix("::").map(str::len);
    let text = match begins {
        Some(rest) => format!(
            "\\u003a:{}",
            text.get(text.len() - rest..).unwrap_or_default()
        ),
        None => text,
    };
    legible(&text).into_owned()
}

/// Longer names are cut, bytes.
const LONGEST_NAME: usize = 256;

/// A name from a file as it is called from there on: what would steer a terminal or begin a line is written
/// as an escape, and what no one would read to its end is cut.
pub fn name(text: &str) -> Cow<'_, str> {
    let is_long = text.len() > LONGEST_NAME;
    let is_plain = text.bytes().all(|byte| (b' '..=b'~').contains(&byte));
    if !is_long && is_plain {
        return Cow::Borrowed(text);
    }
    if !is_long && !text.chars().any(|c| c == '\n' || steers(c)) {
        return Cow::Borrowed(text);
    }
    let shown = |part: &str| legible(part).replace('\n', "\\u000a");
    if !is_long {
        return Cow::Owned(shown(text));
    }
    // What is cut off tells it from others that begin alike.
    let start: String = text.chars().take(LONGEST_NAME / 2).collect();
    let sum = crc32fast::hash(text.as_bytes());
    Cow::Owned(format!(
        "{}...({} bytes, {sum:08x})",
        shown(&start),
        text.len()
    ))
}

/// The text as one line, so that a name in it cannot look like several.
pub fn one_line(text: &str) -> Cow<'_, str> {
    if text.contains('\n') {
        Cow::Owned(text.replace('\n', "\\n"))
    } else {
        Cow::Borrowed(text)
    }
}

/// The text with what was typed, such as the name of a file, on one line each: an error is a paragraph
/// of its own making.
pub fn typed_on_one_line<S: AsRef<str>>(text: &str, typed: impl IntoIterator<Item = S>) -> String {
    let mut names = BTreeSet::new();
    for argument in typed {
        for part in argument.as_ref().split(['/', '=']) {
            // What was made from a name has another extension.
            let stem = part.rsplit_once('.').map_or(part, |(stem, _)| stem);
            let parts = [part, stem].into_iter().filter(|part| part.contains('\n'));
            names.extend(parts.map(str::to_owned));
        }
    }
    let mut names: Vec<String> = names.into_iter().collect();
    names.sort_by_key(|name| std::cmp::Reverse(name.len()));
    names.iter().fold(text.to_owned(), |text, name| {
        text.replace(name.as_str(), &one_line(name))
    })
}

/// The first characters of every word and of the whole, the blanks between words as they are.
pub fn shortened(text: &str, word: usize, whole: usize) -> String {
    let mut short = String::new();
    let mut rest = whole;
    for part in text.split_inclusive([' ', '\n']) {
        let length = part.trim_end_matches([' ', '\n']).chars().count();
        let room = rest.min(word);
        if length <= room {
            short.push_str(part);
        } else {
            short.extend(part.chars().take(room));
            short.push_str("...");
            short.extend(part.chars().skip(length));
        }
        rest = rest.saturating_sub(part.chars().count());
        if rest == 0 {
            if short.len() < text.len() && !short.ends_with("...") {
                short.push_str("...");
            }
            break;
        }
    }
    short
}

/// Whether a character is a command to a terminal, begins a line, or turns the direction in which text
/// is shown.
fn steers(character: char) -> bool {
    let turns = matches!(
        character,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
    );
    turns || (character != '\n' && character.is_control())
}

/// A word as a shell takes it.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=+,:@".contains(c);
    if word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", one_line(word).replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_fine_stays_as_it_is() {
        let text = "sonar `vorn_ä`:\n  - left out\n";
        assert!(matches!(legible(text), Cow::Borrowed(same) if same == text));
    }

    #[test]
    fn names_do_not_steer_a_terminal() {
        assert_eq!(
            legible("sonar `\u{1b}[31mred\r\u{9b}2J`\n\n"),
            "sonar `\\u001b[31mred\\u000d\\u009b2J`\n\n"
        );
    }

    #[test]
    fn a_name_is_no_command_and_no_line_of_its_own() {
        assert_eq!(
            inert_line("a\n::error::b\u{1b}"),
            "a\\u000a::error::b\\u001b"
        );
        assert_eq!(inert_line(" ::error::b"), "\\u003a:error::b");
        assert_eq!(inert_line("a ##[error]b"), "a \\u0023#[error]b");
        assert_eq!(inert_line("a: b::c # d"), "a: b::c # d");
    }

    #[test]
    fn a_name_is_one_short_line_that_steers_nothing() {
        assert!(matches!(name("vorn_ä"), Cow::Borrowed("vorn_ä")));
        let evil = name("a\n::error::b\u{1b}[2J\u{202e}c\u{2028}d");
        assert_eq!(evil, "a\\u000a::error::b\\u001b[2J\\u202ec\\u2028d");
        let [a, b] = ["a", "b"].map(|end| "x".repeat(1_000_000) + end);
        let (a, b) = (name(&a), name(&b));
        assert!(a.len() < 200 && a != b, "{a} {b}");
        assert!(a.contains("1000001 bytes"), "{a}");
    }

    #[test]
    fn a_name_of_a_megabyte_ends() {
        let text = format!("a\n{}\nb", "x".repeat(1_000_000));
        let shown = legible(&text);
        assert!(shown.len() < LONGEST + 100);
        assert!(
            shown.ends_with("x... and 996000 more characters\nb"),
            "{shown}"
        );
    }

    #[test]
    fn words_and_wholes_are_cut() {
        assert_eq!(shortened("a bc d", 10, 100), "a bc d");
        assert_eq!(shortened("a bcdef d\n", 3, 100), "a bcd... d\n");
        assert_eq!(shortened("ab cd ef", 10, 6), "ab cd ...");
        assert_eq!(shortened("ab cd", 10, 5), "ab cd");
        assert_eq!(shortened(&"w".repeat(1_000_000), 100, 4000).len(), 103);
        assert!(shortened(&"w ".repeat(1_000_000), 100, 4000).len() <= 4003);
    }

    #[test]
    fn what_was_typed_stays_on_its_line() {
        let typed = |arguments: &[&str]| {
            let text = "a\nb.mcap and g/a\nb.golden.json\nnext";
            typed_on_one_line(text, arguments)
        };
        let one = "a\\nb.mcap and g/a\\nb.golden.json\nnext";
        assert_eq!(typed(&["check", "--log=x/a\nb.mcap"]), one);
        assert_eq!(typed(&["x/a\nb.mcap"]), one);
        assert_eq!(typed(&["\n.\n"]).lines().count(), 1);
    }

    #[test]
    fn a_name_makes_no_line_of_its_own() {
        assert_eq!(one_line("a\nb"), "a\\nb");
    }
}
