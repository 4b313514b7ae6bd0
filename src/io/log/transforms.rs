//! Where the sonars sit: the tree of transforms between frames.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Vector3};

use super::message::{FARTHEST, TransformMessage};
use crate::core::config::SonarOverride;
use crate::core::geometry::Pose2;

/// A sonar tilted more than this out of the plane is worth a word, radians.
const TILT: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Every edge of the transform tree, by child frame.
#[derive(Debug, Clone, Default)]
pub struct TransformTree {
    edges: BTreeMap<String, Edge>,
    /// How often the transform of a frame was no pose.
    unusable: BTreeMap<String, u64>,
    /// Transforms whose quaternion is zero, of frames that have no other: the first.
    unturned: BTreeMap<String, Edge>,
}

/// No robot has more frames; further ones are passed over.
const MOST_FRAMES: usize = 10_000;

#[derive(Debug, Clone)]
struct Edge {
    parent: String,
    parent_from_child: Isometry3<f64>,
    origin: Origin,
    moved: bool,
    rival: Option<Rival>,
}

/// What else is said of the transform of a frame, as by another publisher.
#[derive(Debug, Clone)]
struct Rival {
    parent: String,
    parent_from_child: Isometry3<f64>,
    /// How often what is said goes from one to the other.
    turns: u64,
    /// Whether it was said last.
    is_last: bool,
    /// Whether something else is said as well.
    is_of_many: bool,
}

impl Edge {
    fn says(&self, parent: &str, parent_from_child: &Isometry3<f64>) -> bool {
        self.parent == parent && is_near(&self.parent_from_child, parent_from_child)
    }

    /// Hears the same frame again; whether something else is said of it.
    fn hear(&mut self, parent: &str, parent_from_child: &Isometry3<f64>) -> bool {
        let is_other = !self.says(parent, parent_from_child);
        match &mut self.rival {
            Some(rival) => {
                rival.turns += u64::from(rival.is_last != is_other);
                rival.is_last = is_other;
                let is_new = is_other
                    && !(rival.parent == parent
                        && is_near(&rival.parent_from_child, parent_from_child));
                if is_new {
                    parent.clone_into(&mut rival.parent);
                    rival.parent_from_child = *parent_from_child;
                    rival.is_of_many = true;
                }
            }
            None if is_other => {
                self.rival = Some(Rival {
                    parent: parent.to_owned(),
                    parent_from_child: *parent_from_child,
                    turns: 1,
                    is_last: true,
                    is_of_many: false,
                });
            }
            None => {}
        }
        is_other
    }

    /// Puts what was said last in the place of what was said before.
    fn follow(&mut self, origin: Origin) {
        self.origin = origin;
        if let Some(rival) = &mut self.rival {
            std::mem::swap(&mut self.parent, &mut rival.parent);
            std::mem::swap(&mut self.parent_from_child, &mut rival.parent_from_child);
            rival.is_last = false;
        }
    }

    /// What contradicts it: a fixed transform has one place, and what goes to and fro between two of them does not move.
    fn contradicted(&self) -> Option<&Rival> {
        const IN_TURN: u64 = 3;
        self.rival.as_ref().filter(|rival| {
            self.origin == Origin::Fixed || (rival.turns >= IN_TURN && !rival.is_of_many)
        })
    }
}

/// Whether two transforms are the same, but for what a publisher rounds.
fn is_near(one: &Isometry3<f64>, other: &Isometry3<f64>) -> bool {
    let change = one.inv_mul(other);
    change.translation.vector.norm() <= 1e-3 && change.rotation.imag().norm() <= 1e-3
}

/// Where a transform comes from; a later one stands before an earlier.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Origin {
    /// The robot's description.
    Description,
    /// `/tf`.
    Moving,
    /// `/tf_static`.
    Fixed,
}

/// Where a sensor sits on the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount {
    /// Projected on the plane: the beam axis is the sensor's x axis.
    pub robot_from_sensor: Pose2,
    /// Angle of the beam axis out of the plane, radians, where it is worth a word.
    pub tilt: Option<f64>,
    /// A transform on the way comes from `/tf` and changed during the log; its first value is
    /// taken.
    pub moved: bool,
}

/// Why a mount cannot be told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoMount {
    /// No chain of transforms joins the two frames.
    Unconnected,
    /// The beam points straight up or down.
    Vertical,
    /// The transforms, each of which may be a place, lead to none.
    Far,
}

impl Mount {
    /// The same with what the configuration says of it instead.
    pub fn overridden(self, known: &SonarOverride) -> Self {
        let found = self.robot_from_sensor;
        let robot_from_sensor = Pose2::new(
            known.x.unwrap_or(found.x),
            known.y.unwrap_or(found.y),
            known.yaw.unwrap_or(found.yaw),
        );
        Self {
            robot_from_sensor,
            ..self
        }
    }

    /// A mount that does not move, laid into the plane.
    ///
    /// # Errors
    /// When the beam is vertical.
    pub fn projected(robot_from_beam: &Isometry3<f64>) -> Result<Self, NoMount> {
        let axis = robot_from_beam.rotation * Vector3::x();
        if axis.xy().norm() < 1e-6 {
            return Err(NoMount::Vertical);
        }
        let position = robot_from_beam.translation.vector;
        if !position.iter().all(|x| x.abs() <= FARTHEST) {
            return Err(NoMount::Far);
        }
        let tilt = libm::atan2(axis.z, axis.xy().norm());
        Ok(Self {
            robot_from_sensor: Pose2::new(position.x, position.y, libm::atan2(axis.y, axis.x)),
            tilt: (tilt.abs() > TILT).then_some(tilt),
            moved: false,
        })
    }
}

impl TransformTree {
    /// Takes a transform. Among those from `/tf` the first counts, else the last.
    pub fn add(&mut self, transform: TransformMessage<'_>, origin: Origin) {
        let frames = self.edges.len() + self.unusable.len();
        let known = self.edges.get_mut(&*transform.child);
        if known.is_none() && frames >= MOST_FRAMES {
            return;
        }
        let is_unturned = transform.is_unturned();
        let Some(parent_from_child) = transform.parent_from_child.filter(|_| !is_unturned) else {
            let child = transform.child.into_owned();
            if let Some(parent_from_child) = transform.parent_from_child {
                self.unturned.entry(child.clone()).or_insert(Edge {
                    parent: transform.parent.into_owned(),
                    parent_from_child,
                    origin,
                    moved: false,
                    rival: None,
                });
            }
            *self.unusable.entry(child).or_default() += 1;
            return;
        };
        match known {
            // A description says how a robot was meant to be.
            Some(known) if origin == Origin::Description && known.origin > origin => {}
            Some(known)
                if known.origin > origin || origin == Origin::Moving && known.origin == origin =>
            {
                let is_other = known.hear(&transform.parent, &parent_from_child);
                known.moved |= is_other && known.origin == Origin::Moving;
            }
            Some(known) if known.origin != Origin::Description && origin == Origin::Fixed => {
                if known.hear(&transform.parent, &parent_from_child) {
                    known.follow(origin);
                }
                known.origin = origin;
                known.moved = false;
            }
            _ => {
                let edge = Edge {
                    parent: transform.parent.into_owned(),
                    parent_from_child,
                    origin,
                    moved: false,
                    rival: None,
                };
                self.edges.insert(transform.child.into_owned(), edge);
            }
        }
    }

    /// Takes the transforms of frames that are not known yet; whether those of known ones say something else.
    pub fn join(&mut self, other: Self) -> bool {
        let mut differs = false;
        for (child, edge) in other.edges {
            match self.edges.get(&child) {
                Some(known) => {
                    differs |= known.parent != edge.parent
                        || known.parent_from_child != edge.parent_from_child;
                }
                None if self.edges.len() >= MOST_FRAMES => {}
                None => {
                    self.edges.insert(child, edge);
                }
            }
        }
        for (child, edge) in other.unturned {
            self.unturned.entry(child).or_insert(edge);
        }
        for (child, count) in other.unusable {
            *self.unusable.entry(child).or_default() += count;
        }
        differs
    }

    /// With the transforms whose quaternion is zero taken for frames that are not turned; `None` where there are none.
    pub fn with_unturned(&self) -> Option<Self> {
        let is_lacking = |child: &String| !self.edges.contains_key(child);
        if !self.unturned.keys().any(is_lacking) {
            return None;
        }
        let mut taken = self.clone();
        for (child, edge) in self.unturned.iter().filter(|(child, _)| is_lacking(child)) {
            taken.edges.insert(child.clone(), edge.clone());
            taken.unusable.remove(child);
        }
        Some(taken)
    }

    /// The frames of which that is so.
    pub fn unturned(&self) -> impl Iterator<Item = &str> {
        let frames = self.unturned.keys().map(String::as_str);
        frames
            .filter(|frame| self.edges.contains_key(*frame) && !self.unusable.contains_key(*frame))
    }

    /// With what else is said of frames whose transforms are contradicted; `None` where none are.
    pub fn with_rivals(&self) -> Option<Self> {
        let is_contradicted = |edge: &Edge| edge.contradicted().is_some();
        if !self.edges.values().any(is_contradicted) {
            return None;
        }
        let mut other = self.clone();
        for edge in other
            .edges
            .values_mut()
            .filter(|edge| is_contradicted(edge))
        {
            edge.follow(edge.origin);
        }
        Some(other)
    }

    /// The frame on the way from a sensor's to the robot's of which two things are said, and how often what is said goes
    /// from one to the other.
    pub fn contradicted(&self, sensor_frame: &str, robot_frame: &str) -> Option<(&str, u64)> {
        let line = self.ancestry(sensor_frame).into_iter();
        let mut below = line.take_while(|ancestor| ancestor.frame != robot_frame);
        below.find_map(|ancestor| {
            let (frame, edge) = self.edges.get_key_value(ancestor.frame)?;
            Some((frame.as_str(), edge.contradicted()?.turns))
        })
    }

    /// What a person is told of transforms that are none.
    pub fn note(&self) -> Option<String> {
        let count: u64 = self.unusable.values().sum();
        let mut frames: Vec<String> = self
            .unusable
            .keys()
            .take(4)
            .map(|f| format!("`{f}`"))
            .collect();
        if self.unusable.len() > frames.len() {
            frames.push("others".to_owned());
        }
        (count > 0).then(|| {
            format!(
                "transforms that hold no pose (NaN, farther off than 100,000 km, or a quaternion of zero) were left out: {count}, of {}",
                frames.join(", ")
            )
        })
    }

    /// Whether a frame was only ever given a transform that holds no pose.
    pub fn is_unusable(&self, frame: &str) -> bool {
        self.unusable.contains_key(frame) && !self.edges.contains_key(frame)
    }

    /// Names of all frames.
    pub fn frames(&self) -> Vec<&str> {
        let mut frames: Vec<&str> = self
            .edges
            .iter()
            .flat_map(|(child, edge)| [child.as_str(), edge.parent.as_str()])
            .collect();
        frames.sort_unstable();
        frames.dedup();
        frames
    }

    /// The mount of a beam in a sensor's frame, through the chain of transforms that joins the
    /// frame to the robot.
    ///
    /// # Errors
    /// When no chain does, or the beam is vertical.
    pub fn mount(
        &self,
        robot_frame: &str,
        sensor_frame: &str,
        sensor_from_beam: &Isometry3<f64>,
    ) -> Result<Mount, NoMount> {
        let (robot_from_sensor, moved) = self
            .between(robot_frame, sensor_frame)
            .ok_or(NoMount::Unconnected)?;
        Ok(Mount {
            moved,
            ..Mount::projected(&(robot_from_sensor * sensor_from_beam))?
        })
    }

    /// The pose of a frame in another, and whether it moves.
    pub fn between(&self, target: &str, source: &str) -> Option<(Isometry3<f64>, bool)> {
        let (targets, sources) = (self.ancestry(target), self.ancestry(source));
        let (from_target, from_source) = targets
            .iter()
            .find_map(|t| Some((t, sources.iter().find(|s| s.frame == t.frame)?)))?;
        let target_from_source = from_target
            .frame_from_start
            .inv_mul(&from_source.frame_from_start);
        Some((target_from_source, from_target.moved || from_source.moved))
    }

    /// The frame that a sensor is mounted on in the end: the top of its chain of transforms, as
    /// far as these do not move and below `world_frame`. `None` for a frame without transforms.
    pub fn carrier(&self, sensor_frame: &str, world_frame: &str) -> Option<&str> {
        let mut carrier = None;
        let mut frame = sensor_frame;
        for _ in 0..self.edges.len() {
            let Some(edge) = self.edges.get(frame) else {
                break;
            };
            if edge.moved || edge.parent == world_frame {
                return carrier.or_else(|| self.edges.get_key_value(frame).map(|(f, _)| &**f));
            }
            carrier = Some(edge.parent.as_str());
            frame = &edge.parent;
        }
        carrier
    }

    /// Whether a frame is another one or hangs on it, however that may move.
    pub fn is_below(&self, frame: &str, other: &str) -> bool {
        self.ancestry(frame).iter().any(|a| a.frame == other)
    }

    /// A frame and all above it, nearest first.
    fn ancestry<'a>(&'a self, frame: &'a str) -> Vec<Ancestor<'a>> {
        let mut line = vec![Ancestor {
            frame,
            frame_from_start: Isometry3::identity(),
            moved: false,
        }];
        // No longer than there are edges, so that a loop ends.
        while let Some(last) = line.last().filter(|_| line.len() <= self.edges.len())
            && let Some(edge) = self.edges.get(last.frame)
        {
            line.push(Ancestor {
                frame: &edge.parent,
                frame_from_start: edge.parent_from_child * last.frame_from_start,
                moved: last.moved || edge.moved,
            });
        }
        line
    }
}

struct Ancestor<'a> {
    frame: &'a str,
    frame_from_start: Isometry3<f64>,
    moved: bool,
}

#[cfg(test)]
mod tests;
