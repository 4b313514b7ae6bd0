//! Mounts that lie otherwise on the robot than transforms say: all headings left out, in degrees or with the other
//! sign, left and right exchanged, the robot's x axis to a side (ros-navigation/navigation2#2499,
//! ros/robot_state_publisher#92).

use super::examined::{Examined, Tried};
use super::finding::{Finding, Weight, names};
use super::heading::{against_speeds, to_the_side};
use super::laid::mounts_lie;
use super::poses;
use super::sonars::MountFacts;
use std::f64::consts::TAU;

use crate::core::geometry::{Vec2, angle_between, direction, rotate, wrap_angle};
use crate::core::rounding::fixed;
use crate::core::wording::counted;

/// A log of which more is explained has its sonars where they are said to be.
const WELL: f64 = 0.9;
/// Laid rightly, no more than such a share of what was unexplained is left; of a log of which half is explained less, since
/// half the sonars are right by chance where two are exchanged.
const LEFT: [f64; 2] = [0.25, 0.1];
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
    let left = if explained.share < 0.5 {
        LEFT[0]
    } else {
        LEFT[1]
    };
    let closes = |tried: &Tried| 1.0 - tried.with.share <= left * (1.0 - explained.share);
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
            tried.named()
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
    ways.extend(turns(of).into_iter().map(|by| turned(of, by)));
    ways
}

/// By what all mounts may be turned: a ring that is counted from another sonar on, and a heading that is off by the same
/// everywhere.
fn turns(of: &Examined<'_>) -> Vec<f64> {
    let sonars = &of.facts.sonars;
    let step = TAU / sonars.len() as f64;
    let mut yaws = sonars.iter().filter_map(|sonar| Some(sonar.mount?.yaw));
    let is_ring = yaws.clone().count() == sonars.len()
        && yaws.clone().all(|yaw| {
            let next = |other: f64| angle_between(other, yaw + step) < TURNED;
            yaws.clone().any(next)
        });
    let first = yaws.next().filter(|_| is_ring && sonars.len() > SEVERAL);
    let of_ring = first.map(|_| [step, -step, 2.0 * step, -2.0 * step]);
    let to_side = to_the_side(&of.survey.log.events.odometry);
    let of_heading = to_side.filter(|by| by.abs() > TURNED / 2.0).map(|by| -by);
    of_ring.into_iter().flatten().chain(of_heading).collect()
}

/// The keys of all mounts turned about the robot's origin.
fn turned(of: &Examined<'_>, by: f64) -> String {
    let keys = of.facts.sonars.iter().filter_map(|sonar| {
        let mount = sonar.mount?;
        let to = rotate(Vec2::new(mount.x, mount.y), by);
        let name = toml::Value::from(sonar.name.as_str());
        let yaw = wrap_angle(mount.yaw + by).to_degrees();
        Some(format!(
            "sonar.{name}.x = {}\nsonar.{name}.y = {}\nsonar.{name}.yaw = {}",
            fixed(to.x, 4),
            fixed(to.y, 4),
            fixed(yaw, 2)
        ))
    });
    keys.collect::<Vec<_>>().join("\n")
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
            Some(tried) => format!("for this log {}{tried}; better, mend what sends the transforms", tried.named()),
            None => "mend what sends the transforms, or give x, y and yaw of each under [sonar.\"NAME\"]".to_owned(),
        },
    )
    .with(tried)
}
