//! Whether the readings of one sonar lie nearer to the map as it is, were the sonar as estimated: least squares
//! over everything at once can run astray where a reading was taken for one of another feature.

use super::parameter::{Parameter, Quantity, Whose};
use super::ranges::{BESIDE_BEAM, BEYOND_END, OF_MAP, SIGMAS};
use super::seen::{Ping, Scene};
use crate::core::geometry::{Vec2, angle_between, rotate};

/// By how much the readings of a sonar are likelier with some of its values changed, in natural logarithms.
/// `None` where the values are not the mount or the ranges of one sonar: of all of them, the map would move.
pub fn gain(scene: &Scene, values: impl Iterator<Item = (Parameter, f64)>) -> Option<f64> {
    let mut whose = None;
    let (mut moved, mut scale, mut offset) = (Vec2::zeros(), 1.0, 0.0);
    for (parameter, value) in values {
        let Parameter::Sonar(Whose::One(sonar), quantity) = parameter else {
            return None;
        };
        whose = Some(sonar);
        match quantity {
            Quantity::X => moved.x += value,
            Quantity::Y => moved.y += value,
            Quantity::RangeScale => scale += value,
            Quantity::RangeOffset => offset += value,
            Quantity::Yaw | Quantity::BeamWidth => return None,
        }
    }
    let whose = whose?;
    let mut gained = 0.0;
    for ping in scene.pings.iter().filter(|ping| ping.sonar == whose) {
        let Some((range, variance)) = ping.echo else {
            continue;
        };
        let as_it_is = misfit(scene, ping, Vec2::zeros(), range, variance);
        let changed = misfit(scene, ping, moved, range * scale + offset, variance);
        gained += (as_it_is - changed) / 2.0;
    }
    Some(gained)
}

/// The square of what a range is off the nearest feature, in standard deviations; no more than a gate.
fn misfit(scene: &Scene, ping: &Ping, robot_from_moved: Vec2, range: f64, variance: f64) -> f64 {
    let mount = scene.mounts.get(ping.sonar.index());
    let robot_yaw = ping.world_from_sensor.yaw - mount.map_or(0.0, |mount| mount.yaw);
    let sensor = ping.world_from_sensor.position() + rotate(robot_from_moved, robot_yaw);
    let variance = variance + OF_MAP * OF_MAP;
    let near = scene.places.iter().filter_map(|place| {
        let expected = place.expected(sensor)?;
        let is_seen = expected.inside > -BEYOND_END
            && angle_between(expected.bearing, ping.world_from_sensor.yaw)
                < ping.beam_width / 2.0 + BESIDE_BEAM;
        let off = range - expected.range;
        is_seen.then_some(off * off / variance)
    });
    near.fold(SIGMAS * SIGMAS, f64::min)
}
