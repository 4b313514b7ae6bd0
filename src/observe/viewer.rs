//! The Rerun viewer: what this tmam needs of it, why a recording is not written or not shown, and what
//! recordings carry for programs.

use std::error::Error as AnyError;
use std::io;

/// The viewer that reads the recordings.
pub const VERSION: &str = "0.36.3";

/// Where a viewer listens unless told otherwise.
pub const DEFAULT_URL: &str = "rerun+http://127.0.0.1:9876/proxy";

/// Whether this tmam writes recordings.
pub const IS_BUILT_IN: bool = cfg!(feature = "viewer");

/// Why a recording could not be written or shown.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error("cannot write the recording: {0}")]
    Write(#[from] io::Error),
    #[error("cannot form the recording: {0}")]
    Form(Box<dyn AnyError + Send + Sync>),
    #[error(
        "this tmam was built without the feature `viewer` and writes, shows and reads no recordings; \
         `cargo install tmam-replay` builds one that does"
    )]
    NotBuiltIn,
    #[error(
        "`{url}` is no viewer's address: {problem}. It looks like {DEFAULT_URL}; the log stands before \
         --connect"
    )]
    Url { url: String, problem: String },
    #[error(
        "no viewer answers at {url}. Start one (`rerun`, viewer {VERSION}), or let --spawn do so"
    )]
    NotThere { url: String },
    #[error(
        "cannot start a viewer: `rerun` is not on the PATH. Install it with `pip install \
         rerun-sdk=={VERSION}`"
    )]
    NotInstalled,
    #[error("cannot start `rerun`: {0}")]
    Spawn(io::Error),
    #[error("`rerun` was started but ended at once ({status}); run `rerun` by itself to see why")]
    Ended { status: String },
    #[error("the viewer at {url} went away before it had everything: {problem}")]
    Gone { url: String, problem: String },
}

/// The results of a run that its recording carries: the files that hold them, as text.
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
    Read(#[from] io::Error),
    #[error("it is a pipe or a device, and a recording is read from a file: save it as one")]
    NoFile,
    #[error("it is cut off: {bytes} bytes, and the recording goes on")]
    CutOff { bytes: u64 },
    /// A message that begins at byte `at`.
    #[error("it cannot be decoded at byte {at}: {source}")]
    Codec {
        at: u64,
        source: Box<dyn AnyError + Send + Sync>,
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
        "it carries no results: it shows a sweep or a comparison{}",
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
