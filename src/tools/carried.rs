//! The results of a replay, as the files that its recording carries.

use std::io;

use crate::core::observer::Setting;
use crate::core::replay::Outcome;
use crate::observe::carried::Carried;
use crate::observe::features;
use crate::tools::golden::{LabelsFile, LogInfo, RangeSigma, labels};

/// What a recording of the replay carries: the features file, to the byte as `--features` writes it,
/// and the label of every arc.
///
/// # Errors
/// When they cannot be formed.
pub fn carried(setting: &Setting<'_>, outcome: &Outcome, log: &LogInfo) -> io::Result<Carried> {
    let mut features = Vec::new();
    features::write(&mut features, setting, outcome)?;
    let labels = LabelsFile {
        log: log.clone(),
        noise: RangeSigma::of(outcome.variance_from, setting.config),
        labels: labels(setting.sonars, outcome),
    };
    Ok(Carried {
        features: String::from_utf8(features).map_err(io::Error::other)?,
        labels: Some(labels.render()?),
    })
}
