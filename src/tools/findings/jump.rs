//! Odometry that jumps: farther, or farther round, than a robot gets from one sample to the next by its speed
//! before and behind (aliasrobotics/RVD#595, introlab/rtabmap_ros#551, SteveMacenski/slam_toolbox#112).

use super::examined::Examined;
use super::finding::{Finding, Weight};
use super::poses;
use crate::core::event::OdometrySample;
use crate::core::geometry::{Vec2, wrap_angle};
use crate::core::rounding::fixed;
use crate::core::statistics::{median, seconds};
use crate::core::wording::times;
use crate::io::log::leaps::{is_leap, neighbours, window};

/// A robot with sonars gains less speed in a second, m/s and rad/s.
const ACCELERATION: [f64; 2] = [4.0, 12.0];
/// Less is within what wheels do, metres and radians.
const LEAST: [f64; 2] = [0.05, 2.0 * std::f64::consts::PI / 180.0];
/// A jump stands out so far from what is usual.
const UNUSUAL: f64 = 10.0;
/// Where more of the steps are jumps, it is how the robot moves.
const MOST: f64 = 0.1;
/// So many jumps are corrections that come again and again.
const SEVERAL: usize = 3;

/// A jump: the samples before and behind it, and what of way and turn no speed explains.
struct Jump<'a> {
    from: &'a OdometrySample,
    to: &'a OdometrySample,
    excess: [f64; 2],
}

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    if poses::are_none(&of.survey.traits.poses) {
        return None; // headings turn over where the robot's axes do
    }
    let twice = of
        .survey
        .clock_set
        .as_ref()
        .map_or(&[][..], |set| &set.twice);
    let (events, input) = (&of.survey.log.events, &of.survey.config.input);
    let samples = window(&events.odometry, &events.readings, input.start, input.end);
    let jumps = jumps(samples, twice);
    let (first, last) = (jumps.first()?, jumps.last()?);
    let at = |stamp_ns: i64| seconds(of.facts.source.start_ns, stamp_ns).max(0.0);
    let largest = |i: usize| {
        let all = jumps.iter().filter_map(|jump| jump.excess.get(i));
        all.copied().fold(0.0, f64::max)
    };
    let again = jumps.len() >= SEVERAL;
    let when = if again {
        let apart = seconds(first.from.stamp_ns, last.from.stamp_ns) / (jumps.len() - 1) as f64;
        format!(
            "the first at {} s, then every {apart:.1} s",
            fixed(at(first.from.stamp_ns), 1)
        )
    } else {
        let all = jumps.iter().map(|jump| fixed(at(jump.from.stamp_ns), 1));
        format!("at {} s", all.collect::<Vec<_>>().join(" s and "))
    };
    let parts = format!(
        "replay the parts by themselves: --end {:.1}, then --start {:.1}",
        at(first.from.stamp_ns),
        at(first.to.stamp_ns)
    );
    Some(Finding::new(
        Weight::Serious,
        "odometry-jump",
        format!(
            "the odometry jumps {}, {when}, by up to {:.2} m and {:.1} deg more than the robot drives and turns",
            times(jumps.len() as u64),
            largest(0),
            largest(1).to_degrees()
        ),
        "the map before and after it does not fit together, and walls are drawn twice",
        if again {
            "a localisation that corrects its pose does that: replay the odometry that it corrects (--odom-topic, or \
             input.world_frame = \"odom\"), which drifts and does not jump"
                .to_owned()
        } else {
            parts
        },
    ))
}

fn jumps<'a>(samples: &'a [OdometrySample], twice: &'a [(i64, i64)]) -> Vec<Jump<'a>> {
    let steps: Vec<&[OdometrySample; 2]> = neighbours(samples, twice).collect();
    let excess: Vec<Option<[f64; 2]>> = (0..steps.len()).map(|k| excess(&steps, k)).collect();
    let usual = |i: usize| {
        let all = excess
            .iter()
            .flatten()
            .filter_map(|excess| excess.get(i).copied());
        let mut all: Vec<f64> = all.collect();
        all.sort_by(f64::total_cmp);
        UNUSUAL * median(&all).unwrap_or_default()
    };
    let usual = [usual(0), usual(1)];
    let jumps = steps
        .iter()
        .zip(&excess)
        .filter_map(|([from, to], excess)| {
            let took = seconds(from.stamp_ns, to.stamp_ns);
            let way = (to.world_from_robot.position() - from.world_from_robot.position()).norm();
            let excess = (*excess)?;
            let bounds = ACCELERATION.iter().zip(LEAST).zip(usual);
            let mut beyond =
                excess
                    .iter()
                    .zip(bounds)
                    .map(|(excess, ((acceleration, least), usual))| {
                        *excess > (acceleration * took * took).max(least).max(usual)
                    });
            let jumps = is_leap(way, took) || beyond.any(|is_beyond| is_beyond);
            jumps.then_some(Jump { from, to, excess })
        });
    let jumps: Vec<Jump<'_>> = jumps.collect();
    match jumps.len() as f64 > MOST * steps.len() as f64 {
        true => Vec::new(),
        false => jumps,
    }
}

/// What of a step's way and turn neither the speed before nor that behind it explains: metres and radians.
fn excess(steps: &[&[OdometrySample; 2]], place: usize) -> Option<[f64; 2]> {
    let speed = |place: usize| steps.get(place).and_then(|[a, b]| speed(a, b));
    let [from, to] = steps.get(place)?;
    let took = seconds(from.stamp_ns, to.stamp_ns);
    let (a, b) = (from.world_from_robot, to.world_from_robot);
    let around = [place.checked_sub(1), Some(place + 1)];
    let speeds = around.into_iter().flatten().filter_map(speed);
    let off = speeds.map(|(v, w)| {
        let way = b.position() - a.position() - v * took;
        [way.norm(), wrap_angle(b.yaw - a.yaw - w * took).abs()]
    });
    off.reduce(|[way, turn], [other, otherwise]| [way.min(other), turn.min(otherwise)])
}

fn speed(a: &OdometrySample, b: &OdometrySample) -> Option<(Vec2, f64)> {
    let took = seconds(a.stamp_ns, b.stamp_ns);
    let (from, to) = (a.world_from_robot, b.world_from_robot);
    let way = to.position() - from.position();
    (took > 0.0).then(|| (way / took, wrap_angle(to.yaw - from.yaw) / took))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::Pose2;

    /// Drives 0.2 m/s in a circle, and is put elsewhere at some samples.
    fn drive(jumps: &[(usize, f64, f64)]) -> Vec<OdometrySample> {
        let sample = |k: usize| {
            let put = || jumps.iter().filter(move |(at, ..)| *at <= k);
            let yaw = 0.02 * k as f64 + put().map(|(_, _, turn)| turn).sum::<f64>();
            let along = put().map(|(_, way, _)| way).sum::<f64>();
            OdometrySample {
                stamp_ns: k as i64 * 100_000_000,
                world_from_robot: Pose2::new(
                    libm::sin(0.02 * k as f64) + along,
                    -libm::cos(0.02 * k as f64),
                    wrap_angle(yaw),
                ),
            }
        };
        (0..300).map(sample).collect()
    }

    #[test]
    fn jumps_in_place_and_in_heading_are_seen_and_a_circle_is_none() {
        assert!(jumps(&drive(&[]), &[]).is_empty());
        let put = [(50, 0.12, 0.0), (120, 0.0, -0.7), (200, -5.0, 0.05)];
        let drive = drive(&put);
        let found = jumps(&drive, &[]);
        let at: Vec<i64> = found
            .iter()
            .map(|jump| jump.to.stamp_ns / 100_000_000)
            .collect();
        assert_eq!(at, [50, 120, 200]);
        let [way, turn] = found[0].excess;
        assert!((way - 0.12).abs() < 0.01 && turn < 1e-9, "{way} {turn}");
        assert!((found[1].excess[1] - 0.7).abs() < 1e-9);
    }
}
