//! Sonars on one mount, as of drivers that stamp every message with the robot's own frame
//! (SteveMacenski/spatio_temporal_voxel_layer#228, utexas-bwi/segbot#48).

use super::examined::Examined;
use super::finding::{Finding, Weight, which_sonars};
use super::mounts::are_alike;
use super::sonars::SonarFacts;

/// So many echoes of a sonar show that it is one of its own.
const ENOUGH: u64 = 20;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    // A sensor that measures with light sits beside a sonar.
    let sound = of.sonars().filter(|(_, traits)| !traits.infrared);
    let placed: Vec<&SonarFacts> = sound
        .map(|(sonar, _)| sonar)
        .filter(|sonar| sonar.mount.is_some() && sonar.echoes >= ENOUGH)
        .collect();
    let events = &of.survey.log.events;
    let shares = |one: &&&SonarFacts| {
        placed.iter().any(|other| {
            other.id != one.id && other.mount == one.mount && !are_alike(events, one.id, other.id)
        })
    };
    let first = placed.iter().find(shares)?;
    let mount = first.mount?;
    let names: Vec<&str> = placed
        .iter()
        .filter(|sonar| sonar.mount == first.mount)
        .map(|sonar| sonar.name.as_str())
        .collect();
    let frame = of.sonars().find(|(sonar, _)| sonar.id == first.id);
    let frame = frame.map_or("", |(_, traits)| traits.frame.as_str());
    Some(Finding::new(
        Weight::Serious,
        "one-mount",
        format!(
            "{} sit at the same place (x = {:.3} m, y = {:.3} m) and look the same way ({:.1} deg), and do not measure \
             the same: their messages name the frame `{frame}`",
            which_sonars(&names, of.facts.sonars.len()),
            mount.x,
            mount.y,
            mount.yaw.to_degrees()
        ),
        "a map from wrong mounts is wrong everywhere",
        format!(
            "let each driver name its sonar's own frame; for this log give x, y and yaw of each: [sonar.{}]",
            toml::Value::from(first.name.as_str())
        ),
    ))
}
