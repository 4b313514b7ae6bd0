//! Why there is no world.

use super::{LARGEST, MIN_WALL_LENGTH};

/// Why a world cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// The file cannot be read.
    #[error("cannot read the world: {0}")]
    Read(#[from] std::io::Error),
    /// Not JSON, or not of the right form.
    #[error(
        "not a world file: {0}; expected {{\"walls\": [[x1,y1,x2,y2], ...], \"points\": [[x,y], ...]}} in metres"
    )]
    Format(#[from] serde_json::Error),
    /// Nothing to see.
    #[error("the world is empty; give it at least one wall or point")]
    Empty,
    /// More than can be looked through for every reading.
    #[error(
        "the world has {things} walls and points, more than {LARGEST}; leave out what no sonar can see"
    )]
    TooLarge {
        /// How many.
        things: usize,
    },
    /// A wall end or a point is infinite or not a number.
    #[error("{kind} {index} has a coordinate that is not finite")]
    NotFinite {
        /// `wall` or `point`.
        kind: &'static str,
        /// Which, from 0.
        index: usize,
    },
    /// A wall without a direction.
    #[error(
        "wall {index} is {length} m long; a wall needs at least {MIN_WALL_LENGTH} m, use a point for less"
    )]
    ShortWall {
        /// Which, from 0.
        index: usize,
        /// Its length, metres.
        length: f64,
    },
    /// Two points in one place could not be told apart.
    #[error("points {first} and {second} are in the same place; remove one")]
    SamePoint {
        /// The earlier one, from 0.
        first: usize,
        /// The later one, from 0.
        second: usize,
    },
}
