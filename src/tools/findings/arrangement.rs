//! Mounts that lie otherwise on the robot than transforms say: all headings left out, in degrees or with the other
//! sign, left and right exchanged, the robot's x axis to a side (ros-navigation/navigation2#2499,
//! ros/robot_state_publisher#92).

use super::examined::{Examined, Tried};
use super::finding::{Finding, Weight, names};
use super::heading::against_speeds;
use super::laid::mounts_lie;
use super::poses;
use super::sonars::MountFacts;
use crate::core::geometry::{Vec2, angle_between, direction};
use crate::core::wording::counted;

/// A log of which more is explained has its sonars where they are said to be.
const WELL: f64 = 0.9;
/// Laid rightly, no more than such a share of what was unexplained is left.
const LEFT: f64 = 0.25;
/// So many sonars show how they lie.
const SEVERAL: usize = 3;
/// A sonar looks elsewhere than outward by more, radians.
const TURNED: f64 = 0.1;
/// A sonar so near to the robot's origin looks outward wherever it looks, metres.
const AT_ORIGIN: f64 = 1e-3;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    let explained = of.explained()?;
    let follows = poses::are_none(&of.survey.traits.poses)
        || against_speeds(of).is_some()
        || of.sonars().any(|(_, mount)| mount.is_optical);
    let may_lie = explained.share <= WELL && of.facts.sonars.len() >= SEVERAL;
    // Half the sonars are right by chance where two are exchanged.
    let closes = |tried: &Tried| 1.0 - tried.with.share <= LEFT * (1.0 - explained.share);
    let tried = (may_lie && !follows && !of.is_long())
        .then(|| of.best(&ways(of)).filter(closes))
        .flatten();
    if !of.survey.traits.unturned.is_empty() {
        return Some(unturned(of, explained.share > WELL, tried));
    }
    let tried = tried?;
    Some(Finding::new(
        Weight::Serious,
        "mounts-lie",
        format!(
            "the map explains {:.0} % of the arcs; with the mounts laid otherwise on the robot it explains more",
            100.0 * explained.share
        ),
        "a map from wrong mounts is wrong everywhere",
        format!(
            "look at the transforms of the sonars' frames, and at what heading the odometry has for forward: for this \
             log {}{tried}",
            tried.keys
        ),
    )
    .with(Some(tried)))
}

/// The ways to lay the mounts that lay several otherwise: a sonar alone that looks elsewhere is told as that.
fn ways(of: &Examined<'_>) -> Vec<String> {
    let mounts = of.facts.sonars.iter().filter_map(|sonar| sonar.mount);
    let looks_elsewhere = |mount: &MountFacts| {
        let place = Vec2::new(mount.x, mount.y);
        place.norm() > AT_ORIGIN && angle_between(direction(place), mount.yaw) > TURNED
    };
    let elsewhere = mounts.filter(looks_elsewhere).count();
    let mut ways = mounts_lie();
    if elsewhere < SEVERAL {
        ways.retain(|way| !way.contains("outward"));
    }
    ways
}

/// Transforms that were never given a turn, as static publishers of an uninitialised message send them
/// (ros2/geometry2#397): all there is to go by.
fn unturned(of: &Examined<'_>, is_well: bool, tried: Option<Tried>) -> Finding {
    let frames = &of.survey.traits.unturned;
    Finding::new(
        if is_well {
            Weight::Notable
        } else {
            Weight::Serious
        },
        "unturned-mounts",
        format!(
            "the quaternion of {} is zero, which no turn has: {}",
            counted(frames.len() as u64, "transform"),
            names(frames.iter().map(String::as_str))
        ),
        "they are taken for frames that are not turned; where they are, a map from these mounts is wrong everywhere",
        match &tried {
            Some(tried) => format!("for this log {}{tried}; better, mend what sends the transforms", tried.keys),
            None => "mend what sends the transforms, or give x, y and yaw of each under [sonar.\"NAME\"]".to_owned(),
        },
    )
    .with(tried)
}
