//! Why a recording could not be written.

use rerun::SerializationError;
use rerun::external::re_log_encoding::CodecError;
use rerun::log::ChunkError;

use super::live::LiveError;

/// Why a recording could not be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file could not be written.
    #[error("cannot write the recording: {0}")]
    Write(#[from] std::io::Error),
    /// Rerun would not encode a message.
    #[error("cannot encode the recording: {0}")]
    Codec(#[from] CodecError),
    /// Rerun would not take the rows of an entity.
    #[error("cannot form a chunk of the recording: {0}")]
    Chunk(#[from] ChunkError),
    /// Rerun would not take a component.
    #[error("cannot form a component of the recording: {0}")]
    Component(Box<SerializationError>),
    /// There is no viewer, or it has gone away.
    #[error(transparent)]
    Live(#[from] LiveError),
}

impl From<SerializationError> for Error {
    fn from(error: SerializationError) -> Self {
        Self::Component(Box::new(error))
    }
}
