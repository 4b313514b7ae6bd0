//! What a joint estimate has to fit: ranges, odometry, and corners in which walls meet.

use nalgebra::{Cholesky, Matrix3, RowVector2, Vector2, Vector3};

use super::arrowhead::{Arrowhead, Factor, Row};
use super::drift::{Drift, DriftEstimator, Increment};
use super::key_pose::KeyPose;
use super::landmark::Landmark;
use crate::core::geometry::{Pose2, Vec2, rotate, unit};
use crate::core::tmam::arc::ArcId;

/// Standard deviation of the two scales of odometry, of distance and of rotation, before anything is seen.
const SCALE: f64 = 0.02;

/// Points that are where two walls meet are on both: standard deviation, metres.
const ON_WALL: f64 = 5e-4;

/// Of a landmark before anything is seen: standard deviation of either parameter, metres and radians. So
/// wide that it matters only where readings determine nothing.
const ANYWHERE: f64 = 100.0;

/// Steps after which a solve ends in any case, and how often a step that makes it worse is halved.
const MAX_STEPS: usize = 12;
const MAX_HALVINGS: usize = 8;

/// A step shorter than this is the last, metres and radians, and so is one that gains less of chi2: what is
/// left is about its square.
const SETTLED: f64 = 1e-4;
const GAIN: f64 = 1e-3;

/// A reading of a landmark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Whose reading.
    pub arc: ArcId,
    /// The landmark, by its place.
    pub landmark: usize,
    /// The key pose before it.
    pub earlier: usize,
    /// How much of the way to the next one was done.
    pub share: f64,
    /// The sensor in the robot's frame at either key pose, as odometry has it.
    pub robot_from_sensor: [Vec2; 2],
    /// Metres.
    pub range: f64,
    /// Square metres.
    pub variance: f64,
}

/// A point that lies on a wall's line, by the places of the two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Incidence {
    pub point: usize,
    pub line: usize,
}

/// The unknowns.
#[derive(Debug, Clone, PartialEq)]
pub struct Unknowns {
    /// `world_from_robot` at each key pose; the first one stays.
    pub poses: Vec<Pose2>,
    /// The landmarks.
    pub landmarks: Vec<Landmark>,
    /// By how much odometry is too short, of distance and of rotation; as shares.
    pub scales: Vector2<f64>,
}

/// What the unknowns have to fit.
#[derive(Debug, Clone)]
pub struct Problem {
    sightings: Vec<Sighting>,
    incidences: Vec<Incidence>,
    drift: Drift,
    /// Each with what makes its residual white.
    increments: Vec<(Increment, Matrix3<f64>)>,
}

/// Unknowns that fit best, and how well.
#[derive(Debug, Clone)]
pub struct Fitted {
    pub unknowns: Unknowns,
    /// Sum of squared residuals, each over its variance.
    pub cost: f64,
    pub factor: Factor,
}

impl Sighting {
    /// Where the sensor was.
    pub fn sensor(&self, poses: &[Pose2]) -> Option<Vec2> {
        let [a, b] = [poses.get(self.earlier)?, poses.get(self.earlier + 1)?];
        let [from_a, from_b] = self.robot_from_sensor;
        Some(a.transform(from_a) * (1.0 - self.share) + b.transform(from_b) * self.share)
    }

    /// By how much the range is longer than its landmark has it.
    pub fn residual(&self, unknowns: &Unknowns) -> Option<f64> {
        let landmark = unknowns.landmarks.get(self.landmark)?;
        let predicted = landmark.predict(self.sensor(&unknowns.poses)?)?;
        Some(self.range - predicted.range)
    }
}

impl Problem {
    /// From key poses, the readings of landmarks, and the points that lie on lines; `None` where odometry
    /// is not finite.
    pub fn new(
        keys: &[KeyPose],
        sightings: Vec<Sighting>,
        incidences: Vec<Incidence>,
        drift: Drift,
    ) -> Option<Self> {
        let pairs = keys.iter().zip(keys.iter().skip(1));
        let increments = pairs.map(|(a, b)| {
            let increment = Increment::between(a, b);
            let lower = Cholesky::new(increment.covariance(&drift))?.l();
            Some((increment, lower.try_inverse()?))
        });
        Some(Self {
            increments: increments.collect::<Option<_>>()?,
            sightings,
            incidences,
            drift,
        })
    }

    /// The readings of landmarks.
    pub fn sightings(&self) -> &[Sighting] {
        &self.sightings
    }

    /// Gauss-Newton from `start`; `None` where the readings do not determine the unknowns.
    pub fn solve(&self, start: Unknowns) -> Option<Fitted> {
        let mut now = start;
        let mut cost = self.cost(&now);
        for _ in 0..MAX_STEPS {
            let factor = self.normal_equations(&now).factor()?;
            let step = factor.solution();
            let mut length = 1.0;
            let mut better = None;
            for _ in 0..MAX_HALVINGS {
                let trial = now.moved(&step.poses, step.shared.as_slice(), length);
                let trial_cost = self.cost(&trial);
                if trial_cost <= cost {
                    better = Some((trial, trial_cost));
                    break;
                }
                length /= 2.0;
            }
            let Some((trial, trial_cost)) = better else {
                break;
            };
            let gained = cost - trial_cost;
            (now, cost) = (trial, trial_cost);
            let poses = step.poses.iter().map(Vector3::amax).fold(0.0, f64::max);
            if gained < GAIN || length * poses.max(step.shared.amax()) < SETTLED {
                break;
            }
        }
        let factor = self.normal_equations(&now).factor()?;
        Some(Fitted {
            unknowns: now,
            cost,
            factor,
        })
    }

    /// Sum of squared residuals, each over its variance.
    pub fn cost(&self, at: &Unknowns) -> f64 {
        let ranges = self.sightings.iter().map(|sighting| {
            let residual = sighting.residual(at).unwrap_or(f64::INFINITY);
            residual * residual / sighting.variance
        });
        let odometry = self.odometry(at);
        let odometry = odometry.map(|(_, white, residual)| (white * residual).norm_squared());
        let corners = self.incidences.iter().map(|incidence| {
            let off = incidence.of(at).map_or(0.0, |(off, _, _)| off);
            off * off / (ON_WALL * ON_WALL)
        });
        let scales = at.scales.norm_squared() / (SCALE * SCALE);
        ranges.sum::<f64>() + odometry.sum::<f64>() + corners.sum::<f64>() + scales
    }

    /// Each increment of odometry, what makes its residual white, and that.
    fn odometry(
        &self,
        at: &Unknowns,
    ) -> impl Iterator<Item = (&Increment, &Matrix3<f64>, Vector3<f64>)> {
        let pairs = at.poses.iter().zip(at.poses.iter().skip(1));
        let increments = self.increments.iter().zip(pairs);
        increments.map(|((increment, white), (a, b))| {
            (increment, white, increment.residual(a, b, &at.scales))
        })
    }

    fn normal_equations(&self, at: &Unknowns) -> Arrowhead {
        let mut system = Arrowhead::new(at.poses.len(), 2 + 2 * at.landmarks.len());
        for (place, scale) in at.scales.iter().enumerate() {
            system.add_shared(&[(place, 1.0)], -*scale, 1.0 / (SCALE * SCALE));
        }
        for place in 2..2 + 2 * at.landmarks.len() {
            system.add_shared(&[(place, 1.0)], 0.0, 1.0 / (ANYWHERE * ANYWHERE));
        }
        self.add_odometry(at, &mut system);
        for sighting in &self.sightings {
            add_sighting(sighting, at, &mut system);
        }
        for incidence in &self.incidences {
            if let Some((off, by_point, by_line)) = incidence.of(at) {
                let point = 2 + 2 * incidence.point;
                let line = 2 + 2 * incidence.line;
                let by_shared = [
                    (point, by_point.x),
                    (point + 1, by_point.y),
                    (line, by_line.x),
                    (line + 1, by_line.y),
                ];
                system.add_shared(&by_shared, -off, 1.0 / (ON_WALL * ON_WALL));
            }
        }
        system
    }

    fn add_odometry(&self, at: &Unknowns, system: &mut Arrowhead) {
        let poses = at.poses.iter().zip(at.poses.iter().skip(1));
        for (earlier, ((increment, white, residual), (a, b))) in
            self.odometry(at).zip(poses).enumerate()
        {
            let residual = white * residual;
            let by_poses = increment.by_poses(a, b).map(|by| white * by);
            let by_scales = white * increment.by_scales();
            let [by_a, by_b] = by_poses;
            let rows = by_a.row_iter().zip(by_b.row_iter());
            for (((by_a, by_b), by_scales), residual) in
                rows.zip(by_scales.row_iter()).zip(residual.iter())
            {
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

    /// Logarithm of how likely the ranges are at this noise of odometry, whatever the poses and landmarks;
    /// but for what the noise does not change (Laplace's approximation).
    pub fn log_evidence(&self, fitted: &Fitted) -> f64 {
        let whitening = self.increments.iter().map(|(_, white)| white.diagonal());
        let whitening = whitening.map(|d| libm::log(d.x) + libm::log(d.y) + libm::log(d.z));
        let ranges = self.sightings.iter().map(|s| libm::log(s.variance) / 2.0);
        whitening.sum::<f64>()
            - ranges.sum::<f64>()
            - (fitted.cost + fitted.factor.log_determinant()) / 2.0
    }

    /// The noise of odometry as an estimate leaves it.
    pub fn learn(&self, fitted: &Fitted) -> Option<Drift> {
        let shared = fitted.factor.shared_covariance();
        let covariances = fitted.factor.pose_covariances(&shared);
        let at = &fitted.unknowns;
        let mut learnt = DriftEstimator::default();
        let poses = at.poses.iter().zip(at.poses.iter().skip(1));
        let own = covariances.own.iter().zip(covariances.own.iter().skip(1));
        let rows = self.odometry(at).zip(poses).zip(own).zip(&covariances.next);
        for ((((increment, _, residual), (a, b)), (own_a, own_b)), with_next) in rows {
            let [by_a, by_b] = increment.by_poses(a, b);
            let cross = by_a * with_next * by_b.transpose();
            let covariance = by_a * own_a * by_a.transpose()
                + by_b * own_b * by_b.transpose()
                + cross
                + cross.transpose();
            learnt.push(increment, residual, &covariance, &self.drift);
        }
        Some(learnt.drift(&self.drift))
    }
}

fn add_sighting(sighting: &Sighting, at: &Unknowns, system: &mut Arrowhead) -> Option<()> {
    let Sighting {
        earlier,
        share,
        landmark,
        robot_from_sensor: [from_a, from_b],
        ..
    } = *sighting;
    let [a, b] = [at.poses.get(earlier)?, at.poses.get(earlier + 1)?];
    let predicted = at
        .landmarks
        .get(landmark)?
        .predict(sighting.sensor(&at.poses)?)?;
    let by_pose = |pose: &Pose2, from: Vec2, weight: f64| {
        let lever = rotate(from, pose.yaw);
        let by_place: RowVector2<f64> = predicted.by_sensor * weight;
        let by_yaw = by_place.x * -lever.y + by_place.y * lever.x;
        Vector3::new(by_place.x, by_place.y, by_yaw)
    };
    let place = 2 + 2 * landmark;
    system.add(&Row {
        earlier,
        by_poses: [by_pose(a, from_a, 1.0 - share), by_pose(b, from_b, share)],
        by_shared: &[
            (place, predicted.by_landmark.x),
            (place + 1, predicted.by_landmark.y),
        ],
        residual: sighting.range - predicted.range,
        information: 1.0 / sighting.variance,
    });
    Some(())
}

impl Incidence {
    /// How far the point is off the line, and the derivatives by the two.
    fn of(&self, at: &Unknowns) -> Option<(f64, Vector2<f64>, Vector2<f64>)> {
        let Landmark::Point(point) = *at.landmarks.get(self.point)? else {
            return None;
        };
        let (about, by_line) = at.landmarks.get(self.line)?.line_about(point)?;
        // The line passes the point at `about.x` along its normal.
        let by_line = by_line.row(0).transpose();
        Some((about.x, -unit(about.y), by_line))
    }
}

impl Unknowns {
    fn moved(&self, poses: &[Vector3<f64>], shared: &[f64], length: f64) -> Self {
        let steps = shared.get(2..).unwrap_or_default().as_chunks::<2>().0;
        let by = |x: f64, y: f64| Vector2::new(x, y) * length;
        let scales = shared
            .first_chunk::<2>()
            .map_or_else(Vector2::zeros, |s| by(s[0], s[1]));
        Self {
            poses: (self.poses.iter().zip(poses))
                .map(|(pose, step)| {
                    let step = step * length;
                    Pose2::new(pose.x + step.x, pose.y + step.y, pose.yaw + step.z)
                })
                .collect(),
            landmarks: (self.landmarks.iter().zip(steps))
                .map(|(landmark, [x, y])| landmark.moved(by(*x, *y)))
                .collect(),
            scales: self.scales + scales,
        }
    }
}
