//! Robots that drive faster than any with sonars: odometry in another unit.

use super::examined::Examined;
use super::finding::{Finding, Weight};
use super::units::UNITS;
use crate::core::event::OdometrySample;
use crate::core::statistics::{median, seconds};
use crate::io::log::tracks::two_tracks;

/// A robot with sonars is slower, metres per second.
pub const FASTEST: f64 = 4.0;
/// A slower one stands, metres per second.
const STANDS: f64 = 0.01;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    if two_tracks(&of.survey.log.events.odometry).is_some() {
        return None; // to and fro
    }
    let speed = usual(&of.survey.log.events.odometry)?;
    let topic = of
        .survey
        .odometry_topic
        .as_deref()
        .filter(|_| speed > FASTEST)?;
    let key = |metres| {
        let topic = toml::Value::from(topic);
        format!("channel.{topic}.metres_per_unit = {metres}")
    };
    let tried = of.best(&UNITS.map(|(_, metres)| key(metres)));
    let unit = tried.as_ref().and_then(|tried| {
        let mut units = UNITS.iter();
        units.find(|(_, metres)| key(*metres) == tried.keys)
    });
    Some(Finding::new(
        Weight::Serious,
        "too-fast",
        format!(
            "the robot drives {speed:.1} m/s in the middle of all steps, as no robot with sonars does"
        ),
        "the path is as much too large, readings lie too far apart for a label",
        match tried.as_ref().zip(unit) {
            Some((tried, (unit, _))) => format!(
                "the odometry on {topic} seems to be in {unit}: {}{tried}",
                tried.keys
            ),
            None => format!(
                "is the odometry on {topic} in metres? [channel.{}] metres_per_unit scales it",
                toml::Value::from(topic)
            ),
        },
    )
    .with(tried))
}

/// The speed in the middle of all steps in which the robot moves, metres per second.
pub fn usual(samples: &[OdometrySample]) -> Option<f64> {
    let speeds = samples.array_windows().map(|[a, b]| {
        let way = b.world_from_robot.position() - a.world_from_robot.position();
        way.norm() / seconds(a.stamp_ns, b.stamp_ns)
    });
    let mut speeds: Vec<f64> = speeds
        .filter(|speed| speed.is_finite() && *speed > STANDS)
        .collect();
    speeds.sort_by(f64::total_cmp);
    median(&speeds)
}
