//! Golden files: what a replay gave when somebody looked at it and found it good, and how what it
//! gives now differs from that.
//!
//! [`compare`] is the heart: two sets of [`Results`], a [`Tolerance`], the differences. `tmam check`
//! and `tmam diff` are made of it, and [`hold`] lets another crate hold features of its own to a
//! golden file in `cargo test`:
//!
//! ```no_run
//! use tmam_replay::golden::{Feature, Results, Tolerance, hold};
//!
//! let walls = [Feature::wall([0.0, 2.0], [3.0, 2.0]), Feature::point(3.0, 2.0)];
//! let found = Results::of_map(walls);
//! // UPDATE_GOLDEN=1 cargo test    writes the file
//! hold("tests/golden/corridor.golden.json", &found, &Tolerance::default())
//!     .unwrap_or_else(|differs| panic!("{differs}"));
//! ```

mod cause;
mod collect;
mod compare;
mod difference;
mod drawn;
mod features_file;
mod file;
mod hold;
mod labels_file;
mod profile;
mod quality;
mod replayed;
mod results;
mod text;
mod tolerance;

pub use cause::Cause;
pub use collect::{labels, results};
pub use compare::{compare, settled};
pub use difference::{
    Change, ChangeUnit, Comparison, Difference, FeatureDifference, FindingDifference, LabelRun,
    NumberChange, SECTIONS, State, StrayedArc,
};
pub use drawn::{drawn, farthest, notes, relabelled, sketched};
pub use features_file::FeaturesFile;
pub use file::{Golden, GoldenError, SCHEMA, WrittenBy, as_recorded, unrecorded};
pub use hold::{Held, HoldError, UPDATE, hold, is_set};
pub use labels_file::{LabelsFile, carried};
pub use profile::{LogInfo, OdometryProfile, SonarProfile, Stamps};
pub use quality::{Quality, Trend, from_to, headline};
pub use replayed::all_results;
pub use results::{Feature, Geometry, LabelledArc, Labels, LineSegment, Mark, RangeSigma, Results};
pub use text::{SHOWN, Section, describe, differences_in_json, headlines, sections};
pub use tolerance::{Tolerance, ToleranceError};
