//! The results of a replay, as the files that its recording carries.

use crate::cli::error::Error;
use crate::core::observer::Setting;
use crate::core::replay::Outcome;
use crate::observe::features;
use crate::observe::carried::Carried;
use crate::tools::golden::{Labels, LogInfo, RangeNoise, write_labels};

/// What a recording of the replay carries: the features file, to the byte as `--features` writes it,
/// and the label of every arc.
///
/// # Errors
/// When they cannot be formed.
pub fn carried(
    setting: &Setting<'_>,
    outcome: &Outcome,
    log: &LogInfo,
    labels: &Labels,
) -> Result<Carried, Error> {
    let unfit = |error: Box<dyn std::error::Error + Send + Sync>| Error::Report(error);
    let mut features = Vec::new();
    features::write(&mut features, setting, outcome).map_err(|error| unfit(Box::new(error)))?;
    let noise = RangeNoise::of(outcome.variance_from, setting.config);
    let labels = write_labels(log, noise, labels).map_err(|error| unfit(Box::new(error)))?;
    Ok(Carried {
        features: String::from_utf8(features).map_err(|error| unfit(Box::new(error)))?,
        labels: Some(labels),
    })
}
