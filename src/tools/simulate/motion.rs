//! When odometry is sampled and sonars fire, and where the robot is then.

use std::f64::consts::TAU;

use crate::core::geometry::{Pose2, wrap_angle};
use crate::io::log::writer::Twist;

use super::error::{SimulateError, positive, require};
use super::path::{Path, Segment};
use super::ring::firing_order;

/// The most readings that a log may hold.
const MAX_READINGS: usize = 6_000_000;

/// Slack for a whole number of periods or steps that rounding has made a little short.
const ROUNDING: f64 = 1e-9;

/// How the robot moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// It stops, all sonars fire, it goes on.
    Stepwise(Stepwise),
    /// It drives without stopping while one sonar fires at a time.
    Driving(Driving),
}

/// Something to log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tick {
    /// Nanoseconds from the start.
    pub after_ns: i64,
    /// Where the robot really is.
    pub world_from_robot: Pose2,
    /// What happens.
    pub action: Action,
}

/// What happens at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Odometry is sampled at this velocity.
    Odometry(Twist),
    /// A sonar fires.
    Fire(usize),
}

impl Motion {
    /// All ticks along `path` in time order, odometry before the shots of its instant.
    pub fn schedule(&self, path: &Path, sonars: usize) -> Result<Vec<Tick>, SimulateError> {
        match self {
            Self::Stepwise(stepwise) => stepwise.schedule(path, sonars),
            Self::Driving(driving) => driving.schedule(path, sonars),
        }
    }
}

/// Seconds to the nearest nanosecond.
fn nanoseconds(seconds: f64) -> i64 {
    libm::round(seconds * 1e9) as i64
}

/// Refuses a log of too many readings.
fn limit(readings: f64) -> Result<(), SimulateError> {
    let refused = || SimulateError::TooLong {
        readings,
        limit: MAX_READINGS,
    };
    // Not `>`, which NaN and so an endless path would pass.
    let fits = readings <= MAX_READINGS as f64;
    fits.then_some(()).ok_or_else(refused)
}

/// Stop and go: all sonars fire at each stop, which has one stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stepwise {
    /// Between stops along the path, metres.
    pub step: f64,
    /// How many stops; none for as many as the path has, a closed one once round.
    pub steps: Option<usize>,
    /// Between the instants at which all sonars fire, seconds.
    pub interval: f64,
    /// The robot turns once round at each stop, and all sonars fire after each turn by this, radians.
    pub scan: Option<f64>,
}

/// Twelve centimetres, which takes the paper's room in its 150 steps.
impl Default for Stepwise {
    fn default() -> Self {
        Self {
            step: 0.12,
            steps: None,
            interval: 0.4,
            scan: None,
        }
    }
}

impl Stepwise {
    fn schedule(&self, path: &Path, sonars: usize) -> Result<Vec<Tick>, SimulateError> {
        positive("the step in metres", self.step)?;
        positive("the time between steps in seconds", self.interval)?;
        let length = path.length();
        let fitting = length / self.step + ROUNDING;
        if let Some(scan) = self.scan {
            positive(
                "the turn between the shots of a scan in degrees",
                scan.to_degrees(),
            )?;
        }
        let shots = self
            .scan
            .map_or(1.0, |scan| libm::floor(TAU / scan + ROUNDING).max(1.0));
        limit(self.steps.map_or(fitting, |steps| steps as f64) * shots * sonars as f64)?;
        // A closed path ends on its first place, which then is not visited twice.
        let most = libm::floor(fitting) as usize + usize::from(!path.is_closed());
        let steps = match self.steps {
            None => most.max(1),
            Some(steps) if steps > most && !path.is_closed() => {
                return Err(SimulateError::PathTooShort {
                    steps,
                    step: self.step,
                    length,
                    most,
                });
            }
            Some(steps) => steps,
        };
        require(steps > 0, "the number of steps", 0.0, "1 or more")?;

        let shots = shots as usize;
        let turned = |shot: usize| self.scan.unwrap_or_default() * shot as f64;
        let instants = (0..steps).flat_map(|step| (0..shots).map(move |shot| (step, shot)));
        let ticks = instants.enumerate().flat_map(|(instant, (step, shot))| {
            let stop = path.at(step as f64 * self.step);
            let tick = Tick {
                after_ns: nanoseconds(instant as f64 * self.interval),
                world_from_robot: Pose2::new(stop.x, stop.y, stop.yaw + turned(shot)),
                action: Action::Odometry(Twist::default()),
            };
            let shots = (0..sonars).map(move |sonar| Tick {
                action: Action::Fire(sonar),
                ..tick
            });
            std::iter::once(tick).chain(shots)
        });
        Ok(ticks.collect())
    }
}

/// A way-point at which the heading changes less than this needs no turn, radians.
const MIN_TURN: f64 = 1e-9;

/// Driving: straight from way-point to way-point, turning in place between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Driving {
    /// Metres per second.
    pub speed: f64,
    /// Radians per second.
    pub turn_rate: f64,
    /// From one sonar's shot to the next one's, seconds.
    pub firing_interval: f64,
    /// Odometry samples per second.
    pub odometry_rate: f64,
    /// How long it drives, round and round on a closed path, seconds; none for once along the path.
    pub duration: Option<f64>,
}

/// Each of sixteen sonars fires every 12.8 cm, and in the built-in room every turn begins and
/// ends at an odometry sample, so that interpolation cuts no corner.
impl Default for Driving {
    fn default() -> Self {
        Self {
            speed: 0.2,
            turn_rate: std::f64::consts::FRAC_PI_4,
            firing_interval: 0.035,
            odometry_rate: 20.0,
            duration: None,
        }
    }
}

impl Driving {
    fn schedule(&self, path: &Path, sonars: usize) -> Result<Vec<Tick>, SimulateError> {
        positive("the speed in metres per second", self.speed)?;
        positive(
            "the turn rate in degrees per second",
            self.turn_rate.to_degrees(),
        )?;
        require(
            self.firing_interval >= 1e-6 && self.firing_interval.is_finite(),
            "the firing interval in seconds",
            self.firing_interval,
            "1e-6 or more",
        )?;
        require(
            self.odometry_rate > 0.0 && self.odometry_rate <= 1000.0,
            "the odometry rate in hertz",
            self.odometry_rate,
            "above 0 and at most 1000",
        )?;
        let mut legs = self.legs(path);
        let once: f64 = legs.iter().map(|leg| leg.duration).sum();
        let duration = self.duration.unwrap_or(once);
        positive("the time to drive in seconds", duration)?;
        limit(duration / self.firing_interval)?;
        limit(duration * self.odometry_rate)?;
        if duration > once {
            let laps = libm::ceil(duration / once);
            let most = f64::from(u16::MAX);
            require(laps <= most, "the number of laps", laps, "65535 or less")?;
            legs = self.legs(&path.clone().repeated(laps as u16)?);
        }

        let period = 1.0 / self.odometry_rate;
        let samples = libm::floor(duration / period + ROUNDING) as usize;
        let mut times: Vec<_> = (0..=samples).map(|i| i as f64 * period).collect();
        // The last sample closes the bracket of the last shots.
        if times.last().is_some_and(|last| duration - last > ROUNDING) {
            times.push(duration);
        }
        let odometry = times.into_iter().map(|seconds| {
            let (world_from_robot, twist) = at(&legs, seconds);
            Tick {
                after_ns: nanoseconds(seconds),
                world_from_robot,
                action: Action::Odometry(twist),
            }
        });

        let order = firing_order(sonars);
        let shots = order.iter().cycle().enumerate();
        let shots = shots.map(|(shot, sonar)| ((shot as f64 + 0.5) * self.firing_interval, sonar));
        let shots = shots.take_while(|(seconds, _)| *seconds < duration - ROUNDING);
        let shots = shots.map(|(seconds, sonar)| Tick {
            after_ns: nanoseconds(seconds),
            world_from_robot: at(&legs, seconds).0,
            action: Action::Fire(*sonar),
        });

        let mut ticks: Vec<_> = odometry.chain(shots).collect();
        ticks.sort_by_key(|tick| tick.after_ns);
        Ok(ticks)
    }

    /// The path as legs: each way-point's turn, if it has one, then the straight piece after it.
    fn legs(&self, path: &Path) -> Vec<Leg> {
        let mut ways = Vec::new();
        let mut heading = None;
        for segment in path.segments() {
            let to = segment.start;
            let angle = heading.map_or(0.0, |from: f64| wrap_angle(to.yaw - from));
            if angle.abs() > MIN_TURN {
                ways.push((Way::Turn { to, angle }, angle.abs() / self.turn_rate));
            }
            ways.push((Way::Straight(*segment), segment.length / self.speed));
            heading = Some(to.yaw);
        }
        let mut begin = 0.0;
        let leg = |(way, duration)| {
            let leg = Leg {
                begin,
                duration,
                way,
            };
            begin += duration;
            leg
        };
        ways.into_iter().map(leg).collect()
    }
}

/// A piece of the drive at constant speed.
struct Leg {
    /// Seconds from the start.
    begin: f64,
    /// Seconds.
    duration: f64,
    way: Way,
}

enum Way {
    /// In place by `angle` to the heading of `to`.
    Turn {
        to: Pose2,
        angle: f64,
    },
    Straight(Segment),
}

/// Where the robot is and how fast it moves, `seconds` from the start; at the end it stands.
fn at(legs: &[Leg], seconds: f64) -> (Pose2, Twist) {
    let begun = legs.partition_point(|leg| leg.begin <= seconds + ROUNDING);
    let Some(leg) = begun.checked_sub(1).and_then(|index| legs.get(index)) else {
        return (Pose2::IDENTITY, Twist::default());
    };
    let share = ((seconds - leg.begin) / leg.duration).clamp(0.0, 1.0);
    let over = begun == legs.len() && seconds >= leg.begin + leg.duration - ROUNDING;
    let (pose, linear, angular) = match &leg.way {
        Way::Turn { to, angle } => {
            let yaw = to.yaw - angle * (1.0 - share);
            (Pose2::new(to.x, to.y, yaw), 0.0, angle / leg.duration)
        }
        Way::Straight(segment) => {
            let pose = segment.at(share * segment.length);
            (pose, segment.length / leg.duration, 0.0)
        }
    };
    let moving = Twist { linear, angular };
    (pose, if over { Twist::default() } else { moving })
}

#[cfg(test)]
mod tests;
