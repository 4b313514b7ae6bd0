//! Driving without stopping, while one sonar fires at a time.

use crate::core::geometry::{Pose2, wrap_angle};
use crate::io::log::writer::Twist;

use super::motion::{Action, ROUNDING, Tick, limit, nanoseconds};
use super::path::Segment;
use super::ring::firing_order;
use super::{Path, SimulateError, positive, require};

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
        }
    }
}

impl Driving {
    /// See [`Motion::schedule`](super::Motion::schedule).
    pub(super) fn schedule(&self, path: &Path, sonars: usize) -> Result<Vec<Tick>, SimulateError> {
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
        let legs = self.legs(path);
        let duration: f64 = legs.iter().map(|leg| leg.duration).sum();
        limit(duration / self.firing_interval)?;
        limit(duration * self.odometry_rate)?;

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
        let mut legs: Vec<Leg> = Vec::new();
        let mut heading = None;
        let mut begin = 0.0;
        let mut push = |way: Way, duration: f64| {
            legs.push(Leg {
                begin,
                duration,
                way,
            });
            begin += duration;
        };
        for segment in path.segments() {
            let angle = heading.map_or(0.0, |from: f64| wrap_angle(segment.start.yaw - from));
            if angle.abs() > MIN_TURN {
                let turn = Way::Turn {
                    to: segment.start,
                    angle,
                };
                push(turn, angle.abs() / self.turn_rate);
            }
            push(Way::Straight(*segment), segment.length / self.speed);
            heading = Some(segment.start.yaw);
        }
        legs
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
    let (pose, moving) = match &leg.way {
        Way::Turn { to, angle } => {
            let pose = Pose2::new(to.x, to.y, to.yaw - angle * (1.0 - share));
            let twist = Twist {
                linear: 0.0,
                angular: angle / leg.duration,
            };
            (pose, twist)
        }
        Way::Straight(segment) => {
            let twist = Twist {
                linear: segment.length / leg.duration,
                angular: 0.0,
            };
            (segment.at(share * segment.length), twist)
        }
    };
    (pose, if over { Twist::default() } else { moving })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::{Vec2, angle_between};
    use crate::tools::simulate::motion::tests::{line, shots};

    #[test]
    fn a_drive_is_steady_and_sonars_take_turns() {
        let driving = Driving::default();
        let ticks = driving.schedule(&Path::room(), 16).unwrap();
        let shots = shots(&ticks);
        assert_eq!(
            shots.len(),
            2857,
            "100 s (18 m at 0.2 m/s and five quarter turns of 2 s) of 35 ms"
        );
        assert_eq!(
            shots[..3],
            [(17_500_000, 0), (52_500_000, 8), (87_500_000, 4)]
        );
        for (one, two) in ticks.iter().zip(ticks.iter().skip(1)) {
            let seconds = (two.after_ns - one.after_ns) as f64 * 1e-9;
            let (a, b) = (one.world_from_robot, two.world_from_robot);
            let driven = (a.position() - b.position()).norm();
            assert!(driven <= driving.speed * seconds + 1e-9);
            assert!(angle_between(a.yaw, b.yaw) <= driving.turn_rate * seconds + 1e-9);
        }
    }

    #[test]
    fn odometry_brackets_every_shot() {
        let driving = Driving {
            speed: 0.37,
            ..Driving::default()
        };
        let ticks = driving.schedule(&line(1.0), 3).unwrap();
        let (first, last) = (ticks.first().unwrap(), ticks.last().unwrap());
        assert!(matches!(first.action, Action::Odometry(_)));
        assert_eq!(last.action, Action::Odometry(Twist::default()));
        assert_eq!(last.world_from_robot, Pose2::new(1.0, 0.0, 0.0));
    }

    #[test]
    fn a_turn_goes_the_short_way() {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, -1.0), (2.0, -1.0)];
        let path = Path::new(&corners.map(|(x, y)| Vec2::new(x, y))).unwrap();
        let legs = Driving::default().legs(&path);
        let angles = legs.iter().filter_map(|leg| match leg.way {
            Way::Turn { angle, .. } => Some(angle.to_degrees()),
            Way::Straight(_) => None,
        });
        let angles: Vec<_> = angles.map(|angle| angle.round()).collect();
        assert_eq!(angles, [-90.0, 90.0]);
    }

    #[test]
    fn what_cannot_be_driven_is_refused() {
        let good = Driving::default();
        for bad in [
            Driving { speed: 0.0, ..good },
            Driving {
                speed: 1e-300,
                ..good
            },
            Driving {
                turn_rate: f64::NAN,
                ..good
            },
            Driving {
                firing_interval: 0.0,
                ..good
            },
            Driving {
                odometry_rate: 1e9,
                ..good
            },
        ] {
            assert!(bad.schedule(&Path::room(), 16).is_err(), "{bad:?}");
        }
    }
}
