//! What really was: the answer that a simulated log carries with each reading, and with each odometry
//! sample where odometry is not exact.

use serde::{Deserialize, Serialize};

use crate::core::event::OdometrySample;
use crate::core::geometry::Pose2;
use crate::core::world::{Echo, Reflector};

/// The kind of thing that echoed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ReflectorKind {
    /// A wall, from the foot of the perpendicular.
    Line,
    /// A diffracting point.
    Point,
    /// A pillar.
    Circle,
    /// A rough wall, from its nearest place in the beam, beside that foot.
    Oblique,
}

/// What a sonar heard in place of the echo that was there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FalseEcho {
    /// The echo of another sonar's sound.
    CrossTalk,
    /// Sound that came by way of two walls.
    DoubleReflection,
}

/// The truth about one reading.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReadingTruth {
    /// The reading's stamp, nanoseconds on the log's own clock.
    pub stamp_ns: i64,
    /// The name (frame id) of the sonar that took it.
    pub sonar: String,
    /// What was there to echo; none where nothing was.
    pub kind: Option<ReflectorKind>,
    /// Which wall, point or pillar of the world, from 0.
    pub index: Option<usize>,
    /// Its distance without noise, metres, rounded to 1e-9.
    pub range: Option<f64>,
    /// Whether the reading was replaced by a random range.
    pub outlier: bool,
    /// What was heard in its place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub false_echo: Option<FalseEcho>,
}

/// The truth about one odometry sample: where the robot was, metres and radians in the frame of the
/// world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoseTruth {
    /// The sample's stamp, nanoseconds on the log's own clock.
    pub stamp_ns: i64,
    /// The robot's origin.
    pub x: f64,
    /// See `x`.
    pub y: f64,
    /// Its heading.
    pub yaw: f64,
}

impl PoseTruth {
    /// Of a robot at a stamp.
    pub fn new(stamp_ns: i64, world_from_robot: Pose2) -> Self {
        let Pose2 { x, y, yaw } = world_from_robot;
        Self {
            stamp_ns,
            x,
            y,
            yaw,
        }
    }
}

/// What exact odometry would have said.
impl From<PoseTruth> for OdometrySample {
    fn from(truth: PoseTruth) -> Self {
        Self {
            stamp_ns: truth.stamp_ns,
            world_from_robot: Pose2::new(truth.x, truth.y, truth.yaw),
        }
    }
}

impl ReadingTruth {
    /// The truth about a reading of `sonar` at `stamp_ns` for which the world gave `echo`.
    pub fn new(stamp_ns: i64, sonar: &str, echo: Option<Echo>, outlier: bool) -> Self {
        let (kind, index) = echo
            .map(|echo| match echo.reflector {
                Reflector::Line(index) if echo.oblique => (ReflectorKind::Oblique, index),
                Reflector::Line(index) => (ReflectorKind::Line, index),
                Reflector::Point(index) => (ReflectorKind::Point, index),
                Reflector::Circle(index) => (ReflectorKind::Circle, index),
            })
            .unzip();
        Self {
            stamp_ns,
            sonar: sonar.to_owned(),
            kind,
            index,
            range: echo.map(|echo| libm::round(echo.range * 1e9) / 1e9),
            outlier,
            false_echo: None,
        }
    }

    /// The wall or point that was there to echo, as the world counts it.
    pub fn reflector(&self) -> Option<Reflector> {
        let index = self.index?;
        Some(match self.kind? {
            ReflectorKind::Line | ReflectorKind::Oblique => Reflector::Line(index),
            ReflectorKind::Point => Reflector::Point(index),
            ReflectorKind::Circle => Reflector::Circle(index),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::Vec2;

    #[test]
    fn the_json_is_what_its_schema_says() {
        let echo = Echo {
            range: 1.234_567_890_123,
            reflector: Reflector::Point(2),
            oblique: false,
            place: Vec2::zeros(),
        };
        let truth = ReadingTruth::new(7, "sonar_00", Some(echo), false);
        let json = serde_json::to_string(&truth).unwrap();
        assert_eq!(
            json,
            r#"{"stamp_ns":7,"sonar":"sonar_00","kind":"point","index":2,"range":1.23456789,"outlier":false}"#
        );
        let again: ReadingTruth = serde_json::from_str(&json).unwrap();
        assert_eq!(again, truth);
        assert_eq!(again.reflector(), Some(Reflector::Point(2)));

        let silence = ReadingTruth::new(7, "sonar_00", None, true);
        let json = serde_json::to_string(&silence).unwrap();
        assert!(json.contains(r#""kind":null,"index":null,"range":null,"outlier":true"#));
        assert_eq!(silence.reflector(), None);
    }
}
