//! The results that a recording carries for programs: the files that hold them, as text.

use std::error::Error;

/// The results of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Carried {
    /// The features file, as it would be written beside the recording.
    pub features: String,
    /// The label of every arc; `None` where a recording has none.
    pub labels: Option<String>,
}

/// Why there are no results in a recording.
#[derive(Debug, thiserror::Error)]
pub enum CarriedError {
    #[error("it cannot be read: {0}")]
    Read(#[from] std::io::Error),
    #[error("it is a pipe or a device, and a recording is read from a file: save it as one")]
    NoFile,
    #[error("it is cut off: {bytes} bytes, and the recording goes on")]
    CutOff { bytes: u64 },
    /// A message that begins at byte `at`.
    #[error("it cannot be decoded at byte {at}: {source}")]
    Codec {
        at: u64,
        source: Box<dyn Error + Send + Sync>,
    },
    #[error("the results that it carries are damaged: {reason}")]
    Damaged { reason: String },
    #[error("{bytes} bytes that are no recording follow its end, at byte {at}")]
    GoesOn { at: u64, bytes: u64 },
    #[error("it holds more than one recording; give each in a file of its own")]
    Several,
    #[error("tmam did not write it, but {writer}")]
    Foreign { writer: String },
    /// One of ours that shows no run, or from before recordings carried results.
    #[error(
        "it carries no results: it shows a sweep{}",
        if *writer == this() { String::new() }
        else { format!(", or an older tmam wrote it ({writer}; this is {})", this()) }
    )]
    Nothing { writer: String },
    #[error("this tmam was built without the feature `viewer` and reads no recordings")]
    NotBuiltIn,
}

/// What recordings say that wrote them.
pub fn this() -> String {
    format!("tmam {}", env!("CARGO_PKG_VERSION"))
}
