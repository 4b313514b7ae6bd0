//! What a simulation refuses.

use crate::core::world::WorldError;
use crate::io::log::writer::WriteError;

/// Why a simulation cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum SimulateError {
    /// A parameter out of its range.
    #[error("{name} is {value}, but must be {allowed}")]
    Parameter {
        /// Which.
        name: &'static str,
        /// What it is.
        value: f64,
        /// What it may be.
        allowed: &'static str,
    },
    /// A key of the configuration that a log cannot be made to need.
    #[error("--needs takes {}", super::untold::KEYS)]
    CannotNeed,
    /// A sonar that the ring does not have.
    #[error("no sonar is called {name:?}; there are {}", sonars.join(", "))]
    NoSuchSonar {
        /// As named.
        name: String,
        /// Those there are.
        sonars: Vec<String>,
    },
    /// A way-point that is not two numbers.
    #[error("{0:?} is not a way-point; write x,y in metres, with spaces between way-points")]
    WaypointText(String),
    /// A late stretch that is none.
    #[error(
        "{0:?} is no late stretch; write FROM:TO:DELAY in seconds after the start, with FROM before TO and a \
         DELAY above 0 and of at most 60"
    )]
    LateText(String),
    /// A late stretch that no reading is in.
    #[error(
        "no reading is later than {last:.1} s after the start, so that none is late from {from} s on; begin the \
         stretch before, or drive longer (--laps, --hours)"
    )]
    NothingLate {
        /// When the stretch begins, seconds after the start.
        from: f64,
        /// When the last reading is taken.
        last: f64,
    },
    /// Nowhere to go.
    #[error("a path needs at least 2 way-points, got {0}")]
    TooFewWaypoints(usize),
    /// A way-point at which there is no direction of travel.
    #[error(
        "way-points {index} and {} are {distance} m apart; neighbours must be at least 1e-6 m apart and finite",
        index + 1
    )]
    Waypoints {
        /// The earlier of the two, from 0.
        index: usize,
        /// How far apart they are, metres.
        distance: f64,
    },
    /// An open path with fewer places than steps.
    #[error(
        "{steps} steps of {step} m do not fit an open path of {length} m; take at most {most}, or end the way-points where they begin"
    )]
    PathTooShort {
        /// The number of steps asked for.
        steps: usize,
        /// Metres a step.
        step: f64,
        /// The path's length, metres.
        length: f64,
        /// How many fit.
        most: usize,
    },
    /// More than anyone wants to replay.
    #[error(
        "the log would hold about {readings:.0} readings, more than {limit}; shorten the path, or sample it less often"
    )]
    TooLong {
        /// How many readings it would hold.
        readings: f64,
        /// How many it may.
        limit: usize,
    },
    /// Walls that cannot be made diffuse.
    #[error(transparent)]
    World(#[from] WorldError),
    /// The log could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Refuses a name that no sonar has.
pub fn known<'a>(
    name: &str,
    mut sonars: impl Iterator<Item = &'a str> + Clone,
) -> Result<(), SimulateError> {
    let names = sonars.clone().map(str::to_owned);
    let unknown = || SimulateError::NoSuchSonar {
        name: name.to_owned(),
        sonars: names.collect(),
    };
    sonars
        .any(|sonar| sonar == name)
        .then_some(())
        .ok_or_else(unknown)
}

/// Refuses a parameter outside `allowed`; `valid` is false for NaN when it is a comparison.
pub fn require(
    valid: bool,
    name: &'static str,
    value: f64,
    allowed: &'static str,
) -> Result<(), SimulateError> {
    let refused = || SimulateError::Parameter {
        name,
        value,
        allowed,
    };
    valid.then_some(()).ok_or_else(refused)
}

/// Refuses what is not a standard deviation.
pub fn deviation(name: &'static str, value: f64) -> Result<(), SimulateError> {
    require(
        value >= 0.0 && value.is_finite(),
        name,
        value,
        "a standard deviation: 0 or more",
    )
}

/// Refuses what is not above zero.
pub fn positive(name: &'static str, value: f64) -> Result<(), SimulateError> {
    require(value > 0.0 && value.is_finite(), name, value, "above 0")
}
