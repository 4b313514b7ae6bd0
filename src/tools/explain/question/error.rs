//! Why no arc answers a question.

use crate::core::pattern::PatternError;

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum QuestionError {
    /// No sonar has such a name.
    #[error("no sonar matches {}; the log has {}", asked.join(", "), sonars.join(", "))]
    NoSuchSonar {
        /// What was asked for.
        asked: Vec<String>,
        /// The log's sonars that have entries.
        sonars: Vec<String>,
    },
    /// A frame or a time alone does not name an arc.
    #[error(
        "--frame and --time name an arc of one sonar: give it with --sensor NAME. Of those asked for, \
         the log has {}", sonars.join(", ")
    )]
    WhichSonar {
        /// Those that match.
        sonars: Vec<String>,
    },
    /// There is no such frame.
    #[error("there is no frame {frame}: the replay has frames 0 to {last}")]
    NoSuchFrame {
        /// Asked for.
        frame: u32,
        /// The last one.
        last: u32,
    },
    /// The frame holds no echo of the sonar.
    #[error("{sonar} has no arc in frame {frame}: {why}{near}")]
    NoArc {
        /// The sonar.
        sonar: String,
        /// The frame.
        frame: u32,
        /// Nothing came back, or it did not fire.
        why: &'static str,
        /// The arcs around it.
        near: String,
    },
    /// The log does not last that long.
    #[error(
        "--time {seconds:.3} s is outside the replay, which lasts from {from:.3} s to {to:.3} s after the \
         log's first reading"
    )]
    OutsideTime {
        /// Asked for.
        seconds: f64,
        /// The replay's first reading.
        from: f64,
        /// Its last one.
        to: f64,
    },
    /// Nothing was measured there.
    #[error(
        "no arc passes near {x},{y}: the nearest, of {sonar} in frame {frame}, passes {distance:.2} m from \
         it, and the longest echo is {reach:.2} m. The sonars were between {low} and {high}, metres in \
         the odometry frame"
    )]
    FarAway {
        /// Asked for, metres.
        x: f64,
        /// Asked for, metres.
        y: f64,
        /// Whose arc is nearest.
        sonar: String,
        /// Its frame.
        frame: u32,
        /// How far it passes, metres.
        distance: f64,
        /// Of the sonars asked for, metres.
        reach: f64,
        /// Where the sonars were, as one types it.
        low: String,
        /// See `low`.
        high: String,
    },
    /// Not one echo.
    #[error("{} gave no echo in the whole replay, so there is no arc to explain", sonars.join(", "))]
    NoEcho {
        /// The sonars.
        sonars: Vec<String>,
    },
    /// A glob.
    #[error(transparent)]
    Glob(#[from] PatternError),
}
