//! What can go wrong in a replay.

/// Any failure of a replay.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The recording could not be written.
    #[error(transparent)]
    Recording(#[from] crate::recording::Error),
}
