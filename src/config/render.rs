//! A configuration as a commented `tmam.toml`.

use std::fmt::Write as _;

use toml::{Table, Value};

use super::Config;
use super::file::to_table;
use super::keys::KEYS;

/// The configuration as a commented `tmam.toml`; [`super::file::parse`] gives the same
/// configuration back.
pub fn render(config: &Config) -> String {
    let table = to_table(config);
    let mut text =
        String::from("# Everything that `tmam replay` uses. Metres, seconds, degrees.\n");
    let mut section = "";
    for key in KEYS.iter().filter(|key| !key.path.contains('*')) {
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
    text.push_str(&render_sonars(&table));
    text
}

fn render_sonars(table: &Table) -> String {
    let mut text = String::new();
    let sonars = table.get("sonar").and_then(Value::as_table);
    for (name, known) in sonars.into_iter().flatten() {
        let _ = write!(text, "\n[sonar.{}]\n", Value::String(name.clone()));
        for key in KEYS
            .iter()
            .filter_map(|key| Some((key.path.strip_prefix("sonar.*.")?, key.doc)))
        {
            if let Some(value) = known.get(key.0) {
                let line = format!("{} = {value}", key.0);
                let _ = writeln!(text, "{line:<32} # {}", key.1);
            }
        }
    }
    if text.is_empty() {
        text.push_str("\n# What is known of single sonars, by name:\n# [sonar.\"front_left\"]\n");
        for key in KEYS {
            if let Some(leaf) = key.path.strip_prefix("sonar.*.") {
                let line = format!("# {leaf} =");
                let _ = writeln!(text, "{line:<32} # {}", key.doc);
            }
        }
    }
    text
}
