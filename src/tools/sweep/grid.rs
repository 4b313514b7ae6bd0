//! What is swept: keys of the configuration, the values they take, and the cells that these make.

use toml::{Table, Value};

use crate::core::config::Config;
use crate::core::legible::one_line;
use crate::core::rounding::rounded;
use crate::io::config::file::{ConfigError, assignment, check, overridden};
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
    /// Whether they are to be added to what is configured.
    pub is_relative: bool,
    /// The keys of all sonars that the path's pattern matches, each with what the values are added to.
    pub stands_for: Vec<(Vec<String>, f64)>,
}

/// Why something cannot be swept.
#[derive(Debug, thiserror::Error)]
pub enum AxisError {
    /// Values that cannot be read.
    #[error("`{spec}` for {key} {problem}")]
    Values {
        /// The key.
        key: String,
        /// As written.
        spec: String,
        /// What is wrong with them.
        problem: ValuesError,
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

/// What is wrong with the values of a key.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum ValuesError {
    #[error("is neither a number nor A:B:STEP (5:15:0.5) nor +-A:STEP nor a list (5,7.5,10)")]
    NotNumbers,
    #[error("has no step; write A:B:STEP, both ends included")]
    NoStep,
    /// A range that never ends.
    #[error("never arrives: a step of {step} does not lead from {from} to {to}")]
    WrongWay { from: f64, to: f64, step: f64 },
    #[error("has {0} twice")]
    Twice(f64),
    /// Alone more than a grid may have.
    #[error("are {0} values")]
    TooMany(f64),
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
        let table: Table = format!("{} = 0", with_quoted_stars(key))
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
        let around = spec.trim().strip_prefix("+-");
        let values = around.map_or_else(|| values(spec), around_configured);
        let values = values.map_err(|problem| AxisError::of_values(key, spec, problem))?;
        let beyond = values.iter().find(|value| !known.bounds.hold(**value));
        if let Some(value) = beyond.filter(|_| around.is_none()) {
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
            is_relative: around.is_some(),
            stands_for: Vec::new(),
        })
    }

    /// The pattern of the sonars that are swept together.
    pub fn pattern(&self) -> Option<&str> {
        match self.parts().as_slice() {
            ["sonar", name, _] if name.contains('*') && self.stands_for.is_empty() => Some(*name),
            _ => None,
        }
    }

    /// The same for the sonars that the pattern matches; what is relative is so to what is configured of each.
    pub fn for_each(
        &self,
        sonars: &[&str],
        configured: &dyn Fn(&Self) -> Option<f64>,
    ) -> Option<Self> {
        let keys = sonars.iter().map(|sonar| {
            let mut key = self.clone();
            key.path = self.path.clone();
            *key.path.get_mut(1)? = (*sonar).to_owned();
            let from = match self.is_relative {
                true => configured(&key)?,
                false => 0.0,
            };
            Some((key.path, from))
        });
        Some(Self {
            stands_for: keys.collect::<Option<_>>()?,
            is_relative: false,
            ..self.clone()
        })
    }

    /// The same around a configured value, where the values are relative.
    pub fn around(&self, configured: f64) -> Self {
        let moved = |value: &f64| rounded(configured + value);
        Self {
            values: self.values.iter().map(moved).collect(),
            is_relative: false,
            ..self.clone()
        }
    }

    /// The key as TOML has it.
    pub fn key(&self) -> String {
        key(&self.path)
    }

    /// What a table calls it: the key without its first part, or what tells it from others.
    pub fn short(&self) -> String {
        let skipped = usize::from(self.path.len() > 1);
        let short = self.path.get(skipped..).unwrap_or_default().join(".");
        one_line(&short).into_owned()
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

    /// A value as lines of `tmam.toml`.
    pub fn lines(&self, value: f64) -> Vec<String> {
        let line = |path: &[String], value: f64| {
            let key = key(path);
            // What is whole may be a count.
            if value.fract() == 0.0 && value.abs() < 1e15 {
                format!("{key} = {value:.0}")
            } else {
                format!("{key} = {value:?}")
            }
        };
        if self.stands_for.is_empty() {
            return vec![line(&self.path, value)];
        }
        let all = self.stands_for.iter();
        all.map(|(path, from)| line(path, rounded(from + value)))
            .collect()
    }

    /// The key, part by part.
    pub fn parts(&self) -> Vec<&str> {
        self.path.iter().map(String::as_str).collect()
    }

    /// Whether the key decides how messages are decoded.
    pub fn is_decoding(&self) -> bool {
        matches!(self.parts().as_slice(), ["channel", ..])
    }

    /// Whether the key decides what the log's messages make together: mounts, beams, clocks.
    pub fn is_of_log(&self) -> bool {
        match self.parts().as_slice() {
            ["input", "start" | "end"] => false,
            ["channel" | "sonar" | "sonars" | "input", ..] => true,
            _ => false,
        }
    }
}

/// A path as TOML has it.
fn key(path: &[String]) -> String {
    let quoted: Vec<String> = path.iter().map(|part| keys::part(part)).collect();
    quoted.join(".")
}

/// A key with the quotes that TOML asks for around a pattern: `sonar.*.yaw`.
fn with_quoted_stars(key: &str) -> String {
    let is_bare = |part: &&str| part.contains('*') && !part.contains(['"', '\'']);
    let quoted = key.split('.').map(|part| match is_bare(&part) {
        true => format!("\"{part}\""),
        false => part.to_owned(),
    });
    quoted.collect::<Vec<_>>().join(".")
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
pub fn values(spec: &str) -> Result<Vec<f64>, ValuesError> {
    let numbers = |separator: char| -> Option<Vec<f64>> {
        let parts = spec.split(separator).map(|part| part.trim().parse::<f64>());
        let numbers = parts.collect::<Result<Vec<f64>, _>>().ok()?;
        numbers.iter().all(|x| x.is_finite()).then_some(numbers)
    };
    if spec.contains(':') {
        return match numbers(':').as_deref() {
            Some(&[from, to, step]) => range(from, to, step),
            Some([_, _]) => Err(ValuesError::NoStep),
            _ => Err(ValuesError::NotNumbers),
        };
    }
    let values = numbers(',').ok_or(ValuesError::NotNumbers)?;
    let mut sorted = values.clone();
    sorted.sort_by(f64::total_cmp);
    match sorted.array_windows().find(|[a, b]| a == b) {
        Some([value, _]) => Err(ValuesError::Twice(*value)),
        None => Ok(values),
    }
}

/// From `-A` to `A` of `A:STEP`: what `+-A:STEP` means.
fn around_configured(spec: &str) -> Result<Vec<f64>, ValuesError> {
    match spec.split_once(':') {
        Some((width, step)) => {
            let [width, step] = [width, step].map(|part| part.trim().parse::<f64>());
            match (width, step) {
                (Ok(width), Ok(step)) => range(-width, width, step),
                _ => Err(ValuesError::NotNumbers),
            }
        }
        None => Err(ValuesError::NoStep),
    }
}

/// From one end to the other, both included; a sum of steps that misses the end by rounding alone
/// is at the end.
fn range(from: f64, to: f64, step: f64) -> Result<Vec<f64>, ValuesError> {
    const SLACK: f64 = 1e-9;
    let count = (to - from) / step;
    let steps = libm::floor(count + SLACK);
    if (0.0..MOST_CELLS as f64).contains(&steps) {
        let values = (0..=steps as usize).map(|k| rounded(from + k as f64 * step));
        Ok(values.collect())
    } else if count.is_finite() && count >= 0.0 {
        Err(ValuesError::TooMany(libm::floor(count) + 1.0))
    } else {
        Err(ValuesError::WrongWay { from, to, step })
    }
}

impl AxisError {
    fn of_values(key: &str, spec: &str, problem: ValuesError) -> Self {
        match problem {
            ValuesError::TooMany(cells) => Self::TooManyCells { cells },
            problem => Self::Values {
                key: key.to_owned(),
                spec: spec.to_owned(),
                problem,
            },
        }
    }
}

/// Every combination of the values of some axes; the last one runs fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    axes: Vec<Axis>,
}

impl Grid {
    /// The grid over some axes.
    ///
    /// # Errors
    /// No axis, one key on two of them, or too many cells.
    pub fn new(axes: Vec<Axis>) -> Result<Self, AxisError> {
        if axes.is_empty() {
            return Err(AxisError::Nothing);
        }
        let mut keys: Vec<String> = axes.iter().map(Axis::key).collect();
        keys.sort();
        if let Some([key, _]) = keys.array_windows().find(|[a, b]| a == b) {
            return Err(AxisError::SweptTwice { key: key.clone() });
        }
        let cells: f64 = axes.iter().map(|axis| axis.values.len() as f64).product();
        if cells > MOST_CELLS as f64 {
            return Err(AxisError::TooManyCells { cells });
        }
        Ok(Self { axes })
    }

    /// The same with other axes, as the log has them.
    ///
    /// # Errors
    /// What `of_log` does not know, and as [`Self::new`].
    pub fn resolved<E: From<AxisError>>(
        &self,
        of_log: impl Fn(&Axis) -> Result<Axis, E>,
    ) -> Result<Self, E> {
        let resolved = self.axes.iter().map(of_log);
        Ok(Self::new(resolved.collect::<Result<_, E>>()?)?)
    }

    /// Whether the log says what is meant by an axis.
    pub fn is_of_log(&self) -> bool {
        let mut axes = self.axes.iter();
        axes.any(|axis| axis.is_relative || axis.pattern().is_some())
    }

    /// What is swept.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// How many cells there are.
    pub fn cells(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// The place of a cell on every axis.
    pub fn places(&self, cell: usize) -> Vec<usize> {
        let mut rest = cell;
        let mut places: Vec<usize> = self
            .axes
            .iter()
            .rev()
            .map(|axis| {
                let count = axis.values.len().max(1);
                let place = rest % count;
                rest /= count;
                place
            })
            .collect();
        places.reverse();
        places
    }

    /// The value of a cell on every axis.
    pub fn values(&self, cell: usize) -> Vec<f64> {
        let places = self.places(cell).into_iter();
        self.axes
            .iter()
            .zip(places)
            .filter_map(|(axis, place)| axis.values.get(place).copied())
            .collect()
    }

    /// A configuration with the values of a cell.
    ///
    /// # Errors
    /// Values that do not go together.
    pub fn configuration(&self, base: &Config, cell: usize) -> Result<Config, ConfigError> {
        let values = self.values(cell).into_iter();
        let mut config = base.clone();
        // Each by itself: TOML does not take two dotted keys of a table that is closed.
        for (axis, value) in self.axes.iter().zip(values) {
            for line in axis.lines(value) {
                config = overridden(&config, &line)?;
            }
        }
        check(&config)?;
        Ok(config)
    }

    /// The flags of `tmam replay` that give a cell.
    pub fn flags(&self, cell: usize) -> String {
        let values = self.values(cell).into_iter();
        let lines = self.axes.iter().zip(values);
        let lines = lines.flat_map(|(axis, value)| axis.lines(value));
        let flags = lines.map(|line| {
            let line = line.replacen(" = ", "=", 1);
            if line.contains(['"', ' ', '\'']) {
                format!("--set '{line}'")
            } else {
                format!("--set {line}")
            }
        });
        flags.collect::<Vec<String>>().join(" ")
    }
}

/// Axes, and settings that are none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Request {
    /// What is swept.
    pub axes: Vec<Axis>,
    /// `KEY=VALUE` with a text or a switch: the same in every cell.
    pub settings: Vec<String>,
}

impl Request {
    /// From flags with a key of their own, and from `KEY=VALUES` texts.
    ///
    /// # Errors
    /// What is neither an axis nor a setting.
    pub fn new(flags: &[(&str, Option<&str>)], set: &[String]) -> Result<Self, AxisError> {
        let mut request = Self::default();
        for (key, spec) in flags {
            if let Some(spec) = spec {
                request.axes.push(Axis::parse(key, spec)?);
            }
        }
        for text in set {
            // Numbers never hold an equals sign, quoted keys may.
            match text.rsplit_once('=') {
                Some((key, spec)) if is_setting(spec) || !takes_numbers(key) => {
                    request.settings.extend(assignment(text));
                }
                Some((key, spec)) => request.axes.push(Axis::parse(key.trim(), spec.trim())?),
                None => return Err(AxisError::of_values(text, "", ValuesError::NotNumbers)),
            }
        }
        Ok(request)
    }
}

/// A text in quotes, a switch or a list of them: no axis. (10:20:10 is a time of day to TOML, and an axis here.)
fn is_setting(spec: &str) -> bool {
    let value = format!("value = {spec}").parse::<toml::Table>();
    let is_other = value.is_ok_and(|table| {
        let value = table.get("value");
        value.is_some_and(|value| value.is_str() || value.is_bool() || value.is_array())
    });
    values(spec).is_err() && is_other
}

/// Whether a key is one of numbers; what is no key is told elsewhere.
fn takes_numbers(key: &str) -> bool {
    let text = format!("{} = 1", with_quoted_stars(key));
    let with_number = overridden(&Config::default(), &text);
    !matches!(with_number, Err(ConfigError::WrongKind { .. }))
}

#[cfg(test)]
mod tests;
