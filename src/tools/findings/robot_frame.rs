//! A robot's frame that is not the one that carries the sonars: their mounts then move with the robot.

use super::examined::Examined;
use super::finding::{Finding, Weight};

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    let traits = &of.survey.traits;
    let first = traits.mounts.first()?;
    let carrier = first.carrier.as_deref()?;
    let moves = |mount: &crate::io::log::traits::MountTraits| {
        mount.moved && mount.carrier.as_deref() == Some(carrier)
    };
    if !traits.mounts.iter().all(moves) {
        return None;
    }
    let key = format!("input.robot_frame = {}", toml::Value::from(carrier));
    let tried = of.tried(&key)?;
    Some(Finding::new(
        Weight::Serious,
        "robot-frame",
        format!(
            "all mounts move in `{}`, which the odometry moves by its words; `{carrier}` carries the sonars",
            traits.robot_frame
        ),
        "the first place of each sonar is taken for the whole log, and the map is wrong",
        format!("set {key}{tried}"),
    )
    .with(Some(tried)))
}
