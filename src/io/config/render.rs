//! A configuration as a commented `tmam.toml`.

use std::fmt::Write as _;

use toml::{Table, Value};

use super::file::to_table;
use super::keys::{self, Key};
use crate::core::config::Config;

/// The configuration as a commented `tmam.toml`; [`super::file::parse`] gives the same
/// configuration back.
pub fn render(config: &Config) -> String {
    let table = to_table(config);
    let mut text =
        String::from("# Everything that `tmam replay` uses. Metres, seconds, degrees.\n");
    let mut section = "";
    for key in keys::KEYS.iter().filter(|key| !key.path.contains('*')) {
        let (head, leaf) = key.path.rsplit_once('.').unwrap_or(("", key.path));
        if head != section {
            section = head;
            let _ = write!(text, "\n[{head}]\n");
        }
        let value = if head.is_empty() {
            table.get(leaf)
        } else {
            table.get(head).and_then(|section| section.get(leaf))
        };
        let line = match value {
            Some(value) => format!("{leaf} = {value}"),
            None => format!("# {leaf} ="),
        };
        let _ = writeln!(text, "{line:<32} # {}", key.doc);
    }
    for (section, example, about) in [
        (
            "sonar",
            "front_left",
            "What is known of single sonars, by name",
        ),
        (
            "channel",
            "/topic",
            "Messages of unknown types, by topic: the paths of their fields",
        ),
    ] {
        text.push_str(&render_named(&table, section, example, about));
    }
    text
}

/// The tables of a section that has one for each name, or which keys they could have.
fn render_named(table: &Table, section: &str, example: &str, about: &str) -> String {
    let keys = || {
        let leaf = |key: &'static Key| {
            let leaf = key.path.strip_prefix(section)?.strip_prefix(".*.")?;
            Some((leaf, key.doc))
        };
        keys::KEYS.iter().filter_map(leaf)
    };
    let mut text = String::new();
    let named = table.get(section).and_then(Value::as_table);
    for (name, known) in named.into_iter().flatten() {
        let _ = write!(text, "\n[{section}.{}]\n", keys::quoted(name));
        for (leaf, doc) in keys() {
            if let Some(value) = known.get(leaf) {
                let line = format!("{leaf} = {value}");
                let _ = writeln!(text, "{line:<32} # {doc}");
            }
        }
    }
    if text.is_empty() {
        let _ = write!(text, "\n# {about}:\n# [{section}.\"{example}\"]\n");
        for (leaf, doc) in keys() {
            let line = format!("# {leaf} =");
            let _ = writeln!(text, "{line:<32} # {doc}");
        }
    }
    text
}
