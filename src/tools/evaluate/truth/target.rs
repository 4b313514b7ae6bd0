//! What an arc can have come from.

use crate::core::world::Reflector;

/// What an arc came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A wall or a point of the world.
    Reflector(Reflector),
    /// Something else.
    Other(Other),
}

impl Target {
    /// The word in files: `line`, `point`, or why neither.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reflector(Reflector::Line(_)) => "line",
            Self::Reflector(Reflector::Point(_)) => "point",
            Self::Other(other) => other.name(),
        }
    }
}

/// Why an arc came from no wall or point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Other {
    /// The log says that its range was replaced by a random one.
    Outlier,
    /// The world has nothing there.
    Nothing,
    /// What the world has there is nearer or farther than the range, beyond the noise.
    Disagrees,
}

impl Other {
    /// Every reason.
    pub const ALL: [Self; 3] = [Self::Outlier, Self::Nothing, Self::Disagrees];

    /// The word in files: `outlier`, `nothing` or `disagrees`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Outlier => "outlier",
            Self::Nothing => "nothing",
            Self::Disagrees => "disagrees",
        }
    }
}
