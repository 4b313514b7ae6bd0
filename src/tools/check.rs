//! `tmam check`: logs held to their golden files, and what is said and kept of it.
//!
//! A [`Suite`] replays each log with the configuration in its golden file. What differs becomes text, a
//! recording, and what CI systems read: [`ReportFiles`] are opened before anything is replayed, and written
//! even where nothing can be.

pub mod annotations;
mod job;
mod junit;
mod overlay;
mod renamed;
mod report;
mod require;
mod suite;
mod summary;
pub mod text;

use std::io::Write as _;
use std::path::Path;

use crate::io::output::{Output, OutputError, is_stdout, make_room};
pub use report::{CheckError, CheckResult, Compared, Report, exit, json, refused};
pub use require::Requirements;
pub use suite::{Options, Suite};
pub use summary::summary as markdown;

/// The reports that are asked for.
#[derive(Debug)]
pub struct ReportFiles {
    junit: Option<Output>,
    summary: Option<Output>,
}

impl ReportFiles {
    /// Opens them; directories that are not there are made.
    ///
    /// # Errors
    /// One that cannot be written.
    pub fn open(junit: Option<&Path>, summary: Option<&Path>) -> Result<Self, OutputError> {
        let open = |path: Option<&Path>| {
            path.map(|path| {
                make_room(path)?;
                Output::create(path)
            })
            .transpose()
        };
        Ok(Self {
            junit: open(junit)?,
            summary: open(summary)?,
        })
    }

    /// Whether one of them goes to standard output, so that nothing else may.
    pub fn take_stdout(&self) -> bool {
        let files = [&self.junit, &self.summary];
        files.into_iter().flatten().any(|out| is_stdout(out.path()))
    }

    /// Writes what came of the logs.
    ///
    /// # Errors
    /// One that cannot be formed or written.
    pub fn write(
        self,
        reports: &[Report],
        notes: &[String],
        strict: bool,
    ) -> Result<(), CheckError> {
        self.write_texts(
            || junit::junit(reports, notes, strict),
            || markdown(reports, notes, strict),
        )
    }

    /// Writes why nothing was checked: whoever reads the reports alone must not see nothing.
    ///
    /// # Errors
    /// As [`ReportFiles::write`].
    pub fn refuse(self, error: &impl std::fmt::Display) -> Result<(), CheckError> {
        let why = error.to_string();
        self.write_texts(|| junit::refused(&why), || summary::refused(&why))
    }

    fn write_texts(
        self,
        junit: impl FnOnce() -> std::io::Result<String>,
        summary: impl FnOnce() -> String,
    ) -> Result<(), CheckError> {
        let write = |mut out: Output, text: String| -> Result<(), OutputError> {
            out.write_all(text.as_bytes())
                .map_err(|source| out.failed(source))?;
            out.commit()
        };
        if let Some(out) = self.junit {
            let text = junit()?;
            write(out, text)?;
        }
        if let Some(out) = self.summary {
            write(out, summary())?;
        }
        Ok(())
    }
}
