//! A heading that does not go with the way that the robot drives, or with the speeds that come with the poses:
//! mirrored (NED), in degrees, of another node.

use std::f64::consts::FRAC_PI_4;

use super::examined::Examined;
use super::finding::{Finding, Weight};
use super::laid::{best_axes, best_unit};
use super::{poses, speed};
use crate::core::event::OdometrySample;
use crate::core::geometry::{Vec2, direction, wrap_angle};
use crate::io::log::tracks::two_tracks;
use crate::io::log::traits::PoseTraits;

/// Less way tells nothing, metres.
const ENOUGH: f64 = 1.0;
/// Shorter steps have no direction, metres.
const STEP: f64 = 0.002;
/// Directions that agree so well are one.
const STEADY: f64 = 0.9;
/// Directions that agree no better have nothing to do with each other.
const LOOSE: f64 = 0.5;
/// A map that explains less is not that of a robot that drives sideways.
const POOR: f64 = 0.6;
/// By so much ways or turns by poses may differ from those by speeds, as a factor.
const FACTOR: f64 = 2.0;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    let samples = &of.survey.log.events.odometry;
    if poses::are_none(&of.survey.traits.poses)
        || two_tracks(samples).is_some()
        || speed::usual(samples).is_some_and(|speed| speed > speed::FASTEST)
    {
        return None; // from which it follows
    }
    let is_poor = of
        .explained()
        .is_none_or(|explained| explained.share < POOR);
    let (what, weight) = against_speeds(of)
        .map(|what| (what, Weight::Serious))
        .or_else(|| against_travel(samples, is_poor))?;
    let is_unit = ways_differ(&of.survey.traits.poses);
    let tried = is_unit.then(|| best_unit(of)).flatten();
    let tried = tried.or_else(|| best_axes(of));
    Some(Finding::new(
        weight,
        "heading",
        what,
        match is_unit {
            true => "the path is as much too long or too short, and walls do not join",
            false => "beams are laid into wrong directions, and walls do not join",
        },
        match &tried {
            Some(tried) => format!(
                "set {}{tried}; better, mend what makes the {}",
                tried.named(),
                if is_unit { "path" } else { "heading" }
            ),
            None => "headings are counter-clockwise from x, in radians, of the frame that the sonars are mounted in \
                     (REP 103): look at what makes them"
                .to_owned(),
        },
    )
    .with(tried))
}

/// Whether the way by poses is another than that by the speeds that come with them.
fn ways_differ(poses: &PoseTraits) -> bool {
    let [way, said] = poses.ways;
    said >= ENOUGH / 10.0 && !(1.0 / FACTOR..FACTOR).contains(&(way / said))
}

/// What the poses say other than the speeds in the same messages.
pub fn against_speeds(of: &Examined<'_>) -> Option<String> {
    let poses = &of.survey.traits.poses;
    let ([way, said], [together, squares]) = (poses.ways, poses.turns);
    // Many drivers leave the speeds at zero.
    if poses.are_of_twist || said < ENOUGH / 10.0 || way.max(said) < ENOUGH {
        return None;
    }
    if ways_differ(poses) {
        return Some(format!(
            "the robot drives {way:.1} m by its poses and {said:.1} m by its speeds"
        ));
    }
    let along = poses.way_along / way;
    let rate = together / squares.max(f64::MIN_POSITIVE);
    if along < LOOSE {
        return Some(format!(
            "of {way:.1} m that the poses move, {:.1} m go where heading and speeds of the same messages say",
            poses.way_along
        ));
    }
    (squares.sqrt() > 0.1 && !(1.0 / FACTOR..FACTOR).contains(&rate)).then(|| {
        let way = if rate < 0.0 { "the other way, " } else { "" };
        let rate = rate.abs();
        format!("the heading turns {way}{rate:.2} times as fast as the rates of turn in the same messages say")
    })
}

/// How the way goes along the heading, and along a heading that is mirrored, as sums of steps turned back by these; and
/// the way.
fn along(samples: &[OdometrySample]) -> ([Vec2; 2], f64) {
    let (mut with, mut against, mut way) = (Vec2::zeros(), Vec2::zeros(), 0.0);
    for [a, b] in samples.array_windows() {
        let step = b.world_from_robot.position() - a.world_from_robot.position();
        if step.norm() < STEP {
            continue;
        }
        let (course, heading) = (direction(step), a.world_from_robot.yaw);
        let heading = heading + wrap_angle(b.world_from_robot.yaw - heading) / 2.0;
        let unit = |angle: f64| Vec2::new(libm::cos(angle), libm::sin(angle)) * step.norm();
        with += unit(course - heading);
        against += unit(course + heading);
        way += step.norm();
    }
    ([with, against], way)
}

/// By how much the robot drives to the side of its heading all the way, radians.
pub fn to_the_side(samples: &[OdometrySample]) -> Option<f64> {
    let ([with, _], way) = along(samples);
    (way >= ENOUGH && with.norm() > STEADY * way).then(|| direction(with))
}

/// What the heading is to the direction of travel.
fn against_travel(samples: &[OdometrySample], is_poor: bool) -> Option<(String, Weight)> {
    let ([with, against], way) = along(samples);
    if way < ENOUGH {
        return None;
    }
    let [agree, mirrored] = [with, against].map(|sum: Vec2| sum.norm() / way);
    if mirrored > STEADY && agree < STEADY {
        let what = "the heading turns against the direction of travel: to the right where the robot drives to the \
                    left (mirrored, or clockwise as in NED)";
        return Some((what.to_owned(), Weight::Serious));
    }
    if agree > STEADY
        && direction(with).abs() > FRAC_PI_4
        && direction(with).abs() < 3.0 * FRAC_PI_4
    {
        let what = format!(
            "the robot drives {:.0} deg to the side of its heading all the way",
            direction(with).to_degrees()
        );
        return Some((what, Weight::Notable));
    }
    (agree < LOOSE).then(|| {
        let what = "the heading has little to do with the direction of travel";
        match is_poor {
            true => (what.to_owned(), Weight::Serious),
            false => (
                format!("{what}: fine for a robot that drives sideways"),
                Weight::Notable,
            ),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::Pose2;

    fn told(heading: impl Fn(f64) -> f64) -> Option<Weight> {
        let sample = |k: i32| {
            let angle = 0.01 * f64::from(k);
            OdometrySample {
                stamp_ns: i64::from(k) * 100_000_000,
                world_from_robot: Pose2::new(
                    libm::sin(angle),
                    -libm::cos(angle),
                    wrap_angle(heading(angle)),
                ),
            }
        };
        let samples: Vec<_> = (0..628).map(sample).collect();
        against_travel(&samples, false).map(|(_, weight)| weight)
    }

    #[test]
    fn mirrored_and_sideways_headings_are_told_and_right_ones_are_not() {
        assert_eq!(told(|course| course), None);
        assert_eq!(
            told(|course| course + std::f64::consts::PI),
            None,
            "backwards"
        );
        assert_eq!(told(|course| -course), Some(Weight::Serious));
        assert_eq!(
            told(|course| std::f64::consts::FRAC_PI_2 - course),
            Some(Weight::Serious)
        );
        assert_eq!(
            told(|course| course + std::f64::consts::FRAC_PI_2),
            Some(Weight::Notable)
        );
        assert_eq!(told(|_| 0.0), Some(Weight::Notable));
    }
}
