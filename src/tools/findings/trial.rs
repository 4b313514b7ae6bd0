//! A replay that writes nothing, to see what comes of a log.

use std::cell::OnceCell;
use std::path::Path;

use serde::{Serialize, Serializer};

use super::odometry::OdometryFacts;
use crate::core::config::Config;
use crate::core::log::Log;
use crate::core::replay::{Outcome, Replay, ReplayError};
use crate::core::statistics::fraction;
use crate::core::tmam::feature::{Kind, Status};
use crate::io::log;
use crate::observe::features::Counts;
use crate::tools::sweep::score::Score;

/// Whether a log can be replayed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Replayable {
    /// As it is.
    Yes,
    /// Without some of its sonars; with the keys of the skeleton whole.
    InPart,
    /// With the keys of the skeleton.
    WithSkeleton,
    /// Not by any configuration.
    No,
}

/// What a replay came to.
#[derive(Debug, Serialize)]
pub struct Trial {
    pub possible: Replayable,
    /// `None` where no configuration that could be thought of helped.
    #[serde(rename = "counts", serialize_with = "counts")]
    pub outcome: Option<Outcome>,
    /// The configuration it ran with: what the survey had, and what `refused` made necessary.
    #[serde(skip)]
    pub config: Config,
    /// What it refused at first.
    #[serde(skip)]
    pub refused: Vec<ReplayError>,
    /// What its map explains, once asked for.
    #[serde(skip)]
    pub explained: OnceCell<Explained>,
}

impl Trial {
    /// No replay at all.
    pub fn none(config: Config) -> Self {
        Self {
            possible: Replayable::No,
            outcome: None,
            config,
            refused: Vec::new(),
            explained: OnceCell::new(),
        }
    }

    /// What its map explains; `None` where nothing was replayed.
    pub fn explained(&self) -> Option<Explained> {
        let outcome = self.outcome.as_ref()?;
        Some(*self.explained.get_or_init(|| Explained::new(outcome)))
    }

    /// Replays a log, with other parameters where those of `config` do not fit it.
    pub fn run(
        log: &Log,
        config: Config,
        odometry: Option<&OdometryFacts>,
        as_it_is: Replayable,
    ) -> Self {
        let mut trial = Self::none(config);
        loop {
            let replay = Replay::new(log, &trial.config);
            match replay.and_then(|replay| replay.run(&mut [])) {
                Ok(outcome) => {
                    trial.outcome = Some(outcome);
                    trial.possible = if trial.refused.is_empty() {
                        as_it_is
                    } else {
                        Replayable::WithSkeleton
                    };
                    return trial;
                }
                Err(refusal) => {
                    let mended = mend(&refusal, &mut trial.config, odometry);
                    trial.refused.push(refusal);
                    // Each mends one parameter for good, so that this ends.
                    if mended.is_none() || trial.refused.len() >= 3 {
                        return trial;
                    }
                }
            }
        }
    }
}

/// What comes of a log with other keys: what its own map explains of it; `None` where nothing does.
pub type Attempt<'a> = dyn Fn(&Config) -> Option<Explained> + 'a;

/// Replays a file with other keys, and writes nothing.
pub fn attempted(path: &Path, config: &Config) -> Option<Explained> {
    let log = log::read(path, config).ok()?;
    let outcome = Replay::new(&log, config).ok()?.run(&mut []).ok()?;
    Some(Explained::new(&outcome))
}

/// How well a replay's own map explains its arcs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Explained {
    /// Share of the arcs.
    pub share: f64,
    /// Bits that an arc takes, the map included.
    pub bits: f64,
    /// Round pillars in the map.
    pub circles: usize,
}

impl Explained {
    pub fn new(outcome: &Outcome) -> Self {
        let score = Score::new(outcome, None);
        Self {
            share: fraction(score.explained.unwrap_or_default(), score.arcs),
            bits: score.bits.unwrap_or(f64::INFINITY),
            circles: (outcome.map.iter())
                .filter(|feature| feature.status == Status::Confirmed)
                .filter(|feature| feature.shape.kind() == Kind::Circle)
                .count(),
        }
    }

    /// Whether it is plainly better than another.
    pub fn beats(self, other: Self) -> bool {
        self.bits < other.bits - GAIN && self.share > other.share
    }
}

/// Advice that saves fewer bits an arc is not given.
const GAIN: f64 = 0.1;

/// Changes the parameter that a replay refused; `None` where no other value would do.
fn mend(
    refusal: &ReplayError,
    config: &mut Config,
    odometry: Option<&OdometryFacts>,
) -> Option<()> {
    match refusal {
        ReplayError::GammaBeyondBeam { beam_width, .. } => {
            config.triple.gamma = fitting_gamma(*beam_width);
        }
        ReplayError::NoFrames { .. } => {
            let gap = &mut config.frames.max_odometry_gap;
            *gap = wider_gap(odometry?, *gap)?;
        }
        _ => return None,
    }
    Some(())
}

/// A gate for the narrowest beam: half of it, in whole tenths of a degree where they suffice.
fn fitting_gamma(beam_width: f64) -> f64 {
    let half = beam_width / 2.0;
    let tenths = libm::floor(half.to_degrees() * 10.0);
    if tenths > 0.0 {
        (tenths / 10.0).to_radians()
    } else {
        half
    }
}

/// A gap that odometry as slow as this needs, in whole tenths of a second; `None` where the
/// present one is wide enough for all but drop-outs.
pub fn wider_gap(odometry: &OdometryFacts, present: f64) -> Option<f64> {
    let usual = odometry.usual_interval.filter(|usual| *usual > present)?;
    Some(libm::ceil(usual * 15.0) / 10.0)
}

fn counts<S: Serializer>(outcome: &Option<Outcome>, serializer: S) -> Result<S::Ok, S::Error> {
    outcome.as_ref().map(Counts::new).serialize(serializer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_beam_in_whole_tenths() {
        assert_eq!(fitting_gamma(7.5_f64.to_radians()), 3.7_f64.to_radians());
        let narrow = fitting_gamma(1e-4);
        assert!(narrow > 0.0 && narrow < 1e-4);
    }
}
