use nalgebra::{Translation3, UnitQuaternion};

use super::*;
use crate::io::log::transforms::Origin;

/// A log with a sonar on `base_link`, and transforms that may move.
struct Made {
    moving: Moving,
    transforms: TransformTree,
}

/// With these transforms between frames, which all move.
fn log(edges: &[(&str, &str)]) -> Made {
    let courses = edges.iter().map(|edge| (*edge, 0..10, 0.0));
    log_of(&courses.collect::<Vec<_>>())
}

/// The same with the steps, of a tenth of a metre and of a second each, in which each transform is
/// said, and what is added to it, metres.
fn log_of(courses: &[((&str, &str), std::ops::Range<i32>, f64)]) -> Made {
    let transform = |stamp_ns: i64, parent: &str, child: &str, x: f64| TransformMessage {
        stamp_ns,
        parent: parent.to_owned().into(),
        child: child.to_owned().into(),
        parent_from_child: Some(Isometry3::from_parts(
            Translation3::new(x, 0.0, 0.0),
            UnitQuaternion::identity(),
        )),
        ..TransformMessage::default()
    };
    let (mut moving, mut transforms) = (Moving::default(), TransformTree::default());
    transforms.add(transform(1, "base_link", "sonar", 0.1), Origin::Fixed);
    for ((parent, child), steps, offset) in courses {
        for step in steps.clone() {
            let stamp_ns = 1 + i64::from(step) * 100_000_000;
            let x = 0.1 * f64::from(step) + offset;
            let moved = transform(stamp_ns, parent, child, x);
            moving.take("/tf", 1, &moved);
            transforms.add(moved, Origin::Moving);
        }
    }
    Made { moving, transforms }
}

impl Made {
    fn circumstances<'a>(&'a self, config: &'a Config) -> Circumstances<'a> {
        Circumstances {
            file: "log",
            config,
            transforms: &self.transforms,
            carriers: self.transforms.carrier("sonar", "").into_iter().collect(),
            poses: 0,
            start_ns: Some(1),
        }
    }

    fn by_transforms(&self, config: &Config) -> Result<Option<Chosen>, LogError> {
        self.moving.odometry(&self.circumstances(config))
    }

    fn passed_over(&self, config: &Config) -> Vec<Edge> {
        self.moving.passed_over(&self.circumstances(config))
    }
}

fn chosen(edges: &[(&str, &str)], config: &Config) -> Result<Option<String>, LogError> {
    let chosen = log(edges).by_transforms(config);
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
    let chosen = |edges: &[(&str, &str)]| log(edges).by_transforms(&config).unwrap();
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
    let chosen = log_of(courses).by_transforms(config).unwrap();
    chosen.unwrap()
}

#[test]
fn a_track_under_another_name_is_told_and_a_loss_where_it_stands_alone() {
    let of = |from: i32, config: &Config| {
        let renamed = [
            (("odom", "base_link"), 0..50, 0.0),
            (("odom2", "base_link"), from..90, 1.0),
        ];
        of(&renamed, config)
    };
    let mut config = Config::default();
    let half = of(50, &config);
    assert_eq!((half.samples.len(), &*half.world_frame), (50, "odom"));
    let loss = &half.losses[0];
    for said in [
        "in `odom` by 50 transforms from 0.0 s to 4.9 s, which are used",
        "in `odom2` by 40 transforms from 5.0 s to 8.9 s, which are left out, 30 of them at times",
        "`input.world_frame = \"odom2\"`",
    ] {
        assert!(loss.contains(said), "no {said}: {loss}");
    }
    let twice = of(0, &config);
    assert_eq!((&*twice.world_frame, twice.losses.len()), ("odom2", 0));
    assert!(
        twice.notes[1].contains("0 of them at times"),
        "{:?}",
        twice.notes
    );

    config.input.world_frame = Some("odom2".to_owned());
    let asked = of(50, &config);
    assert_eq!(
        (asked.samples.len(), asked.losses.len(), asked.notes.len()),
        (40, 0, 1)
    );
    config.input.world_frame = Some("nope".to_owned());
    let error = log(&[("odom", "base_link")])
        .by_transforms(&config)
        .unwrap_err();
    assert!(
        error.to_string().contains("which input.world_frame names"),
        "{error}"
    );
}

#[test]
fn a_single_transform_that_closes_a_circle_changes_nothing() {
    for odd in [("base_link", "odom"), ("sonar", "odom")] {
        for first in [true, false] {
            let mut courses = vec![(("odom", "base_link"), 0..60, 0.0)];
            courses.insert(usize::from(!first), (odd, 7..8, 0.0));
            let chosen = of(&courses, &Config::default());
            assert_eq!((chosen.samples.len(), &*chosen.world_frame), (60, "odom"));
        }
    }
}

#[test]
fn the_way_back_leads_to_any_world_that_is_asked_for() {
    let weird = [(("base_link", "start"), 0..50, 0.0)];
    let mut config = Config::default();
    assert!(log_of(&weird).by_transforms(&config).unwrap().is_none());
    config.input.world_frame = Some("start".to_owned());
    let chosen = of(&weird, &config);
    let frames = (&*chosen.world_frame, &*chosen.robot_frame);
    assert_eq!(frames, ("start", "base_link"));
    assert!((chosen.samples[49].world_from_robot.x + 4.9).abs() < 1e-12);
}

#[test]
fn transforms_that_hold_no_pose_are_counted() {
    let mut made = log(&[("odom", "base_link")]);
    made.moving.take(
        "/tf",
        1,
        &TransformMessage {
            stamp_ns: 5,
            parent: "odom".into(),
            child: "base_link".into(),
            ..TransformMessage::default()
        },
    );
    let chosen = made.by_transforms(&Config::default()).unwrap().unwrap();
    assert_eq!((chosen.samples.len(), chosen.unusable), (10, 1));
}

#[test]
fn poses_without_a_turn_are_lost_where_others_have_one_and_used_where_none_has() {
    let take = |turned: &[bool]| {
        let mut track = Odometry::new(Role::Odometry, false);
        for (k, is_turned) in (1..).zip(turned) {
            let w = f64::from(u8::from(*is_turned));
            let pose = TransformMessage {
                stamp_ns: k,
                parent_from_child: Some(Isometry3::translation(k as f64, 0.0, 0.0)),
                quaternion: Some([0.0, 0.0, 0.0, w]),
                ..TransformMessage::default()
            };
            track.take(k, &pose);
        }
        let chosen = track.choose("/odom".to_owned()).unwrap();
        (chosen.samples.len(), chosen.unusable, chosen.notes.len())
    };
    assert_eq!(take(&[false, true, true, false]), (2, 2, 0));
    assert_eq!(take(&[false, false]), (2, 0, 1));
}
