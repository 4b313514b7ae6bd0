//! An arc between its neighbours in its sonar's sequence, and what keeps the three from being a triple.

use std::fmt::Write as _;

use serde::Serialize;

use super::sequences::{SonarEntry, way_to};
use crate::core::config::Config;
use crate::core::rounding::{number, optional};
use crate::core::statistics::seconds;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::triple::{Between, bend, conditions};
use crate::tools::tables::{TableColumn, listed};

/// A reading, placed in the world. SI units and radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Reading {
    pub frame: u32,
    pub stamp_ns: i64,
    /// After the log's first reading.
    #[serde(serialize_with = "number")]
    pub seconds: f64,
    #[serde(serialize_with = "number")]
    pub x: f64,
    #[serde(serialize_with = "number")]
    pub y: f64,
    /// Direction of the beam.
    #[serde(serialize_with = "number")]
    pub yaw: f64,
    #[serde(serialize_with = "number")]
    pub range: f64,
    #[serde(serialize_with = "number")]
    pub sigma: f64,
    #[serde(serialize_with = "number")]
    pub beam_width: f64,
}

impl Reading {
    pub fn new(arc: &Arc, origin_ns: i64) -> Self {
        Self {
            frame: arc.id.frame,
            stamp_ns: arc.stamp_ns,
            seconds: seconds(origin_ns, arc.stamp_ns),
            x: arc.world_from_sensor.x,
            y: arc.world_from_sensor.y,
            yaw: arc.world_from_sensor.yaw,
            range: arc.range,
            sigma: arc.variance.max(0.0).sqrt(),
            beam_width: arc.beam_width,
        }
    }
}

/// What stands next to an arc in its sonar's sequence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "is", rename_all = "kebab-case")]
pub enum Neighbour {
    Echo(Reading),
    /// The sonar fired, and nothing came back.
    NoEcho {
        frame: u32,
    },
    /// The sequence begins or ends here.
    End,
}

/// A bound that keeps an arc from being the middle of a triple. SI units or radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Obstacle {
    /// The key of the configuration.
    pub key: &'static str,
    pub between: Between,
    #[serde(serialize_with = "number")]
    pub found: f64,
    #[serde(serialize_with = "number")]
    pub allowed: f64,
}

/// An arc between its neighbours.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Situation {
    pub before: Neighbour,
    pub after: Neighbour,
    /// Way of the sensor from the arc before, metres.
    #[serde(serialize_with = "optional")]
    pub way_before: Option<f64>,
    /// Way of the sensor to the arc after, metres.
    #[serde(serialize_with = "optional")]
    pub way_after: Option<f64>,
    /// The conditions that do not hold, where it has two echoes beside it.
    pub obstacles: Vec<Obstacle>,
    /// The three arcs, where there are three.
    #[serde(skip)]
    pub three: Option<[Arc; 3]>,
}

impl Situation {
    /// How the arc at `place` of a sequence stands.
    pub fn new(sequence: &[SonarEntry<'_>], place: usize, config: &Config, origin_ns: i64) -> Self {
        let [before, this, after] =
            [place.checked_sub(1), Some(place), place.checked_add(1)].map(|at| sequence.get(at?));
        let neighbour =
            |given: Option<&SonarEntry<'_>>| match given.map(|given| (given.frame, given.report)) {
                None => Neighbour::End,
                Some((_, Some(report))) => Neighbour::Echo(Reading::new(&report.arc, origin_ns)),
                Some((frame, None)) => Neighbour::NoEcho { frame },
            };
        let three = match [before, this, after].map(|given| Some(given?.report?.arc)) {
            [Some(before), Some(arc), Some(after)] => Some([before, arc, after]),
            _ => None,
        };
        let ways = [way_to(sequence, place), way_to(sequence, place + 1)];
        let conditions = match (&three, &ways) {
            (Some(three), [Some(to), Some(on)]) => Some(conditions([to, on], bend(three), config)),
            _ => None,
        };
        let broken = (conditions.into_iter().flatten()).filter(|(_, c, _)| !c.holds());
        let [way_before, way_after] = ways.map(|way| way.map(|way| way.length));
        Self {
            before: neighbour(before),
            after: neighbour(after),
            way_before,
            way_after,
            obstacles: broken
                .map(|(between, condition, _)| Obstacle {
                    key: condition.key,
                    between,
                    found: condition.found,
                    allowed: condition.bound,
                })
                .collect(),
            three,
        }
    }

    /// The readings, and why they are no triple.
    pub fn text(&self, arc: &Reading) -> String {
        let beside = [("before", &self.before), ("after", &self.after)];
        let [before, after] = beside.map(|(name, neighbour)| match neighbour {
            Neighbour::Echo(reading) => Some((name, *reading)),
            _ => None,
        });
        let columns: [TableColumn<'_, (&str, Reading)>; 9] = [
            ("", &|(name, _)| (*name).to_owned()),
            ("frame", &|(_, r)| r.frame.to_string()),
            ("time s", &|(_, r)| format!("{:.3}", r.seconds)),
            ("x m", &|(_, r)| format!("{:.4}", r.x)),
            ("y m", &|(_, r)| format!("{:.4}", r.y)),
            ("yaw deg", &|(_, r)| format!("{:.2}", r.yaw.to_degrees())),
            ("range m", &|(_, r)| format!("{:.4}", r.range)),
            ("sigma mm", &|(_, r)| format!("{:.2}", r.sigma * 1e3)),
            ("beam deg", &|(_, r)| {
                format!("{:.1}", r.beam_width.to_degrees())
            }),
        ];
        let rows = [before, Some(("this arc", *arc)), after];
        let mut text = listed(1, &columns, rows.iter().flatten());
        for (side, neighbour) in beside {
            let _ = match neighbour {
                Neighbour::Echo(_) => Ok(()),
                Neighbour::NoEcho { frame } => {
                    writeln!(
                        text,
                        "  The sonar's reading {side} it, in frame {frame}, had no echo."
                    )
                }
                Neighbour::End => writeln!(text, "  The sonar has no reading {side} it."),
            };
        }
        for obstacle in &self.obstacles {
            let _ = writeln!(text, "  Not a triple: {}.", self.broken(obstacle));
        }
        text
    }

    /// Why it is the middle of no triple.
    pub fn obstacle(&self) -> Option<String> {
        let beside = [("before", &self.before), ("after", &self.after)];
        let silent = beside
            .into_iter()
            .find_map(|(side, neighbour)| match neighbour {
                Neighbour::Echo(_) => None,
                Neighbour::NoEcho { frame } => Some(format!(
                    "The sonar's reading {side} it, in frame {frame}, had no echo"
                )),
                Neighbour::End => Some(format!("The sonar has no reading {side} it")),
            });
        let broken = self.obstacles.first();
        silent.or(broken.map(|first| format!("Not a triple: {}", self.broken(first))))
    }

    fn broken(&self, obstacle: &Obstacle) -> String {
        let from = match (obstacle.between, &self.before, &self.after) {
            (Between::Before, Neighbour::Echo(other), _) => {
                format!("from the reading before (frame {})", other.frame)
            }
            (Between::After, _, Neighbour::Echo(other)) => {
                format!("to the reading after (frame {})", other.frame)
            }
            _ => "between the way to it and the way on".to_owned(),
        };
        let (what, factor, unit, decimals) = match obstacle.key {
            "sequence.max_gap" => ("", 1.0, "s", 3),
            "sequence.max_baseline" => ("", 1.0, "m", 3),
            "triple.turn_tolerance" => ("the beam turned by ", 1_f64.to_degrees(), "deg", 2),
            _ => ("the path bends by ", 1_f64.to_degrees(), "deg", 2),
        };
        format!(
            "{what}{:.decimals$} {unit} {from}; {} is {:.decimals$}",
            obstacle.found * factor,
            obstacle.key,
            obstacle.allowed * factor
        )
    }
}
