//! Simulated drives through the paper's room, replayed under every rule and scored.

use std::io::Cursor;
use std::ops::RangeInclusive;

use tmam_replay::config::Config;
use tmam_replay::config::file::parse;
use tmam_replay::evaluate::truth::AGREEING_RANGE;
use tmam_replay::evaluate::{Evaluation, Truth, evaluate};
use tmam_replay::log::read_with_truth_in;
use tmam_replay::replay::Replay;
use tmam_replay::simulate::{
    Driving, Motion, OdometryNoise, Path, RangeNoise, Ring, Simulation, Stepwise,
};
use tmam_replay::world::World;

/// How the robot goes through the room.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// It stops every 12 cm for all sonars, as in the paper.
    Stepwise,
    /// It does not stop, and its sonars fire in turn.
    Driven,
}

/// One drive at one noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// The drive.
    pub drive: Drive,
    /// Standard deviation of the ranges, metres.
    pub sigma: f64,
}

impl Case {
    /// For the head of a row.
    pub fn name(&self) -> String {
        let drive = match self.drive {
            Drive::Stepwise => "stepwise",
            Drive::Driven => "driven",
        };
        format!("{drive}, {:.0} mm", self.sigma * 1e3)
    }

    fn log(&self, seed: u64) -> Vec<u8> {
        let simulation = Simulation {
            world: World::room(),
            path: Path::room(),
            motion: match self.drive {
                Drive::Stepwise => Motion::Stepwise(Stepwise::default()),
                Drive::Driven => Motion::Driving(Driving::default()),
            },
            ring: Ring::default(),
            range_noise: RangeNoise {
                sigma: self.sigma,
                ..RangeNoise::default()
            },
            odometry_noise: OdometryNoise::default(),
            seed,
        };
        simulation
            .write(Cursor::new(Vec::new()))
            .unwrap()
            .into_inner()
    }
}

/// The rules that are compared, each with nothing else changed.
pub struct Rules(Vec<(&'static str, Config)>);

impl Rules {
    /// Every rule there is.
    pub fn all() -> Self {
        let known = ["paper", "noise-aware"].into_iter().filter_map(|name| {
            let config = parse(&format!("rule = \"{name}\"")).ok()?;
            Some((name, config))
        });
        Self(known.collect())
    }

    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.iter().map(|(name, _)| *name)
    }
}

/// Of each rule, the scores over the seeds.
pub fn run(case: Case, seeds: RangeInclusive<u64>, rules: &Rules) -> Vec<Vec<Evaluation>> {
    let mut scores: Vec<Vec<Evaluation>> = rules.0.iter().map(|_| Vec::new()).collect();
    for seed in seeds {
        let bytes = case.log(seed);
        let (log, recorded) =
            read_with_truth_in(Cursor::new(bytes), "room.mcap", &Config::default()).unwrap();
        assert!(log.losses.is_empty(), "{:?}", log.losses);
        for ((_, config), scores) in rules.0.iter().zip(&mut scores) {
            let replay = Replay::new(&log, config).unwrap();
            let truth = Truth::new(&replay, &recorded, None, AGREEING_RANGE).unwrap();
            let (_, evaluation) = evaluate(&replay, &truth).unwrap();
            scores.push(evaluation);
        }
    }
    scores
}
