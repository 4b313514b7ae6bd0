//! Why a log cannot be replayed.

use crate::core::legible::one_line;
use crate::core::observer::ObserverError;
use crate::core::pattern::PatternError;

/// Why there is nothing to replay in a log that could be read.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// No sonar has a name that was asked for.
    #[error("no sonar matches {}; the log has {}", asked.join(", "), one_line(&sonars.join(", ")))]
    NoSuchSonar {
        /// Patterns that were asked for.
        asked: Vec<String>,
        /// Sonars of the log.
        sonars: Vec<String>,
    },
    /// A gate that the beam cannot reach.
    #[error(
        "triple.gamma is {:.6} deg; it must be below the beam width, which is {:.6} deg for sonar \
         `{sonar}`. Give a smaller --gamma, or leave the sonar out with --sensor",
        gamma.to_degrees(), beam_width.to_degrees(), sonar = one_line(sonar)
    )]
    GammaBeyondBeam {
        /// The gate, radians.
        gamma: f64,
        /// Radians.
        beam_width: f64,
        /// The sonar's name.
        sonar: String,
    },
    /// Not one reading in the window.
    #[error(
        "no reading lies in the window: the log has {readings} of them in {seconds:.3} s. Widen the \
         window that --start and --end leave"
    )]
    EmptyWindow {
        /// Readings of the log.
        readings: usize,
        /// From the first to the last.
        seconds: f64,
    },
    /// Not one reading with a pose.
    #[error(
        "no frame could be opened: none of {readings} range readings ({ranges}) has a pose from \
         {samples} odometry samples ({odometry}). {advice}"
    )]
    NoFrames {
        /// Readings in the window.
        readings: u64,
        /// Their time span.
        ranges: String,
        /// Odometry samples.
        samples: usize,
        /// Their time span.
        odometry: String,
        /// What to do.
        advice: &'static str,
    },
    /// A pattern of sonars that cannot be read.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// An observer could not go on.
    #[error(transparent)]
    Observer(#[from] ObserverError),
}

impl ReplayError {
    /// Whether nothing is wrong but that the log, or its window, holds nothing to replay.
    pub fn found_nothing(&self) -> bool {
        matches!(self, Self::NoFrames { .. } | Self::EmptyWindow { .. })
    }
}
