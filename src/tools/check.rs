//! `tmam check`: logs held to their golden files, and what is said and kept of it.
//!
//! A [`Suite`] replays each log with the configuration in its golden file. What differs becomes text, a
//! recording, and what CI systems read.

pub mod annotations;
mod artifacts;
mod job;
mod junit;
mod overlay;
mod report;
mod report_files;
mod suite;
mod summary;
pub mod text;

pub use report::{CheckError, CheckResult, Compared, Report, exit, json, refused};
pub use report_files::ReportFiles;
pub use suite::{Options, Suite};
