//! Colours for a person at a terminal: what is wrong catches the eye. Files and pipes get none, and neither does who
//! sets NO_COLOR.

use std::borrow::Cow;

#[cfg(feature = "terminal")]
pub use anstream::stream::RawStream as Stream;
#[cfg(not(feature = "terminal"))]
pub use std::io::Write as Stream;

const RED: &str = "31";
const GREEN: &str = "32";
const YELLOW: &str = "33";
const CYAN: &str = "36";

/// What lines begin with, and its colour.
const WORDS: [(&str, &str); 18] = [
    ("error:", RED),
    ("warning:", YELLOW),
    ("note:", CYAN),
    ("hint:", CYAN),
    ("DIFFERS ", RED),
    ("UNUSABLE ", RED),
    ("NOTHING TO JUDGE ", YELLOW),
    ("ok ", GREEN),
    ("better:", GREEN),
    ("worse:", RED),
    ("better and worse:", YELLOW),
    ("worst place:", YELLOW),
    ("cause:", YELLOW),
    ("BLOCKING ", RED),
    ("serious ", YELLOW),
    ("suspects ", YELLOW),
    ("stretch ", YELLOW),
    ("cause ", YELLOW),
];

/// The text as this stream shows it.
pub fn in_colour<'a>(text: &'a str, stream: &impl Stream) -> Cow<'a, str> {
    match is_coloured(stream) {
        true => Cow::Owned(painted(text)),
        false => Cow::Borrowed(text),
    }
}

#[cfg(feature = "terminal")]
fn is_coloured(stream: &impl Stream) -> bool {
    anstream::AutoStream::choice(stream) != anstream::ColorChoice::Never
}

#[cfg(not(feature = "terminal"))]
fn is_coloured(_: &impl Stream) -> bool {
    false
}

/// The text with the words that lines begin with in their colours; of several logs, behind the log's name.
fn painted(text: &str) -> String {
    let mut painted = String::new();
    for line in text.split_inclusive('\n') {
        let start = line.trim_start();
        let behind = start.split_once(": ").map_or("", |(_, rest)| rest);
        let found = [start, behind].into_iter().find_map(|from| {
            let (word, colour) = WORDS.iter().find(|(word, _)| from.starts_with(word))?;
            Some((line.len() - from.len(), word.trim_end(), colour))
        });
        match found.and_then(|(at, word, colour)| {
            let (before, from) = line.split_at_checked(at)?;
            Some((before, word, from.strip_prefix(word)?, colour))
        }) {
            None => painted.push_str(line),
            Some((before, word, rest, colour)) => {
                painted.push_str(&format!("{before}\x1b[1;{colour}m{word}\x1b[0m{rest}"));
            }
        }
    }
    painted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_word_that_a_line_begins_with_is_painted_and_no_other() {
        for (line, shown) in [
            (
                "error: no such log\n",
                "\x1b[1;31merror:\x1b[0m no such log\n",
            ),
            ("  suspects 3", "  \x1b[1;33msuspects\x1b[0m 3"),
            (
                "hall: warning: cut off",
                "hall: \x1b[1;33mwarning:\x1b[0m cut off",
            ),
            ("DIFFERS   a.mcap", "\x1b[1;31mDIFFERS\x1b[0m   a.mcap"),
        ] {
            assert_eq!(painted(line), shown);
        }
        for line in [
            "no error: here",
            "errors 3",
            "suspected",
            "a: b: error: c",
            "",
        ] {
            assert_eq!(painted(line), line);
        }
    }
}
