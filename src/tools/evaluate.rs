//! How well a replay did, where the truth is known.
//!
//! [`Truth`] says what echoed at each arc and which walls and points could be seen at all; a
//! [`Scorer`] watches a replay and ends in an [`Evaluation`]. None of it reads or writes anything:
//! a sweep over configurations makes the truth once and a scorer for each run.

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

pub use scorer::{Evaluation, Scorer};
pub use truth::{Truth, TruthError};

use crate::core::replay::{Outcome, Replay, ReplayError};

/// Runs a replay and scores it.
///
/// # Errors
/// When there is nothing to replay.
pub fn evaluate(replay: &Replay<'_>, truth: &Truth) -> Result<(Outcome, Evaluation), ReplayError> {
    let mut scorer = Scorer::new(truth);
    let outcome = replay.run(&mut [&mut scorer])?;
    let evaluation = scorer.evaluate(&outcome);
    Ok((outcome, evaluation))
}

/// A share; `None` of nothing.
fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}
