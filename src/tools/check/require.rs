//! What a team asks of results, besides that they stay: `walls = ">= 6"`.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::core::rounding::rounded;
use crate::tools::golden::Quality;

/// Why a suite file is of no use.
#[derive(Debug, thiserror::Error)]
pub enum RequirementError {
    #[error("{0}")]
    Toml(#[from] Box<toml::de::Error>),
    #[error("`{key} = \"{bound}\"` asks for nothing that is measured; {}", if *.is_known {
        "give a bound such as \">= 6\", \"<= 2\", \"> 0.8\" or \"< 0.01\""
    } else {
        "there are walls, points, circles, arcs, labelled, suspects, explained (a share, 0 to 1), and where a log carries \
         the truth wrong_labels (a share) and nees"
    })]
    Unknown {
        key: String,
        bound: String,
        is_known: bool,
    },
    #[error(
        "`{key} = \"{bound}\"` asks for what no log can be: {key} is a share, from 0 to 1, so 80 % is 0.8"
    )]
    NoShare { key: String, bound: String },
}

/// A suite file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SuiteFile {
    #[serde(default)]
    require: BTreeMap<String, OfAllOrOne>,
}

/// A bound for every log, or the bounds of one.
#[derive(Debug, Deserialize)]
#[serde(
    untagged,
    expecting = "a bound such as \">= 6\", or a table of them for one log"
)]
enum OfAllOrOne {
    All(String),
    One(BTreeMap<String, String>),
}

/// What is asked of the results of each log.
#[derive(Debug, Clone, Default)]
pub struct Requirements {
    all: Vec<Requirement>,
    /// By the name of the log, without its extension, which may be there in the file; before those of all.
    one: BTreeMap<String, Vec<Requirement>>,
}

/// Whether a value is within a limit.
type IsMet = fn(f64, f64) -> bool;

#[derive(Debug, Clone)]
struct Requirement {
    measure: String,
    bound: String,
    is_met: IsMet,
    limit: f64,
}

impl Requirements {
    /// Of a suite file.
    ///
    /// # Errors
    /// Text that is not TOML, or asks for what is not measured.
    pub fn parse(text: &str) -> Result<Self, RequirementError> {
        let file: SuiteFile = toml::from_str(text).map_err(Box::new)?;
        let mut requirements = Self::default();
        for (key, of) in file.require {
            match of {
                OfAllOrOne::All(bound) => requirements.all.push(Requirement::of(&key, &bound)?),
                OfAllOrOne::One(bounds) => {
                    let bounds = bounds.iter();
                    let own = bounds.map(|(key, bound)| Requirement::of(key, bound));
                    let log = key.strip_suffix(".mcap").unwrap_or(&key).to_owned();
                    requirements.one.insert(log, own.collect::<Result<_, _>>()?);
                }
            }
        }
        Ok(requirements)
    }

    /// The logs of which something of their own is asked, without their extension.
    pub fn logs(&self) -> impl Iterator<Item = &str> {
        self.one.keys().map(String::as_str)
    }

    /// What the results of a log do not meet, in words.
    pub fn missed(&self, log: &str, quality: &Quality) -> Vec<String> {
        let own = || self.one.get(log).into_iter().flatten();
        let of_all = self.all.iter();
        let of_all = of_all.filter(|one| own().all(|own| own.measure != one.measure));
        let asked = own().chain(of_all);
        asked.filter_map(|one| one.missed(quality)).collect()
    }
}

impl Requirement {
    fn of(measure: &str, text: &str) -> Result<Self, RequirementError> {
        let measures = Quality::default().measures();
        let is_known = measures.iter().any(|(name, _)| *name == measure);
        let unknown = || RequirementError::Unknown {
            key: measure.to_owned(),
            bound: text.to_owned(),
            is_known,
        };
        /// A bound of two signs before its first sign alone.
        const BOUNDS: [(&str, IsMet); 4] = [
            (">=", |value, limit| value >= limit),
            ("<=", |value, limit| value <= limit),
            (">", |value, limit| value > limit),
            ("<", |value, limit| value < limit),
        ];
        let mut bounds = BOUNDS.into_iter();
        let parsed = bounds.find_map(|(sign, is_met)| {
            let limit: f64 = text.trim().strip_prefix(sign)?.trim().parse().ok()?;
            limit.is_finite().then_some((is_met, limit))
        });
        let (is_met, limit) = parsed.filter(|_| is_known).ok_or_else(unknown)?;
        if Quality::SHARES.contains(&measure) && !(0.0..=1.0).contains(&limit) {
            return Err(RequirementError::NoShare {
                key: measure.to_owned(),
                bound: text.to_owned(),
            });
        }
        Ok(Self {
            measure: measure.to_owned(),
            bound: text.trim().to_owned(),
            is_met,
            limit,
        })
    }

    fn missed(&self, quality: &Quality) -> Option<String> {
        let mut measures = quality.measures().into_iter();
        let (_, value) = measures.find(|(name, _)| *name == self.measure)?;
        let (measure, bound) = (&self.measure, &self.bound);
        match value.map(rounded) {
            Some(value) if (self.is_met)(value, self.limit) => None,
            Some(value) => Some(format!("{measure} is {value}, and {bound} is required")),
            None => Some(format!(
                "{measure} is not known, as {}, and {bound} is required",
                unknown_since(measure, quality)
            )),
        }
    }
}

/// Why a measure has no value.
fn unknown_since(measure: &str, quality: &Quality) -> &'static str {
    match measure {
        "suspects" | "explained" => "only TMAM's map says what should have echoed",
        _ if quality.wrong_labels.is_none() => "the log carries no truth",
        _ => "no feature has a covariance and a match",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_of_one_log_stand_before_those_of_all() {
        let text = "[require]\nwalls = '>= 6'\nexplained = \">0.8\"\n[require.'hall.mcap']\nwalls = '>= 2'\nnees = '< 2'";
        let requirements = Requirements::parse(text).unwrap();
        let quality = Quality {
            walls: 4,
            explained: Some(0.8),
            ..Quality::default()
        };
        let missed = |log| requirements.missed(log, &quality);
        let explained = "explained is 0.8, and >0.8 is required";
        assert_eq!(
            missed("room"),
            [explained, "walls is 4, and >= 6 is required"]
        );
        assert_eq!(missed("hall").len(), 2);
        assert!(missed("hall")[0].contains("no truth"));
    }

    #[test]
    fn what_cannot_be_asked_is_refused_with_what_can() {
        let refused = |text: &str| Requirements::parse(text).unwrap_err().to_string();
        assert!(refused("[require]\ndoors = '>= 1'").contains("there are walls"));
        assert!(refused("[require]\nwalls = 'six'").contains("give a bound"));
        assert!(refused("[require]\nwalls = 6").contains("a bound such as"));
        assert!(refused("[requires]").contains("unknown field"));
        for share in ["explained = '>= 80'", "wrong_labels = '< -0.1'"] {
            let said = refused(&format!("[require]\n{share}"));
            assert!(said.contains("a share, from 0 to 1"), "{said}");
        }
        assert!(Requirements::parse("[require]\nexplained = '>= 1'\nnees = '< 2'").is_ok());
    }
}
