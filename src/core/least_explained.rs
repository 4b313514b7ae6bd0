//! The stretch of a log that its own map explains least: there something was off for a while.
//!
//! A mount or a scale that is wrong is wrong all along. Readings that come late while a computer is busy, a wheel
//! that slips, people who walk beside the robot leave a stretch. Whether it is the clock can be tried: at the poses
//! of another time the map explains what it does not at these.

use crate::core::config::{Config, Poses};
use crate::core::observer::Setting;
use crate::core::odometry::Track;
use crate::core::replay::{Outcome, Replay, Stretch};
use crate::core::statistics::{fraction, seconds};
use crate::core::tmam::arc::Arc;

/// By so many arcs those that are not explained outnumber those that are, in a stretch, at least.
const EXCESS: i64 = 20;
/// No stretch is longer than this share of all arcs: it would be the rule.
const LONGEST: f64 = 1.0 / 3.0;
/// Elsewhere at least this share of the arcs is explained, or the map is no measure.
const ELSEWHERE: f64 = 2.0 / 3.0;
/// Delays are tried in steps of so many seconds, to either side.
const STEP: f64 = 0.01;
/// Up to so many steps.
const STEPS: i32 = 100;
/// With so many arcs of a long stretch.
const TRIED: usize = 200;
/// A delay must explain this share of what is explained elsewhere.
const AS_ELSEWHERE: f64 = 0.8;

/// Where poses were estimated, odometry is to explain this share elsewhere: it is right, then, and what the poses
/// took in was late.
const BY_ODOMETRY: f64 = 0.9;

/// The stretch of a replay that is explained least; `None` where none stands out. Estimated poses take in a delay as
/// if odometry had drifted: then it is looked for at those of odometry.
pub fn least_explained(replay: &Replay<'_>, outcome: &Outcome) -> Option<Stretch> {
    let found = least_explained_by(&replay.setting(), outcome);
    if found.is_some() || outcome.joint().is_none() {
        return found;
    }
    let config = Config {
        poses: Poses::Odometry,
        ..replay.config().clone()
    };
    let replay = Replay::new(replay.log(), &config).ok()?;
    let outcome = replay.run(&mut []).ok()?;
    let found = least_explained_by(&replay.setting(), &outcome)?;
    let is_late = found.delay.is_some() && found.elsewhere >= BY_ODOMETRY;
    is_late.then_some(Stretch {
        by_odometry: true,
        ..found
    })
}

fn least_explained_by(setting: &Setting<'_>, outcome: &Outcome) -> Option<Stretch> {
    let mut arcs: Vec<Arc> = outcome.reports.iter().map(|report| report.arc).collect();
    arcs.sort_by_key(|arc| arc.stamp_ns);
    let prediction = outcome.prediction.as_ref()?;
    let is_explained = |arc: &Arc| prediction.residual(arc).is_some();
    let explained: Vec<bool> = arcs.iter().map(is_explained).collect();
    let (from, to) = worst(&explained)?;
    let part = arcs.get(from..to)?;
    let count = |arcs: &[bool]| arcs.iter().filter(|explained| **explained).count() as u64;
    let (all, within) = (count(&explained), count(explained.get(from..to)?));
    let (whole, long) = (arcs.len() as u64, part.len() as u64);
    let elsewhere = fraction(all - within, whole - long);
    if long as f64 > LONGEST * whole as f64 || elsewhere < ELSEWHERE {
        return None;
    }
    let frames = || part.iter().map(|arc| arc.id.frame);
    let after = |arc: &Arc| seconds(setting.origin_ns, arc.stamp_ns);
    Some(Stretch {
        seconds: [after(part.first()?), after(part.last()?)],
        frames: [frames().min()?, frames().max()?],
        arcs: long,
        explained: fraction(within, long),
        elsewhere,
        by_odometry: false,
        delay: delay(part, setting, outcome)
            .filter(|(_, share)| *share >= AS_ELSEWHERE * elsewhere),
    })
}

/// Where those that are not explained outnumber the others most: from one place to before another.
fn worst(explained: &[bool]) -> Option<(usize, usize)> {
    let (mut sum, mut from) = (0, 0);
    let mut best = (EXCESS, None);
    for (place, explained) in explained.iter().enumerate() {
        if sum <= 0 {
            (sum, from) = (0, place);
        }
        sum += if *explained { -1 } else { 1 };
        if sum > best.0 {
            best = (sum, Some((from, place + 1)));
        }
    }
    best.1
}

/// The delay with which the map explains most of these arcs, the middle of such, and the share that it explains.
fn delay(arcs: &[Arc], setting: &Setting<'_>, outcome: &Outcome) -> Option<(f64, f64)> {
    let config = setting.config;
    let path = outcome.joint().map(|joint| &joint.path);
    let tried: Vec<&Arc> = arcs.iter().step_by(arcs.len().div_ceil(TRIED)).collect();
    let explained = |delay: f64| {
        let track = Track::of_ranges(&setting.events.odometry, config)
            .with_range_delay(config.input.range_delay + delay);
        let is_explained = |arc: &&&Arc| {
            let instant = track.instant_of_ns(arc.stamp_ns);
            let sonar = setting.sonars.get(arc.id.sonar.index());
            let (Some(sonar), Ok(robot)) = (sonar, track.world_from_robot(instant)) else {
                return false;
            };
            let sensor = robot.compose(&sonar.robot_from_sensor);
            let world_from_sensor = path.map_or(sensor, |path| path.correct(instant, &sensor));
            let moved = Arc {
                world_from_sensor,
                ..***arc
            };
            let prediction = outcome.prediction.as_ref();
            prediction.is_some_and(|prediction| prediction.residual(&moved).is_some())
        };
        tried.iter().filter(is_explained).count() as u64
    };
    let delays = (-STEPS..=STEPS).map(|step| STEP * f64::from(step));
    let counts: Vec<(f64, u64)> = delays.map(|delay| (delay, explained(delay))).collect();
    let most = counts.iter().map(|(_, count)| *count).max()?;
    let best: Vec<f64> = (counts.iter().filter(|(_, count)| *count == most))
        .map(|(delay, _)| *delay)
        .collect();
    let middle = best.iter().sum::<f64>() / best.len() as f64;
    Some((middle, fraction(most, tried.len() as u64)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_most_are_not_explained_a_stretch_begins_and_ends() {
        let mut explained = vec![true; 300];
        explained[100..140].fill(false);
        explained[110] = true;
        explained[5] = false;
        assert_eq!(worst(&explained), Some((100, 140)));
        assert_eq!(worst(&explained[..115]), None, "too short");
        assert_eq!(worst(&[]), None);
    }
}
