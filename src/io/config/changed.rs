//! A change of parameters as keys of `tmam.toml`.

use super::keys;
use crate::core::calibrate::change::{Change, configured_delay, configured_range};
use crate::core::calibrate::parameter::{Parameter, Quantity, Whose};
use crate::core::config::Config;
use crate::core::event::{Events, Sonar, SonarId};

/// A key with its value, in the unit of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct ChangedKey {
    /// Part by part.
    pub path: Vec<String>,
    /// As it is configured, or as the log has it.
    pub configured: f64,
    /// As it is to be.
    pub value: f64,
}

impl ChangedKey {
    /// `sonar.front.yaw=12.3`, as `--set` takes it.
    pub fn setting(&self) -> String {
        let path: Vec<String> = self.path.iter().map(|part| keys::part(part)).collect();
        format!("{}={}", path.join("."), self.value)
    }

    /// A table that holds it alone.
    fn table(&self) -> toml::Table {
        let mut value = toml::Value::Float(self.value);
        for part in self.path.iter().rev() {
            value = toml::Value::Table([(part.clone(), value)].into_iter().collect());
        }
        match value {
            toml::Value::Table(table) => table,
            _ => toml::Table::new(),
        }
    }
}

/// The keys that a change is made of, for a log as it is configured.
pub fn changed_keys(change: &Change, events: &Events, config: &Config) -> Vec<ChangedKey> {
    let mut changed = Vec::new();
    let input = &config.input;
    let mut of_input = |key: &str, parameter, configured: f64, value: f64, decimals| {
        if change.by.contains_key(&parameter) {
            changed.push(key_of(&["input", key], configured, value, decimals));
        }
    };
    let of = |parameter| change.of(parameter);
    let (delay, rate) = (Parameter::RangeDelay, Parameter::ClockRate);
    let value = input.range_delay + of(delay);
    of_input("range_delay", delay, input.range_delay, value, 4);
    let value = input.range_clock_rate + of(rate);
    of_input("range_clock_rate", rate, input.range_clock_rate, value, 6);
    let (distance, turn) = (Parameter::OdometryScale, Parameter::OdometryTurnScale);
    let value = input.odometry_scale * (1.0 + of(distance));
    of_input("odometry_scale", distance, input.odometry_scale, value, 5);
    let configured = input.odometry_turn_scale;
    let value = configured * (1.0 + of(turn));
    of_input("odometry_turn_scale", turn, configured, value, 5);
    changed.extend(of_all_ranges(change, config));
    for (place, sonar) in (0..).zip(&events.sonars) {
        changed.extend(of_sonar(change, SonarId(place), sonar, events, config));
    }
    changed
}

fn key_of(path: &[&str], configured: f64, value: f64, decimals: i32) -> ChangedKey {
    let unit = libm::pow(10.0, f64::from(decimals));
    ChangedKey {
        path: path.iter().map(|part| (*part).to_owned()).collect(),
        // Zero has no sign.
        configured: libm::round(configured * unit) / unit + 0.0,
        value: libm::round(value * unit) / unit + 0.0,
    }
}

/// Whether one key can say it of all sonars: none has its own.
fn is_of_all(change: &Change, config: &Config) -> bool {
    let ranges = [Quantity::RangeScale, Quantity::RangeOffset];
    let of_one = |parameter: &Parameter| matches!(parameter, Parameter::Sonar(Whose::One(_), of) if ranges.contains(of));
    let own = config.sonar.values();
    let mut own = own.map(|own| own.range_scale.or(own.range_offset));
    own.all(|own| own.is_none()) && !change.by.keys().any(of_one)
}

fn of_all_ranges(change: &Change, config: &Config) -> Vec<ChangedKey> {
    if !is_of_all(change, config) {
        return Vec::new();
    }
    let of = |quantity| change.of(Parameter::Sonar(Whose::All, quantity));
    let scale = config.sonars.range_scale.unwrap_or(1.0);
    let offset = config.sonars.range_offset.unwrap_or(0.0);
    let more = 1.0 + of(Quantity::RangeScale);
    let both = [
        ("range_scale", scale, scale * more, 5),
        (
            "range_offset",
            offset,
            offset * more + of(Quantity::RangeOffset),
            4,
        ),
    ];
    let changed = both
        .into_iter()
        .filter(|(_, configured, value, _)| configured != value);
    changed
        .map(|(key, configured, value, decimals)| {
            key_of(&["sonars", key], configured, value, decimals)
        })
        .collect()
}

fn of_sonar(
    change: &Change,
    id: SonarId,
    sonar: &Sonar,
    events: &Events,
    config: &Config,
) -> Vec<ChangedKey> {
    let name = sonar.name.as_str();
    let own = |quantity| change.of(Parameter::Sonar(Whose::One(id), quantity));
    let all = |quantity| change.of(Parameter::Sonar(Whose::All, quantity));
    let mount = sonar.robot_from_sensor;
    let mut changed = Vec::new();
    let mut add = |key: &str, configured: f64, value: f64, decimals| {
        if configured != value {
            changed.push(key_of(&["sonar", name, key], configured, value, decimals));
        }
    };
    let both = |quantity| own(quantity) + all(quantity);
    add("x", mount.x, mount.x + both(Quantity::X), 4);
    add("y", mount.y, mount.y + both(Quantity::Y), 4);
    let degrees = |angle: f64| angle.to_degrees();
    let yaw = mount.yaw + own(Quantity::Yaw);
    add("yaw", degrees(mount.yaw), degrees(yaw), 2);
    let wider = both(Quantity::BeamWidth);
    if let Some(reading) = events.readings.of_sonar(id).next() {
        let width = reading.beam_width;
        add("beam_width", degrees(width), degrees(width + wider), 2);
    }
    if !is_of_all(change, config) {
        let [scale, offset] = configured_range(config, name);
        let more = 1.0 + both(Quantity::RangeScale);
        let beyond = both(Quantity::RangeOffset);
        add("range_scale", scale, scale * more, 5);
        add("range_offset", offset, offset * more + beyond, 4);
    }
    let delay = configured_delay(config, name);
    add("range_delay", delay, delay + own(Quantity::Delay), 4);
    changed
}

/// Texts as of configuration files, each over the one before, with these keys over all of them.
///
/// # Errors
/// A text that is no TOML.
pub fn with_keys(texts: &[String], changed: &[ChangedKey]) -> Result<String, Box<toml::de::Error>> {
    let mut table = toml::Table::new();
    for text in texts {
        super::file::overlay(&mut table, text.parse().map_err(Box::new)?);
    }
    for key in changed {
        super::file::overlay(&mut table, key.table());
    }
    Ok(table.to_string())
}
