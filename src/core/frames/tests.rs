use super::*;
use crate::core::event::OdometrySample;

const NONE: f64 = f64::INFINITY;

fn sonars() -> Vec<Sonar> {
    let sonar = |name: &str, yaw| Sonar {
        name: name.into(),
        topic: name.into(),
        robot_from_sensor: Pose2::new(0.1, 0.0, yaw),
    };
    vec![sonar("a", 0.0), sonar("b", 1.0)]
}

/// At 1 m/s along x for ten seconds.
fn odometry() -> Vec<OdometrySample> {
    (0..=100)
        .map(|k| OdometrySample {
            stamp_ns: k * 100_000_000,
            world_from_robot: Pose2::new(k as f64 * 0.1, 0.0, 0.0),
        })
        .collect()
}

fn reading(millis: i64, sonar: u16, range: f64) -> RangeReading {
    RangeReading {
        stamp_ns: millis * 1_000_000,
        sonar: SonarId(sonar),
        range,
        min_range: 0.1,
        max_range: 5.0,
        beam_width: 0.4,
        variance: 0.0,
    }
}

fn frames(readings: &[RangeReading], bounds: &config::Frames) -> (Vec<Frame>, Tally) {
    let (odometry, sonars) = (odometry(), sonars());
    let mut framer = Framer::new(
        Track::new(&odometry, bounds),
        &sonars,
        &[true, true],
        bounds,
    );
    let mut frames: Vec<Frame> = readings.iter().filter_map(|r| framer.push(r)).collect();
    let (last, tally) = framer.finish();
    frames.extend(last);
    (frames, tally)
}

#[test]
fn a_frame_opens_every_step() {
    let readings: Vec<_> = (0..100).map(|k| reading(k * 20, 0, 1.0)).collect();
    let (frames, _) = frames(&readings, &config::Frames::default());
    let opened: Vec<f64> = frames.iter().map(|f| f.world_from_robot.x).collect();
    assert_eq!(frames.len(), 20, "{opened:?}");
    assert!(frames.iter().zip(0..).all(|(f, k)| f.index == k));
    assert_eq!(frames[1].stamp_ns, 100_000_000);
}

#[test]
fn the_first_echo_is_kept_and_replaces_a_no_echo() {
    let readings = [
        reading(0, 0, NONE),
        reading(10, 0, 1.0),
        reading(20, 0, 2.0),
        reading(30, 1, NONE),
        reading(40, 1, 7.0),
    ];
    let (frames, tally) = frames(&readings, &config::Frames::default());
    let [frame] = frames.as_slice() else { panic!() };
    assert_eq!(frame.stamp_ns, 0, "a no-echo opens a frame");
    assert_eq!(frame.entries[0].echo.unwrap().range, 1.0);
    assert_eq!(frame.entries[0].stamp_ns, 10_000_000);
    assert_eq!(frame.entries[1].echo, None);
    assert_eq!(frame.entries[1].stamp_ns, 30_000_000);
    assert_eq!((tally.echoes, tally.no_echoes, tally.surplus), (2, 3, 3));
}

#[test]
fn an_invalid_reading_opens_a_frame_and_has_no_entry_in_it() {
    let readings = [reading(0, 0, f64::NAN), reading(50, 0, 1.0)];
    let (frames, tally) = frames(&readings, &config::Frames::default());
    assert_eq!(frames.len(), 1);
    assert_eq!(frames[0].stamp_ns, 0);
    assert_eq!(frames[0].entries[0].stamp_ns, 50_000_000);
    assert_eq!(tally.dropped.get("invalid"), Some(&1));
}

#[test]
fn a_reading_without_a_pose_opens_nothing_and_is_counted() {
    let (frames, tally) = frames(
        &[reading(-5, 0, 1.0), reading(20_000, 0, 1.0)],
        &config::Frames::default(),
    );
    assert!(frames.is_empty());
    assert_eq!(tally.dropped.len(), 2);
}

#[test]
fn step_zero_opens_a_frame_at_every_stamp() {
    let every = config::Frames {
        step: 0.0,
        ..config::Frames::default()
    };
    let readings = [reading(0, 0, 1.0), reading(0, 1, 1.0), reading(1, 0, 1.0)];
    let (frames, _) = frames(&readings, &every);
    assert_eq!(
        frames.iter().map(|f| f.entries.len()).collect::<Vec<_>>(),
        [2, 1]
    );
}

#[test]
fn the_sensor_is_placed_by_its_mount() {
    let (frames, _) = frames(&[reading(1000, 1, 1.0)], &config::Frames::default());
    let sensor = frames[0].entries[0].world_from_sensor;
    assert!((sensor.x - 1.1).abs() < 1e-12 && (sensor.yaw - 1.0).abs() < 1e-12);
}
