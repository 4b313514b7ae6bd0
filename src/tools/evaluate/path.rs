//! A path against the one that the robot really drove.

use nalgebra::Vector3;
use serde::Serialize;

use crate::core::config::Frames;
use crate::core::event::OdometrySample;
use crate::core::geometry::{Pose2, Vec2, wrap_angle};
use crate::core::joint::path::CorrectedPath;
use crate::core::odometry::Track;
use crate::core::rounding::{number, rounded};

/// How far a path is from the truth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PathScore {
    /// Poses of it for whose stamps the truth is known.
    pub poses: u64,
    /// What the robot really drove from the first to the last of them, metres.
    #[serde(serialize_with = "number")]
    pub length: f64,
    /// With the first pose laid on the true one: what went wrong since.
    pub from_first: PathError,
    /// With the whole path laid on the true one by the rotation and translation that leave the least
    /// squares of positions (Umeyama 1991, without scale): the absolute trajectory error.
    pub aligned: PathError,
    /// Normalised error squared of the key poses per degree of freedom, with the first pose laid on the
    /// true one: 1 on average where their covariances are honest. Where poses were estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees: Option<f64>,
}

/// The errors along a path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PathError {
    /// Root mean square of positions, metres.
    #[serde(serialize_with = "number")]
    pub rms: f64,
    /// The largest of them, metres.
    #[serde(serialize_with = "number")]
    pub max: f64,
    /// Root mean square of headings, radians.
    #[serde(serialize_with = "number")]
    pub heading: f64,
}

impl PathScore {
    /// Of a path in any frame; `None` where the true one is not known at two of its poses.
    pub fn new(path: &[(i64, Pose2)], truth: &[OdometrySample]) -> Option<Self> {
        let bounds = Frames {
            max_odometry_gap: f64::INFINITY,
            ..Frames::default()
        };
        let track = Track::new(truth, &bounds);
        let pairs: Vec<[Pose2; 2]> = path
            .iter()
            .filter_map(|(stamp_ns, pose)| Some([track.world_from_robot(*stamp_ns).ok()?, *pose]))
            .collect();
        let ([true_first, first], [_, _, ..]) = (*pairs.first()?, pairs.as_slice()) else {
            return None;
        };
        let places = || pairs.iter().map(|[known, _]| known.position());
        let ways = places().zip(places().skip(1)).map(|(a, b)| (b - a).norm());
        Some(Self {
            poses: pairs.len() as u64,
            length: ways.fold(0.0, |sum, way| sum + way),
            from_first: PathError::of(&pairs, true_first.compose(&first.inverse())),
            aligned: PathError::of(&pairs, alignment(&pairs)),
            nees: None,
        })
    }

    /// The same with the normalised error of an estimated path.
    pub fn with_nees(self, path: &CorrectedPath, truth: &[OdometrySample]) -> Self {
        let bounds = Frames {
            max_odometry_gap: f64::INFINITY,
            ..Frames::default()
        };
        let track = Track::new(truth, &bounds);
        let keys = path.keys.iter().zip(&path.world_from_robot);
        let known = keys
            .filter_map(|(key, pose)| Some((*pose, track.world_from_robot(key.stamp_ns).ok()?)));
        let known: Vec<(Pose2, Pose2)> = known.collect();
        let Some((first, true_first)) = known.first() else {
            return self;
        };
        let path_from_truth = first.compose(&true_first.inverse());
        let errors = known.iter().zip(&path.covariances).skip(1);
        let errors: Vec<f64> = errors
            .filter_map(|((pose, known), covariance)| {
                let known = path_from_truth.compose(known);
                let off = Vector3::new(
                    pose.x - known.x,
                    pose.y - known.y,
                    wrap_angle(pose.yaw - known.yaw),
                );
                Some(off.dot(&(covariance.try_inverse()? * off)) / 3.0)
            })
            .collect();
        let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
        Self {
            nees: (!errors.is_empty()).then(|| rounded(mean)),
            ..self
        }
    }
}

impl PathError {
    /// Of pairs of a true pose and one of the path, which is laid into the world by `world_from_path`.
    fn of(pairs: &[[Pose2; 2]], world_from_path: Pose2) -> Self {
        let (mut squares, mut max, mut turns) = (0.0, 0.0_f64, 0.0);
        for [known, pose] in pairs {
            let laid = world_from_path.compose(pose);
            let off = (laid.position() - known.position()).norm();
            let turned = wrap_angle(laid.yaw - known.yaw);
            squares += off * off;
            max = max.max(off);
            turns += turned * turned;
        }
        let count = pairs.len().max(1) as f64;
        Self {
            rms: (squares / count).sqrt(),
            max,
            heading: (turns / count).sqrt(),
        }
    }
}

/// `world_from_path` of least squares of positions.
fn alignment(pairs: &[[Pose2; 2]]) -> Pose2 {
    let count = pairs.len().max(1) as f64;
    let middle = |which: fn(&[Pose2; 2]) -> Vec2| {
        let places = pairs.iter().map(which);
        places.fold(Vec2::zeros(), |sum, place| sum + place) / count
    };
    let (known, path) = (middle(|[k, _]| k.position()), middle(|[_, p]| p.position()));
    let (mut along, mut across) = (0.0, 0.0);
    for [k, p] in pairs {
        let (k, p) = (k.position() - known, p.position() - path);
        along += p.dot(&k);
        across += p.perp(&k);
    }
    let turn = Pose2::new(0.0, 0.0, libm::atan2(across, along));
    let shift = known - turn.transform(path);
    Pose2::new(shift.x, shift.y, turn.yaw)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::unit;

    /// The path of a robot that goes round a circle of a metre.
    fn round() -> Vec<(i64, Pose2)> {
        let pose = |k: i64| {
            let place = unit(0.05 * k as f64);
            Pose2::new(place.x, place.y, 0.05 * k as f64 + 1.5)
        };
        (0..100).map(|k| (k * 50_000_000, pose(k))).collect()
    }

    fn score(path: &[(i64, Pose2)], known: &[(i64, Pose2)]) -> Option<PathScore> {
        let samples = known.iter().map(|(stamp_ns, pose)| OdometrySample {
            stamp_ns: *stamp_ns,
            world_from_robot: *pose,
        });
        PathScore::new(path, &samples.collect::<Vec<_>>())
    }

    #[test]
    fn a_path_in_another_frame_has_no_error() {
        let other_from_world = Pose2::new(3.0, -2.0, 2.5);
        let path: Vec<(i64, Pose2)> = round()
            .iter()
            .map(|(stamp_ns, pose)| (*stamp_ns, other_from_world.compose(pose)))
            .collect();
        let score = score(&path, &round()).unwrap();
        assert_eq!(score.poses, 100);
        for error in [score.from_first, score.aligned] {
            assert!(
                error.max < 1e-12 && error.rms < 1e-12 && error.heading < 1e-12,
                "{error:?}"
            );
        }
        assert!((score.length - 99.0 * 0.05).abs() < 0.01, "{score:?}");
    }

    #[test]
    fn what_turns_from_the_start_on_counts_less_once_the_whole_is_aligned() {
        // A tenth of a radian off about the first pose, but for that pose itself.
        let first = round()[0].1;
        let turned = first
            .compose(&Pose2::new(0.0, 0.0, 0.1))
            .compose(&first.inverse());
        let mut path: Vec<(i64, Pose2)> = round();
        for (_, pose) in &mut path[1..] {
            *pose = turned.compose(pose);
        }
        let score = score(&path, &round()).unwrap();
        assert!((score.from_first.heading - 0.1).abs() < 1e-3, "{score:?}");
        assert!(score.from_first.max > 0.15, "{score:?}");
        assert!(score.aligned.rms < 1e-3, "{score:?}");
    }

    #[test]
    fn poses_between_those_that_are_known_are_held_against_what_lies_between() {
        let known: Vec<(i64, Pose2)> = round().into_iter().step_by(2).collect();
        let score = score(&round(), &known).unwrap();
        assert_eq!(score.poses, 99, "the last one lies beyond");
        assert!(score.aligned.max < 2e-3, "{score:?}");
    }

    #[test]
    fn without_the_truth_there_is_no_error() {
        assert_eq!(score(&round(), &[]), None);
        assert_eq!(score(&round()[..1], &round()), None);
    }
}
