//! Why there is no truth.

/// Why there is no truth to hold a replay against.
#[derive(Debug, thiserror::Error)]
pub enum TruthError {
    /// Nothing says it.
    #[error(
        "{file} carries no truth to evaluate against. Give the walls and points that were there with \
         --truth WORLD.json ({{\"walls\": [[x1,y1,x2,y2], ...], \"points\": [[x,y], ...]}}, metres in the \
         odometry frame), or evaluate a log that `tmam simulate` wrote"
    )]
    None {
        /// The log.
        file: String,
    },
    /// The world in the log is of no use.
    #[error(
        "the world in {file} cannot be used: {problem}. Give the right one with --truth WORLD.json"
    )]
    World {
        /// The log.
        file: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A tolerance that is none.
    #[error("--agree is {value} m; it must be 0 or more")]
    Agreement {
        /// Metres.
        value: f64,
    },
    /// The log says that something echoed which its world does not have.
    #[error(
        "{file} says that {kind} {index} echoed, but its world has {known} of them. Give the world with \
         --truth WORLD.json"
    )]
    NoSuchReflector {
        /// The log.
        file: String,
        /// `wall` or `point`.
        kind: &'static str,
        /// From 0.
        index: usize,
        /// How many there are.
        known: usize,
    },
}
