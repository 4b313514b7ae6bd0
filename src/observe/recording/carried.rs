//! What a recording carries for programs: the results of the run that it shows, as the files that
//! hold them.

mod find;
#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::{BufReader, Write};
use std::path::Path;

use rerun::TextDocument;
use rerun::external::re_log_encoding::CodecError;

use super::Error;
use super::encode::RrdWriter;
use super::table::put_static;
use find::find;

const FEATURES: &str = "/run/features";
const LABELS: &str = "/run/labels";

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
    /// The file cannot be read.
    #[error("it cannot be read: {0}")]
    Read(#[from] std::io::Error),
    /// It cannot be read twice, nor from any place.
    #[error("it is a pipe or a device, and a recording is read from a file: save it as one")]
    NoFile,
    /// The file ends before the recording does.
    #[error("it is cut off: {bytes} bytes, and the recording goes on")]
    CutOff {
        /// Its length.
        bytes: u64,
    },
    /// It is no recording that can be read.
    #[error("it cannot be decoded at byte {at}: {source}")]
    Codec {
        /// Where the message begins.
        at: u64,
        /// Why.
        source: Box<CodecError>,
    },
    /// Its results are not whole.
    #[error("the results that it carries are damaged: {reason}")]
    Damaged {
        /// What is wrong.
        reason: String,
    },
    /// The file goes on after the recording.
    #[error("{bytes} bytes that are no recording follow its end, at byte {at}")]
    GoesOn {
        /// Where it ends.
        at: u64,
        /// What follows.
        bytes: u64,
    },
    /// Several recordings in one file.
    #[error("it holds more than one recording; give each in a file of its own")]
    Several,
    /// Another program's.
    #[error("tmam did not write it, but {writer}")]
    Foreign {
        /// What wrote it.
        writer: String,
    },
    /// One of ours that shows no run, or from before recordings carried results.
    #[error(
        "it carries no results: it shows a sweep{}",
        if *.writer == this() { String::new() }
        else { format!(", or an older tmam wrote it ({writer}; this is {})", this()) }
    )]
    Nothing {
        /// What wrote it.
        writer: String,
    },
}

/// What recordings say that wrote them.
pub(super) fn this() -> String {
    format!("tmam {}", env!("CARGO_PKG_VERSION"))
}

impl Carried {
    /// Writes the documents. No view shows them.
    pub(super) fn put<W: Write>(&self, out: &mut RrdWriter<W>) -> Result<(), Error> {
        let features = (FEATURES, Some(&self.features));
        for (path, text) in [features, (LABELS, self.labels.as_ref())] {
            if let Some(text) = text {
                put_static(path, &TextDocument::new(text.as_str()), out)?;
            }
        }
        Ok(())
    }

    /// Reads the documents of a recording.
    ///
    /// # Errors
    /// A file that is no whole recording of one run.
    pub fn read(path: &Path) -> Result<Self, CarriedError> {
        // Opening a pipe would wait for a writer.
        if !std::fs::metadata(path)?.is_file() {
            return Err(CarriedError::NoFile);
        }
        let file = File::open(path)?;
        let len = file.metadata()?.len();
        find(BufReader::new(file), len)
    }
}
