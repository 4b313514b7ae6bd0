use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use super::*;
use crate::io::log::message::{Content, RangeMessage, TransformMessage};

/// A log with a sonar on `base_link` and these transforms between frames, which all move.
fn log(edges: &[(&str, &str)]) -> Gatherer {
    let courses = edges.iter().map(|edge| (*edge, 0..10, 0.0));
    log_of(&courses.collect::<Vec<_>>())
}

/// The same with the steps, of a tenth of a metre and of a second each, in which each transform is
/// said, and what is added to it, metres.
fn log_of(courses: &[((&str, &str), std::ops::Range<i32>, f64)]) -> Gatherer {
    let mut gatherer = Gatherer::default();
    let transform = |stamp_ns: i64, parent: &str, child: &str, x: f64| TransformMessage {
        stamp_ns,
        parent: parent.to_owned(),
        child: child.to_owned(),
        parent_from_child: Some(Isometry3::from_parts(
            Translation3::new(x, 0.0, 0.0),
            UnitQuaternion::identity(),
        )),
    };
    let fixed = vec![transform(1, "base_link", "sonar", 0.1)];
    gatherer.take(Role::Transform, "/tf_static", 0, Content::Transforms(fixed));
    for ((parent, child), steps, offset) in courses {
        for step in steps.clone() {
            let stamp_ns = 1 + i64::from(step) * 100_000_000;
            let x = 0.1 * f64::from(step) + offset;
            let moved = vec![transform(stamp_ns, parent, child, x)];
            gatherer.take(Role::Transform, "/tf", 1, Content::Transforms(moved));
        }
    }
    let range = RangeMessage::plain(1, "sonar", 1.0);
    gatherer.take(Role::Range, "/sonar", 1, Content::Ranges(vec![range]));
    gatherer
}

fn chosen(edges: &[(&str, &str)], config: &Config) -> Result<Option<String>, LogError> {
    let chosen = log(edges).by_transforms(config, "log");
    chosen.map(|chosen| chosen.map(|c| format!("{} in {}", c.robot_frame, c.world_frame)))
}

#[test]
fn what_the_robot_carries_and_the_way_back_are_no_odometry() {
    let config = Config::default();
    let of = |edges: &[(&str, &str)]| chosen(edges, &config).unwrap();
    assert_eq!(of(&[("odom", "base_link")]).unwrap(), "base_link in odom");
    assert_eq!(of(&[("base_link", "head")]), None);
    assert_eq!(of(&[("base_link", "left"), ("base_link", "right")]), None);
    assert_eq!(of(&[("base_link", "arm"), ("arm", "hand")]), None);
    let all = [
        ("map", "odom"),
        ("odom", "base_link"),
        ("base_link", "head"),
    ];
    assert_eq!(of(&all).unwrap(), "base_link in odom");
}

#[test]
fn a_robots_frame_that_nothing_moves_is_refused() {
    let mut config = Config::default();
    config.input.robot_frame = Some("nope".to_owned());
    let error = chosen(&[("odom", "base_link")], &config).unwrap_err();
    let said = error.to_string();
    assert!(said.contains("does not say how `nope` moves"), "{said}");
    assert!(said.contains("`base_link` in `odom`"), "{said}");
}

#[test]
fn a_transform_to_the_odometrys_frame_is_turned_round() {
    let config = Config::default();
    let chosen = |edges: &[(&str, &str)]| log(edges).by_transforms(&config, "log").unwrap();
    let back = chosen(&[("base_link", "odom")]).unwrap();
    assert_eq!(
        (&*back.robot_frame, &*back.world_frame),
        ("base_link", "odom")
    );
    let last = back.samples.last().unwrap().world_from_robot;
    assert!((last.x + 0.9).abs() < 1e-12, "{last:?}");
    assert!(
        back.notes[0].contains("the other way round"),
        "{:?}",
        back.notes
    );
    // A ball that someone else sees is not the robot.
    let ball = chosen(&[("base_link", "odom"), ("world", "ball")]).unwrap();
    assert_eq!(ball.robot_frame, "base_link");
    // Two ways back contradict each other.
    assert!(chosen(&[("base_link", "odom"), ("base_link", "map")]).is_none());
    // Forwards counts more.
    let both = chosen(&[("odom", "base_link"), ("base_link", "map")]).unwrap();
    assert_eq!(
        (&*both.world_frame, both.samples[9].world_from_robot.x),
        ("odom", 0.9)
    );
}

#[test]
fn damaged_names_on_tf_are_counted_as_lost() {
    let damaged = [
        (("odom", "base_link"), 0..60, 0.0),
        (("odo#", "base_link"), 60..61, 0.0),
        (("odom", "base_lin#"), 61..63, 0.0),
        (("odom", "ball"), 0..1, 0.0),
    ];
    let config = Config::default();
    let chosen = log_of(&damaged)
        .by_transforms(&config, "log")
        .unwrap()
        .unwrap();
    assert_eq!(
        (chosen.samples.len(), &*chosen.robot_frame),
        (60, "base_link")
    );
    let [loss] = chosen.losses.as_slice() else {
        panic!("{:?}", chosen.losses)
    };
    assert!(
        loss.starts_with("3 of 63 transforms on /tf give the pose of"),
        "{loss}"
    );
    assert!(
        loss.contains("`base_link` in `odo#`") && loss.contains("`base_lin#` in `odom`"),
        "{loss}"
    );
}

#[test]
fn names_of_any_length_are_compared_at_once() {
    let names: Vec<String> = (0..100)
        .map(|k| format!("{k}{}", "x".repeat(100_000)))
        .collect();
    let courses = names.iter().enumerate();
    let edges: Vec<_> = courses
        .map(|(k, name)| {
            (
                ("world", name.as_str()),
                0..if k % 2 == 0 { 20 } else { 2 },
                0.0,
            )
        })
        .collect();
    // With the product of lengths this would take a day.
    assert!(
        log_of(&edges)
            .by_transforms(&Config::default(), "log")
            .is_err()
    );
}

#[test]
fn a_track_that_is_renamed_is_joined_where_it_goes_on_and_told_where_it_does_not() {
    let chosen = |offset: f64, from: i32, config: &Config| {
        let renamed = [
            (("odom", "base_link"), 0..50, 0.0),
            (("odom2", "base_link"), from..90, offset),
        ];
        log_of(&renamed)
            .by_transforms(config, "log")
            .unwrap()
            .unwrap()
    };
    let mut config = Config::default();
    let joined = chosen(0.0, 50, &config);
    assert_eq!((joined.samples.len(), joined.losses.len()), (90, 0));
    assert!(
        joined.notes[1].contains("all are taken for one track"),
        "{:?}",
        joined.notes
    );

    let apart = chosen(-5.0, 50, &config);
    assert_eq!(apart.samples.len(), 50);
    let loss = &apart.losses[0];
    for said in [
        "in `odom` by 50 transforms from ",
        "in `odom2` by 40 transforms from 5.0 s to 8.9 s, which do not go on",
        "`input.world_frame = \"odom2\"`",
    ] {
        assert!(loss.contains(said), "no {said}: {loss}");
    }
    let longer = chosen(-5.0, 20, &config);
    assert_eq!(longer.world_frame, "odom2");
    let loss = &longer.losses[0];
    assert!(
        loss.contains("50 transforms") && loss.contains("10 of them at times that the former lack"),
        "{loss}"
    );
    let twice = chosen(-5.0, 0, &config);
    assert_eq!(
        (twice.world_frame.as_str(), twice.losses.len()),
        ("odom2", 0)
    );
    assert!(
        twice.notes[1].contains("in two frames at the same time"),
        "{:?}",
        twice.notes
    );

    config.input.world_frame = Some("odom2".to_owned());
    let asked = chosen(-5.0, 50, &config);
    assert_eq!(
        (asked.samples.len(), asked.losses.len(), asked.notes.len()),
        (40, 0, 1)
    );
    config.input.world_frame = Some("nope".to_owned());
    let error = log(&[("odom", "base_link")])
        .by_transforms(&config, "log")
        .unwrap_err();
    assert!(
        error.to_string().contains("which input.world_frame names"),
        "{error}"
    );
}

#[test]
fn what_was_passed_over_is_told() {
    let wheels = log(&[("base_link", "left"), ("base_link", "right")]);
    let passed_over = wheels.passed_over(&Config::default());
    assert_eq!(passed_over.len(), 2);
    let error = LogError::NoOdometry {
        file: "log".to_owned(),
        asked: Vec::new(),
        found: vec!["/tf".to_owned()],
        passed_over,
    };
    let said = error.to_string();
    assert!(
        said.contains("- `left` in `base_link`") && said.contains("input.world_frame = \"left\""),
        "{said}"
    );
}

fn of(courses: &[((&str, &str), std::ops::Range<i32>, f64)], config: &Config) -> Chosen {
    let chosen = log_of(courses).by_transforms(config, "log").unwrap();
    chosen.unwrap()
}

#[test]
fn a_transform_that_closes_a_circle_costs_itself_alone() {
    for odd in [("base_link", "odom"), ("sonar", "odom")] {
        for first in [true, false] {
            let mut courses = vec![(("odom", "base_link"), 0..60, 0.0)];
            courses.insert(usize::from(!first), (odd, 7..8, 0.0));
            let chosen = of(&courses, &Config::default());
            assert_eq!((chosen.samples.len(), &*chosen.world_frame), (60, "odom"));
            let loss = format!("gives the pose of `{}` in `{}`", odd.1, odd.0);
            assert!(chosen.losses[0].contains(&loss), "{:?}", chosen.losses);
        }
    }
}

#[test]
fn a_robots_frame_that_is_renamed_goes_on_and_is_told_where_it_does_not() {
    let renamed = |offset| {
        let courses = [
            (("odom", "base_link"), 0..40, 0.0),
            (("odom", "base_footprint"), 40..90, offset),
        ];
        of(&courses, &Config::default())
    };
    let joined = renamed(0.0);
    assert_eq!((joined.samples.len(), joined.losses.len()), (90, 0));
    assert_eq!(joined.robot_frame, "base_link");
    let apart = renamed(5.0);
    assert_eq!(apart.samples.len(), 40);
    let loss = &apart.losses[0];
    assert!(
        loss.contains("`base_footprint` in `odom` by 50 transforms from 4.0 s to 8.9 s"),
        "{loss}"
    );
    // Another robot in the same world.
    let other = [
        (("world", "base_link"), 0..50, 0.0),
        (("world", "base_2"), 0..90, 5.0),
    ];
    let chosen = of(&other, &Config::default());
    assert_eq!((chosen.samples.len(), chosen.losses.len()), (50, 0));
}

#[test]
fn tracks_that_overlap_or_alternate_are_joined_where_they_agree() {
    let overlap = |offset| {
        let courses = [
            (("odom", "base_link"), 0..55, 0.0),
            (("odom2", "base_link"), 50..90, offset),
        ];
        of(&courses, &Config::default())
    };
    let joined = overlap(0.0);
    assert_eq!((joined.samples.len(), joined.losses.len()), (90, 0));
    let apart = overlap(3.0);
    assert_eq!((apart.samples.len(), apart.losses.len()), (55, 1));
    let alternating = [
        (("odom", "base_link"), 0..30, 0.0),
        (("odom2", "base_link"), 30..60, 0.0),
        (("odom", "base_link"), 60..90, 0.0),
    ];
    let joined = of(&alternating, &Config::default());
    assert_eq!((joined.samples.len(), joined.losses.len()), (90, 0));
}

#[test]
fn the_way_back_bears_damage_other_names_and_any_world() {
    let damaged = [
        (("base_link", "odom"), 0..60, 0.0),
        (("base_lin_", "odom"), 60..61, 0.0),
        (("base_link", "odoX"), 61..62, 0.0),
    ];
    let chosen = of(&damaged, &Config::default());
    assert_eq!(chosen.samples.len(), 60);
    assert!(
        chosen.losses[0].starts_with("2 of 62 transforms on /tf give"),
        "{:?}",
        chosen.losses
    );
    let renamed = [
        (("base_link", "odom"), 0..50, 0.0),
        (("base_link", "odom_2"), 50..90, 0.0),
    ];
    let chosen = of(&renamed, &Config::default());
    assert_eq!((chosen.samples.len(), chosen.losses.len()), (90, 0));

    let weird = [(("base_link", "start"), 0..50, 0.0)];
    let mut config = Config::default();
    assert!(
        log_of(&weird)
            .by_transforms(&config, "log")
            .unwrap()
            .is_none()
    );
    config.input.world_frame = Some("start".to_owned());
    let chosen = of(&weird, &config);
    assert_eq!(
        (&*chosen.world_frame, &*chosen.robot_frame),
        ("start", "base_link")
    );
    assert!((chosen.samples[49].world_from_robot.x + 4.9).abs() < 1e-12);
}
