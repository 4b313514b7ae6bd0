//! One thing that a person should know of a log, and the words it is told in.

use serde::Serialize;

use super::examined::Tried;
use crate::core::legible::one_line;

/// How much a finding matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Weight {
    /// The log cannot be replayed as it is, or there is nothing to judge in it.
    Blocking,
    /// The map will be wrong, or lack a part.
    Serious,
    /// Good to know.
    Notable,
}

/// One thing that a person should know.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    pub weight: Weight,
    /// A name for machines, `no-mount`.
    pub code: &'static str,
    pub what: String,
    /// What it does to the map; may be empty.
    pub effect: String,
    /// What to do; may be empty.
    pub mend: String,
    /// The keys in `mend`, where they were tried and help.
    #[serde(skip)]
    pub tried: Option<Tried>,
}

impl Finding {
    pub fn new(
        weight: Weight,
        code: &'static str,
        what: impl Into<String>,
        effect: impl Into<String>,
        mend: impl Into<String>,
    ) -> Self {
        Self {
            weight,
            code,
            what: what.into(),
            effect: effect.into(),
            mend: mend.into(),
            tried: None,
        }
    }

    /// With the keys that it names, where they were tried.
    pub fn with(self, tried: Option<Tried>) -> Self {
        Self { tried, ..self }
    }
}

impl Finding {
    /// In one line.
    pub fn line(&self) -> String {
        let mut line = one_line(&self.what).into_owned();
        if !self.effect.is_empty() {
            line.push_str(": ");
            line.push_str(&one_line(&self.effect));
        }
        if !self.mend.is_empty() {
            line.push_str(". To do: ");
            line.push_str(&one_line(&self.mend));
        }
        line
    }

    /// Whether what the reader notes or refuses says it already.
    pub fn is_noted(&self) -> bool {
        NOTED.contains(&self.code)
    }
}

/// Findings that come with a note, a loss or an error of their own.
const NOTED: [&str; 11] = [
    "beam-width",
    "clock-jump",
    "incomplete",
    "no-beam-width",
    "no-echo",
    "no-mount",
    "no-pose",
    "noise",
    "repeats",
    "unread-channel",
    "unstamped",
];

/// `a`, `a and b`, `a, b and 14 more`.
pub fn names<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    match names.as_slice() {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [one, two] => format!("{one} and {two}"),
        [one, two, three] => format!("{one}, {two} and {three}"),
        [one, two, rest @ ..] => format!("{one}, {two} and {} more", rest.len()),
    }
}

/// `sonar a`, `3 of 16 sonars (a, b and c)`, `all 16 sonars`.
pub fn which_sonars(some: &[&str], all: usize) -> String {
    match some {
        [one] => format!("sonar {one}"),
        _ if some.len() == all => format!("all {all} sonars"),
        _ => format!(
            "{} of {all} sonars ({})",
            some.len(),
            names(some.iter().copied())
        ),
    }
}

pub fn percent(share: f64) -> String {
    match share * 100.0 {
        p if p > 0.0 && p < 1.0 => "less than 1 %".to_owned(),
        p => format!("{p:.0} %"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_short() {
        assert_eq!(names(["a", "b"]), "a and b");
        assert_eq!(names(["a", "b", "c", "d"]), "a, b and 2 more");
        assert_eq!(which_sonars(&["a", "b"], 2), "all 2 sonars");
        assert_eq!(which_sonars(&["a", "b"], 3), "2 of 3 sonars (a and b)");
        assert_eq!(which_sonars(&["a"], 1), "sonar a");
        assert_eq!(percent(0.004), "less than 1 %");
        assert_eq!(percent(0.25), "25 %");
    }

    #[test]
    fn the_weightiest_come_first() {
        assert!(Weight::Blocking < Weight::Serious && Weight::Serious < Weight::Notable);
    }
}
