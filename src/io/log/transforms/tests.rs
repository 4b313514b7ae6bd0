use super::*;
use nalgebra::{Translation3, UnitQuaternion};
use std::f64::consts::{FRAC_PI_2, PI};

fn transform(parent: &str, child: &str, xyz: [f64; 3], rpy: [f64; 3]) -> TransformMessage<'static> {
    TransformMessage {
        parent: parent.to_owned().into(),
        child: child.to_owned().into(),
        parent_from_child: Some(Isometry3::from_parts(
            Translation3::from(Vector3::from(xyz)),
            UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]),
        )),
        ..TransformMessage::default()
    }
}

fn mount(tree: &TransformTree, robot: &str, sensor: &str) -> Result<Mount, NoMount> {
    tree.mount(robot, sensor, &Isometry3::identity())
}

fn close(a: Pose2, b: Pose2) -> bool {
    (a.position() - b.position()).norm() < 1e-12 && (a.yaw - b.yaw).abs() < 1e-12
}

#[test]
fn a_chain_is_followed_up_and_down() {
    let mut tree = TransformTree::default();
    tree.add(
        transform("base_footprint", "base_link", [0.0, 0.0, 0.1], [0.0; 3]),
        Origin::Fixed,
    );
    tree.add(
        transform("base_link", "ring", [0.5, 0.0, 0.0], [0.0, 0.0, FRAC_PI_2]),
        Origin::Fixed,
    );
    tree.add(
        transform("ring", "sonar", [0.1, 0.0, 0.0], [0.0; 3]),
        Origin::Fixed,
    );
    let below = mount(&tree, "base_footprint", "sonar").unwrap();
    assert!(close(
        below.robot_from_sensor,
        Pose2::new(0.5, 0.1, FRAC_PI_2)
    ));
    tree.add(
        transform("base_footprint", "head", [-1.0, 0.0, 0.0], [0.0; 3]),
        Origin::Fixed,
    );
    let across = mount(&tree, "head", "sonar").unwrap();
    assert!(close(
        across.robot_from_sensor,
        Pose2::new(1.5, 0.1, FRAC_PI_2)
    ));
}

#[test]
fn the_robots_own_frame_is_a_mount_and_an_unknown_one_is_not() {
    let tree = TransformTree::default();
    let own = mount(&tree, "base_link", "base_link").unwrap();
    assert_eq!(own.robot_from_sensor, Pose2::IDENTITY);
    assert_eq!(
        mount(&tree, "base_link", "sonar"),
        Err(NoMount::Unconnected)
    );
}

#[test]
fn fixed_transforms_stand_before_moving_ones() {
    let mut tree = TransformTree::default();
    tree.add(
        transform("base_link", "sonar", [9.0, 0.0, 0.0], [0.0; 3]),
        Origin::Moving,
    );
    tree.add(
        transform("base_link", "sonar", [0.1, 0.0, 0.0], [0.0; 3]),
        Origin::Fixed,
    );
    tree.add(
        transform("base_link", "sonar", [8.0, 0.0, 0.0], [0.0; 3]),
        Origin::Moving,
    );
    let mount = mount(&tree, "base_link", "sonar").unwrap();
    assert!(close(mount.robot_from_sensor, Pose2::new(0.1, 0.0, 0.0)));
    assert!(!mount.moved);
}

#[test]
fn a_mount_that_moves_is_noticed() {
    let mut tree = TransformTree::default();
    tree.add(
        transform("base_link", "sonar", [0.1, 0.0, 0.0], [0.0; 3]),
        Origin::Moving,
    );
    assert!(!mount(&tree, "base_link", "sonar").unwrap().moved);
    tree.add(
        transform("base_link", "sonar", [0.1, 0.0, 0.0], [0.0, 0.0, 0.3]),
        Origin::Moving,
    );
    assert!(mount(&tree, "base_link", "sonar").unwrap().moved);
}

#[test]
fn loops_end_and_vertical_beams_are_refused() {
    let mut tree = TransformTree::default();
    tree.add(transform("a", "b", [0.0; 3], [0.0; 3]), Origin::Fixed);
    tree.add(transform("b", "a", [0.0; 3], [0.0; 3]), Origin::Fixed);
    assert_eq!(mount(&tree, "base_link", "a"), Err(NoMount::Unconnected));
    tree.add(
        transform("base_link", "up", [0.0; 3], [0.0, -FRAC_PI_2, 0.0]),
        Origin::Fixed,
    );
    assert_eq!(mount(&tree, "base_link", "up"), Err(NoMount::Vertical));
}

#[test]
fn a_tilted_sonar_is_projected_and_noticed() {
    let mut tree = TransformTree::default();
    tree.add(
        transform("base_link", "s", [0.1, 0.2, 0.3], [0.0, -0.2, 1.0]),
        Origin::Fixed,
    );
    let mount = mount(&tree, "base_link", "s").unwrap();
    assert!(close(mount.robot_from_sensor, Pose2::new(0.1, 0.2, 1.0)));
    assert!((mount.tilt.unwrap() - 0.2).abs() < 1e-12);
}

#[test]
fn a_beam_turns_with_its_frame() {
    let mut tree = TransformTree::default();
    let flipped = transform("base_link", "ring", [0.1, 0.0, 0.0], [PI, 0.0, 0.0]);
    tree.add(flipped, Origin::Fixed);
    let beam = Isometry3::rotation(Vector3::z() * 0.3);
    let mount = tree.mount("base_link", "ring", &beam).unwrap();
    assert!(close(mount.robot_from_sensor, Pose2::new(0.1, 0.0, -0.3)));
}

#[test]
fn what_carries_a_sensor_stands_still_against_it() {
    let mut tree = TransformTree::default();
    for x in [1.0, 2.0] {
        let moving = transform("odom", "base_footprint", [x, 0.0, 0.0], [0.0; 3]);
        tree.add(moving, Origin::Moving);
    }
    tree.add(
        transform("base_footprint", "base_link", [0.0; 3], [0.0; 3]),
        Origin::Fixed,
    );
    tree.add(
        transform("base_link", "s", [0.1, 0.0, 0.0], [0.0; 3]),
        Origin::Fixed,
    );
    assert_eq!(tree.carrier("s", "map"), Some("base_footprint"));
    assert_eq!(tree.carrier("s", "base_footprint"), Some("base_link"));
    assert_eq!(
        tree.carrier("base_footprint", "odom"),
        Some("base_footprint")
    );
    assert_eq!(tree.carrier("unknown", "odom"), None);
}

#[test]
fn a_fixed_transform_that_says_two_things_is_contradicted_and_the_last_is_used() {
    let at = |x: f64| transform("base_link", "sonar", [x, 0.0, 0.0], [0.0; 3]);
    let mut tree = TransformTree::default();
    for x in [0.1, 0.2, 0.1, 0.1, 0.2] {
        tree.add(at(x), Origin::Fixed);
    }
    assert_eq!(tree.contradicted("sonar", "base_link"), Some(("sonar", 3)));
    let used = mount(&tree, "base_link", "sonar").unwrap();
    assert_eq!(used.robot_from_sensor.x, 0.2);
    let other = mount(&tree.with_rivals().unwrap(), "base_link", "sonar").unwrap();
    assert_eq!(other.robot_from_sensor.x, 0.1);
}

#[test]
fn what_goes_to_and_fro_on_tf_is_contradicted_and_what_moves_is_not() {
    let at = |x: f64| transform("base_link", "sonar", [x, 0.0, 0.0], [0.0; 3]);
    let said = |places: &[f64]| {
        let mut tree = TransformTree::default();
        for x in places {
            tree.add(at(*x), Origin::Moving);
        }
        let x = mount(&tree, "base_link", "sonar")
            .unwrap()
            .robot_from_sensor
            .x;
        assert_eq!(x, places[0]);
        tree.contradicted("sonar", "base_link")
            .map(|(_, turns)| turns)
    };
    assert_eq!(said(&[0.1, 0.2, 0.1, 0.2]), Some(3));
    assert_eq!(said(&[0.1, 0.1, 0.2, 0.2]), None);
    assert_eq!(said(&[0.1, 0.2, 0.3, 0.2, 0.1]), None);
}

#[test]
fn a_quaternion_of_zero_is_taken_where_there_is_no_other() {
    let unturned = |child: &str| TransformMessage {
        quaternion: Some([0.0; 4]),
        ..transform("base_link", child, [0.1, 0.0, 0.0], [0.0; 3])
    };
    let mut tree = TransformTree::default();
    tree.add(unturned("front"), Origin::Fixed);
    tree.add(unturned("left"), Origin::Fixed);
    tree.add(
        transform("base_link", "left", [0.2, 0.0, 0.0], [0.0; 3]),
        Origin::Fixed,
    );
    assert!(tree.is_unusable("front") && mount(&tree, "base_link", "front").is_err());
    let taken = tree.with_unturned().unwrap();
    assert_eq!(taken.unturned().collect::<Vec<_>>(), ["front"]);
    let x = |sonar| {
        mount(&taken, "base_link", sonar)
            .unwrap()
            .robot_from_sensor
            .x
    };
    assert_eq!((x("front"), x("left")), (0.1, 0.2));
}
