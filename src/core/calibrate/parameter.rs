//! What can be off.

use crate::core::event::SonarId;

/// A number that the configuration gives and a log can be held against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Parameter {
    /// How late ranges are stamped, seconds.
    RangeDelay,
    /// By how much their clock runs fast, as a share.
    ClockRate,
    /// What distances of odometry are multiplied with, less one.
    OdometryScale,
    /// What its turns are multiplied with, less one.
    OdometryTurnScale,
    /// What is known of sonars: of one, or of all of them alike.
    Sonar(Whose, Quantity),
}

/// Whose quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Whose {
    /// All sonars alike.
    All,
    /// One sonar.
    One(SonarId),
}

/// A quantity of a sonar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Mount in the robot's frame, metres.
    X,
    /// See `X`.
    Y,
    /// Direction of the beam axis in the robot's frame, radians.
    Yaw,
    /// What ranges are multiplied with, less one.
    RangeScale,
    /// What is added to ranges after that, metres.
    RangeOffset,
    /// How late its ranges are stamped beside those of the others, seconds.
    Delay,
    /// Full opening angle of the beam in which it hears, radians.
    BeamWidth,
}

impl Whose {
    /// Whether a sonar is meant.
    pub fn holds(self, sonar: SonarId) -> bool {
        match self {
            Self::All => true,
            Self::One(one) => one == sonar,
        }
    }
}
