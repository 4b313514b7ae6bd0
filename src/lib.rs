//! Replays MCAP logs of sonar range and odometry channels, steps TMAM - the three measurements
//! association model of Wang, Hou, Ma, Zhang, Zhang and Tan - over them frame by frame, and shows
//! what it saw and decided.
//!
//! A replay reads a log once, frames it once and steps every arc once; what watches it is an
//! [`Observer`]. This one counts the labels of a drive along the walls of a room:
//!
//! ```
//! use tmam_replay::{Config, Frame, Label, Observer, ObserverError, Replay, Step, read};
//!
//! #[derive(Default)]
//! struct Contacts(usize);
//!
//! impl Observer for Contacts {
//!     fn frame(&mut self, _: &Frame, step: &Step) -> Result<(), ObserverError> {
//!         let contacts = step.labelled.iter().filter(|arc| arc.label == Label::Contact);
//!         self.0 += contacts.count();
//!         Ok(())
//!     }
//!
//!     fn finish(&mut self, step: &Step) -> Result<(), ObserverError> {
//!         let contacts = step.labelled.iter().filter(|arc| arc.label == Label::Contact);
//!         self.0 += contacts.count();
//!         Ok(())
//!     }
//! }
//!
//! let config = Config::default();
//! let log = read("sample_logs/room_drive.mcap".as_ref(), &config)?;
//! let mut contacts = Contacts::default();
//! let outcome = Replay::new(&log, &config)?.run(&mut [&mut contacts])?;
//! assert_eq!(contacts.0, 234);
//! assert_eq!(outcome.map.len(), 12, "six walls and six corners");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`golden`] holds what a program of yours finds to a golden file in `cargo test`.
//!
//! Without the default feature `viewer` there is no Rerun in the build, and no recording.

// The floors stand open for the program and for this repository's own tests; what is meant for
// others is handed on below.
#[doc(hidden)]
pub mod cli;
#[doc(hidden)]
pub mod core;
#[doc(hidden)]
pub mod io;
#[doc(hidden)]
pub mod observe;
#[doc(hidden)]
pub mod tools;

pub use core::config::{Config, Rule};
pub use core::event::{Events, OdometrySample, RangeReading, Readings, Sonar, SonarId};
pub use core::frames::{Echo, Entry, Frame};
pub use core::log::Log;
pub use core::observer::{Observer, ObserverError};
pub use core::replay::{Outcome, Replay, ReplayError};
pub use core::tmam::Tmam;
pub use core::tmam::arc::{Arc, ArcId};
pub use core::tmam::feature::{Action, MapFeature, Point, Segment, Shape, Status};
pub use core::tmam::label::{Kind, Label, Reason};
pub use core::tmam::report::ArcReport;
pub use core::tmam::step::{Extraction, Step};
pub use io::config::file::{ConfigError, check, parse};
pub use io::log::{LogError, read};
pub use tools::golden;
