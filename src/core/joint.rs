//! Poses and features estimated together, from odometry and from what a replay made of the ranges.
//!
//! A replay takes the poses of odometry for true. Where they drift, it sees a wall again somewhere else.
//! Here the poses are unknowns as well: what was seen twice pulls the path straight
//! (`docs/algorithm.md`). Batch, at the end of the log: Gauss-Newton over key poses and landmarks.

pub mod arrowhead;
mod association;
pub mod drift;
pub mod key_pose;
pub mod landmark;
mod merge;
pub mod path;
mod problem;
#[cfg(test)]
pub mod testing;

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, Matrix2, Vector2};

use self::association::Association;
use self::drift::Drift;
use self::key_pose::{Between, KeyPose, between, key_poses};
use self::landmark::Landmark;
use self::merge::Seen;
use self::path::CorrectedPath;
use self::problem::{Fitted, Incidence, Problem, Sighting, Unknowns};
use crate::core::config::Config;
use crate::core::event::SonarId;
use crate::core::frames::Frame;
use crate::core::geometry::Pose2;
use crate::core::tmam::arc::{Arc, ArcId};
use crate::core::tmam::feature::{MapFeature, Segment, Shape};
use crate::core::tmam::map::{corners, ends, refine};
use crate::core::tmam::prediction::{MapPrediction, Reach};
use crate::core::tmam::step::{Closure, Extraction};

/// A landmark has this many readings at least.
const FEWEST: usize = 3;

/// Fewer landmarks do not hold a path.
const FEWEST_LANDMARKS: usize = 3;

/// Key poses times unknowns of landmarks squared, at most: what a solve takes grows with it, to some ten
/// seconds here.
const MOST_WORK: usize = 4_000_000_000;

/// This near to its end a wall is not told from its corner, metres.
const MARGIN: f64 = 0.05;

/// The noise of odometry before anything is known of it: more than most robots have, since too much costs
/// little.
const AT_FIRST: Drift = Drift {
    distance: 0.02,
    heading: 0.007,
    turn: 0.017,
};

/// Corrected poses must make the ranges likelier by so much in the logarithm. Of exact poses one log in twenty
/// does more: a noise cannot be less than none, so twice the gain is a mixture of chi2 with none to three
/// degrees of freedom (chi-bar-square).
const DECISIVE: f64 = 2.7;

/// A map that explains a smaller share of the arcs does not say where the robot was: then only sonars of which more
/// is explained are asked.
const LEAST_EXPLAINED: f64 = 0.3;

/// Of the arcs that are explained beyond chance, the share that may be so no longer: by which short pieces a map has
/// three in a hundred come and go. A loop that is closed wrongly costs a fifth.
const SHARE_LOST: f64 = 0.05;

/// Ranges that are off by so much are explained by chance, metres.
const ASTRAY: f64 = 0.3;

/// Rounds of merging after which it ends in any case.
const MAX_ROUNDS: usize = 8;

/// Gathering opens the gate of three standard deviations by so many more, in turn.
const SLACKS: [f64; 3] = [2.0, 1.0, 0.0];

/// How often the noise of odometry is learnt, at most, and what it must gain in the logarithm of the
/// likelihood to go on.
const LEARNT: usize = 10;
const LEARNING_ENDS: f64 = 0.1;

/// A feature is seen again where the robot drove on by so much without seeing it, metres: a loop that is
/// closed. What is seen sooner are pieces of one sight.
const ELSEWHERE: f64 = 2.0;

/// Chi2 that merges may cost: each so much on average (of a true one it has two degrees of freedom), and
/// all of them together so much more.
const COST_EACH: f64 = 4.0;
const COST_OF_ALL: f64 = 16.0;

/// What the joint estimate is made from.
#[derive(Debug)]
pub struct Evidence<'a> {
    /// Frames at the poses of odometry.
    pub frames: &'a [Frame],
    /// Every arc at the pose of odometry, by frame and sonar.
    pub arcs: &'a [Arc],
    /// Sonars of which hardly a triple is explained: where the map explains little, they correct no pose.
    pub hardly: &'a BTreeSet<SonarId>,
}

impl Evidence<'_> {
    /// That of the first frames.
    pub fn until(&self, frames: usize) -> Self {
        let frames = self.frames.get(..frames).unwrap_or(self.frames);
        let last = frames.last().map(|frame| frame.index);
        let arcs = (self.arcs).partition_point(|arc| Some(arc.id.frame) <= last);
        Self {
            frames,
            arcs: self.arcs.get(..arcs).unwrap_or(self.arcs),
            hardly: self.hardly,
        }
    }

    /// The arcs of the other sonars.
    fn believed(&self) -> Vec<Arc> {
        let believed = |arc: &&Arc| !self.hardly.contains(&arc.id.sonar);
        self.arcs.iter().filter(believed).copied().collect()
    }
}

/// Poses and features that fit the ranges and odometry together.
#[derive(Debug, Clone, PartialEq)]
pub struct JointEstimate {
    /// The path.
    pub path: CorrectedPath,
    /// The map; covariances are joint with those of the path.
    pub features: Vec<MapFeature>,
    /// The map with the covariances that it has where the path is given.
    pub features_given_path: Vec<MapFeature>,
    /// By how much odometry is too short, of distance and of rotation, as shares.
    pub scales: [f64; 2],
    /// Their standard deviations.
    pub scale_sigmas: [f64; 2],
    /// What was seen again after the robot was elsewhere, in the order in which it was found out.
    pub closures: Vec<Closure>,
    /// Features of the replay that turned out to be others, and are gone.
    pub absorbed: Vec<u32>,
    /// Each arc's sensor as odometry has it.
    pub odom_from_sensor: BTreeMap<ArcId, Pose2>,
    /// The arcs that the map explains, at the poses of odometry and at these.
    pub explained: [Explained; 2],
}

/// The share of arcs that a map explains.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Explained {
    /// Of all arcs.
    pub share: f64,
    /// Of arcs whose ranges are off: a map in which walls are there twice explains more by chance.
    by_chance: f64,
}

/// Why the poses stay those of odometry.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum OdometryKept {
    /// The ranges are as likely at the poses of odometry.
    #[error("the ranges fit no better at other poses")]
    Agrees,
    /// Nothing that the path could be held against.
    #[error(
        "too little is seen: {landmarks} features with {FEWEST} readings or more along {keys} key poses"
    )]
    TooLittle {
        /// Features with enough readings.
        landmarks: usize,
        /// Key poses of the path.
        keys: usize,
    },
    /// More than can be solved in bounded time and memory.
    #[error(
        "{landmarks} features along {keys} key poses are too many to estimate together; \
         --start and --end replay a part of the log"
    )]
    TooMuch {
        /// Features with enough readings.
        landmarks: usize,
        /// Key poses of the path.
        keys: usize,
    },
    /// Most of what was heard came from nothing in the map: too little to hold a path against.
    #[error(
        "of the sonars that hear walls and points, the map explains only {:.0} % of the arcs: too little to \
         correct odometry by it", 100.0 * .0
    )]
    LittleExplained(f64),
    /// What comes out explains less.
    #[error(
        "corrected poses explain {:.1} % of the arcs beyond chance, odometry {:.1} %: something was taken for something \
         else", 100.0 * after, 100.0 * before
    )]
    ExplainsLess {
        /// Share of arcs at the poses of odometry.
        before: f64,
        /// Share at the corrected poses.
        after: f64,
    },
    /// Odometry that bad is broken, or its clock or mounts are.
    #[error(
        "odometry would be off by {:.0} cm and {:.1} deg after a metre and by {:.1} deg after a turn of a \
         radian: that is no noise; look for a cause with tmam info",
        100.0 * .0.distance, .0.heading.to_degrees(), .0.turn.to_degrees()
    )]
    Implausible(Drift),
    /// The equations have no solution.
    #[error("the ranges do not determine the poses")]
    Undetermined,
}

/// The state of an estimate on its way.
struct Solver<'a> {
    arcs: Vec<Arc>,
    places: BTreeMap<ArcId, usize>,
    keys: Vec<KeyPose>,
    reach: Reach,
    drift: Drift,
    /// Whether corners are on the walls that meet in them.
    join_corners: bool,
    config: &'a Config,
}

/// A solved problem, and which landmark is which feature.
struct Solved {
    problem: Problem,
    fitted: Fitted,
    ids: Vec<u32>,
}

/// A solved problem, and what was merged on the way to it.
struct Settled {
    solved: Solved,
    closures: Vec<Closure>,
    absorbed: Vec<u32>,
}

/// Estimates poses and features together. `extractions` and `map` are those of a replay at the poses of
/// `start`, or of odometry where that is `None`.
///
/// # Errors
/// Where odometry is to be kept, and why.
pub fn estimate(
    evidence: &Evidence,
    extractions: &[&Extraction],
    map: &[MapFeature],
    start: Option<&JointEstimate>,
    config: &Config,
) -> Result<JointEstimate, OdometryKept> {
    let of = |arcs| estimate_by(arcs, evidence, extractions, map, start, config);
    match of(evidence.arcs.to_vec()) {
        Err(little @ OdometryKept::LittleExplained(_)) if !evidence.hardly.is_empty() => {
            match of(evidence.believed()) {
                Err(OdometryKept::TooLittle { .. }) => Err(little),
                found => found,
            }
        }
        found => found,
    }
}

/// The same by some of the arcs.
fn estimate_by(
    arcs: Vec<Arc>,
    evidence: &Evidence,
    extractions: &[&Extraction],
    map: &[MapFeature],
    start: Option<&JointEstimate>,
    config: &Config,
) -> Result<JointEstimate, OdometryKept> {
    let before = match start {
        Some(start) => start.explained[0],
        None => explained(map, evidence.arcs, config),
    };
    let mut solver = Solver::new(evidence, arcs, start, config);
    let mut association = Association::of_replay(extractions, map);
    let owners = &mut association.owners;
    owners.retain(|arc, _| solver.places.contains_key(arc));
    let counts = association.counts();
    let landmarks = counts
        .iter()
        .filter(|(id, (count, _))| *count >= FEWEST && association.is_landmark(**id))
        .count();
    let keys = solver.keys.len();
    if keys < 2 || landmarks < FEWEST_LANDMARKS {
        return Err(OdometryKept::TooLittle { landmarks, keys });
    }
    if !is_bounded(landmarks, keys) {
        return Err(OdometryKept::TooMuch { landmarks, keys });
    }
    let Settled {
        solved,
        closures,
        absorbed,
    } = solver
        .settle(&mut association, start)
        .ok_or(OdometryKept::Undetermined)?;
    let undetermined = OdometryKept::Undetermined;
    if start.is_none()
        && !is_told(config)
        && !solver
            .is_likelier(&association, &solved)
            .ok_or(undetermined)?
    {
        return Err(OdometryKept::Agrees);
    }
    if solver.drift.is_implausible() {
        return Err(OdometryKept::Implausible(solver.drift));
    }
    let shared = solved.fitted.factor.shared_covariance();
    let mut path = solver.path(&solved.fitted);
    let covariances = solved.fitted.factor.pose_covariances(&shared);
    path.covariances = covariances.own;
    let features_given_path = association.features;
    let explained_of = |arcs: &[Arc]| {
        let arcs = solver.corrected(arcs, &path, 1.0);
        explained(&features_given_path, &arcs, config)
    };
    let of_believed = explained_of(&solver.arcs).share;
    if of_believed < LEAST_EXPLAINED {
        return Err(OdometryKept::LittleExplained(of_believed));
    }
    let explained = [before, explained_of(evidence.arcs)];
    let [before, after] = explained.map(|it| it.beyond_chance());
    if after < before * (1.0 - SHARE_LOST) {
        return Err(OdometryKept::ExplainsLess { before, after });
    }
    Ok(JointEstimate {
        path,
        features: solved.joint(&features_given_path, &shared, &solver),
        features_given_path,
        scales: solved.fitted.unknowns.scales.into(),
        scale_sigmas: [0, 1].map(|at| {
            shared
                .get((at, at))
                .map_or(0.0, |variance| variance.max(0.0).sqrt())
        }),
        closures,
        absorbed,
        odom_from_sensor: (evidence.arcs.iter())
            .map(|arc| (arc.id, arc.world_from_sensor))
            .collect(),
        explained,
    })
}

fn is_bounded(landmarks: usize, keys: usize) -> bool {
    let unknowns = landmarks.saturating_mul(2);
    unknowns.saturating_mul(unknowns).saturating_mul(keys) <= MOST_WORK
}

/// The noise of odometry, as far as the configuration does not say it.
fn given(found: Drift, config: &Config) -> Drift {
    Drift {
        distance: config.noise.odometry_distance.unwrap_or(found.distance),
        heading: config.noise.odometry_heading.unwrap_or(found.heading),
        turn: config.noise.odometry_turn.unwrap_or(found.turn),
    }
}

/// Whether the configuration says that odometry drifts: then ranges that would be as likely without say nothing
/// against it.
fn is_told(config: &Config) -> bool {
    let told = given(Drift::NONE, config);
    told != Drift::NONE
}

/// The arcs that a map explains.
pub fn explained(map: &[MapFeature], arcs: &[Arc], config: &Config) -> Explained {
    let reach = Reach::of(config.map.max_wall_gap);
    let prediction = MapPrediction::new(map, &reach);
    let share = |off: f64| {
        let explained = arcs.iter().filter(|arc| {
            let range = arc.range + off;
            prediction.residual(&Arc { range, ..**arc }).is_some()
        });
        explained.count() as f64 / arcs.len().max(1) as f64
    };
    Explained {
        share: share(0.0),
        by_chance: (share(ASTRAY) + share(-ASTRAY)) / 2.0,
    }
}

impl Explained {
    /// What is explained beyond chance, as a share of all arcs.
    fn beyond_chance(&self) -> f64 {
        self.share - self.by_chance
    }
}

impl<'a> Solver<'a> {
    fn new(
        evidence: &Evidence,
        arcs: Vec<Arc>,
        start: Option<&JointEstimate>,
        config: &'a Config,
    ) -> Self {
        Self {
            places: (arcs.iter().enumerate())
                .map(|(place, arc)| (arc.id, place))
                .collect(),
            arcs,
            reach: Reach {
                margin: MARGIN,
                ..Reach::of(config.map.max_wall_gap)
            },
            drift: start.map_or_else(|| given(AT_FIRST, config), |start| start.path.drift),
            config,
            keys: key_poses(evidence.frames),
            join_corners: false,
        }
    }

    /// Solves, merges what is one, learns the noise of odometry, and gathers readings.
    fn settle(
        &mut self,
        association: &mut Association,
        start: Option<&JointEstimate>,
    ) -> Option<Settled> {
        let (poses, scales) = match start {
            Some(start) => (start.path.at(&self.keys), start.scales.into()),
            None => {
                let poses = self.keys.iter().map(|key| key.odom_from_robot);
                (poses.collect(), Vector2::zeros())
            }
        };
        let mut settled = Settled {
            solved: self.solve(association, poses, scales)?,
            closures: start.map_or_else(Vec::new, |start| start.closures.clone()),
            absorbed: Vec::new(),
        };
        self.merge(association, &mut settled)?;
        self.learn(association, &mut settled.solved)?;
        for slack in SLACKS {
            let path = self.path(&settled.solved.fitted);
            let arcs = self.corrected(&self.arcs, &path, 1.0 + slack / 3.0);
            *association = association.gathered(&arcs, &self.reach);
            settled.solved = self.again(association, &settled.solved)?;
            self.merge(association, &mut settled)?;
        }
        self.join_corners = self.config.noise_aware.join_corners;
        settled.solved = self.again(association, &settled.solved)?;
        self.learn(association, &mut settled.solved)?;
        Some(settled)
    }

    /// Whether the ranges are likelier with the noise of odometry that was found than without any.
    fn is_likelier(&mut self, association: &Association, solved: &Solved) -> Option<bool> {
        let found = std::mem::replace(&mut self.drift, Drift::NONE);
        let without = self.again(&mut association.clone(), solved);
        self.drift = found;
        Some(solved.log_evidence() > without?.log_evidence() + DECISIVE)
    }
}

impl Solver<'_> {
    /// Solves for the landmarks that have enough readings, and puts them where they are then.
    fn solve(
        &self,
        association: &mut Association,
        poses: Vec<Pose2>,
        scales: Vector2<f64>,
    ) -> Option<Solved> {
        // In the order in which they are first seen: the poses before have nothing to do with them.
        let mut ids: Vec<(ArcId, u32)> = (association.counts().iter())
            .filter(|(_, (count, _))| *count >= FEWEST)
            .filter(|(id, _)| association.is_landmark(**id))
            .map(|(id, (_, first))| (*first, *id))
            .collect();
        ids.sort_unstable();
        let ids: Vec<u32> = ids.into_iter().map(|(_, id)| id).collect();
        let by_id = self.landmark_places(&ids);
        let landmark = |id: &u32| Landmark::of(&association.feature(*id)?.shape);
        let landmarks: Option<Vec<Landmark>> = ids.iter().map(landmark).collect();
        let sightings = association
            .owners
            .iter()
            .filter_map(|(arc, owner)| self.sighting(arc, *by_id.get(owner)?));
        let incidences = self.incidences(association, &by_id);
        let problem = Problem::new(&self.keys, sightings.collect(), incidences, self.drift)?;
        let fitted = problem.solve(Unknowns {
            poses,
            landmarks: landmarks?,
            scales,
        })?;
        let solved = Solved {
            problem,
            fitted,
            ids,
        };
        solved.place(association, self);
        Some(solved)
    }

    /// Corners on the two walls that meet in them.
    fn incidences(
        &self,
        association: &Association,
        places: &BTreeMap<u32, usize>,
    ) -> Vec<Incidence> {
        if !self.join_corners {
            return Vec::new();
        }
        let meetings = corners::meetings(&association.features).into_iter();
        meetings
            .filter_map(|(point, lines)| {
                let point = *places.get(&point)?;
                let [a, b] = [places.get(&lines[0])?, places.get(&lines[1])?];
                Some([a, b].map(|line| Incidence { point, line: *line }))
            })
            .flatten()
            .collect()
    }

    /// Learns the noise of odometry: expectation maximisation, whose strides grow as long as they make the
    /// ranges more likely; it is slow where ranges tell little.
    fn learn(&mut self, association: &mut Association, solved: &mut Solved) -> Option<()> {
        let mut stride = 1.0;
        for _ in 0..LEARNT {
            let evidence = solved.log_evidence();
            let before = self.drift;
            let learnt = solved.problem.learn(&solved.fitted)?;
            self.drift = given(before.towards(&learnt, stride), self.config);
            let mut found = self.again(association, solved)?;
            if found.log_evidence() < evidence && stride > 1.0 {
                stride = 1.0;
                self.drift = given(before.towards(&learnt, stride), self.config);
                found = self.again(association, solved)?;
            } else {
                stride *= 2.0;
            }
            let gained = found.log_evidence() - evidence;
            *solved = found;
            if gained.abs() < LEARNING_ENDS {
                break;
            }
        }
        Some(())
    }

    fn again(&self, association: &mut Association, solved: &Solved) -> Option<Solved> {
        let now = &solved.fitted.unknowns;
        self.solve(association, now.poses.clone(), now.scales)
    }

    fn landmark_places(&self, ids: &[u32]) -> BTreeMap<u32, usize> {
        ids.iter().enumerate().map(|(at, id)| (*id, at)).collect()
    }

    fn sighting(&self, arc: &ArcId, landmark: usize) -> Option<Sighting> {
        let arc = self.arcs.get(*self.places.get(arc)?)?;
        let at = between(&self.keys, arc.stamp_ns);
        let from = |key: usize| {
            let key = self.keys.get(key)?;
            Some(key.odom_from_robot.inverse_transform(arc.center()))
        };
        Some(Sighting {
            arc: arc.id,
            landmark,
            earlier: at.earlier,
            share: at.share,
            robot_from_sensor: [from(at.earlier)?, from(at.earlier + 1)?],
            range: arc.range,
            variance: arc.variance + self.between_key_poses(arc),
        })
    }

    fn between_key_poses(&self, arc: &Arc) -> f64 {
        let bearing = arc.world_from_sensor.yaw;
        (self.drift).between_key_poses(&self.keys, arc.stamp_ns, bearing)
    }

    fn path(&self, fitted: &Fitted) -> CorrectedPath {
        CorrectedPath {
            keys: self.keys.clone(),
            world_from_robot: fitted.unknowns.poses.clone(),
            covariances: Vec::new(),
            drift: self.drift,
        }
    }

    /// Every arc where the path has it, with a deviation so many times its own.
    fn corrected(&self, arcs: &[Arc], path: &CorrectedPath, wider: f64) -> Vec<Arc> {
        let arcs = arcs.iter();
        arcs.map(|arc| Arc {
            world_from_sensor: path.correct(arc.stamp_ns, &arc.world_from_sensor),
            variance: (arc.variance + self.between_key_poses(arc)) * wider * wider,
            ..*arc
        })
        .collect()
    }

    /// Merges what is one, as long as the cost does not jump.
    fn merge(&self, association: &mut Association, settled: &mut Settled) -> Option<()> {
        let Settled {
            solved,
            closures,
            absorbed,
        } = settled;
        for _ in 0..MAX_ROUNDS {
            let mut pairs = solved.pairs(association);
            loop {
                if pairs.is_empty() {
                    return Some(());
                }
                let mut tried = association.clone();
                for (kept, gone) in &pairs {
                    tried.merge(*kept, *gone, self.config.map.confirm_runs);
                }
                let found = self.again(&mut tried, solved);
                let allowed = COST_EACH * pairs.len() as f64 + COST_OF_ALL;
                match found {
                    Some(found) if found.fitted.cost - solved.fitted.cost <= allowed => {
                        closures.extend(
                            pairs
                                .iter()
                                .filter_map(|pair| self.closure(association, pair)),
                        );
                        absorbed.extend(pairs.iter().map(|(_, gone)| *gone));
                        *association = tried;
                        *solved = found;
                        break;
                    }
                    _ => pairs.truncate(pairs.len() / 2),
                }
            }
        }
        Some(())
    }

    /// A loop that is closed, if the robot drove on between the last it saw of the one feature and the first
    /// it saw of the other.
    fn closure(&self, association: &Association, (kept, gone): &(u32, u32)) -> Option<Closure> {
        let of = |id: u32| {
            let owners = association
                .owners
                .iter()
                .filter(move |(_, owner)| **owner == id);
            owners.filter_map(|(arc, _)| self.arcs.get(*self.places.get(arc)?))
        };
        let (first, again) = (of(*kept).next()?, of(*gone).next()?);
        let last = of(*kept).take_while(|arc| arc.id < again.id).last()?;
        let driven = self.driven(again.stamp_ns) - self.driven(last.stamp_ns);
        let shape = association.feature(*kept)?.shape;
        (driven >= ELSEWHERE).then_some(Closure {
            kind: shape.kind(),
            place: shape.middle(),
            frames: [first.id.frame, again.id.frame],
        })
    }

    /// The way from the first key pose to a stamp by odometry, metres.
    fn driven(&self, stamp_ns: i64) -> f64 {
        let Between { earlier, share } = between(&self.keys, stamp_ns);
        let until: f64 = (self.keys.iter().take(earlier + 1))
            .map(|key| key.driven)
            .sum();
        until + share * self.keys.get(earlier + 1).map_or(0.0, |key| key.driven)
    }
}

impl Solved {
    fn log_evidence(&self) -> f64 {
        self.problem.log_evidence(&self.fitted)
    }

    /// Pairs of features that are one, as (id that stays, id that goes).
    fn pairs(&self, association: &Association) -> Vec<(u32, u32)> {
        let landmarks = self.fitted.unknowns.landmarks.iter().zip(&self.ids);
        let seen: Vec<Seen> = landmarks
            .enumerate()
            .map(|(place, (landmark, id))| Seen {
                landmark: *landmark,
                extent: extent(association, *id),
                at: 2 + 2 * place,
            })
            .collect();
        let pairs = merge::pairs(&seen, self.fitted.factor.shared_covariance());
        let ids = pairs.iter().filter_map(|pair| {
            let (a, b) = (*self.ids.get(pair.first)?, *self.ids.get(pair.second)?);
            Some((a, b))
        });
        ids.collect()
    }

    /// Puts the features where the landmarks are, with the covariances that they have given the path.
    fn place(&self, association: &mut Association, solver: &Solver) {
        let unknowns = &self.fitted.unknowns;
        let mut information = vec![Matrix2::zeros(); self.ids.len()];
        let mut sensors = vec![Vec::new(); self.ids.len()];
        for sighting in self.problem.sightings() {
            let at = sighting.landmark;
            if let Some(sensor) = sighting.sensor(&unknowns.poses)
                && let Some(landmark) = unknowns.landmarks.get(at)
                && let Some(predicted) = landmark.predict(sensor)
                && let Some(information) = information.get_mut(at)
                && let Some(sensors) = sensors.get_mut(at)
            {
                let by = predicted.by_landmark;
                *information += by.transpose() * by / sighting.variance;
                sensors.push(sensor);
            }
        }
        let readings: Vec<usize> = sensors.iter().map(Vec::len).collect();
        let places = solver.landmark_places(&self.ids);
        for (arc, id) in &association.by_runs {
            if let Some(at) = places.get(id)
                && let Some(sensors) = sensors.get_mut(*at)
                && let Some(sighting) = solver.sighting(arc, *at)
            {
                sensors.extend(sighting.sensor(&unknowns.poses));
            }
        }
        for feature in &mut association.features {
            if let Some(at) = places.get(&feature.id)
                && let Some(landmark) = unknowns.landmarks.get(*at)
                && let Some(covariance) = information.get(*at).and_then(|i| i.try_inverse())
                && let (Some(sensors), Some(readings)) = (sensors.get(*at), readings.get(*at))
            {
                feature.shape = landmark.shape(covariance, sensors);
                feature.readings = u32::try_from(*readings).unwrap_or(u32::MAX);
            }
        }
        if solver.config.noise_aware.end_at_corners {
            let points = refine::confirmed_points(&association.features);
            for feature in &mut association.features {
                feature.shape = ends::cut(feature.shape, &points);
            }
        }
    }

    /// The features with their joint covariances.
    fn joint(
        &self,
        features: &[MapFeature],
        shared: &DMatrix<f64>,
        solver: &Solver,
    ) -> Vec<MapFeature> {
        let places = solver.landmark_places(&self.ids);
        let mut joint = features.to_vec();
        for feature in &mut joint {
            if let Some(at) = places.get(&feature.id)
                && let Some(landmark) = self.fitted.unknowns.landmarks.get(*at)
            {
                let block = shared.fixed_view::<2, 2>(2 + 2 * at, 2 + 2 * at);
                feature.shape = landmark.covering(block.into_owned(), &feature.shape);
            }
        }
        joint
    }
}

/// Where a line reaches.
fn extent(association: &Association, id: u32) -> Option<Segment> {
    match association.feature(id)?.shape {
        Shape::Line(segment) => Some(segment),
        Shape::Point(_) | Shape::Circle(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::replay::Replay;

    #[test]
    fn sonars_that_hear_none_of_the_map_leave_the_poses_to_the_others() {
        let config = Config::default();
        let mut log = testing::drifting_room(1);
        let path = |log: &_| {
            let replay = Replay::new(log, &config).unwrap();
            let outcome = replay.run(&mut []).unwrap();
            outcome.poses.unwrap().map(|joint| joint.path)
        };
        let of_all = path(&log).unwrap();
        // All but those that look to the sides hear noise.
        let mut at = 0;
        log.events.readings.change(|reading| {
            if ![4, 12].contains(&reading.sonar.0) {
                reading.range += 0.4 * libm::sin(f64::from(at));
            }
            at += 1;
        });
        let of_two = path(&log).unwrap();
        let last = of_two.covariances.last().unwrap();
        let sigma = (last.m11 + last.m22).sqrt();
        let end = |path: &CorrectedPath| path.world_from_robot.last().unwrap().position();
        let off = (end(&of_two) - end(&of_all)).norm();
        let odometry = of_all.end_correction();
        assert!(
            off < 3.0 * sigma && off < odometry / 2.0,
            "{off} {sigma} {odometry}"
        );
    }

    #[test]
    fn what_is_solved_is_bounded() {
        // Twice round the office of the sample logs, and what no drive has.
        assert!(is_bounded(365, 1904));
        assert!(is_bounded(500, 4000));
        assert!(!is_bounded(501, 4000) && !is_bounded(20_000, 10));
        assert!(!is_bounded(usize::MAX, usize::MAX));
    }
}
