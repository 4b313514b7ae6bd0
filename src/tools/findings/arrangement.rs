//! Mounts that lie otherwise on the robot than transforms say: all headings left out, in degrees or with the other
//! sign, left and right exchanged, the robot's x axis to a side (ros-navigation/navigation2#2499,
//! ros/robot_state_publisher#92).

use super::examined::{Examined, Tried};
use super::finding::{Finding, Weight};
use super::heading::against_speeds;
use super::laid::mounts_lie;
use super::poses;

/// A log of which more is explained has its sonars where they are said to be.
const WELL: f64 = 0.9;
/// Laid rightly, no more than such a share of what was unexplained is left.
const LEFT: f64 = 0.25;
/// So many sonars show how they lie.
const SEVERAL: usize = 3;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    let explained = of.explained()?;
    let follows = poses::are_none(&of.survey.traits.poses)
        || against_speeds(of).is_some()
        || of.sonars().any(|(_, mount)| mount.is_optical);
    if explained.share > WELL || of.facts.sonars.len() < SEVERAL || follows || of.is_long() {
        return None;
    }
    // Half the sonars are right by chance where two are exchanged.
    let closes = |tried: &Tried| 1.0 - tried.with.share <= LEFT * (1.0 - explained.share);
    let tried = of.best(&mounts_lie()).filter(closes)?;
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
