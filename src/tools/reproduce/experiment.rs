//! The experiment, and the trials of the paper's rule.

use std::io::Cursor;

use super::counts::Counts;
use crate::core::config::{Config, Rule, Triple};
use crate::core::geometry::Vec2;
use crate::core::log::Log;
use crate::core::replay::{Outcome, Replay, ReplayError};
use crate::core::ties;
use crate::core::tmam::Tmam;
use crate::core::tmam::feature::{MapFeature, Status};
use crate::core::tmam::step::Step;
use crate::core::world::World;
use crate::io::log::truth::RecordedTruth;
use crate::io::log::{LogError, read_with_truth_in};
use crate::tools::evaluate::truth::AGREEING_RANGE;
use crate::tools::evaluate::{Evaluation, Truth, TruthError};
use crate::tools::report::map::draw;
use crate::tools::simulate::{RangeNoise, SimulateError, Simulation};

/// The noises at which the paper's rule is tried, metres,
const NOISES: [f64; 6] = [0.0, 0.000_3, 0.001, 0.003, 0.01, 0.02];
/// the bounds on the ratio of its angles, of which beta is one over alpha,
const ALPHAS: [f64; 3] = [0.25, 0.5, 0.8];
/// and on the smaller one, degrees.
const GAMMAS: [f64; 3] = [2.0, 5.0, 10.0];
/// How many of the nearest are told.
const NEAREST: usize = 5;

/// Why the experiment cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum ReproduceError {
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    #[error(transparent)]
    Log(#[from] LogError),
    #[error(transparent)]
    Replay(#[from] ReplayError),
    #[error(transparent)]
    Truth(#[from] TruthError),
}

/// The experiment under one rule.
pub struct Experiment {
    pub rule: Rule,
    pub outcome: Outcome,
    pub evaluation: Evaluation,
    pub counts: Counts,
    path: Vec<Vec2>,
}

/// What the paper's rule counts at one noise under some parameters.
pub struct Trial {
    /// Metres.
    pub sigma: f64,
    pub alpha: f64,
    /// Degrees.
    pub gamma: f64,
    pub counts: Counts,
}

/// The experiment under both rules, and where the paper's comes nearest to its own numbers.
pub struct Reproduction {
    /// Metres.
    pub sigma: f64,
    pub seed: u64,
    /// Under the paper's rule and the noise-aware one.
    pub rules: [Experiment; 2],
    /// The nearest first.
    pub nearest: Vec<Trial>,
    /// Trials that were made.
    pub tried: usize,
}

impl Reproduction {
    /// Simulates the paper's room at this noise (metres), and replays it.
    ///
    /// # Errors
    /// A noise that is none.
    pub fn new(sigma: f64, seed: u64) -> Result<Self, ReproduceError> {
        let (log, truth) = room(sigma, seed)?;
        let under = |rule| Experiment::new(&log, &truth, rule);
        let mut trials = Vec::new();
        for sigma in NOISES {
            trials.extend(trials_at(sigma, seed)?);
        }
        let tried = trials.len();
        let mut nearest: Vec<Trial> = Vec::new();
        while nearest.len() < NEAREST {
            let left = trials.iter().enumerate();
            let distances = left.map(|(place, trial)| (trial.counts.distance(), place));
            let Some((_, place)) = ties::first_least(distances, |_, _| 1e-9) else {
                break;
            };
            nearest.push(trials.remove(place));
        }
        Ok(Self {
            sigma,
            seed,
            rules: [under(Rule::Paper)?, under(Rule::NoiseAware)?],
            nearest,
            tried,
        })
    }

    /// Figures like the paper's 5 and 6: the extracted features, and the map; SVG.
    pub fn figures(&self) -> [String; 2] {
        let [_, noise_aware] = &self.rules;
        [noise_aware.extracted(), noise_aware.outcome.map.clone()].map(|features| {
            let room = World::room();
            let picture = draw(&noise_aware.path, &[], &features, &[], Some(&room));
            format!("{picture}\n")
        })
    }
}

impl Experiment {
    fn new(log: &Log, recorded: &RecordedTruth, rule: Rule) -> Result<Self, ReproduceError> {
        let config = Config::with_rule(rule);
        let replay = Replay::new(log, &config)?;
        let outcome = replay.run(&mut [])?;
        let truth = Truth::new(&replay, recorded, None, AGREEING_RANGE)?;
        let path = replay.path(&outcome);
        let extractions: Vec<_> = outcome.extractions.iter().collect();
        Ok(Self {
            rule,
            evaluation: Evaluation::new(&truth, &path, &outcome),
            counts: Counts::of(outcome.tally.readings, &extractions, &outcome.map),
            path: path.iter().map(|(_, pose)| pose.position()).collect(),
            outcome,
        })
    }

    /// What was extracted, as features of a map.
    fn extracted(&self) -> Vec<MapFeature> {
        let used = self.outcome.extractions.iter();
        let used = used.filter(|extraction| extraction.action.rejection().is_none());
        let features = used.filter_map(|extraction| {
            Some(MapFeature {
                id: extraction.id,
                shape: extraction.shape?,
                readings: u32::try_from(extraction.associated.len()).unwrap_or(u32::MAX),
                runs: 1,
                status: Status::Confirmed,
            })
        });
        features.collect()
    }
}

/// The log of the paper's room in its 150 steps.
fn room(sigma: f64, seed: u64) -> Result<(Log, RecordedTruth), ReproduceError> {
    let simulation = Simulation {
        range_noise: RangeNoise {
            sigma,
            ..RangeNoise::default()
        },
        seed,
        ..Simulation::default()
    };
    let bytes = simulation.write(Cursor::new(Vec::new()))?.into_inner();
    let read = read_with_truth_in(Cursor::new(bytes), "room.mcap", &Config::default())?;
    Ok(read)
}

/// The paper's rule at one noise under all parameters.
fn trials_at(sigma: f64, seed: u64) -> Result<Vec<Trial>, ReproduceError> {
    let (log, _) = room(sigma, seed)?;
    let mut trials = Vec::new();
    for alpha in ALPHAS {
        for gamma in GAMMAS {
            let config = Config {
                triple: Triple {
                    alpha,
                    beta: 1.0 / alpha,
                    gamma: gamma.to_radians(),
                    ..Triple::default()
                },
                ..Config::with_rule(Rule::Paper)
            };
            let replay = Replay::new(&log, &config)?;
            let mut tmam = Tmam::new(replay.config());
            let mut steps: Vec<Step> = (replay.frames().iter())
                .map(|frame| tmam.step(frame))
                .collect();
            steps.push(tmam.finish());
            let extractions: Vec<_> = steps.iter().flat_map(|step| &step.extractions).collect();
            let readings = replay.readings().count() as u64;
            trials.push(Trial {
                sigma,
                alpha,
                gamma,
                counts: Counts::of(readings, &extractions, tmam.map().features()),
            });
        }
    }
    Ok(trials)
}
