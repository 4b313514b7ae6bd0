//! How an arc stands to its neighbours, and what keeps it from being the middle of a triple.

use serde::Serialize;

use super::need::{Need, Relation};
use super::rule::Change;
use super::watch::Given;
use crate::core::config::Config;
use crate::core::geometry::{angle_between, direction};
use crate::core::rounding::{number, optional};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::pair::MIN_BASELINE;

/// A reading, placed in the world. SI units and radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Reading {
    /// The frame that holds it.
    pub frame: u32,
    /// Its stamp.
    pub stamp_ns: i64,
    /// Seconds after the log's first reading.
    #[serde(serialize_with = "number")]
    pub seconds: f64,
    /// The sensor's position.
    #[serde(serialize_with = "number")]
    pub x: f64,
    /// The same.
    #[serde(serialize_with = "number")]
    pub y: f64,
    /// The direction of its beam.
    #[serde(serialize_with = "number")]
    pub yaw: f64,
    /// The range.
    #[serde(serialize_with = "number")]
    pub range: f64,
    /// The standard deviation of the range.
    #[serde(serialize_with = "number")]
    pub sigma: f64,
    /// The full opening angle of the beam.
    #[serde(serialize_with = "number")]
    pub beam_width: f64,
}

impl Reading {
    /// The reading of an arc.
    pub fn new(arc: &Arc, origin_ns: i64) -> Self {
        Self {
            frame: arc.id.frame,
            stamp_ns: arc.stamp_ns,
            seconds: super::question::since(arc.stamp_ns, origin_ns),
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
    /// An echo.
    Echo(Reading),
    /// The sonar fired, and nothing came back.
    NoEcho {
        /// The frame in which it fired.
        frame: u32,
    },
    /// The sequence begins or ends here.
    End,
}

impl Neighbour {
    fn new(given: Option<&Given>, origin_ns: i64) -> Self {
        match given {
            Some(Given { arc: Some(arc), .. }) => Self::Echo(Reading::new(arc, origin_ns)),
            Some(given) => Self::NoEcho { frame: given.frame },
            None => Self::End,
        }
    }
}

/// Which two arcs a bound is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Between {
    /// The arc and the one before it.
    Before,
    /// The arc and the one after it.
    After,
    /// The way to the arc and the way on from it.
    Both,
}

/// A bound that keeps an arc from being the middle of a triple.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Obstacle {
    /// The key of the configuration.
    pub key: &'static str,
    /// Between which arcs.
    pub between: Between,
    /// What was found, SI units or radians.
    #[serde(serialize_with = "number")]
    pub found: f64,
    /// What is allowed.
    #[serde(serialize_with = "number")]
    pub allowed: f64,
}

/// An arc between its neighbours.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Situation {
    /// The entry before it.
    pub before: Neighbour,
    /// The entry after it.
    pub after: Neighbour,
    /// Way of the sensor from the arc before, metres.
    #[serde(serialize_with = "optional")]
    pub way_before: Option<f64>,
    /// Way of the sensor to the arc after, metres.
    #[serde(serialize_with = "optional")]
    pub way_after: Option<f64>,
    /// What keeps it from being the middle of a triple, where it has two echoes beside it.
    pub obstacles: Vec<Obstacle>,
    /// The three arcs, where there are three.
    #[serde(skip)]
    pub three: Option<[Arc; 3]>,
}

impl Situation {
    /// How the arc at `place` of a sequence stands.
    pub fn new(sequence: &[Given], place: usize, config: &Config, origin_ns: i64) -> Self {
        let given = |at: Option<usize>| at.and_then(|at| sequence.get(at));
        let (before, after) = (given(place.checked_sub(1)), given(place.checked_add(1)));
        let arc = |given: Option<&Given>| given.and_then(|given| given.arc);
        let (first, middle, last) = (arc(before), arc(given(Some(place))), arc(after));
        let way = |a: Option<Arc>, b: Option<Arc>| Some((b?.center() - a?.center()).norm());
        let three = match (first, middle, last) {
            (Some(first), Some(middle), Some(last)) => Some([first, middle, last]),
            _ => None,
        };
        Self {
            before: Neighbour::new(before, origin_ns),
            after: Neighbour::new(after, origin_ns),
            way_before: way(first, middle),
            way_after: way(middle, last),
            obstacles: three.map_or_else(Vec::new, |three| obstacles(&three, config)),
            three,
        }
    }

    /// What would make the arc the middle of a triple, and the label that it would have `then`, if
    /// any.
    pub fn changes(&self, then: Option<&'static str>) -> Vec<Change> {
        if self.obstacles.is_empty() {
            return Vec::new();
        }
        let mut needs: Vec<Need> = Vec::new();
        for need in self.obstacles.iter().map(Obstacle::need) {
            match needs.iter_mut().find(|known| known.key == need.key) {
                Some(known) => known.bound = known.bound.max(need.bound),
                None => needs.push(need),
            }
        }
        vec![Change {
            label: then.unwrap_or("a triple"),
            needs,
            impossible: None,
        }]
    }
}

impl Obstacle {
    /// What would remove it.
    pub fn need(&self) -> Need {
        Need {
            key: self.key,
            relation: Relation::AtLeast,
            bound: self.found,
        }
    }
}

/// Every bound that three arcs break, in the order in which the machine asks.
fn obstacles([first, middle, last]: &[Arc; 3], config: &Config) -> Vec<Obstacle> {
    let (sequence, triple) = (&config.sequence, &config.triple);
    let seconds = |a: &Arc, b: &Arc| {
        let seconds = b.stamp_ns.saturating_sub(a.stamp_ns) as f64 * 1e-9;
        seconds.abs()
    };
    let way = |a: &Arc, b: &Arc| (b.center() - a.center()).norm();
    let turn = |a: &Arc, b: &Arc| angle_between(a.world_from_sensor.yaw, b.world_from_sensor.yaw);
    let mut broken = Vec::new();
    let mut ask = |key, between, found: f64, allowed: f64| {
        if found > allowed {
            broken.push(Obstacle {
                key,
                between,
                found,
                allowed,
            });
        }
    };
    let pairs = [
        (Between::Before, first, middle),
        (Between::After, middle, last),
    ];
    for (between, a, b) in pairs {
        ask("sequence.max_gap", between, seconds(a, b), sequence.max_gap);
        ask(
            "sequence.max_baseline",
            between,
            way(a, b),
            sequence.max_baseline,
        );
    }
    for (between, a, b) in pairs {
        ask(
            "triple.turn_tolerance",
            between,
            turn(a, b),
            triple.turn_tolerance,
        );
    }
    if way(first, middle) >= MIN_BASELINE && way(middle, last) >= MIN_BASELINE {
        let towards = |a: &Arc, b: &Arc| direction(b.center() - a.center());
        let bend = angle_between(towards(first, middle), towards(middle, last));
        ask(
            "triple.bend_tolerance",
            Between::Both,
            bend,
            triple.bend_tolerance,
        );
    }
    broken
}
