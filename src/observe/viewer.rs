//! The Rerun viewer: what this tmam needs of it, and why a recording is not written or not shown.

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
    Form(Box<dyn std::error::Error + Send + Sync>),
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
