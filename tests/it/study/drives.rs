//! Simulated drives through the paper's room, replayed under every rule and scored.

use std::io::Cursor;
use std::ops::RangeInclusive;

use rayon::prelude::*;
use tmam_replay::core::config::Config;
use tmam_replay::core::geometry::Vec2;
use tmam_replay::core::log::Log;
use tmam_replay::core::replay::{Outcome, Replay};
use tmam_replay::core::world::{Pillar, Wall, World};
use tmam_replay::io::config::file::parse;
use tmam_replay::io::log::read_with_truth_in;
use tmam_replay::tools::evaluate::truth::AGREEING_RANGE;
use tmam_replay::tools::evaluate::{Evaluation, Truth};
use tmam_replay::tools::simulate::{
    Driving, FalseEchoes, Motion, OdometryNoise, Path, RangeNoise, Ring, Simulation, Stepwise,
    Untold,
};

/// How the robot goes through the room.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// It stops every 12 cm for all sonars, as in the paper.
    Stepwise,
    /// It does not stop, and its sonars fire in turn.
    Driven,
    /// The same, ten times round.
    TenLaps,
    /// Driven once round with odometry that drifts by 2 mm and 0.05 deg after a metre, and by 0.1 deg
    /// after turning by a radian.
    LittleDrift,
    /// Driven once round where this share of the walls, in per cent, is rough.
    Rough(u8),
    /// Driven once round where of twenty readings one is of another sonar's sound.
    CrossTalk,
    /// Past posts in a row instead of a wall, this many centimetres apart.
    Posts(u8),
    /// Driven once round a hall with four pillars of this radius, centimetres; without any where it is 0.
    Pillars(u8),
    /// So often round the office of the sample logs, with odometry that is exact, or drifts by much.
    Office { laps: u16, drifts: bool },
    /// Once through the loft of the sample logs, whose walls are oblique, and rough by this share, in per cent.
    Loft(u8),
    /// Driven three times round with odometry that drifts by much.
    ThreeLapsMuchDrift,
    /// The same once round where of twenty readings one is of any range.
    MuchDriftOutliers,
    /// Three times round with odometry that drifts by three times as much.
    ThriceMuchDrift,
    /// Driven once round where of twenty readings one is of any range.
    Outliers,
    /// It stops every 60 cm and turns once round by two degrees at a time, with four sonars.
    Scans,
    /// The same past posts in a row, half a metre apart: what looks alike stands where drift may put it.
    ThriceMuchDriftPosts,
    /// Driven once round with odometry that drifts by 1 cm and 0.2 deg after a metre, and by 0.5 deg
    /// after turning by a radian.
    MuchDrift,
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
            Drive::Stepwise => "stepwise".to_owned(),
            Drive::Driven => "driven".to_owned(),
            Drive::TenLaps => "ten laps".to_owned(),
            Drive::LittleDrift => "little drift".to_owned(),
            Drive::MuchDrift => "much drift".to_owned(),
            Drive::ThreeLapsMuchDrift => "three laps, much drift".to_owned(),
            Drive::MuchDriftOutliers => "much drift, 5 % outliers".to_owned(),
            Drive::ThriceMuchDrift => "three laps, three times much drift".to_owned(),
            Drive::ThriceMuchDriftPosts => {
                "three laps past posts 50 cm apart, three times much drift".to_owned()
            }
            Drive::Rough(share) => format!("{share} % of the walls rough"),
            Drive::CrossTalk => "5 % cross-talk".to_owned(),
            Drive::Outliers => "driven, 5 % outliers".to_owned(),
            Drive::Scans => "dense scans".to_owned(),
            Drive::Pillars(0) => "hall without pillars".to_owned(),
            Drive::Pillars(radius) => format!("pillars of {radius} cm"),
            Drive::Posts(apart) => format!("posts {apart} cm apart"),
            Drive::Office { laps, drifts } => {
                let drift = if drifts { ", much drift" } else { "" };
                let laps = if laps == 1 { "once" } else { "twice" };
                format!("office {laps}{drift}")
            }
            Drive::Loft(0) => "loft".to_owned(),
            Drive::Loft(share) => format!("loft, {share} % of the walls rough"),
        };
        format!("{drive}, {:.0} mm", self.sigma * 1e3)
    }

    /// The drive's log.
    pub fn log(&self, seed: u64) -> Vec<u8> {
        let simulation = Simulation {
            world: match self.drive {
                Drive::Posts(apart) => row_of_posts(f64::from(apart) / 100.0),
                Drive::ThriceMuchDriftPosts => row_of_posts(0.5),
                Drive::Pillars(radius) => hall(f64::from(radius) / 100.0),
                Drive::Office { .. } => world_of("office"),
                Drive::Loft(_) => world_of("loft"),
                _ => World::room(),
            },
            diffuse: match self.drive {
                Drive::Rough(share) | Drive::Loft(share) => f64::from(share) / 100.0,
                _ => 0.0,
            },
            path: match self.drive {
                Drive::TenLaps => Path::room().repeated(10).unwrap(),
                Drive::ThreeLapsMuchDrift
                | Drive::ThriceMuchDrift
                | Drive::ThriceMuchDriftPosts => Path::room().repeated(3).unwrap(),
                Drive::Pillars(_) => HALL_PATH.parse().unwrap(),
                Drive::Office { laps, .. } => path_of("office").repeated(laps).unwrap(),
                Drive::Loft(_) => path_of("loft"),
                _ => Path::room(),
            },
            motion: match self.drive {
                Drive::Stepwise => Motion::Stepwise(Stepwise::default()),
                Drive::Scans => Motion::Stepwise(Stepwise {
                    step: 0.6,
                    scan: Some(2_f64.to_radians()),
                    ..Stepwise::default()
                }),
                _ => Motion::Driving(Driving::default()),
            },
            ring: Ring {
                sonars: if self.drive == Drive::Scans { 4 } else { 16 },
                ..Ring::default()
            },
            range_noise: RangeNoise {
                sigma: self.sigma,
                outliers: if matches!(self.drive, Drive::MuchDriftOutliers | Drive::Outliers) {
                    0.05
                } else {
                    0.0
                },
                ..RangeNoise::default()
            },
            false_echoes: FalseEchoes {
                cross_talk: if self.drive == Drive::CrossTalk {
                    0.05
                } else {
                    0.0
                },
                ..FalseEchoes::default()
            },
            odometry_noise: match self.drive {
                Drive::LittleDrift => drift(0.002, 0.05, 0.1),
                Drive::MuchDrift
                | Drive::MuchDriftOutliers
                | Drive::ThreeLapsMuchDrift
                | Drive::Office { drifts: true, .. } => drift(0.01, 0.2, 0.5),
                Drive::ThriceMuchDrift | Drive::ThriceMuchDriftPosts => drift(0.03, 0.6, 1.5),
                _ => OdometryNoise::default(),
            },
            untold: Untold::default(),
            late: None,
            silent: Vec::new(),
            without_truth: false,
            seed,
        };
        simulation
            .write(Cursor::new(Vec::new()))
            .unwrap()
            .into_inner()
    }
}

/// Metres and degrees after a metre, degrees after a radian.
fn drift(distance: f64, heading: f64, turn: f64) -> OdometryNoise {
    OdometryNoise {
        distance,
        heading: heading.to_radians(),
        turn: turn.to_radians(),
    }
}

/// The room, but for its long wall along y = 5, in whose place posts stand in a row.
fn row_of_posts(apart: f64) -> World {
    let room = World::room();
    let is_long = |wall: &&Wall| wall.start.y == 5.0 && wall.end.y == 5.0;
    let walls: Vec<Wall> = room
        .walls()
        .iter()
        .filter(|wall| !is_long(wall))
        .copied()
        .collect();
    let count = (8.0 / apart).round() as usize;
    let posts = (1..count).map(|k| Vec2::new(apart * k as f64, 5.0));
    World::new(walls, posts.collect()).unwrap()
}

/// Round the pillars of the hall, and between them.
const HALL_PATH: &str = "1.2,1.2 7.8,1.2 7.8,5.8 1.2,5.8 1.2,3.5 7.8,3.5";

/// A hall of 9 by 7 m with pillars of one radius on the middle lines between the ways.
fn hall(radius: f64) -> World {
    let corners = [(0.0, 0.0), (9.0, 0.0), (9.0, 7.0), (0.0, 7.0)].map(|(x, y)| Vec2::new(x, y));
    let next = corners.iter().cycle().skip(1);
    let walls = corners.iter().zip(next).map(|(a, b)| Wall::new(*a, *b));
    let places = [(3.0, 2.35), (6.0, 2.35), (3.0, 4.65), (6.0, 4.65)];
    let pillars = places.map(|(x, y)| Pillar {
        center: Vec2::new(x, y),
        radius,
    });
    let pillars = pillars.into_iter().filter(|pillar| pillar.radius > 0.0);
    World::with_pillars(walls.collect(), Vec::new(), pillars.collect()).unwrap()
}

fn sample_text(name: &str) -> String {
    std::fs::read_to_string(crate::support::sample(name)).unwrap()
}

pub fn world_of(sample: &str) -> World {
    World::from_json(&sample_text(&format!("{sample}.world.json"))).unwrap()
}

pub fn path_of(sample: &str) -> Path {
    sample_text(&format!("{sample}.waypoints")).parse().unwrap()
}

/// The switches of the noise-aware rule.
const SWITCHES: [&str; 12] = [
    "label_by_opinion",
    "converge",
    "reject_misfits",
    "break_runs",
    "reject_mirrored",
    "fuse_by_information",
    "merge",
    "confirm",
    "end_at_corners",
    "gather",
    "join_corners",
    "crossings",
];

/// TMAM under the noise-aware rule, without what it took over from TBF, with odometry's poses, and under the paper's;
/// and its rivals: their configurations.
pub const METHODS: [(&str, &str); 9] = [
    ("tmam", ""),
    ("tmam, without crossings", "noise_aware.crossings = false\n"),
    ("tmam, odometry's poses", "poses = \"odometry\"\n"),
    ("tmam, paper's rule", "rule = \"paper\"\n"),
    ("two-measurement", "method = \"two-measurement\"\n"),
    ("tbf", "method = \"tbf\"\n"),
    ("atm", "method = \"atm\"\n"),
    ("rcd", "method = \"rcd\"\n"),
    ("crowley", "method = \"crowley\"\n"),
];

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

    /// The noise-aware rule, as it is.
    pub fn noise_aware() -> Self {
        Self(vec![("noise-aware", Config::default())])
    }

    /// The same where rough walls that are seen at an angle support the walls of the map.
    pub fn oblique_walls() -> Self {
        let config = parse("[noise_aware]\noblique_walls = true").unwrap();
        Self(vec![("with oblique_walls", config)])
    }

    /// The noise-aware rule without circles, and with them.
    pub fn circles() -> Self {
        let with = parse("[noise_aware]\ncircles = true").unwrap();
        Self(vec![
            ("without circles", Config::default()),
            ("circles", with),
        ])
    }

    /// The noise-aware rule where the messages' variance is not believed and sigma is measured.
    pub fn measuring() -> Self {
        let config = parse("[noise]\ntrust_variance = false").unwrap();
        Self(vec![("noise-aware", config)])
    }

    /// The noise-aware rule at the poses of odometry, and at poses that are estimated with the features.
    pub fn poses() -> Self {
        let rules = ["odometry", "joint"];
        Self(
            rules
                .map(|name| (name, parse(&format!("poses = \"{name}\"")).unwrap()))
                .to_vec(),
        )
    }

    /// The same estimate where the noise of odometry is told: half, just, and twice what much drift is.
    pub fn told([distance, heading, turn]: [f64; 3]) -> Self {
        let rules = [("told half", 0.5), ("told", 1.0), ("told twice", 2.0)];
        Self(
            rules
                .map(|(name, by)| {
                    let [distance, heading, turn] = [distance, heading, turn].map(|noise| noise * by);
                    let text = format!(
                        "[noise]\nodometry_distance = {distance}\nodometry_heading = {heading}\nodometry_turn = {turn}"
                    );
                    (name, parse(&text).unwrap())
                })
                .to_vec(),
        )
    }

    /// All methods, with frames as fine as dense scans need where these are asked for.
    pub fn methods(dense: bool) -> Self {
        let frames = if dense {
            "frames.step_angle = 1.0\n"
        } else {
            ""
        };
        let all = METHODS.map(|(name, text)| (name, parse(&format!("{text}{frames}")).unwrap()));
        Self(all.to_vec())
    }

    /// Of these rules some alone.
    pub fn only(mut self, names: &[&str]) -> Self {
        self.0.retain(|(name, _)| names.contains(name));
        self
    }

    /// All methods, and TMAM with circles beside them.
    pub fn methods_and_circles() -> Self {
        let Self(mut all) = Self::methods(false);
        let config = parse("noise_aware.circles = true").unwrap();
        all.insert(1, ("tmam, circles", config));
        Self(all)
    }

    /// The noise-aware rule, and it without each of its switches.
    pub fn without_each() -> Self {
        let mut rules = vec![("all", Config::default())];
        for switch in SWITCHES {
            let text = format!("[noise_aware]\n{switch} = false");
            rules.push((switch, parse(&text).unwrap()));
        }
        Self(rules)
    }

    /// A log replayed under each of them.
    pub fn replay(&self, log: &Log) -> Vec<(&'static str, Outcome)> {
        let outcome = |config| Replay::new(log, config).unwrap().run(&mut []).unwrap();
        let rules = self.0.iter();
        rules
            .map(|(name, config)| (*name, outcome(config)))
            .collect()
    }

    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.iter().map(|(name, _)| *name)
    }
}

/// Of each rule, the scores over the seeds.
pub fn run(case: Case, seeds: RangeInclusive<u64>, rules: &Rules) -> Vec<Vec<Evaluation>> {
    let of_seed = |seed| -> Vec<Evaluation> {
        let bytes = case.log(seed);
        let (log, recorded) =
            read_with_truth_in(Cursor::new(bytes), "room.mcap", &Config::default()).unwrap();
        assert!(log.losses.is_empty(), "{:?}", log.losses);
        let score = |(_, config): &(_, Config)| {
            let replay = Replay::new(&log, config).unwrap();
            let truth = Truth::new(&replay, &recorded, None, AGREEING_RANGE).unwrap();
            let outcome = replay.run(&mut []).unwrap();
            Evaluation::new(&truth, &replay.path(&outcome), &outcome)
        };
        rules.0.iter().map(score).collect()
    };
    let by_seed: Vec<Vec<Evaluation>> = seeds.into_par_iter().map(of_seed).collect();
    let mut by_rule: Vec<Vec<Evaluation>> = rules.0.iter().map(|_| Vec::new()).collect();
    for of_seed in by_seed {
        for (score, scores) in of_seed.into_iter().zip(&mut by_rule) {
            scores.push(score);
        }
    }
    by_rule
}
