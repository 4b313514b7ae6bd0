//! What can go wrong in a replay, and the exit code that goes with it.

/// Any failure of a replay.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The recording could not be written.
    #[error(transparent)]
    Recording(#[from] crate::recording::Error),
}
