//! Mounts of which transforms say two things, as two publishers of one frame do (luxonis/depthai-ros#619,
//! YDLIDAR/ydlidar_ros2_driver#68).

use super::examined::Examined;
use super::finding::{Finding, Weight, which_sonars};
use super::sonars::{MountFacts, SonarFacts};
use crate::core::geometry::{Pose2, angle_between};
use crate::core::wording::times;
use crate::io::config::keys;
use crate::io::log::traits::Contradicted;

/// Mounts that differ by less make no other map, metres and radians.
const ALIKE: (f64, f64) = (0.005, 0.01);

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    let two = of
        .sonars()
        .filter_map(|(sonar, traits)| Some((sonar, sonar.mount?, traits.contradicted.as_ref()?)));
    let differ = |(_, mount, other): &(&SonarFacts, MountFacts, &Contradicted)| {
        let other = other.robot_from_sensor;
        libm::hypot(mount.x - other.x, mount.y - other.y) > ALIKE.0
            || angle_between(mount.yaw, other.yaw) > ALIKE.1
    };
    let two: Vec<_> = two.filter(differ).collect();
    let (first, mount, other) = *two.first()?;
    let names: Vec<&str> = two.iter().map(|(sonar, ..)| sonar.name.as_str()).collect();
    let keys = two.iter().flat_map(|(sonar, _, other)| {
        let section = format!("sonar.{}", keys::part(&sonar.name));
        let Pose2 { x, y, yaw } = other.robot_from_sensor;
        [("x", x), ("y", y), ("yaw", yaw.to_degrees())]
            .map(|(key, value)| format!("{section}.{key} = {}", libm::round(value * 1e4) / 1e4))
    });
    let keys: Vec<String> = keys.collect();
    let tried = of.tried(&keys.join("\n"));
    let place = |x: f64, y: f64, yaw: f64| {
        format!(
            "x = {x:.3} m, y = {y:.3} m, yaw = {:.1} deg",
            yaw.to_degrees()
        )
    };
    let said = other.robot_from_sensor;
    Some(Finding::new(
        Weight::Serious,
        "two-mounts",
        format!(
            "transforms of `{}` say two things, going from one to the other {}: {} {} at {}, or at {}; the former is \
             used",
            other.frame,
            times(other.turns),
            which_sonars(&names, of.facts.sonars.len()),
            if names.len() == 1 { "sits" } else { "sit" },
            place(mount.x, mount.y, mount.yaw),
            place(said.x, said.y, said.yaw),
        ),
        format!("one of them is wrong, and so is what {} hears if it is the one that is used", first.name),
        match &tried {
            Some(tried) => format!("end one of the two publishers; for this log {}{tried}", tried.named()),
            None => "end one of the two publishers; the other place explains no more of this log".to_owned(),
        },
    )
    .with(tried))
}
