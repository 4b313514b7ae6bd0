//! How well a replay did, where the truth is known.
//!
//! [`Truth`] says what echoed at each arc and which walls and points could be seen at all; a
//! [`Evaluation`] holds what a replay came to against it. None of it reads or writes anything.

pub mod drawing;
pub mod errors;
pub mod extracted;
pub mod json;
pub mod labels;
pub mod map;
pub mod matching;
pub mod scorer;
pub mod suspects;
pub mod text;
pub mod truth;

pub use scorer::Evaluation;
pub use truth::{Truth, TruthError};

/// A share; `None` of nothing.
fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}
