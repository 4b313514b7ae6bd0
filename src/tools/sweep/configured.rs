//! The configuration without the sweep, and how far the best cell leads over it.

use toml::Value;

use super::axes::Axis;
use super::columns::Column;
use super::score::Score;
use super::{CellError, Sweep};
use crate::core::config::Config;
use crate::core::event::Sonar;
use crate::io::config::file::to_table;

/// What the log gives without the sweep.
#[derive(Debug)]
pub struct Configured {
    /// The value on every axis, in the unit of its key; `None` where it is each message's own.
    pub values: Vec<Option<f64>>,
    /// What it comes to.
    pub score: Result<Score, CellError>,
}

/// The best cell beside what is configured.
#[derive(Debug)]
pub enum Lead {
    /// They differ first in this column, the best cell being better in it.
    Better(Difference),
    /// No ranked column tells them apart.
    Alike,
    /// The grid leaves out what is configured, which is better than all of it.
    Worse(Difference),
    /// The configuration cannot be replayed without the sweep.
    Failed(String),
}

/// Where the best cell and the configured values differ first.
#[derive(Debug)]
pub struct Difference {
    /// The column.
    pub column: &'static Column,
    /// In it, of the best cell and of what is configured; `None` where there is no such number.
    pub best: Option<f64>,
    /// See `best`.
    pub configured: Option<f64>,
    /// How many columns rank before it, in which both are alike.
    pub alike: usize,
}

impl Sweep {
    /// How far the best cell leads over what is configured.
    pub fn lead(&self) -> Option<Lead> {
        let (_, best) = self.best()?;
        let configured = match &self.configured.score {
            Ok(score) => score,
            Err(error) => return Some(Lead::Failed(error.to_string())),
        };
        let mut ranked = self.ranked_by.iter().copied().enumerate();
        let first = ranked.find(|(_, column)| column.compare(best, configured).is_ne());
        let Some((alike, column)) = first else {
            return Some(Lead::Alike);
        };
        let difference = Difference {
            column,
            best: (column.of)(best),
            configured: (column.of)(configured),
            alike,
        };
        Some(if column.compare(best, configured).is_lt() {
            Lead::Better(difference)
        } else {
            Lead::Worse(difference)
        })
    }
}

impl Difference {
    /// Whether a table shows both numbers alike.
    pub fn is_small(&self) -> bool {
        let shown = |number| self.column.number(number);
        shown(self.best) == shown(self.configured)
    }
}

/// What is configured on an axis: in the configuration, in the log's mounts, or measured.
pub fn value(axis: &Axis, config: &Config, sonars: &[Sonar], sigma: Option<f64>) -> Option<f64> {
    let mut inner = Some(Value::Table(to_table(config)));
    for part in &axis.path {
        inner = inner.and_then(|value| value.get(part).cloned());
    }
    let path: Vec<&str> = axis.path.iter().map(String::as_str).collect();
    match (inner, path.as_slice()) {
        (Some(Value::Float(number)), _) => Some(number),
        (Some(Value::Integer(number)), _) => Some(number as f64),
        (_, ["sonar", name, leaf]) => {
            let sonar = sonars.iter().find(|sonar| sonar.name == *name)?;
            let mount = sonar.robot_from_sensor;
            match *leaf {
                "x" => Some(legible(mount.x)),
                "y" => Some(legible(mount.y)),
                "yaw" => Some(legible(mount.yaw.to_degrees())),
                _ => None,
            }
        }
        (_, ["noise", "sigma_abs"]) => sigma,
        _ => None,
    }
}

/// A number of a log's mount without the dust of its conversions: it is told, and not calculated with.
fn legible(number: f64) -> f64 {
    libm::round(number * 1e4) / 1e4
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::Pose2;

    #[test]
    fn what_is_configured_comes_from_the_configuration_then_from_the_log() {
        let mut config = Config::default();
        config.triple.gamma = 7_f64.to_radians();
        config.map.confirm_runs = 4;
        let sonars = [Sonar {
            name: "front".to_owned(),
            topic: "/front".to_owned(),
            robot_from_sensor: Pose2::new(0.1, 0.2, -20_f64.to_radians()),
        }];
        let said = |key: &str| {
            let axis = Axis::parse(key, "1").unwrap();
            value(&axis, &config, &sonars, Some(0.003))
        };
        assert_eq!(said("triple.gamma"), Some(7.0));
        assert_eq!(said("map.confirm_runs"), Some(4.0));
        assert_eq!(said("sonar.front.yaw"), Some(-20.0));
        assert_eq!(said("sonar.front.x"), Some(0.1));
        assert_eq!(said("sonar.front.beam_width"), None);
        assert_eq!(said("noise.sigma_abs"), Some(0.003));
    }
}
