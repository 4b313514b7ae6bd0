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

mod collect;
mod compare;
mod difference;
mod features_file;
mod file;
mod hold;
mod labels_file;
mod results;
mod tolerance;

pub use collect::{LogInfo, labels, results};
pub use compare::compare;
pub use difference::{
    Change, ChangeUnit, Comparison, Difference, FeatureDifference, LabelRun, NumberChange,
    SECTIONS, SHOWN, Section, State, StrayedArc, describe, differences_in_json, sections,
};
pub use features_file::FeaturesFile;
pub use file::{Golden, GoldenError, SCHEMA, WrittenBy, as_recorded, unrecorded};
pub use hold::{Held, HoldError, UPDATE, hold, is_set};
pub use labels_file::{LabelsFile, carried};
pub use results::{
    Feature, Geometry, LabelledArc, Labels, LineSegment, Margin, Mark, Measured, RangeSigma,
    Results,
};
pub use tolerance::{Tolerance, ToleranceError};
