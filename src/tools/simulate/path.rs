//! The path: straight lines between way-points, walked facing along the direction of travel.

use std::str::FromStr;

use crate::core::geometry::{Pose2, Vec2, direction};

use super::error::{SimulateError, require};

/// Way-points nearer than this have no direction between them, metres.
const MIN_SEGMENT: f64 = 1e-6;

/// A way-point within this of the distance walked counts as reached, metres.
const REACHED: f64 = 1e-9;

/// A polyline through way-points, metres in the world; always has a direction of travel.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    segments: Vec<Segment>,
}

/// One straight piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Where it begins, facing along it.
    pub start: Pose2,
    /// Metres.
    pub length: f64,
    end: Vec2,
}

impl Segment {
    /// The pose `distance` metres along.
    pub fn at(&self, distance: f64) -> Pose2 {
        let along = (self.end - self.start.position()) / self.length;
        let position = self.start.position() + along * distance;
        Pose2::new(position.x, position.y, self.start.yaw)
    }
}

impl Path {
    /// The path through `waypoints`, metres.
    pub fn new(waypoints: &[Vec2]) -> Result<Self, SimulateError> {
        if waypoints.len() < 2 {
            return Err(SimulateError::TooFewWaypoints(waypoints.len()));
        }
        for (index, segment) in segments(waypoints).enumerate() {
            let distance = segment.length;
            if !(distance >= MIN_SEGMENT && distance.is_finite()) {
                return Err(SimulateError::Waypoints { index, distance });
            }
        }
        Ok(Self {
            segments: segments(waypoints).collect(),
        })
    }

    /// A loop of 18 m through the built-in room that sees all its walls and corners.
    pub fn room() -> Self {
        let waypoints = [
            (1.0, 1.0),
            (3.0, 1.0),
            (3.0, 3.0),
            (7.0, 3.0),
            (7.0, 4.0),
            (1.0, 4.0),
            (1.0, 1.0),
        ]
        .map(|(x, y)| Vec2::new(x, y));
        Self {
            segments: segments(&waypoints).collect(),
        }
    }

    /// The path `laps` times over, if it ends where it begins.
    pub fn repeated(self, laps: u16) -> Result<Self, SimulateError> {
        require(
            laps == 1 || laps > 1 && self.is_closed(),
            "the number of laps",
            f64::from(laps),
            "1, or more on way-points that end where they begin",
        )?;
        let laps = std::iter::repeat_n(self.segments, usize::from(laps));
        Ok(Self {
            segments: laps.flatten().collect(),
        })
    }

    /// Metres from the first way-point to the last.
    pub fn length(&self) -> f64 {
        self.segments.iter().map(|segment| segment.length).sum()
    }

    /// Whether it ends exactly where it begins.
    pub fn is_closed(&self) -> bool {
        let ends = self.segments.first().zip(self.segments.last());
        ends.is_some_and(|(first, last)| first.start.position() == last.end)
    }

    /// The pose after `distance` metres, facing along travel; at a way-point already along the
    /// next piece. A closed path is walked round and round, an open one to its end.
    pub fn at(&self, distance: f64) -> Pose2 {
        let mut left = distance;
        let length = self.length();
        if self.is_closed() && distance >= length - REACHED {
            left = (distance - length * libm::floor((distance + REACHED) / length)).max(0.0);
        }
        for segment in &self.segments {
            if left < segment.length - REACHED {
                return segment.at(left);
            }
            left -= segment.length;
        }
        self.segments
            .last()
            .map_or(Pose2::IDENTITY, |segment| segment.at(segment.length))
    }

    /// The straight pieces, in order.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }
}

/// The straight pieces between neighbouring way-points.
fn segments(waypoints: &[Vec2]) -> impl Iterator<Item = Segment> {
    let pairs = waypoints.iter().zip(waypoints.iter().skip(1));
    pairs.map(|(start, end)| Segment {
        start: Pose2::new(start.x, start.y, direction(end - start)),
        length: (end - start).norm(),
        end: *end,
    })
}

/// Reads `x,y x,y ...`, metres.
impl FromStr for Path {
    type Err = SimulateError;

    fn from_str(text: &str) -> Result<Self, SimulateError> {
        let parse = |waypoint: &str| {
            let (x, y) = waypoint.split_once(',')?;
            Some(Vec2::new(x.parse().ok()?, y.parse().ok()?))
        };
        let waypoints = text.split_whitespace().map(|waypoint| {
            parse(waypoint).ok_or_else(|| SimulateError::WaypointText(waypoint.to_owned()))
        });
        Self::new(&waypoints.collect::<Result<Vec<_>, _>>()?)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    fn path(waypoints: &[(f64, f64)]) -> Result<Path, SimulateError> {
        let waypoints: Vec<_> = waypoints.iter().map(|(x, y)| Vec2::new(*x, *y)).collect();
        Path::new(&waypoints)
    }

    #[test]
    fn the_room_loop_is_150_steps_of_12_cm() {
        let room = Path::room();
        assert_eq!(room.length(), 18.0);
        assert!(room.is_closed());
        assert_eq!(room.at(0.0), Pose2::new(1.0, 1.0, 0.0));
        assert_eq!(room.at(75.0 * 0.12), Pose2::new(7.0, 4.0, PI));
        assert_eq!(room.at(18.0), room.at(0.0));
        assert_eq!(room.at(38.0), room.at(2.0));
        assert_eq!(room.at(2.0), Pose2::new(3.0, 1.0, FRAC_PI_2));
    }

    #[test]
    fn a_path_is_driven_more_than_once_if_it_is_closed() {
        let twice = Path::room().repeated(2).unwrap();
        assert_eq!((twice.length(), twice.segments().len()), (36.0, 12));
        assert_eq!(Path::room().repeated(1).unwrap(), Path::room());
        let open = path(&[(0.0, 0.0), (1.0, 0.0)]).unwrap();
        assert!(open.clone().repeated(2).is_err() && open.repeated(1).is_ok());
        assert!(Path::room().repeated(0).is_err());
    }

    #[test]
    fn an_open_path_ends_facing_along_its_last_piece() {
        let open = path(&[(0.0, 0.0), (1.0, 0.0), (1.0, 2.0)]).unwrap();
        assert!(!open.is_closed());
        assert_eq!(open.at(3.0), Pose2::new(1.0, 2.0, FRAC_PI_2));
        assert_eq!(open.at(99.0), Pose2::new(1.0, 2.0, FRAC_PI_2));
    }

    #[test]
    fn way_points_are_read_from_text() {
        let read: Path = " 0,0  1,-0.5\t1e1,2 ".parse().unwrap();
        assert_eq!(read, path(&[(0.0, 0.0), (1.0, -0.5), (10.0, 2.0)]).unwrap());
        for (text, part) in [
            ("", "at least 2"),
            ("0,0 1", "\"1\""),
            ("0,0 1,2,3", "\"1,2,3\""),
            ("0;0 1,2", "\"0;0\""),
            ("0,0 nan,2", "finite"),
        ] {
            let message = text.parse::<Path>().unwrap_err().to_string();
            assert!(message.contains(part), "{text}: {message}");
        }
    }

    #[test]
    fn a_path_without_a_direction_is_refused() {
        assert!(matches!(path(&[]), Err(SimulateError::TooFewWaypoints(0))));
        assert!(matches!(
            path(&[(1.0, 1.0)]),
            Err(SimulateError::TooFewWaypoints(1))
        ));
        for second in [(0.0, 0.0), (f64::NAN, 0.0), (f64::INFINITY, 0.0)] {
            let refused = path(&[(1.0, 0.0), (0.0, 0.0), second]);
            assert!(matches!(
                refused,
                Err(SimulateError::Waypoints { index: 1, .. })
            ));
        }
    }
}
