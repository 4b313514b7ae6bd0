//! Groups readings into frames: one step of the replay, at most one reading per sonar.

use std::collections::BTreeMap;

use nalgebra::Matrix3;

use crate::core::config;
use crate::core::event::{RangeReading, Return, Sonar, SonarId};
use crate::core::geometry::{Pose2, angle_between};
use crate::core::odometry::Track;
use crate::core::ties;

/// One step of the replay.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Counts from 0, at the first reading of the log.
    pub index: u32,
    /// Stamp of the reading that opened the frame.
    pub stamp_ns: i64,
    /// The robot at that stamp.
    pub world_from_robot: Pose2,
    /// What was corrected, where the pose is not odometry's own.
    pub correction: Option<Box<Correction>>,
    /// What each sonar gave, sorted by sonar; a sonar that did not fire has no entry.
    pub entries: Vec<Entry>,
}

/// A pose of odometry that was corrected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correction {
    /// The robot as odometry has it.
    pub odom_from_robot: Pose2,
    /// Covariance of the corrected pose over (x, y, yaw) in the world.
    pub covariance: Matrix3<f64>,
}

/// The one reading that a sonar gives a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Which sonar.
    pub sonar: SonarId,
    /// When it was taken.
    pub stamp_ns: i64,
    /// The sensor at that stamp.
    pub world_from_sensor: Pose2,
    /// By how much the sensor may be off along its axis that poses beside it are not: variance, square metres.
    pub pose_variance: f64,
    /// Full opening angle of the beam, radians.
    pub beam_width: f64,
    /// What came back; `None` where nothing echoed.
    pub echo: Option<Echo>,
}

/// What came back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Echo {
    /// Measured distance, metres.
    pub range: f64,
    /// Its variance as the driver reports it, square metres; 0 where it does not.
    pub variance: f64,
}

/// Groups readings into frames. Takes them in stamp order, ties by sonar.
#[derive(Debug)]
pub struct Framer<'a> {
    track: Track<'a>,
    /// Where among its samples the last reading was.
    near: usize,
    sonars: &'a [Sonar],
    selected: &'a [bool],
    step: f64,
    step_angle: f64,
    open: Option<Frame>,
    next_index: u32,
    tally: Tally,
}

/// What became of the readings.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tally {
    /// Readings that were taken in.
    pub readings: u64,
    /// Echoes among them, with a pose.
    pub echoes: u64,
    /// Readings with a pose in which nothing echoed.
    pub no_echoes: u64,
    /// Readings that could not be used, by reason.
    pub dropped: BTreeMap<&'static str, u64>,
    /// Echoes and no-echoes that a frame had no room for: the sonar had given it its reading.
    pub surplus: u64,
}

impl<'a> Framer<'a> {
    /// A framer that has seen nothing yet. Every sonar opens frames, and those `selected` (one
    /// flag for each sonar) have entries in them.
    pub fn new(
        track: Track<'a>,
        sonars: &'a [Sonar],
        selected: &'a [bool],
        bounds: &config::Frames,
    ) -> Self {
        Self {
            track,
            near: 0,
            sonars,
            selected,
            step: bounds.step,
            step_angle: bounds.step_angle,
            open: None,
            next_index: 0,
            tally: Tally::default(),
        }
    }

    /// Takes the next reading; returns the frame that it closed by opening another.
    pub fn push(&mut self, reading: &RangeReading) -> Option<Frame> {
        let selected = self.selected.get(reading.sonar.index()) == Some(&true);
        self.tally.readings += u64::from(selected);
        let world_from_robot = match (self.track).world_from_robot_next(reading, &mut self.near) {
            Ok(pose) => pose,
            Err(reason) => {
                if selected {
                    *self.tally.dropped.entry(reason.name()).or_default() += 1;
                }
                return None;
            }
        };
        let closed = self.advance(reading.stamp_ns, &world_from_robot);
        if selected {
            self.enter(reading, &world_from_robot);
        }
        closed
    }

    /// Lets a reading before those that are asked for pass, so that frames have the numbers of the whole run; returns
    /// the frame that it closed.
    pub fn pass(&mut self, reading: &RangeReading) -> Option<Frame> {
        let world_from_robot = self.track.world_from_robot_at(reading).ok()?;
        self.advance(reading.stamp_ns, &world_from_robot)
    }

    /// Opens a frame at this stamp and pose, if it is time; returns the one that was open.
    fn advance(&mut self, stamp_ns: i64, world_from_robot: &Pose2) -> Option<Frame> {
        if !self.opens(stamp_ns, world_from_robot) {
            return None;
        }
        let index = self.next_index;
        self.next_index += 1;
        self.open.replace(Frame {
            index,
            stamp_ns,
            world_from_robot: *world_from_robot,
            correction: None,
            entries: Vec::new(),
        })
    }

    /// The last frame, and what became of the readings.
    pub fn finish(self) -> (Option<Frame>, Tally) {
        (self.open, self.tally)
    }

    fn opens(&self, stamp_ns: i64, world_from_robot: &Pose2) -> bool {
        let Some(open) = &self.open else {
            return true;
        };
        if self.step == 0.0 {
            return stamp_ns != open.stamp_ns;
        }
        let opened = &open.world_from_robot;
        let step = (world_from_robot.position() - opened.position()).norm();
        let turn = angle_between(world_from_robot.yaw, opened.yaw);
        // Robots that stop every 0.1 m stop at multiples of it.
        ties::at_least(step, self.step, ties::LENGTH)
            || ties::at_least(turn, self.step_angle, ties::ANGLE)
    }

    /// Gives the open frame the sonar's first echo, or, failing that, its first no-echo.
    fn enter(&mut self, reading: &RangeReading, world_from_robot: &Pose2) {
        let echo = match reading.classify() {
            Return::Echo => {
                self.tally.echoes += 1;
                Some(Echo {
                    range: reading.range,
                    variance: reading.variance,
                })
            }
            Return::NoEcho => {
                self.tally.no_echoes += 1;
                None
            }
            Return::Invalid => {
                *self.tally.dropped.entry("invalid").or_default() += 1;
                return;
            }
        };
        let (Some(frame), Some(sonar)) = (&mut self.open, self.sonars.get(reading.sonar.index()))
        else {
            return;
        };
        let entry = Entry {
            pose_variance: 0.0,
            sonar: reading.sonar,
            stamp_ns: reading.stamp_ns,
            world_from_sensor: world_from_robot.compose(&sonar.robot_from_sensor),
            beam_width: reading.beam_width,
            echo,
        };
        match frame
            .entries
            .binary_search_by_key(&reading.sonar, |e| e.sonar)
        {
            Err(place) => frame.entries.insert(place, entry),
            Ok(place) => match frame.entries.get_mut(place) {
                Some(held) if held.echo.is_none() && entry.echo.is_some() => {
                    *held = entry;
                    self.tally.surplus += 1;
                }
                _ => self.tally.surplus += 1,
            },
        }
    }
}

#[cfg(test)]
mod tests;
