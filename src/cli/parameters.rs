//! The flags that make a configuration, for every command that replays.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use toml::Value;

use crate::cli::error::Error;
use crate::core::config::{Config, Rule};
use crate::io::config::file::{ConfigError, check, overridden, parse_layers};

/// Parameters of the replay; a flag stands before the configuration file.
#[derive(Debug, Clone, Default, PartialEq, Args)]
#[command(next_help_heading = "Parameters")]
pub struct Parameters {
    #[command(flatten)]
    selection: Selection,
    /// Paper's rule: a contact arc has theta_c < ALPHA * theta_i [default: 0.5]
    #[arg(long, value_name = "RATIO")]
    alpha: Option<f64>,
    /// Paper's rule: an intersection arc has theta_c > BETA * theta_i [default: 2]
    #[arg(long, value_name = "RATIO")]
    beta: Option<f64>,
    /// Paper's rule: the smaller angle of a labelled arc is below this [default: 10]
    #[arg(long, value_name = "DEG")]
    gamma: Option<f64>,
    /// Distance driven that opens a new frame; 0 opens one at every stamp [default: 0.1]
    #[arg(long, value_name = "M")]
    step: Option<f64>,
    /// Turn that opens a new frame [default: 10]
    #[arg(long, value_name = "DEG")]
    step_angle: Option<f64>,
    /// Paper's rule: points nearer than this are one point of the map [default: 0.2]
    #[arg(long, value_name = "M")]
    match_distance: Option<f64>,
    /// Any other key of the configuration, repeatable: triple.turn_tolerance=4
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// What has no number to sweep: the file, the rule, and what is chosen of the log.
#[derive(Debug, Clone, Default, PartialEq, Args)]
#[command(next_help_heading = "Parameters")]
pub struct Selection {
    /// Configuration file; `tmam config` prints one with every key
    #[arg(long, value_name = "FILE.toml")]
    config: Option<PathBuf>,
    /// How arcs are labelled and features fused [default: noise-aware]
    #[arg(long, value_enum)]
    rule: Option<RuleName>,
    /// Leave out readings earlier than this after the first one
    #[arg(long, value_name = "S")]
    start: Option<f64>,
    /// Leave out readings later than this after the first one
    #[arg(long, value_name = "S")]
    end: Option<f64>,
    /// Only sonars with such a name, repeatable; frames keep the numbers of the whole run
    #[arg(long, value_name = "GLOB")]
    sensor: Vec<String>,
    /// Topics that carry ranges, repeatable [default: found by type]
    #[arg(long, value_name = "GLOB")]
    range_topic: Vec<String>,
    /// Topic that carries odometry [default: found by type]
    #[arg(long, value_name = "GLOB")]
    odom_topic: Vec<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, ValueEnum)]
enum RuleName {
    /// The paper's rule, with its errors corrected
    Paper,
    /// What the readings support within their noise
    NoiseAware,
}

impl Parameters {
    /// The sonars that `--sensor` names, for a command in which it selects something else than the
    /// readings that are replayed.
    pub fn take_sensors(&mut self) -> Vec<String> {
        std::mem::take(&mut self.selection.sensor)
    }

    /// The configuration in effect: defaults, then the file, then the flags.
    ///
    /// # Errors
    /// A file that cannot be read, and whatever is not allowed in it or in the flags.
    pub fn configuration(&self) -> Result<Config, Error> {
        let mut config = self.selection.configuration(&self.set)?;
        self.apply(&mut config);
        check(&config)?;
        Ok(config)
    }

    /// What is given, for a command that puts it over a configuration of its own: texts as of a
    /// configuration file, each over the one before. None where nothing is given.
    ///
    /// # Errors
    /// As [`Parameters::configuration`].
    pub fn layers(&self) -> Result<Vec<String>, Error> {
        self.configuration()?;
        let file = self.selection.file_text()?;
        let flags = self.as_toml();
        let given = std::iter::once(file)
            .chain(self.set.iter().cloned())
            .chain(std::iter::once(flags));
        Ok(given.filter(|text| !text.trim().is_empty()).collect())
    }

    /// The flags as keys of the configuration.
    fn as_toml(&self) -> String {
        let number = |value: Option<f64>| value.map(Value::from);
        let globs = |globs: &[String]| (!globs.is_empty()).then(|| Value::from(globs.to_vec()));
        let selection = &self.selection;
        let rule = selection.rule.and_then(|rule| {
            let value = rule.to_possible_value()?;
            Some(Value::from(value.get_name()))
        });
        [
            ("rule", rule),
            ("triple.alpha", number(self.alpha)),
            ("triple.beta", number(self.beta)),
            ("triple.gamma", number(self.gamma)),
            ("frames.step", number(self.step)),
            ("frames.step_angle", number(self.step_angle)),
            ("map.match_distance", number(self.match_distance)),
            ("input.start", number(selection.start)),
            ("input.end", number(selection.end)),
            ("input.sonars", globs(&selection.sensor)),
            ("input.range_topics", globs(&selection.range_topic)),
            ("input.odometry_topics", globs(&selection.odom_topic)),
        ]
        .into_iter()
        .filter_map(|(key, value)| Some(format!("{key} = {}\n", value?)))
        .collect()
    }

    /// As [`Parameters::layers`], with another file in place of the one that is given, and with
    /// other values over everything.
    ///
    /// # Errors
    /// As [`Parameters::configuration`].
    pub fn varied_layers(
        &self,
        file: Option<PathBuf>,
        set: &[String],
    ) -> Result<Vec<String>, Error> {
        let mut other = self.clone();
        other.selection.config = file.or(other.selection.config);
        let mut layers = other.layers()?;
        for text in set {
            overridden(&Config::default(), text).map_err(|source| Error::Set { source })?;
        }
        layers.extend(set.iter().cloned());
        Ok(layers)
    }

    /// The flags as one types them, for a command that a person is told to run next: those of the
    /// sonars left out.
    pub fn as_typed(&self) -> String {
        let rule = self.selection.rule.and_then(|rule| {
            let value = rule.to_possible_value()?;
            Some(value.get_name().to_owned())
        });
        let number = |value: Option<f64>| value.map(|value| value.to_string());
        let path = self
            .selection
            .config
            .as_ref()
            .map(|path| path.display().to_string());
        let single = [
            ("config", path),
            ("rule", rule),
            ("alpha", number(self.alpha)),
            ("beta", number(self.beta)),
            ("gamma", number(self.gamma)),
            ("step", number(self.step)),
            ("step-angle", number(self.step_angle)),
            ("match-distance", number(self.match_distance)),
            ("start", number(self.selection.start)),
            ("end", number(self.selection.end)),
        ];
        let single = single
            .into_iter()
            .filter_map(|(name, value)| Some((name, value?)));
        let many = [
            ("set", &self.set),
            ("range-topic", &self.selection.range_topic),
            ("odom-topic", &self.selection.odom_topic),
        ];
        let many = many
            .into_iter()
            .flat_map(|(name, values)| values.iter().map(move |value| (name, value.clone())));
        single
            .chain(many)
            .map(|(name, value)| format!(" --{name} {}", quoted(&value)))
            .collect()
    }

    fn apply(&self, config: &mut Config) {
        let set = |value: &mut f64, flag: Option<f64>| *value = flag.unwrap_or(*value);
        let set_degrees =
            |value: &mut f64, flag: Option<f64>| *value = flag.map_or(*value, f64::to_radians);
        set(&mut config.triple.alpha, self.alpha);
        set(&mut config.triple.beta, self.beta);
        set_degrees(&mut config.triple.gamma, self.gamma);
        set(&mut config.frames.step, self.step);
        set_degrees(&mut config.frames.step_angle, self.step_angle);
        set(&mut config.map.match_distance, self.match_distance);
    }
}

impl Selection {
    /// The file with these flags and those of `set` over it, `KEY=VALUE` each.
    ///
    /// # Errors
    /// A file that cannot be read, and whatever is not allowed in it or in the flags.
    pub fn configuration(&self, set: &[String]) -> Result<Config, Error> {
        let text = self.file_text()?;
        let mut config = parse_layers(&[&text]).map_err(|source| self.in_file(source))?;
        check(&config).map_err(|source| self.in_file(source))?;
        if !set.is_empty() {
            let set = set.iter().map(String::as_str);
            let layers: Vec<&str> = std::iter::once(text.as_str()).chain(set).collect();
            config = parse_layers(&layers).map_err(|source| Error::Set { source })?;
        }
        self.apply(&mut config);
        check(&config)?;
        Ok(config)
    }

    /// Whether a flag stands for a key of the configuration that could be swept.
    pub fn gives(&self, key: &str) -> bool {
        match key {
            "input.start" => self.start.is_some(),
            "input.end" => self.end.is_some(),
            _ => false,
        }
    }

    fn file_text(&self) -> Result<String, Error> {
        let Some(path) = &self.config else {
            return Ok(String::new());
        };
        std::fs::read_to_string(path).map_err(|source| Error::Read {
            path: path.clone(),
            source,
        })
    }

    fn in_file(&self, source: ConfigError) -> Error {
        Error::ConfigFile {
            path: self.config.clone().unwrap_or_default(),
            source,
        }
    }

    fn apply(&self, config: &mut Config) {
        config.rule = match self.rule {
            Some(RuleName::Paper) => Rule::Paper,
            Some(RuleName::NoiseAware) => Rule::NoiseAware,
            None => config.rule,
        };
        let input = &mut config.input;
        input.start = self.start.or(input.start);
        input.end = self.end.or(input.end);
        for (globs, flags) in [
            (&mut input.sonars, &self.sensor),
            (&mut input.range_topics, &self.range_topic),
            (&mut input.odometry_topics, &self.odom_topic),
        ] {
            if !flags.is_empty() {
                globs.clone_from(flags);
            }
        }
    }
}

/// A word as a shell takes it.
pub(super) fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=+,:@".contains(c);
    if word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}
