//! What really echoed, and what could be seen at all.

mod survey;

use std::collections::BTreeMap;

use serde::Serialize;

use super::matching::{Comparison, LINE_OFFSET, POINT_DISTANCE, compare};
use crate::core::calibrate::change::{configured_delay, nanoseconds};
use crate::core::event::{OdometrySample, RangeReading, Return, SonarId};
use crate::core::geometry::{Pose2, Vec2};
use crate::core::odometry::Track;
use crate::core::replay::Replay;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{Kind, Shape};
use crate::core::truth::{FalseEcho, ReflectorKind};
use crate::core::world::{Reflector, World};
use crate::io::log::truth::RecordedTruth;

/// A wall or point that echoed fewer times than this cannot be asked of a map: a triple has three
/// readings.
pub const VISIBLE: u64 = 3;

/// Standard deviations within which a range agrees with the echo model.
pub const AGREEING_SIGMAS: f64 = 5.0;

/// Metres within which a range always agrees with the echo model: what is left of the world's and
/// the poses' own errors where a driver claims millimetres.
pub const AGREEING_RANGE: f64 = 0.05;

/// What an arc came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A wall or a point of the world.
    Reflector(Reflector),
    /// Something else.
    Other(Other),
}

impl Target {
    /// The word in files: `line`, `point`, `circle`, or why none of them.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reflector(Reflector::Line(_)) => "line",
            Self::Reflector(Reflector::Point(_)) => "point",
            Self::Reflector(Reflector::Circle(_)) => "circle",
            Self::Other(other) => other.name(),
        }
    }

    /// Which wall or which point of the world, from 0.
    pub fn index(self) -> Option<usize> {
        match self {
            Self::Reflector(of) => Some(of.index()),
            Self::Other(_) => None,
        }
    }
}

/// Why an arc came from no wall or point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Other {
    /// The log says that its range was replaced by a random one.
    Outlier,
    /// It says that the sonar heard another one.
    CrossTalk,
    /// It says that the sound came by way of two walls.
    DoubleReflection,
    /// A rough wall, from a place beside the foot of the perpendicular.
    Oblique,
    /// The world has nothing there.
    Nothing,
    /// What the world has there is nearer or farther than the range, beyond the noise.
    Disagrees,
}

impl Other {
    /// Every reason.
    pub const ALL: [Self; 6] = [
        Self::Outlier,
        Self::CrossTalk,
        Self::DoubleReflection,
        Self::Oblique,
        Self::Nothing,
        Self::Disagrees,
    ];

    /// The word in files: `outlier`, `cross-talk`, `double-reflection`, `oblique`, `nothing` or
    /// `disagrees`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Outlier => "outlier",
            Self::CrossTalk => "cross-talk",
            Self::DoubleReflection => "double-reflection",
            Self::Oblique => "oblique",
            Self::Nothing => "nothing",
            Self::Disagrees => "disagrees",
        }
    }
}

/// Why there is no truth to hold a replay against.
#[derive(Debug, thiserror::Error)]
pub enum TruthError {
    /// Nothing says it.
    #[error(
        "{file} carries no truth to evaluate against. Give the walls and points that were there with \
         --truth WORLD.json ({{\"walls\": [[x1,y1,x2,y2], ...], \"points\": [[x,y], ...]}}, metres in the \
         odometry frame), or evaluate a log that `tmam simulate` wrote"
    )]
    None {
        /// The log.
        file: String,
    },
    /// The world in the log is of no use.
    #[error(
        "the world in {file} cannot be used: {problem}. Give the right one with --truth WORLD.json"
    )]
    World {
        /// The log.
        file: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A tolerance that is none.
    #[error("--agree is {value} m; it must be 0 or more")]
    Agreement {
        /// Metres.
        value: f64,
    },
    /// The log says that something echoed which its world does not have.
    #[error(
        "{file} says that {kind} {index} echoed, but its world has {known} of them. Give the world with \
         --truth WORLD.json"
    )]
    NoSuchReflector {
        /// The log.
        file: String,
        /// `wall`, `point` or `pillar`.
        kind: &'static str,
        /// From 0.
        index: usize,
        /// How many there are.
        known: usize,
    },
}

/// Where the truth came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// The log says what echoed at each reading.
    Log,
    /// The echo model at each arc's pose, in a world from a file or the log.
    EchoModel,
}

/// What really echoed.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    world: World,
    recorded: BTreeMap<(i64, SonarId), Target>,
    agreeing_range: f64,
    /// How often each wall and point echoed.
    seen: BTreeMap<Reflector, u64>,
    /// Where the robot was, by stamp; empty where nothing says so.
    poses: Vec<OdometrySample>,
}

/// Where odometry has the world at the first reading of a part of a log: it has drifted until then. `None` of a whole
/// log, whose first pose fixes the world, and where the true poses are not known.
fn at_the_start_of_a_part(replay: &Replay<'_>, poses: &[OdometrySample]) -> Option<Pose2> {
    replay.config().input.start?;
    let first = replay.readings().next()?.stamp_ns;
    let at = |samples| {
        let track = Track::new(samples, &replay.config().frames);
        track.world_from_robot(first).ok()
    };
    let odom_from_robot: Pose2 = at(&replay.log().events.odometry)?;
    Some(odom_from_robot.compose(&at(poses)?.inverse()))
}

impl Truth {
    /// The truth about a log: what it carries itself, or else the echo model in a `given` world.
    ///
    /// A given world that is not the log's own replaces all that the log says. `agreeing_range`
    /// (metres) is [`AGREEING_RANGE`] unless the world's own errors are known.
    ///
    /// # Errors
    /// When there is no truth, or what the log says of it is of no use.
    pub fn new(
        replay: &Replay<'_>,
        recorded: &RecordedTruth,
        given: Option<World>,
        agreeing_range: f64,
    ) -> Result<Self, TruthError> {
        let file = &replay.log().file;
        if !(agreeing_range >= 0.0 && agreeing_range.is_finite()) {
            return Err(TruthError::Agreement {
                value: agreeing_range,
            });
        }
        let own = match (recorded.world(), &given) {
            (Ok(world), _) => world,
            (Err(_), Some(_)) => None,
            (Err(problem), None) => {
                return Err(TruthError::World {
                    file: file.clone(),
                    problem: problem.to_string(),
                });
            }
        };
        let is_own = given.is_none() || given.as_ref() == own;
        let world = given
            .or_else(|| own.cloned())
            .ok_or_else(|| TruthError::None { file: file.clone() })?;
        let mut world = if is_own { world } else { survey::whole(&world) };
        let poses = recorded.poses().iter().map(|pose| (*pose).into());
        let mut poses: Vec<OdometrySample> = poses.collect();
        poses.sort_by_key(|pose| pose.stamp_ns);
        if let Some(odom_from_world) = at_the_start_of_a_part(replay, &poses) {
            world = world.moved(&odom_from_world);
        }
        let mut truth = Self {
            recorded: BTreeMap::new(),
            agreeing_range,
            seen: BTreeMap::new(),
            world,
            poses,
        };
        if is_own {
            truth.take_recorded(replay, recorded)?;
        }
        truth.see(replay);
        Ok(truth)
    }

    /// The same; `None` where nothing says the truth.
    ///
    /// # Errors
    /// When what a log says of it is of no use.
    pub fn if_known(
        replay: &Replay<'_>,
        recorded: &RecordedTruth,
        given: Option<World>,
        agreeing_range: f64,
    ) -> Result<Option<Self>, TruthError> {
        match Self::new(replay, recorded, given, agreeing_range) {
            Ok(truth) => Ok(Some(truth)),
            Err(TruthError::None { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Where the robot was, by stamp; empty where nothing says so.
    pub fn poses(&self) -> &[OdometrySample] {
        &self.poses
    }

    /// Where the truth came from.
    pub fn origin(&self) -> Origin {
        if self.recorded.is_empty() {
            Origin::EchoModel
        } else {
            Origin::Log
        }
    }

    /// Metres within which a range always agrees with the echo model.
    pub fn agreeing_range(&self) -> f64 {
        self.agreeing_range
    }

    /// What an arc came from: as the log says, or else what the echo model has at its pose, if the
    /// range agrees with that.
    pub fn target(&self, arc: &Arc) -> Target {
        match self.recorded.get(&(arc.stamp_ns, arc.id.sonar)) {
            Some(target) => *target,
            None => self.modelled(
                arc.world_from_sensor,
                arc.beam_width,
                arc.range,
                arc.variance,
            ),
        }
    }

    /// How often a wall or point echoed.
    pub fn echoes(&self, reflector: Reflector) -> u64 {
        self.seen.get(&reflector).copied().unwrap_or_default()
    }

    /// The walls, or points, that a feature can be, with how well it fits each and at what cost.
    pub fn candidates(&self, shape: &Shape) -> impl Iterator<Item = (Reflector, Comparison, f64)> {
        let ends = match shape {
            Shape::Line(segment) => segment.ends(),
            Shape::Point(point) => [point.position; 2],
            Shape::Circle(circle) => [circle.center; 2],
        };
        let is_near = move |reflector: &Reflector| {
            let there = match reflector {
                Reflector::Line(index) => {
                    let wall = self.world.walls().get(*index);
                    wall.map(|wall| [wall.start, wall.end])
                }
                Reflector::Point(index) => self.world.points().get(*index).map(|p| [*p; 2]),
                Reflector::Circle(index) => {
                    let pillar = self.world.pillars().get(*index);
                    pillar.map(|pillar| [pillar.center; 2])
                }
            };
            there.is_some_and(|there| boxes_meet(ends, there))
        };
        let near = self.reflectors(shape.kind()).into_iter().filter(is_near);
        near.filter_map(|reflector| {
            let comparison = compare(shape, reflector, &self.world)?;
            Some((reflector, comparison, comparison.cost?))
        })
    }

    /// Every wall, or point, of the world.
    pub fn reflectors(&self, kind: Kind) -> Vec<Reflector> {
        match kind {
            Kind::Line => (0..self.world.walls().len()).map(Reflector::Line).collect(),
            Kind::Point => (0..self.world.points().len())
                .map(Reflector::Point)
                .collect(),
            Kind::Circle => (0..self.world.pillars().len())
                .map(Reflector::Circle)
                .collect(),
        }
    }

    /// Whether a wall or point echoed often enough to be asked of a map.
    pub fn is_visible(&self, reflector: Reflector) -> bool {
        self.echoes(reflector) >= VISIBLE
    }

    fn modelled(
        &self,
        world_from_sensor: Pose2,
        beam_width: f64,
        range: f64,
        variance: f64,
    ) -> Target {
        let agreeing = (AGREEING_SIGMAS * variance.max(0.0).sqrt()).max(self.agreeing_range);
        match self
            .world
            .echo(world_from_sensor, beam_width, f64::INFINITY)
        {
            None => Target::Other(Other::Nothing),
            Some(echo) if (echo.range - range).abs() <= agreeing && echo.oblique => {
                Target::Other(Other::Oblique)
            }
            Some(echo) if (echo.range - range).abs() <= agreeing => {
                Target::Reflector(echo.reflector)
            }
            Some(_) => Target::Other(Other::Disagrees),
        }
    }

    fn take_recorded(
        &mut self,
        replay: &Replay<'_>,
        recorded: &RecordedTruth,
    ) -> Result<(), TruthError> {
        let log = replay.log();
        let sonars = log.events.sonars.iter().zip(0_u16..);
        let ids: BTreeMap<&str, SonarId> = sonars
            .map(|(sonar, id)| (sonar.name.as_str(), SonarId(id)))
            .collect();
        for truth in recorded.readings() {
            let Some(sonar) = ids.get(truth.sonar.as_str()) else {
                continue;
            };
            let target = match truth.reflector() {
                _ if truth.outlier => Target::Other(Other::Outlier),
                _ if truth.false_echo == Some(FalseEcho::CrossTalk) => {
                    Target::Other(Other::CrossTalk)
                }
                _ if truth.false_echo == Some(FalseEcho::DoubleReflection) => {
                    Target::Other(Other::DoubleReflection)
                }
                None => Target::Other(Other::Nothing),
                Some(reflector) => {
                    self.check(reflector, &log.file)?;
                    match truth.kind {
                        Some(ReflectorKind::Oblique) => Target::Other(Other::Oblique),
                        _ => Target::Reflector(reflector),
                    }
                }
            };
            // The replay has its stamps put right.
            let delay_ns = nanoseconds(configured_delay(replay.config(), &truth.sonar));
            let stamp_ns = truth.stamp_ns.saturating_sub(delay_ns);
            self.recorded.insert((stamp_ns, *sonar), target);
        }
        Ok(())
    }

    fn check(&self, reflector: Reflector, file: &str) -> Result<(), TruthError> {
        let (kind, index, known) = match reflector {
            Reflector::Line(index) => ("wall", index, self.world.walls().len()),
            Reflector::Point(index) => ("point", index, self.world.points().len()),
            Reflector::Circle(index) => ("pillar", index, self.world.pillars().len()),
        };
        if index < known {
            return Ok(());
        }
        Err(TruthError::NoSuchReflector {
            file: file.to_owned(),
            kind,
            index,
            known,
        })
    }

    /// Counts how often each wall and point echoed, over every reading: what could be seen does
    /// not depend on the frames that a configuration makes of them.
    fn see(&mut self, replay: &Replay<'_>) {
        let setting = replay.setting();
        let track = Track::of_ranges(&replay.log().events.odometry, setting.config);
        let echoes = replay
            .readings()
            .filter(|reading| reading.classify() == Return::Echo);
        for reading in echoes {
            if let Some(Target::Reflector(of)) = self.reading_target(replay, &track, &reading) {
                *self.seen.entry(of).or_default() += 1;
            }
        }
    }

    /// What a reading came from; `None` where it has no pose.
    fn reading_target(
        &self,
        replay: &Replay<'_>,
        track: &Track<'_>,
        reading: &RangeReading,
    ) -> Option<Target> {
        let setting = replay.setting();
        let sonar = setting.sonars.get(reading.sonar.index())?;
        let world_from_robot = track.world_from_robot_at(reading).ok()?;
        if let Some(target) = self.recorded.get(&(reading.stamp_ns, reading.sonar)) {
            return Some(*target);
        }
        let noise = &setting.config.noise;
        Some(self.modelled(
            world_from_robot.compose(&sonar.robot_from_sensor),
            reading.beam_width,
            reading.range,
            noise.variance(reading.range, reading.variance),
        ))
    }
}

/// Whether the boxes around two spans are so near to each other that these can match.
fn boxes_meet(a: [Vec2; 2], b: [Vec2; 2]) -> bool {
    const MARGIN: f64 = 2.0 * LINE_OFFSET.max(POINT_DISTANCE);
    let ([a, b], [c, d]) = (a, b);
    let apart = (a.inf(&b) - c.sup(&d)).sup(&(c.inf(&d) - a.sup(&b)));
    apart.max() <= MARGIN
}

#[cfg(test)]
mod tests;
