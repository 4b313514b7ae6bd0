//! The keys of `tmam.toml`: unit, meaning and bounds of each, in the order in which they are shown.

mod table;

pub use table::keys;
use toml_writer::{ToTomlKey, TomlKeyBuilder};

/// How a value is written in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// As it is inside: metres, seconds, plain numbers, text.
    Plain,
    /// Degrees in the file, radians inside.
    Degrees,
}

/// Which numbers a key takes, in the unit of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bounds {
    /// Not a number, or any finite one.
    Any,
    /// Above the first and below the second.
    Between(f64, f64),
    /// Above.
    Above(f64),
    /// Not below.
    AtLeast(f64),
}

/// One key.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// `section.key`, or `key` at the top level; `sonar.*.key` for a single sonar's, `channel.*.key`
    /// for a topic's.
    pub path: &'static str,
    /// How its value is written.
    pub unit: Unit,
    /// Which numbers it takes.
    pub bounds: Bounds,
    /// One line for a person.
    pub doc: &'static str,
}

/// The key that a path in a file names.
pub fn find(path: &[&str]) -> Option<&'static Key> {
    keys().find(|key| {
        let parts: Vec<&str> = key.path.split('.').collect();
        parts.len() == path.len()
            && parts
                .iter()
                .zip(path)
                .all(|(part, given)| *part == "*" || part == given)
    })
}

/// The known path nearest to an unknown one, if any is near.
pub fn nearest(path: &[&str]) -> Option<String> {
    let given = path.join(".");
    keys()
        .map(|key| match path {
            [_, name, _] => key.path.replace('*', name),
            _ => key.path.to_owned(),
        })
        .flat_map(|known| {
            // A right key in the wrong section, or without one, is near too.
            let leaf = known.rsplit('.').next().unwrap_or_default().to_owned();
            let given_leaf = path.last().copied().unwrap_or_default();
            [
                (strsim::jaro_winkler(&given, &known), known.clone()),
                (strsim::jaro_winkler(given_leaf, &leaf) - 0.05, known),
            ]
        })
        .filter(|(likeness, _)| *likeness > 0.8)
        .max_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, known)| known)
}

impl Bounds {
    /// Whether a number, in the unit of the file, is allowed.
    pub fn hold(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Any => true,
                Self::Between(low, high) => value > low && value < high,
                Self::Above(low) => value > low,
                Self::AtLeast(low) => value >= low,
            }
    }
}

impl std::fmt::Display for Bounds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Any => write!(f, "a finite number"),
            Self::Between(low, high) => write!(f, "above {low} and below {high}"),
            Self::Above(low) => write!(f, "above {low}"),
            Self::AtLeast(low) => write!(f, "at least {low}"),
        }
    }
}
/// A part of a key in quotes, on one line whatever it holds.
pub fn quoted(part: &str) -> String {
    TomlKeyBuilder::new(part).as_basic().to_toml_key()
}

/// A part of a key as TOML has it: in quotes where it must be.
pub fn part(part: &str) -> String {
    let bare = TomlKeyBuilder::new(part).as_unquoted();
    bare.map_or_else(|| quoted(part), |bare| bare.to_toml_key())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_name_is_a_key() {
        for name in [
            "sonar_00",
            "a b",
            "a\nb",
            "\u{1b}[31m",
            "\"\\'",
            "\u{85}\t",
            "",
        ] {
            for key in [quoted(name), part(name)] {
                let text = format!("[sonar.{key}]\nx = 1");
                let table: toml::Table = text.parse().unwrap();
                let sonars = table.get("sonar").unwrap().as_table().unwrap();
                assert_eq!(sonars.keys().collect::<Vec<_>>(), [name], "{text}");
            }
        }
    }
}
