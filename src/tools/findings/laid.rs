//! Keys that lay poses or mounts otherwise, and the best of them.

use super::examined::{Examined, Tried};
use super::units::UNITS;

/// The key that lays the odometry's axes or mounts so that most of the log is explained, or makes the path of the
/// speeds.
pub fn best_axes(of: &Examined<'_>) -> Option<Tried> {
    let topic = toml::Value::from(of.survey.odometry_topic.as_deref()?);
    let axes = [
        "up = \"y\"",
        "up = \"-y\"",
        "up = \"-z\"",
        "heading = \"clockwise\"",
        "heading = \"compass\"",
    ];
    let mut keys = axes.map(|key| format!("channel.{topic}.{key}")).to_vec();
    keys.extend(mounts_lie());
    let laid = of.best(&keys).filter(Tried::is_most);
    let speeds = of.best(&[from_speeds()]).filter(Tried::is_most);
    // Poses that are only turned say where the map lies; speeds do not.
    match (laid, speeds) {
        (Some(laid), Some(speeds)) if speeds.with.beats(laid.with) => Some(speeds),
        (laid, speeds) => laid.or(speeds),
    }
}

/// The key that takes the odometry's lengths for ones in another unit, so that most of the log is explained.
pub fn best_unit(of: &Examined<'_>) -> Option<Tried> {
    let topic = toml::Value::from(of.survey.odometry_topic.as_deref()?);
    let key = |(_, metres)| format!("channel.{topic}.metres_per_unit = {metres}");
    of.best(&UNITS.map(key)).filter(Tried::is_most)
}

/// The key that makes the path of the speeds, whatever the poses are.
pub fn from_speeds() -> String {
    "input.odometry_from_speeds = true".to_owned()
}

/// The keys that lay mounts otherwise.
pub fn mounts_lie() -> Vec<String> {
    let ways = [
        "outward",
        "mirrored",
        "turned-left",
        "turned-right",
        "turned-round",
    ];
    ways.map(|way| format!("sonars.mounts = \"{way}\""))
        .to_vec()
}
