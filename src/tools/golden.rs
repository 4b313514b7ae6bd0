//! Golden files: what a replay gave when somebody looked at it and found it good, and how what it
//! gives now differs from that.
//!
//! [`compare`] is the heart: two sets of [`Results`], a [`Tolerance`], the differences. `tmam check`
//! and `tmam diff` are made of it, and [`hold`] lets another crate hold features of its own to a
//! golden file in `cargo test`:
//!
//! ```no_run
//! use tmam_replay::tools::golden::{Feature, Results, Tolerance, hold};
//!
//! let walls = [Feature::wall([0.0, 2.0], [3.0, 2.0]), Feature::point(3.0, 2.0)];
//! let found = Results::of_map(walls);
//! // UPDATE_GOLDEN=1 cargo test    writes the file
//! hold("tests/golden/corridor.golden.json", &found, &Tolerance::default())
//!     .unwrap_or_else(|differs| panic!("{differs}"));
//! ```

mod coding;
mod collect;
mod compare;
mod difference;
mod digest;
mod error;
mod features_file;
mod file;
mod hold;
mod label_table;
mod labels;
mod labels_file;
mod layout;
mod pairing;
mod range_noise;
mod replayed;
mod results;
mod rows;
mod sonars;
mod text;
mod tolerance;
mod unrecorded;

pub use collect::{labels, results};
pub use compare::compare;
pub use difference::{
    Change, Comparison, Difference, FeatureDifference, LabelChange, LabelRun, Set, SonarDifference,
    State, StrayedArc, Value,
};
pub use digest::digest;
pub use error::GoldenError;
pub use features_file::FeaturesFile;
pub use file::{Golden, LogInfo, SCHEMA, Tool, as_recorded};
pub use hold::{HoldError, Outcome, UPDATE, hold, is_set};
pub use labels_file::{LabelsFile, read_labels, write_labels};
pub use range_noise::RangeNoise;
pub use replayed::{Replayed, replay};
pub use results::{Feature, Geometry, LabelledArc, Labels, Margin, Mark, Measured, Results};
pub use text::{counts, describe, in_frames};
pub use tolerance::{Tolerance, ToleranceError};
pub use unrecorded::unrecorded;
