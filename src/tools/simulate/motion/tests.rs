use super::*;
use crate::core::geometry::{Vec2, angle_between};

/// A path along x, metres.
fn line(length: f64) -> Path {
    Path::new(&[Vec2::zeros(), Vec2::new(length, 0.0)]).unwrap()
}

/// When which sonar fired.
fn shots(ticks: &[Tick]) -> Vec<(i64, usize)> {
    let fired = |tick: &Tick| match tick.action {
        Action::Fire(sonar) => Some((tick.after_ns, sonar)),
        Action::Odometry(_) => None,
    };
    ticks.iter().filter_map(fired).collect()
}

#[test]
fn a_drive_is_steady_and_sonars_take_turns() {
    let driving = Driving::default();
    let ticks = driving.schedule(&Path::room(), 16).unwrap();
    let shots = shots(&ticks);
    assert_eq!(
        shots.len(),
        2857,
        "100 s (18 m at 0.2 m/s and five quarter turns of 2 s) of 35 ms"
    );
    assert_eq!(
        shots[..3],
        [(17_500_000, 0), (52_500_000, 8), (87_500_000, 4)]
    );
    for (one, two) in ticks.iter().zip(ticks.iter().skip(1)) {
        let seconds = (two.after_ns - one.after_ns) as f64 * 1e-9;
        let (a, b) = (one.world_from_robot, two.world_from_robot);
        let driven = (a.position() - b.position()).norm();
        assert!(driven <= driving.speed * seconds + 1e-9);
        assert!(angle_between(a.yaw, b.yaw) <= driving.turn_rate * seconds + 1e-9);
    }
}

#[test]
fn odometry_brackets_every_shot() {
    let driving = Driving {
        speed: 0.37,
        ..Driving::default()
    };
    let ticks = driving.schedule(&line(1.0), 3).unwrap();
    let (first, last) = (ticks.first().unwrap(), ticks.last().unwrap());
    assert!(matches!(first.action, Action::Odometry(_)));
    assert_eq!(last.action, Action::Odometry(Twist::default()));
    assert_eq!(last.world_from_robot, Pose2::new(1.0, 0.0, 0.0));
}

#[test]
fn a_closed_path_is_driven_for_as_long_as_asked() {
    let for_seconds = |duration| Driving {
        duration: Some(duration),
        ..Driving::default()
    };
    let ticks = for_seconds(250.0).schedule(&Path::room(), 16).unwrap();
    assert_eq!(ticks.last().unwrap().after_ns, 250_000_000_000);
    let once = Driving::default().schedule(&Path::room(), 16).unwrap();
    let begin = once.iter().zip(&ticks).take(3000);
    assert!(begin.clone().count() == 3000 && begin.clone().all(|(one, other)| one == other));
    // What does not end where it begins is driven to its end at most.
    assert!(for_seconds(1.0).schedule(&line(1.0), 3).is_ok());
    assert!(for_seconds(1e3).schedule(&line(1.0), 3).is_err());
    assert!(for_seconds(-1.0).schedule(&Path::room(), 3).is_err());
}

#[test]
fn a_turn_goes_the_short_way() {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, -1.0), (2.0, -1.0)];
    let path = Path::new(&corners.map(|(x, y)| Vec2::new(x, y))).unwrap();
    let legs = Driving::default().legs(&path);
    let angles = legs.iter().filter_map(|leg| match leg.way {
        Way::Turn { angle, .. } => Some(angle.to_degrees()),
        Way::Straight(_) => None,
    });
    let angles: Vec<_> = angles.map(|angle| angle.round()).collect();
    assert_eq!(angles, [-90.0, 90.0]);
}

#[test]
fn what_cannot_be_driven_is_refused() {
    let good = Driving::default();
    for bad in [
        Driving { speed: 0.0, ..good },
        Driving {
            speed: 1e-300,
            ..good
        },
        Driving {
            turn_rate: f64::NAN,
            ..good
        },
        Driving {
            firing_interval: 0.0,
            ..good
        },
        Driving {
            odometry_rate: 1e9,
            ..good
        },
    ] {
        assert!(bad.schedule(&Path::room(), 16).is_err(), "{bad:?}");
    }
}

#[test]
fn the_room_takes_150_steps_of_16_shots() {
    let ticks = Motion::Stepwise(Stepwise::default())
        .schedule(&Path::room(), 16)
        .unwrap();
    assert_eq!(ticks.len(), 150 * 17);
    assert_eq!(ticks.last().unwrap().after_ns, 59_600_000_000);
    assert!(ticks.is_sorted_by_key(|tick| tick.after_ns));
}

#[test]
fn steps_end_with_an_open_path_and_go_round_a_closed_one() {
    let stepwise = |steps| Stepwise {
        step: 0.5,
        steps,
        ..Stepwise::default()
    };
    let count = |path: &Path, steps| {
        let ticks = stepwise(steps).schedule(path, 1)?;
        Ok::<_, SimulateError>(shots(&ticks).len())
    };
    assert_eq!(count(&line(1.0), None).unwrap(), 3);
    assert_eq!(count(&line(1.0), Some(2)).unwrap(), 2);
    assert_eq!(count(&line(0.1), None).unwrap(), 1);
    assert!(matches!(
        count(&line(1.0), Some(4)),
        Err(SimulateError::PathTooShort { most: 3, .. })
    ));
    assert_eq!(count(&Path::room(), None).unwrap(), 36);
    assert_eq!(count(&Path::room(), Some(100)).unwrap(), 100);
    assert!(count(&Path::room(), Some(0)).is_err());
    assert!(count(&Path::room(), Some(usize::MAX)).is_err());
}

#[test]
fn what_cannot_be_walked_is_refused() {
    for step in [0.0, -1.0, f64::NAN, 1e-300, f64::INFINITY] {
        let stepwise = Stepwise {
            step,
            ..Stepwise::default()
        };
        assert!(stepwise.schedule(&line(1.0), 16).is_err(), "{step}");
    }
}
