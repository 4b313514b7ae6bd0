//! Which drive a log holds: a digest of its events.

use sha2::{Digest as _, Sha256};

use crate::core::event::Events;
use crate::core::rounding::rounded;

/// SHA-256 over what was read from a log: sonars and their mounts, readings, odometry, in stamp order.
///
/// Of the events, not of the file: a log that was compressed otherwise, cut into other chunks or
/// written in another order holds the same drive. Numbers count to 1e-9.
pub fn sha256(events: &Events) -> String {
    let mut hash = Sha256::new();
    let numbers = |hash: &mut Sha256, numbers: &[f64]| {
        for number in numbers {
            let number = if number.is_nan() {
                f64::NAN
            } else {
                rounded(*number)
            };
            hash.update(number.to_bits().to_le_bytes());
        }
    };
    hash.update((events.sonars.len() as u64).to_le_bytes());
    for sonar in &events.sonars {
        hash.update((sonar.name.len() as u64).to_le_bytes());
        hash.update(sonar.name.as_bytes());
        let mount = sonar.robot_from_sensor;
        numbers(&mut hash, &[mount.x, mount.y, mount.yaw]);
    }
    hash.update((events.readings.len() as u64).to_le_bytes());
    for r in events.readings.iter() {
        hash.update(r.stamp_ns.to_le_bytes());
        hash.update(r.sonar.0.to_le_bytes());
        numbers(
            &mut hash,
            &[r.range, r.min_range, r.max_range, r.beam_width, r.variance],
        );
    }
    hash.update((events.odometry.len() as u64).to_le_bytes());
    for sample in &events.odometry {
        hash.update(sample.stamp_ns.to_le_bytes());
        let pose = sample.world_from_robot;
        numbers(&mut hash, &[pose.x, pose.y, pose.yaw]);
    }
    format!("{:x}", hash.finalize())
}
