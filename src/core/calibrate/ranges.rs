//! Where sonars are, by how much their ranges are off, when they were taken and how long odometry's metre
//! is: least squares over the range residuals (6) and (7) of all readings, whatever the beams hold.
//!
//! The features are unknowns as well, and so are the poses where these are estimated: what explains the
//! same residuals as they do counts for nothing. A feature that one sonar alone supports says nothing of
//! that sonar as long as another one is near.

use std::collections::BTreeMap;

use nalgebra::{Cholesky, DMatrix, DVector, RowVector2, Vector2, Vector3};

use super::change::scaled;
use super::parameter::{Parameter, Quantity, Whose};
use super::seen::{Ping, Place, Scene};
use crate::core::event::SonarId;
use crate::core::geometry::{Pose2, Vec2, angle_between, rotate, unit};
use crate::core::joint::arrowhead::{Arrowhead, Row, Solution};
use crate::core::joint::drift::{Drift, Increment};
use crate::core::joint::key_pose::{KeyPose, between, key_poses};
use crate::core::odometry::Track;
use crate::core::replay::{Outcome, Replay};

/// What all sonars share, with its standard deviation before the log is looked at.
const SHARED: [(Parameter, f64); 4] = [
    (Parameter::OdometryScale, 0.05),
    (Parameter::OdometryTurnScale, 0.05),
    (Parameter::RangeDelay, 0.3),
    (Parameter::ClockRate, 0.01),
];
/// The unknowns of one sonar, likewise.
const OF_SONAR: [(Quantity, f64); 4] = [
    (Quantity::X, 0.1),
    (Quantity::Y, 0.1),
    (Quantity::RangeScale, 0.1),
    (Quantity::RangeOffset, 0.1),
];
/// The same where each sonar's clock is asked for: a delay stands for a mount along the way, and is not told from it
/// where both are unknown.
const CLOCK_OF_SONAR: [(Quantity, f64); 1] = [(Quantity::Delay, 0.3)];
/// The same of the parameters of features, metres and radians.
const ANYWHERE: f64 = 100.0;

/// How far a range may be off its feature, in turn, metres; in the end only by the noise.
const GATES: [f64; 5] = [0.15, 0.10, 0.05, 0.02, 0.0];
pub const SIGMAS: f64 = 3.5;

/// What maps are off by beside the noise, metres.
pub const OF_MAP: f64 = 0.001;

/// A bearing may be so far outside of the beam, radians: mounts are turned.
pub const BESIDE_BEAM: f64 = 0.2;

/// How far beyond a line's ends its foot may be, metres.
pub const BEYOND_END: f64 = 0.05;

/// Features with fewer readings of other sonars are a sonar's own.
pub const OF_OTHERS: usize = 3;

/// The step by which derivatives by scales are taken.
const STEP: f64 = 1e-4;

/// What the ranges say.
#[derive(Debug, Clone)]
pub struct RangeEstimate {
    /// The parameters, as they lie in what follows.
    pub parameters: Vec<Parameter>,
    /// Best values of all of them together, as changes of what is configured.
    pub together: DVector<f64>,
    /// The information on them, features and poses being whatever they are.
    pub information: DMatrix<f64>,
    /// By how much the variance of each is more than their noise says, since what is off is off for many
    /// readings together: a factor.
    pub inflation: Vec<f64>,
    /// Readings of features, by sonar.
    pub readings: Vec<usize>,
}

/// Some parameters alone, the others being as configured.
#[derive(Debug, Clone, PartialEq)]
pub struct Alone {
    /// Their values.
    pub values: Vec<(Parameter, f64)>,
    /// Their standard deviations.
    pub deviations: Vec<f64>,
    /// By how much the log is likelier with them, in natural logarithms.
    pub gain: f64,
}

/// What is unknown of the sonars.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unknown {
    /// Their mounts, and the scales and offsets of their ranges.
    Mounts,
    /// Their clocks.
    Clocks,
}

impl Unknown {
    fn of_sonar(self) -> &'static [(Quantity, f64)] {
        match self {
            Self::Mounts => &OF_SONAR,
            Self::Clocks => &CLOCK_OF_SONAR,
        }
    }
}

struct Problem<'a> {
    scene: &'a Scene,
    unknown: Unknown,
    /// When the clocks started.
    origin_ns: i64,
    keys: Vec<KeyPose>,
    /// `None` where the poses are exact.
    drift: Option<Drift>,
    /// Of each ping, the derivatives of the sensor's place by the scales of odometry.
    by_scales: Vec<[Vec2; 2]>,
    /// Of each ping, the direction of the robot's x axis.
    ahead: Vec<Vec2>,
    /// Of each ping, its sensor in the robot's frame at the two key poses around it, with their weights; none
    /// where the poses are exact.
    at_keys: Vec<[(usize, Vec2, f64); 2]>,
}

/// The unknowns on their way.
#[derive(Clone)]
struct State {
    poses: Vec<Pose2>,
    parameters: DVector<f64>,
    places: Vec<Place>,
}

/// What a reading is held against.
#[derive(Clone, Copy)]
struct Match {
    ping: usize,
    place: usize,
}

/// What a reading says of the unknowns that are not poses.
struct Residual {
    by_shared: Vec<(usize, f64)>,
    by_sensor: RowVector2<f64>,
    /// Measured less predicted, metres.
    residual: f64,
    variance: f64,
}

/// What the ranges of a replay say of its parameters; `None` where there is too little.
pub fn estimate(
    scene: &Scene,
    unknown: Unknown,
    replay: &Replay<'_>,
    outcome: &Outcome,
) -> Option<RangeEstimate> {
    let problem = Problem::new(scene, unknown, replay, outcome);
    let mut state = problem.start(outcome);
    let mut matches = Vec::new();
    let mut factor = None;
    for gate in GATES {
        matches = problem.matches(&state, gate);
        let found = problem.system(&state, &matches).factor()?;
        state = problem.moved(&state, &found.solution());
        factor = Some(found);
    }
    let count = problem.parameters();
    let shared = factor?.shared_covariance();
    let covariance = shared.view((0, 0), (count, count)).into_owned();
    // Where the poses are unknown, they take what would be off together.
    let clustered = match problem.drift {
        None => problem.clustered(&state, &matches, &shared),
        Some(_) => vec![0.0; count],
    };
    let both = covariance.diagonal();
    let both = both.iter().zip(&clustered);
    let inflation = both.map(|(fisher, clustered)| (clustered / fisher).max(1.0));
    let inflation = inflation.collect();
    let mut readings = vec![0; scene.mounts.len()];
    for one in &matches {
        let ping = scene.pings.get(one.ping)?;
        if let Some(count) = readings.get_mut(ping.sonar.index()) {
            *count += 1;
        }
    }
    Some(RangeEstimate {
        parameters: problem.named(),
        together: state.parameters,
        information: covariance.try_inverse()?,
        inflation,
        readings,
    })
}

impl RangeEstimate {
    /// Some parameters alone, the others as configured.
    pub fn alone(&self, parameters: &[Parameter]) -> Option<Alone> {
        let mut directions = DMatrix::zeros(self.parameters.len(), parameters.len());
        let mut more = 1.0_f64;
        for (column, parameter) in parameters.iter().enumerate() {
            for (row, own) in self.parameters.iter().enumerate() {
                let is_part = match (parameter, own) {
                    (Parameter::Sonar(Whose::All, of), Parameter::Sonar(_, own)) => of == own,
                    (parameter, own) => parameter == own,
                };
                if is_part {
                    *directions.get_mut((row, column))? = 1.0;
                    more = more.max(self.inflation.get(row).copied().unwrap_or(1.0));
                }
            }
        }
        let gradient = directions.transpose() * (&self.information * &self.together);
        let information = directions.transpose() * (&self.information * &directions);
        let covariance = information.try_inverse()?;
        let values = &covariance * &gradient;
        let deviations = covariance.diagonal();
        let deviations = deviations.iter().map(|v| (v * more).max(0.0).sqrt());
        Some(Alone {
            gain: gradient.dot(&values) / 2.0 / more,
            values: (parameters.iter().copied())
                .zip(values.iter().copied())
                .collect(),
            deviations: deviations.collect(),
        })
    }
}

impl RangeEstimate {
    /// One value that some parameters have together, the others being as configured.
    pub fn common(&self, parameters: &[Parameter]) -> Option<Alone> {
        let is_part = |own: &Parameter| f64::from(u8::from(parameters.contains(own)));
        let all =
            DVector::from_iterator(self.parameters.len(), self.parameters.iter().map(is_part));
        let toward = &self.information * &all;
        let information = all.dot(&toward);
        let gradient = self.together.dot(&toward);
        let (value, deviation) = (gradient / information, (1.0 / information).sqrt());
        (information > 0.0).then(|| Alone {
            values: parameters.iter().map(|of| (*of, value)).collect(),
            deviations: vec![deviation; parameters.len()],
            gain: gradient * value / 2.0,
        })
    }

    /// How late each sonar is stamped, with its standard deviation, where their clocks are unknown.
    pub fn delays(&self) -> Vec<(Parameter, f64, f64)> {
        let Some(covariance) = self.information.clone().try_inverse() else {
            return Vec::new();
        };
        let shared = self
            .parameters
            .iter()
            .position(|own| *own == Parameter::RangeDelay);
        let of = |at: usize| self.together.get(at).copied().unwrap_or(0.0);
        let both = |a: usize, b: usize| covariance.get((a, b)).copied().unwrap_or(0.0);
        let own = self.parameters.iter().enumerate();
        let own = own.filter(|(_, own)| matches!(own, Parameter::Sonar(_, Quantity::Delay)));
        // What all share and what each has alone are not told apart; their sum is.
        own.map(|(at, own)| {
            let (delay, variance) = match shared {
                Some(all) => (
                    of(all) + of(at),
                    both(all, all) + 2.0 * both(all, at) + both(at, at),
                ),
                None => (of(at), both(at, at)),
            };
            (*own, delay, variance.max(0.0).sqrt())
        })
        .collect()
    }
}

impl<'a> Problem<'a> {
    fn new(scene: &'a Scene, unknown: Unknown, replay: &Replay<'_>, outcome: &Outcome) -> Self {
        let odometry = &replay.log().events.odometry;
        let keys = key_poses(replay.frames());
        let drift = outcome.joint().map(|joint| joint.path.drift);
        let pings = scene.pings.iter();
        let ahead = |ping: &Ping| {
            let mount = scene.mounts.get(ping.sonar.index());
            unit(ping.world_from_sensor.yaw - mount.map_or(0.0, |mount| mount.yaw))
        };
        Self {
            scene,
            unknown,
            origin_ns: odometry.first().map_or(0, |sample| sample.stamp_ns),
            by_scales: by_scales(scene, replay),
            ahead: pings.clone().map(ahead).collect(),
            at_keys: match drift {
                Some(_) => pings.map(|ping| at_keys(&keys, ping)).collect(),
                None => Vec::new(),
            },
            keys,
            drift,
        }
    }

    fn parameters(&self) -> usize {
        SHARED.len() + self.unknown.of_sonar().len() * self.scene.mounts.len()
    }

    fn named(&self) -> Vec<Parameter> {
        let shared = SHARED.iter().map(|(parameter, _)| *parameter);
        let sonars = (0..).zip(&self.scene.mounts).flat_map(|(sonar, _)| {
            let own = self.unknown.of_sonar().iter();
            own.map(move |(of, _)| Parameter::Sonar(Whose::One(SonarId(sonar)), *of))
        });
        shared.chain(sonars).collect()
    }

    /// The standard deviation of each parameter before the log is looked at.
    fn before(&self) -> impl Iterator<Item = f64> {
        let shared = SHARED.iter().map(|(_, before)| *before);
        let sonars = self.scene.mounts.iter();
        let own = |_| self.unknown.of_sonar().iter().map(|(_, before)| *before);
        shared.chain(sonars.flat_map(own))
    }

    /// Where the unknowns of a sonar begin.
    fn own(&self, ping: &Ping) -> usize {
        SHARED.len() + self.unknown.of_sonar().len() * ping.sonar.index()
    }

    /// Where the scale and the offset of a sonar's ranges stand, where they are unknown.
    fn of_range(&self, ping: &Ping) -> Option<[usize; 2]> {
        let own = self.own(ping);
        (self.unknown == Unknown::Mounts).then_some([own + 2, own + 3])
    }

    /// The scale and the offset of a sonar's ranges.
    fn scale_and_offset(&self, state: &State, ping: &Ping) -> [f64; 2] {
        let places = self.of_range(ping);
        places.map_or([1.0, 0.0], |[scale, offset]| {
            [1.0 + state.of(scale), state.of(offset)]
        })
    }

    fn start(&self, outcome: &Outcome) -> State {
        State {
            poses: match outcome.joint() {
                Some(joint) => joint.path.world_from_robot.clone(),
                None => vec![Pose2::IDENTITY],
            },
            parameters: DVector::zeros(self.parameters()),
            places: self.scene.places.clone(),
        }
    }

    /// The derivatives of a sensor's place by the parameters that it depends on. The scales of odometry act
    /// on the path where that is unknown.
    fn by_parameters(&self, at: usize, ping: &Ping) -> impl Iterator<Item = (usize, Vec2)> {
        let seconds = ping.stamp_ns.saturating_sub(self.origin_ns) as f64 * 1e-9;
        let x = self.ahead.get(at).copied().unwrap_or_default();
        let own = self.own(ping);
        let by = [(2, -ping.velocity), (3, -ping.velocity * seconds)];
        let of_sonar = match self.unknown {
            Unknown::Mounts => [Some((own, x)), Some((own + 1, Vec2::new(-x.y, x.x)))],
            Unknown::Clocks => [Some((own, -ping.velocity)), None],
        };
        let by_scales = self.by_scales.get(at).filter(|_| self.drift.is_none());
        let by_scales = by_scales.map(|[distance, turn]| [(0, *distance), (1, *turn)]);
        let of_sonar = of_sonar.into_iter().flatten();
        by.into_iter()
            .chain(of_sonar)
            .chain(by_scales.into_iter().flatten())
    }

    /// Where the sensor is.
    fn sensor(&self, state: &State, at: usize, ping: &Ping) -> Vec2 {
        let mut place = match self.drift {
            None => ping.world_from_sensor.position(),
            Some(_) => {
                let from = self.at_keys.get(at).into_iter().flatten();
                from.fold(Vec2::zeros(), |sum, (key, from, weight)| {
                    let pose = state.poses.get(*key);
                    sum + pose.map_or_else(Vec2::zeros, |pose| pose.transform(*from) * *weight)
                })
            }
        };
        for (parameter, by) in self.by_parameters(at, ping) {
            place += by * state.of(parameter);
        }
        place
    }

    /// Which features the readings are of.
    fn matches(&self, state: &State, gate: f64) -> Vec<Match> {
        let mut candidates: Vec<(usize, Vec<(usize, f64)>)> = Vec::new();
        let mut heard: BTreeMap<usize, BTreeMap<SonarId, usize>> = BTreeMap::new();
        for (at, ping) in self.scene.pings.iter().enumerate() {
            let Some((range, variance)) = ping.echo else {
                continue;
            };
            let sensor = self.sensor(state, at, ping);
            let [scale, offset] = self.scale_and_offset(state, ping);
            let wide = gate + SIGMAS * (variance + OF_MAP * OF_MAP).sqrt();
            let near = |(at, place): (usize, &Place)| {
                let predicted = place.landmark.predict(sensor)?;
                let off = (range - (predicted.range - offset) / scale).abs();
                // Most are not, which costs no angle.
                let is_as_far = off < wide;
                let expected = is_as_far.then(|| place.expected(sensor)).flatten()?;
                let is_it = expected.inside > -BEYOND_END
                    && angle_between(expected.bearing, ping.world_from_sensor.yaw)
                        < ping.beam_width / 2.0 + BESIDE_BEAM;
                is_it.then_some((at, off))
            };
            let places = state.places.iter().enumerate();
            let mut near: Vec<(usize, f64)> = places.filter_map(near).collect();
            near.sort_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((place, _)) = near.first() {
                let by = heard.entry(*place).or_default();
                *by.entry(ping.sonar).or_default() += 1;
                candidates.push((at, near));
            }
        }
        let is_of_others = |place: usize, sonar: SonarId| {
            let by = heard.get(&place).into_iter().flatten();
            let others = by.filter(|(other, _)| **other != sonar);
            others.map(|(_, count)| count).sum::<usize>() >= OF_OTHERS
        };
        let best = |(at, near): (usize, Vec<(usize, f64)>)| {
            let sonar = self.scene.pings.get(at)?.sonar;
            let (first, _) = *near.first()?;
            let is_like = |place: usize| {
                let both = state.places.get(first).zip(state.places.get(place));
                both.is_some_and(|(a, b)| a.is_like(b))
            };
            let mut others = near.iter().map(|(place, _)| *place);
            let others = others
                .find(|place| is_of_others(*place, sonar) && (*place == first || is_like(*place)));
            let place = others.unwrap_or(first);
            Some(Match { ping: at, place })
        };
        candidates.into_iter().filter_map(best).collect()
    }

    /// A reading's residual, as the sonar measures it: ranges that shrink would fit ever better.
    fn residual(&self, state: &State, one: &Match) -> Option<Residual> {
        let ping = self.scene.pings.get(one.ping)?;
        let (range, variance) = ping.echo?;
        let sensor = self.sensor(state, one.ping, ping);
        let landmark = state.places.get(one.place)?.landmark;
        let predicted = landmark.predict(sensor)?;
        let [scale, offset] = self.scale_and_offset(state, ping);
        let measured = (predicted.range - offset) / scale;
        let by_sensor = predicted.by_sensor / scale;
        let of_range = self.of_range(ping);
        let of_range = of_range.map(|[of_scale, of_offset]| {
            [(of_scale, -measured / scale), (of_offset, -1.0 / scale)]
        });
        let place = self.parameters() + 2 * one.place;
        let by_parameters = self.by_parameters(one.ping, ping);
        let by_parameters =
            by_parameters.map(|(at, by)| (at, by_sensor.x * by.x + by_sensor.y * by.y));
        Some(Residual {
            by_shared: by_parameters
                .chain(of_range.into_iter().flatten())
                .chain([
                    (place, predicted.by_landmark.x / scale),
                    (place + 1, predicted.by_landmark.y / scale),
                ])
                .collect(),
            by_sensor,
            residual: range - measured,
            variance: variance + OF_MAP * OF_MAP,
        })
    }

    fn system(&self, state: &State, matches: &[Match]) -> Arrowhead {
        let count = self.parameters();
        let mut system = Arrowhead::new(state.poses.len(), count + 2 * state.places.len());
        for (at, before) in self.before().enumerate() {
            system.add_shared(&[(at, 1.0)], -state.of(at), 1.0 / (before * before));
        }
        for at in count..count + 2 * state.places.len() {
            system.add_shared(&[(at, 1.0)], 0.0, 1.0 / (ANYWHERE * ANYWHERE));
        }
        if let Some(drift) = &self.drift {
            self.add_odometry(state, drift, &mut system);
        }
        for one in matches {
            let Some(residual) = self.residual(state, one) else {
                continue;
            };
            // Cauchy's: what is of something else pulls little, and what is off together agrees.
            let off = residual.residual * residual.residual / residual.variance;
            let information = 1.0 / residual.variance / (1.0 + off / (SIGMAS * SIGMAS));
            if self.drift.is_none() {
                system.add_shared(&residual.by_shared, residual.residual, information);
                continue;
            }
            let Some(from) = self.at_keys.get(one.ping).copied() else {
                continue;
            };
            let by_poses = from.map(|(key, from, weight)| {
                let yaw = state.poses.get(key).map_or(0.0, |pose| pose.yaw);
                let lever = rotate(from, yaw);
                let by = residual.by_sensor * weight;
                Vector3::new(by.x, by.y, by.x * -lever.y + by.y * lever.x)
            });
            system.add(&Row {
                earlier: from[0].0,
                by_poses,
                by_shared: &residual.by_shared,
                residual: residual.residual,
                information,
            });
        }
        system
    }

    fn add_odometry(&self, state: &State, drift: &Drift, system: &mut Arrowhead) {
        let scales = Vector2::new(state.of(0), state.of(1));
        let keys = self.keys.iter().zip(self.keys.iter().skip(1));
        let poses = state.poses.iter().zip(state.poses.iter().skip(1));
        for (earlier, ((from, to), (a, b))) in keys.zip(poses).enumerate() {
            let increment = Increment::between(from, to);
            let lower = Cholesky::new(increment.covariance(drift)).map(|factor| factor.l());
            let Some(white) = lower.and_then(|lower| lower.try_inverse()) else {
                continue;
            };
            let residual = white * increment.residual(a, b, &scales);
            let [by_a, by_b] = increment.by_poses(a, b).map(|by| white * by);
            let by_scales = white * increment.by_scales();
            let rows = by_a.row_iter().zip(by_b.row_iter());
            let rows = rows.zip(by_scales.row_iter()).zip(residual.iter());
            for (((by_a, by_b), by_scales), residual) in rows {
                let by_scales = by_scales.into_owned();
                system.add(&Row {
                    earlier,
                    by_poses: [by_a, by_b].map(|by| by.transpose()),
                    by_shared: &[(0, by_scales.x), (1, by_scales.y)],
                    residual: -residual,
                    information: 1.0,
                });
            }
        }
    }

    fn moved(&self, state: &State, step: &Solution) -> State {
        let of = |at: usize| step.shared.get(at).copied().unwrap_or(0.0);
        let mut moved = state.clone();
        if self.drift.is_some() {
            for (pose, step) in moved.poses.iter_mut().zip(&step.poses) {
                *pose = Pose2::new(pose.x + step.x, pose.y + step.y, pose.yaw + step.z);
            }
        }
        for (at, value) in moved.parameters.iter_mut().enumerate() {
            *value += of(at);
        }
        let first = self.parameters();
        for (at, place) in moved.places.iter_mut().enumerate() {
            let step = Vector2::new(of(first + 2 * at), of(first + 2 * at + 1));
            place.landmark = place.landmark.moved(step);
        }
        moved
    }

    /// The variances of the shared unknowns where the readings of one feature by one sonar are off together.
    fn clustered(&self, state: &State, matches: &[Match], covariance: &DMatrix<f64>) -> Vec<f64> {
        let mut clusters: BTreeMap<(usize, SonarId), DVector<f64>> = BTreeMap::new();
        for one in matches {
            let (Some(residual), Some(ping)) =
                (self.residual(state, one), self.scene.pings.get(one.ping))
            else {
                continue;
            };
            let none = || DVector::zeros(covariance.nrows());
            let cluster = (clusters.entry((one.place, ping.sonar))).or_insert_with(none);
            for (at, by) in residual.by_shared {
                if let Some(entry) = cluster.get_mut(at) {
                    *entry += by * residual.residual / residual.variance;
                }
            }
        }
        let mut variances = vec![0.0; covariance.nrows()];
        for score in clusters.values() {
            let step = covariance * score;
            for (variance, step) in variances.iter_mut().zip(step.iter()) {
                *variance += step * step;
            }
        }
        variances
    }
}

impl State {
    fn of(&self, parameter: usize) -> f64 {
        self.parameters.get(parameter).copied().unwrap_or(0.0)
    }
}

/// A ping's sensor in the robot's frame at the two key poses around it, with their weights.
fn at_keys(keys: &[KeyPose], ping: &Ping) -> [(usize, Vec2, f64); 2] {
    let between = between(keys, ping.stamp_ns);
    let from = |key: usize, weight: f64| {
        let sensor = ping.odom_from_sensor.position();
        let from = keys.get(key);
        let from = from.map(|key| key.odom_from_robot.inverse_transform(sensor));
        (key, from.unwrap_or_default(), weight)
    };
    [
        from(between.earlier, 1.0 - between.share),
        from(between.earlier + 1, between.share),
    ]
}

/// The derivatives of each sensor's place by the scales of odometry's distance and turns.
fn by_scales(scene: &Scene, replay: &Replay<'_>) -> Vec<[Vec2; 2]> {
    let odometry = &replay.log().events.odometry;
    let tracks = [[1.0 + STEP, 1.0], [1.0, 1.0 + STEP]].map(|scales| scaled(odometry, scales));
    let tracks = tracks
        .each_ref()
        .map(|samples| Track::of_ranges(samples, replay.config()));
    let by = |ping: &Ping, track: &Track<'_>| {
        let pose = track.world_from_robot(track.instant_of_ns(ping.stamp_ns));
        let mount = scene.mounts.get(ping.sonar.index())?;
        let moved = pose.ok()?.compose(mount).position();
        Some((moved - ping.odom_from_sensor.position()) / STEP)
    };
    let pings = scene.pings.iter();
    pings
        .map(|ping| {
            tracks
                .each_ref()
                .map(|track| by(ping, track).unwrap_or_default())
        })
        .collect()
}
