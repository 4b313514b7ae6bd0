//! The flags that make a configuration, for every command that replays.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use toml::Value;

use crate::cli::error::Error;
use crate::core::config::{Config, Method};
use crate::core::legible::quoted;
use crate::io::config::file::{ConfigError, assignment, check, layered, overridden, parse_layers};
use crate::io::text_file::read_text;

/// Parameters of the replay; a flag stands before the configuration file.
#[derive(Debug, Clone, Default, PartialEq, Args)]
#[command(next_help_heading = "Parameters")]
pub struct Parameters {
    #[command(flatten)]
    selection: Selection,
    /// Paper's rule: a contact arc has theta_c < ALPHA * theta_i [default: 0.5]
    #[arg(long, value_name = "RATIO", hide_short_help = true)]
    alpha: Option<f64>,
    /// Paper's rule: an intersection arc has theta_c > BETA * theta_i [default: 2]
    #[arg(long, value_name = "RATIO", hide_short_help = true)]
    beta: Option<f64>,
    /// Paper's rule: the smaller angle of a labelled arc is below this [default: 10]
    #[arg(long, value_name = "DEG", hide_short_help = true)]
    gamma: Option<f64>,
    /// Distance driven that opens a new frame; 0 opens one at every stamp [default: 0.1]
    #[arg(long, value_name = "M", hide_short_help = true)]
    step: Option<f64>,
    /// Turn that opens a new frame [default: 10]
    #[arg(long, value_name = "DEG", hide_short_help = true)]
    step_angle: Option<f64>,
    /// Paper's rule: points nearer than this are one point of the map [default: 0.2]
    #[arg(long, value_name = "M", hide_short_help = true)]
    match_distance: Option<f64>,
    /// Any other key of the configuration, repeatable: triple.turn_tolerance=4
    #[arg(long, value_name = "KEY=VALUE", value_parser = assignment)]
    set: Vec<String>,
}

/// What has no number to sweep: the file, the method, the rule, the poses, and what is chosen of the log.
#[derive(Debug, Clone, Default, PartialEq, Args)]
#[command(next_help_heading = "Parameters")]
pub struct Selection {
    /// Configuration file; `tmam config` prints one with every key
    #[arg(long, value_name = "FILE.toml")]
    config: Option<PathBuf>,
    /// What makes the map: TMAM, or a method that its paper discusses [default: tmam]
    #[arg(long, value_enum, hide_short_help = true)]
    method: Option<MethodName>,
    /// How TMAM labels arcs and fuses features [default: noise-aware]
    #[arg(long, value_enum)]
    rule: Option<RuleName>,
    /// Where the robot's poses come from; the paper's rule takes odometry's [default: joint]
    #[arg(long, value_enum, hide_short_help = true)]
    poses: Option<PosesName>,
    /// Leave out readings earlier than this after the first one; frames keep the numbers of the whole run
    #[arg(long, value_name = "S", hide_short_help = true)]
    start: Option<f64>,
    /// Leave out readings later than this after the first one
    #[arg(long, value_name = "S", hide_short_help = true)]
    end: Option<f64>,
    /// Only sonars with such a name, repeatable
    ///
    /// Frames keep the numbers of the whole run.
    #[arg(long, value_name = "GLOB")]
    sensor: Vec<String>,
    /// Topics that carry ranges, repeatable [default: found by type]
    #[arg(long, value_name = "GLOB", hide_short_help = true)]
    range_topic: Vec<String>,
    /// Topic that carries odometry [default: found by type]
    #[arg(long, value_name = "GLOB", hide_short_help = true)]
    odom_topic: Vec<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, ValueEnum)]
pub(super) enum MethodName {
    /// Three measurements association model
    Tmam,
    /// Two measurements, the model that TMAM replaces
    TwoMeasurement,
    /// Triangulation-based fusion (Wijk and Christensen)
    Tbf,
    /// Arc-transversal median (Choset and Nagatani)
    Atm,
    /// Regions of constant depth (Leonard); the robot must turn on the spot
    Rcd,
    /// Three aligned readings (Crowley)
    Crowley,
}

#[derive(Debug, Clone, Copy, PartialEq, ValueEnum)]
enum RuleName {
    /// The paper's rule, with its errors corrected
    Paper,
    /// What the readings support within their noise
    NoiseAware,
}

#[derive(Debug, Clone, Copy, PartialEq, ValueEnum)]
enum PosesName {
    /// Odometry, as the log has it
    Odometry,
    /// Odometry and ranges together, estimated with the features
    Joint,
}

impl MethodName {
    /// As a text of a configuration file.
    pub fn layer(self) -> String {
        let value = self.to_possible_value();
        value.map_or_else(String::new, |value| {
            format!("method = \"{}\"", value.get_name())
        })
    }
}

/// A flag: its name, the key of the configuration that it stands for, and its value if it is given.
type Flag = (&'static str, &'static str, Option<Value>);

impl Parameters {
    /// The sonars that `--sensor` names, for a command in which it selects something else than the
    /// readings that are replayed.
    pub fn take_sensors(&mut self) -> Vec<String> {
        std::mem::take(&mut self.selection.sensor)
    }

    /// The configuration's file, where one is named.
    pub fn file(&self) -> Option<&Path> {
        self.selection.file()
    }

    /// The configuration in effect: defaults, then the file, then the flags.
    ///
    /// # Errors
    /// A file that cannot be read, and whatever is not allowed in it or in the flags.
    pub fn configuration(&self) -> Result<Config, Error> {
        self.selection.with_flags(&self.set, &self.flags())
    }

    /// The same for a command that looks into TMAM.
    ///
    /// # Errors
    /// As [`Parameters::configuration`], and where another method is asked for.
    pub fn of_tmam(&self, command: &'static str) -> Result<Config, Error> {
        let config = self.configuration()?;
        let of_tmam = config.method == Method::Tmam;
        of_tmam
            .then_some(config)
            .ok_or(Error::OfTmamAlone { command })
    }

    /// What is given, for a command that puts it over a configuration of its own: texts as of a
    /// configuration file, each over the one before. None where nothing is given.
    ///
    /// # Errors
    /// As [`Parameters::configuration`].
    pub fn layers(&self) -> Result<Vec<String>, Error> {
        self.configuration()?;
        let given = std::iter::once(self.selection.file_text()?)
            .chain(self.set.iter().cloned())
            .chain(std::iter::once(as_toml(&self.flags())));
        Ok(given.filter(|text| !text.trim().is_empty()).collect())
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
        let file = self.selection.config.iter();
        let file = file.map(|path| ("config", path.display().to_string()));
        let flags = self.flags().into_iter().filter(|flag| flag.0 != "sensor");
        let flags = flags.flat_map(|(name, _, value)| {
            let typed = match value {
                None => Vec::new(),
                Some(Value::Array(values)) => values.iter().map(typed).collect(),
                Some(value) => vec![typed(&value)],
            };
            typed.into_iter().map(move |value| (name, value))
        });
        let set = self.set.iter().map(|text| ("set", text.clone()));
        let all = file.chain(flags).chain(set);
        all.map(|(name, value)| format!(" --{name} {}", quoted(&value)))
            .collect()
    }

    fn flags(&self) -> Vec<Flag> {
        let numbers = [
            ("alpha", "triple.alpha", self.alpha),
            ("beta", "triple.beta", self.beta),
            ("gamma", "triple.gamma", self.gamma),
            ("step", "frames.step", self.step),
            ("step-angle", "frames.step_angle", self.step_angle),
            ("match-distance", "map.match_distance", self.match_distance),
        ];
        let numbers = numbers.map(|(name, key, number)| (name, key, number.map(Value::from)));
        let mut flags = self.selection.flags();
        flags.splice(3..3, numbers);
        flags
    }
}

impl Selection {
    /// The configuration's file, where one is named.
    pub fn file(&self) -> Option<&Path> {
        self.config.as_deref()
    }

    /// The file with these flags and those of `set` over it, `KEY=VALUE` each.
    ///
    /// # Errors
    /// A file that cannot be read, and whatever is not allowed in it or in the flags.
    pub fn configuration(&self, set: &[String]) -> Result<Config, Error> {
        self.with_flags(set, &self.flags())
    }

    fn with_flags(&self, set: &[String], flags: &[Flag]) -> Result<Config, Error> {
        let text = self.file_text()?;
        let mut config = parse_layers(&[&text]).map_err(|source| self.in_file(source))?;
        check(&config).map_err(|source| self.in_file(source))?;
        if !set.is_empty() {
            let set = set.iter().map(String::as_str);
            let layers: Vec<&str> = std::iter::once(text.as_str()).chain(set).collect();
            config = parse_layers(&layers).map_err(|source| Error::Set { source })?;
        }
        Ok(layered(config, &[as_toml(flags)])?)
    }

    /// Whether a flag stands for a key of the configuration that could be swept.
    pub fn gives(&self, key: &str) -> bool {
        let mut flags = self.flags().into_iter();
        flags.any(|(_, of, value)| of == key && value.is_some())
    }

    fn flags(&self) -> Vec<Flag> {
        let method = self.method.and_then(|method| method.to_possible_value());
        let rule = self.rule.and_then(|rule| rule.to_possible_value());
        let poses = self.poses.and_then(|poses| poses.to_possible_value());
        let [method, rule, poses] =
            [method, rule, poses].map(|name| Some(Value::from(name?.get_name())));
        let globs = |globs: &[String]| (!globs.is_empty()).then(|| Value::from(globs.to_vec()));
        vec![
            ("method", "method", method),
            ("rule", "rule", rule),
            ("poses", "poses", poses),
            ("start", "input.start", self.start.map(Value::from)),
            ("end", "input.end", self.end.map(Value::from)),
            ("sensor", "input.sonars", globs(&self.sensor)),
            (
                "range-topic",
                "input.range_topics",
                globs(&self.range_topic),
            ),
            (
                "odom-topic",
                "input.odometry_topics",
                globs(&self.odom_topic),
            ),
        ]
    }

    fn file_text(&self) -> Result<String, Error> {
        let Some(path) = &self.config else {
            return Ok(String::new());
        };
        read_text(path).map_err(|source| Error::Read {
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
}

/// The flags that are given as keys of the configuration.
fn as_toml(flags: &[Flag]) -> String {
    let given = flags.iter();
    let given = given.filter_map(|(_, key, value)| Some((key, value.as_ref()?)));
    given
        .map(|(key, value)| format!("{key} = {value}\n"))
        .collect()
}

/// A value as one types it.
fn typed(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Float(number) => number.to_string(),
        other => other.to_string(),
    }
}
