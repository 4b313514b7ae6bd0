//! Readings that merely repeat a sonar's last value while the robot moved: a driver that publishes
//! more often than its sonar fires.

use crate::core::config::Frames;
use crate::core::event::{OdometrySample, RangeReading, Readings, Return, Sonar};
use crate::core::geometry::{Pose2, wrap_angle};
use crate::core::odometry::Track;

/// Less than this between two readings is no motion, metres and radians.
const MOTION: f64 = 1e-3;

/// A larger share of a sonar's readings than this is worth a word.
const SHARE: f64 = 0.2;

/// Marks the readings that repeat the one before of the same sonar, an echo with the same bits,
/// from another pose. Readings and samples are in stamp order; readings were taken `range_delay`
/// seconds before their stamps. One outside the samples repeats nothing.
pub fn find(
    readings: &Readings,
    samples: &[OdometrySample],
    range_delay: f64,
    sonars: usize,
) -> Vec<bool> {
    let bounds = Frames {
        max_odometry_gap: f64::INFINITY,
        max_extrapolation: 0.0,
        ..Frames::default()
    };
    let track = Track::new(samples, &bounds).with_range_delay(range_delay);
    let mut last: Vec<Option<(u64, Pose2)>> = vec![None; sonars];
    let mut near = 0;
    let repeats = |reading: RangeReading| {
        let here = track.world_from_robot_next(&reading, &mut near).ok();
        let here = here.filter(|_| reading.classify() == Return::Echo);
        let now = here.map(|here| (reading.range.to_bits(), here));
        let Some(last) = last.get_mut(reading.sonar.index()) else {
            return false;
        };
        match (std::mem::replace(last, now), now) {
            (Some((same, there)), Some((bits, here))) => same == bits && has_moved(there, here),
            _ => false,
        }
    };
    readings.iter().map(repeats).collect()
}

fn has_moved(from: Pose2, to: Pose2) -> bool {
    (to.position() - from.position()).norm() > MOTION
        || wrap_angle(to.yaw - from.yaw).abs() > MOTION
}

/// What a person is told of the repeats; `None` where there are few.
pub fn note(
    readings: &Readings,
    repeats: &[bool],
    sonars: &[Sonar],
    dropped: bool,
) -> Option<String> {
    let mut counts = vec![(0_u32, 0_u32); sonars.len()];
    for (reading, repeats) in readings.iter().zip(repeats) {
        if let Some((all, repeated)) = counts.get_mut(reading.sonar.index()) {
            *all += 1;
            *repeated += u32::from(*repeats);
        }
    }
    let total = repeats.iter().filter(|repeats| **repeats).count();
    let shares: Vec<String> = sonars
        .iter()
        .zip(counts)
        .filter(|(_, (all, repeated))| f64::from(*repeated) > SHARE * f64::from(*all))
        .map(|(sonar, (all, repeated))| {
            let percent = 100.0 * f64::from(repeated) / f64::from(all);
            format!("{} {percent:.0} %", sonar.name)
        })
        .collect();
    let what = match total {
        1 => "reading that repeats the sonar's last value although the robot moved",
        _ => "readings that repeat the sonar's last value although the robot moved",
    };
    match (total, dropped, shares.is_empty()) {
        (0, ..) => None,
        (_, true, _) => Some(format!("{total} {what} left out")),
        (_, false, true) => Some(format!(
            "{total} {what}, of {}; input.drop_repeats leaves them out",
            readings.len()
        )),
        (_, false, false) => Some(format!(
            "many {what} ({}): a driver that republishes, or a coarse resolution; input.drop_repeats \
             leaves them out",
            shares.join(", ")
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::event::SonarId;

    fn reading(stamp_ns: i64, sonar: u16, range: f64) -> RangeReading {
        RangeReading {
            stamp_ns,
            sonar: SonarId(sonar),
            range,
            min_range: 0.1,
            max_range: 4.0,
            beam_width: 0.4,
            variance: 0.0,
        }
    }

    /// Drives a metre in 100 ns, then stands.
    fn samples() -> Vec<OdometrySample> {
        [(0, 0.0), (100, 1.0), (200, 1.0)]
            .map(|(stamp_ns, x)| OdometrySample {
                stamp_ns,
                world_from_robot: Pose2::new(x, 0.0, 0.0),
            })
            .to_vec()
    }

    #[test]
    fn the_same_echo_from_another_pose_repeats() {
        let readings = Readings::from_iter([
            reading(0, 0, 1.5),
            reading(5, 1, 1.5),  // another sonar
            reading(10, 0, 1.5), // repeats
            reading(20, 0, 1.6),
            reading(30, 0, f64::INFINITY),
            reading(40, 0, f64::INFINITY), // nothing echoed twice
            reading(120, 0, 1.7),
            reading(140, 0, 1.7), // the robot stands
            reading(500, 0, 1.7), // where it is then is not known
        ]);
        let repeats = find(&readings, &samples(), 0.0, 2);
        let found: Vec<usize> = (0..readings.len()).filter(|i| repeats[*i]).collect();
        assert_eq!(found, [2]);
    }

    #[test]
    fn many_repeats_are_worth_a_word() {
        let sonars = [Sonar {
            name: "left".into(),
            topic: "/left".into(),
            robot_from_sensor: Pose2::IDENTITY,
        }];
        let readings: Readings = (0..5).map(|k| reading(10 * k, 0, 1.5)).collect();
        let all = find(&readings, &samples(), 0.0, 1);
        let said = note(&readings, &all, &sonars, false).unwrap();
        assert!(said.contains("left 80 %"), "{said}");
        let said = note(&readings, &all, &sonars, true).unwrap();
        assert!(said.starts_with("4 readings"), "{said}");
        let one = [true, false, false, false, false];
        let said = note(&readings, &one, &sonars, false).unwrap();
        assert!(said.starts_with("1 reading that repeats"), "{said}");
        assert_eq!(note(&readings, &[false; 5], &sonars, false), None);
    }
}
