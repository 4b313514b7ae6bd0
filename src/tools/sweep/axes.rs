//! What is swept: a key of the configuration and the values it takes.

use toml::{Table, Value};

use crate::core::rounding::rounded;
use crate::io::config::file::ConfigError;
use crate::io::config::keys::{self, Unit};

/// More cells than this are more than a person waits for.
pub const MOST_CELLS: usize = 100_000;

/// A key and its values, in the unit of `tmam.toml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// As in `tmam.toml`: `triple.alpha`, `sonar.front.yaw`.
    pub path: Vec<String>,
    /// Unit of the values.
    pub unit: Unit,
    /// In the order in which they were given.
    pub values: Vec<f64>,
}

/// Why something cannot be swept.
#[derive(Debug, thiserror::Error)]
pub enum AxisError {
    /// No numbers.
    #[error("`{spec}` for {key} is neither a number nor A:B:STEP (5:15:0.5) nor a list (5,7.5,10)")]
    NotNumbers {
        /// The key.
        key: String,
        /// As written.
        spec: String,
    },
    /// A range without a step.
    #[error("`{spec}` for {key} has no step; write A:B:STEP, both ends included")]
    NoStep {
        /// The key.
        key: String,
        /// As written.
        spec: String,
    },
    /// A range that never ends.
    #[error("`{spec}` for {key} never arrives: a step of {step} does not lead from {from} to {to}")]
    WrongWay {
        /// The key.
        key: String,
        /// As written.
        spec: String,
        /// First value.
        from: f64,
        /// Last value.
        to: f64,
        /// From one to the next.
        step: f64,
    },
    /// A value that is listed twice.
    #[error("`{spec}` for {key} has {value} twice")]
    Twice {
        /// The key.
        key: String,
        /// As written.
        spec: String,
        /// The value.
        value: f64,
    },
    /// Two axes of one key.
    #[error("{key} is given twice; sweep it once")]
    SweptTwice {
        /// The key.
        key: String,
    },
    /// Too many cells.
    #[error(
        "the grid has {cells} cells, more than {MOST_CELLS}: give larger steps, or sweep fewer keys at a \
         time"
    )]
    TooManyCells {
        /// How many there are; from 1e15 on it is not exact.
        cells: f64,
    },
    /// No axis at all.
    #[error(
        "nothing to sweep: give --alpha, --beta, --gamma, --step or --set KEY with values, such as \
         --gamma 5:15:1 or --set sonar.front.yaw=-5:5:0.5"
    )]
    Nothing,
    /// The configuration does not have such a key, or not such a value.
    #[error("--set {text}: {source}")]
    Config {
        /// As written.
        text: String,
        /// What is wrong.
        source: ConfigError,
    },
}

impl Axis {
    /// The axis of a key: a dotted path as TOML has it.
    ///
    /// # Errors
    /// A key that does not exist, and values that cannot be read.
    pub fn parse(key: &str, spec: &str) -> Result<Self, AxisError> {
        let text = || format!("{key}={spec}");
        let bad = |source| AxisError::Config {
            text: text(),
            source,
        };
        let table: Table = format!("{key} = 0")
            .parse()
            .map_err(|source| bad(ConfigError::Malformed(Box::new(source))))?;
        let path = path(&table);
        let parts: Vec<&str> = path.iter().map(String::as_str).collect();
        let known = keys::find(&parts).ok_or_else(|| {
            bad(ConfigError::UnknownKey {
                key: parts.join("."),
                suggestion: keys::nearest(&parts),
            })
        })?;
        let values = values(key, spec)?;
        if let Some(value) = values.iter().find(|value| !known.bounds.hold(**value)) {
            return Err(bad(ConfigError::OutOfBounds {
                key: parts.join("."),
                value: *value,
                bounds: known.bounds,
                unit: known.unit,
            }));
        }
        Ok(Self {
            unit: known.unit,
            path,
            values,
        })
    }

    /// The key as TOML has it.
    pub fn key(&self) -> String {
        let quoted: Vec<String> = self.path.iter().map(|part| keys::part(part)).collect();
        quoted.join(".")
    }

    /// What a table calls it: the key without its first part, or what tells it from others.
    pub fn short(&self) -> String {
        let skipped = usize::from(self.path.len() > 1);
        self.path.get(skipped..).unwrap_or_default().join(".")
    }

    /// What stands above its values in a table.
    pub fn heading(&self) -> String {
        format!("{} {}", self.short(), self.unit_name())
            .trim_end()
            .to_owned()
    }

    /// `deg`, or nothing for a key in SI units.
    pub fn unit_name(&self) -> &'static str {
        match self.unit {
            Unit::Degrees => "deg",
            Unit::Plain => "",
        }
    }

    /// A value as a line of `tmam.toml`.
    pub fn line(&self, value: f64) -> String {
        // What is whole may be a count.
        if value.fract() == 0.0 && value.abs() < 1e15 {
            format!("{} = {value:.0}", self.key())
        } else {
            format!("{} = {value:?}", self.key())
        }
    }

    /// Whether the key decides how messages are decoded.
    pub fn is_decoding(&self) -> bool {
        self.path
            .first()
            .is_some_and(|section| section == "channel")
    }

    /// Whether the key decides what the log's messages make together: mounts, beams, clocks.
    pub fn is_of_log(&self) -> bool {
        let section = self.path.first().map(String::as_str);
        let leaf = self.path.last().map(String::as_str);
        match section {
            Some("channel" | "sonar" | "sonars") => true,
            Some("input") => !matches!(leaf, Some("start" | "end")),
            _ => false,
        }
    }
}

/// The path of a table's only leaf.
fn path(table: &Table) -> Vec<String> {
    let mut parts = Vec::new();
    let mut inner = Some(table);
    while let Some((name, value)) = inner.and_then(|table| table.iter().next()) {
        parts.push(name.clone());
        inner = match value {
            Value::Table(table) => Some(table),
            _ => None,
        };
    }
    parts
}

/// The values of `A:B:STEP` with both ends, of a list with commas, or of a single number.
///
/// # Errors
/// Whatever is none of these.
pub fn values(key: &str, spec: &str) -> Result<Vec<f64>, AxisError> {
    let (key, spec) = (key.to_owned(), spec.to_owned());
    let numbers = |separator: char| -> Option<Vec<f64>> {
        let parts = spec.split(separator).map(|part| part.trim().parse::<f64>());
        let numbers = parts.collect::<Result<Vec<f64>, _>>().ok()?;
        numbers.iter().all(|x| x.is_finite()).then_some(numbers)
    };
    if !spec.contains(':') {
        let Some(values) = numbers(',') else {
            return Err(AxisError::NotNumbers { key, spec });
        };
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        let twice = sorted.array_windows().find(|[a, b]| a == b);
        return match twice {
            Some([value, _]) => {
                let value = *value;
                Err(AxisError::Twice { key, spec, value })
            }
            None => Ok(values),
        };
    }
    match numbers(':').as_deref() {
        Some([from, to, step]) => range(*from, *to, *step).ok_or_else(|| {
            let count = (to - from) / step;
            if count.is_finite() && count >= 0.0 {
                return AxisError::TooManyCells {
                    cells: libm::floor(count) + 1.0,
                };
            }
            AxisError::WrongWay {
                key,
                spec,
                from: *from,
                to: *to,
                step: *step,
            }
        }),
        Some([_, _]) => Err(AxisError::NoStep { key, spec }),
        _ => Err(AxisError::NotNumbers { key, spec }),
    }
}

/// From one end to the other, both included; a sum of steps that misses the end by rounding alone
/// is at the end.
fn range(from: f64, to: f64, step: f64) -> Option<Vec<f64>> {
    const SLACK: f64 = 1e-9;
    let steps = libm::floor((to - from) / step + SLACK);
    if !(0.0..MOST_CELLS as f64).contains(&steps) {
        return None;
    }
    Some(
        (0..=steps as usize)
            .map(|k| rounded(from + k as f64 * step))
            .collect(),
    )
}

#[cfg(test)]
mod tests;
