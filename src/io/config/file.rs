//! `tmam.toml`: reading and checking a configuration. Angles are degrees in the file.

use std::collections::{BTreeMap, BTreeSet};

use toml::{Table, Value};

use super::keys::{self, Bounds, Unit};
use crate::core::config::Config;
use crate::core::pattern::{PatternError, glob_set};

/// What is wrong with a configuration.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// Not TOML.
    #[error("{0}")]
    Malformed(#[from] Box<toml::de::Error>),
    /// A value of the wrong kind.
    #[error("{key} = {value} is no value that it can have. It is: {doc}")]
    WrongKind {
        /// Its path.
        key: String,
        /// As written, in degrees where it is an angle.
        value: Value,
        /// What the key means.
        doc: &'static str,
    },
    /// A key that does not exist.
    #[error("unknown key `{key}`{}", did_you_mean(.suggestion.as_deref()))]
    UnknownKey {
        /// As written.
        key: String,
        /// The known key nearest to it.
        suggestion: Option<String>,
    },
    /// A number outside its bounds.
    #[error("{key} is {value}; it must be {bounds}{}", if *.unit == Unit::Degrees { " degrees" } else { "" })]
    OutOfBounds {
        /// Its path.
        key: String,
        /// As written.
        value: f64,
        /// What is allowed.
        bounds: Bounds,
        /// Of the value.
        unit: Unit,
    },
    /// A description of messages that contradicts itself or lacks something.
    #[error("channel `{topic}` {problem}")]
    BadChannel {
        /// The topic.
        topic: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// A topic or sonar pattern that cannot be read.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// A window that ends before it starts.
    #[error("the window ends at {end} s, before its start at {start} s; give --start below --end")]
    EmptyWindow {
        /// Seconds after the first reading.
        start: f64,
        /// Seconds after the first reading.
        end: f64,
    },
}

fn did_you_mean(suggestion: Option<&str>) -> String {
    match suggestion {
        Some(key) => format!("; did you mean `{key}`?"),
        None => "; `tmam config` lists every key".to_owned(),
    }
}

/// Reads a configuration; what it does not name keeps its default.
///
/// # Errors
/// Text that is not TOML, unknown keys and values of the wrong type. Bounds are left to [`check`].
pub fn parse(text: &str) -> Result<Config, ConfigError> {
    parse_layers(&[text])
}

/// Reads a configuration from several texts; what a later one names stands before the earlier ones.
///
/// # Errors
/// As [`parse`].
pub fn parse_layers(texts: &[&str]) -> Result<Config, ConfigError> {
    let mut table = Table::new();
    for text in texts {
        overlay(&mut table, text.parse().map_err(Box::new)?);
    }
    into_radians(&mut table)?;
    read(table)
}

/// A configuration with what a text names instead.
///
/// # Errors
/// As [`parse`].
pub fn overridden(config: &Config, text: &str) -> Result<Config, ConfigError> {
    let mut above: Table = text.parse().map_err(Box::new)?;
    into_radians(&mut above)?;
    let mut table = Table::try_from(config).unwrap_or_default();
    overlay(&mut table, above);
    read(table)
}

fn read(mut table: Table) -> Result<Config, ConfigError> {
    let error = match table.clone().try_into() {
        Ok(config) => return Ok(config),
        Err(error) => Box::new(error),
    };
    // Which of the values it is, is tried: each alone.
    each_leaf(&mut table, &mut Vec::new(), &mut |path, value| {
        let mut alone = value.clone();
        for part in path.iter().rev() {
            alone = Value::Table(Table::from_iter([((*part).to_owned(), alone)]));
        }
        match (alone.try_into::<Config>(), keys::find(path)) {
            (Err(_), Some(key)) => Err(ConfigError::WrongKind {
                key: path.join("."),
                value: value.clone(),
                doc: key.doc,
            }),
            _ => Ok(()),
        }
    })?;
    Err(error.into())
}

/// A configuration with what texts name instead, each over the one before; checked.
///
/// # Errors
/// As [`parse`] and [`check`].
pub fn layered(mut config: Config, texts: &[String]) -> Result<Config, ConfigError> {
    for text in texts {
        config = overridden(&config, text)?;
    }
    check(&config)?;
    Ok(config)
}

/// Turns the degrees of a text into radians; every key must be known.
fn into_radians(table: &mut Table) -> Result<(), ConfigError> {
    each_leaf(table, &mut Vec::new(), &mut |path, value| {
        let key = keys::find(path).ok_or_else(|| ConfigError::UnknownKey {
            key: path.join("."),
            suggestion: keys::nearest(path),
        })?;
        if key.unit == Unit::Degrees
            && let Some(degrees) = number(value)
        {
            *value = Value::Float(degrees.to_radians());
        }
        Ok(())
    })
}

/// Puts the values of one table over those of another.
pub(super) fn overlay(below: &mut Table, above: Table) {
    for (name, value) in above {
        match (below.get_mut(&name), value) {
            (Some(Value::Table(below)), Value::Table(above)) => overlay(below, above),
            (_, value) => {
                below.insert(name, value);
            }
        }
    }
}

/// Checks that every number lies within its bounds and that what belongs together is there.
///
/// # Errors
/// The first value that is not allowed.
pub fn check(config: &Config) -> Result<(), ConfigError> {
    let mut table = to_table(config);
    each_leaf(&mut table, &mut Vec::new(), &mut |path, value| {
        let (Some(key), Some(value)) = (keys::find(path), number(value)) else {
            return Ok(());
        };
        if key.bounds.hold(value) {
            return Ok(());
        }
        Err(ConfigError::OutOfBounds {
            key: path.join("."),
            value,
            bounds: key.bounds,
            unit: key.unit,
        })
    })?;
    for (topic, fields) in &config.channel {
        if let Some(problem) = fields.problem() {
            return Err(ConfigError::BadChannel {
                topic: topic.clone(),
                problem,
            });
        }
    }
    if let (Some(start), Some(end)) = (config.input.start, config.input.end)
        && end < start
    {
        return Err(ConfigError::EmptyWindow { start, end });
    }
    let input = &config.input;
    for globs in [&input.range_topics, &input.odometry_topics, &input.sonars] {
        glob_set(globs)?;
    }
    Ok(())
}

/// The configuration as it stands in the file: degrees, rounded where the conversion left dust.
pub(crate) fn to_table(config: &Config) -> Table {
    let mut table = Table::try_from(config).unwrap_or_default();
    let walked = each_leaf(&mut table, &mut Vec::new(), &mut |path, value| {
        if keys::find(path).is_some_and(|key| key.unit == Unit::Degrees)
            && let Some(radians) = number(value)
        {
            let degrees = radians.to_degrees();
            *value = Value::Float(libm::round(degrees * 1e9) / 1e9);
        }
        Ok(())
    });
    debug_assert!(walked.is_ok(), "the walk itself cannot fail");
    table
}

/// What of a configuration became otherwise: `triple.gamma 10.0 -> 8.0 deg`, a key each.
pub fn differences(then: &Config, now: &Config) -> Vec<String> {
    let changes = changes(then, now).into_iter();
    changes
        .map(|(key, change)| format!("{key} {change}"))
        .collect()
}

/// The keys that became otherwise, each with its change: `10.0 -> 8.0 deg`.
pub fn changes(then: &Config, now: &Config) -> Vec<(String, String)> {
    let leaves = |config: &Config| {
        let mut leaves = BTreeMap::new();
        let walked = each_leaf(
            &mut to_table(config),
            &mut Vec::new(),
            &mut |path, value| {
                let unit = keys::find(path).map_or(Unit::Plain, |key| key.unit);
                leaves.insert(path.join("."), (value.to_string(), unit));
                Ok(())
            },
        );
        debug_assert!(walked.is_ok(), "the walk itself cannot fail");
        leaves
    };
    let (then, now) = (leaves(then), leaves(now));
    let keys: BTreeSet<&String> = then.keys().chain(now.keys()).collect();
    let changed = keys
        .into_iter()
        .filter(|key| then.get(*key) != now.get(*key));
    let shown = |leaf: Option<&(String, Unit)>| leaf.map_or("none", |(value, _)| value).to_owned();
    changed
        .map(|key| {
            let (was, is) = (then.get(key), now.get(key));
            let unit = match was.or(is) {
                Some((_, Unit::Degrees)) => " deg",
                _ => "",
            };
            (
                key.clone(),
                format!("{} -> {}{unit}", shown(was), shown(is)),
            )
        })
        .collect()
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Float(x) => Some(*x),
        Value::Integer(n) => Some(*n as f64),
        _ => None,
    }
}

/// Calls `visit` with the path and value of everything in the table that is not itself a table.
fn each_leaf(
    table: &mut Table,
    path: &mut Vec<String>,
    visit: &mut impl FnMut(&[&str], &mut Value) -> Result<(), ConfigError>,
) -> Result<(), ConfigError> {
    for (name, value) in table.iter_mut() {
        path.push(name.clone());
        match value {
            Value::Table(inner) => each_leaf(inner, path, visit)?,
            leaf => {
                let path: Vec<&str> = path.iter().map(String::as_str).collect();
                visit(&path, leaf)?;
            }
        }
        path.pop();
    }
    Ok(())
}

/// A line of a configuration as one types it: the quotes of a text may be left out, which the shell would take.
///
/// # Errors
/// A line without `=`; whether it means anything else is for the configuration to say.
pub fn assignment(line: &str) -> Result<String, String> {
    if !line.contains('=') {
        return Err("it has no `=`: give KEY=VALUE, such as frames.step=0.15".to_owned());
    }
    let bare = |(key, text): (&str, &str)| {
        let value = Value::String(text.trim().to_owned());
        format!("{} = {value}", key.trim())
    };
    Ok(match line.parse::<Table>() {
        Ok(_) => line.to_owned(),
        Err(_) => line.split_once('=').map_or_else(|| line.to_owned(), bare),
    })
}

#[cfg(test)]
mod tests;
