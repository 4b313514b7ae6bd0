use std::collections::BTreeMap;
use std::io::Cursor;

use super::*;
use crate::core::truth::{FalseEcho, ReflectorKind};
use crate::io::log::container::{self, Channel, RawMessage, Unchecked};

fn room(motion: Motion) -> Simulation {
    Simulation {
        motion,
        ..Simulation::default()
    }
}

fn bytes(simulation: &Simulation) -> Vec<u8> {
    simulation
        .write(Cursor::new(Vec::new()))
        .unwrap()
        .into_inner()
}

/// What is recorded on topics whose names begin so.
fn messages(log: &[u8], topic: &str) -> Vec<Vec<u8>> {
    let mut found = Vec::new();
    let visit = &mut |channel: &Channel, message: RawMessage<'_>| {
        if channel.topic.starts_with(topic) {
            found.push(message.data.to_vec());
        }
    };
    let losses = container::walk_in(Cursor::new(log), Unchecked::LeftOut, visit).unwrap();
    assert!(losses.is_empty());
    found
}

fn truths(log: &[u8]) -> Vec<ReadingTruth> {
    let all = messages(log, "/truth").len();
    let of_world = messages(log, "/truth/world").len();
    let truths: Vec<ReadingTruth> = messages(log, "/truth")
        .iter()
        .filter_map(|data| serde_json::from_slice(data).ok())
        .collect();
    assert_eq!(truths.len() + of_world, all);
    truths
}

/// The last 4 bytes but 4 of a `sensor_msgs/msg/Range` are its range.
fn ranges(log: &[u8]) -> Vec<f32> {
    let ranges = messages(log, "/sonar/").into_iter();
    ranges
        .map(|data| {
            let (_, tail) = data.split_last_chunk::<8>().unwrap();
            f32::from_le_bytes(tail[..4].try_into().unwrap())
        })
        .collect()
}

#[test]
fn without_noise_every_range_is_the_truth() {
    for motion in [
        Motion::Stepwise(Stepwise::default()),
        Motion::Driving(Driving::default()),
    ] {
        let log = bytes(&room(motion));
        let (truths, ranges) = (truths(&log), ranges(&log));
        assert_eq!(truths.len(), ranges.len());
        for (truth, range) in truths.iter().zip(ranges) {
            match truth.range {
                Some(expected) => assert!((f64::from(range) - expected).abs() < 1e-6),
                None => assert_eq!(range, f32::INFINITY),
            }
            assert!(!truth.outlier);
        }
    }
}

#[test]
fn the_room_loop_sees_every_wall_and_corner() {
    for motion in [
        Motion::Stepwise(Stepwise::default()),
        Motion::Driving(Driving::default()),
    ] {
        let mut seen = BTreeMap::new();
        for truth in truths(&bytes(&room(motion))) {
            if let Some(reflector) = truth.reflector() {
                *seen.entry(format!("{reflector:?}")).or_insert(0) += 1;
            }
        }
        assert_eq!(seen.len(), 12, "{seen:?}");
        assert!(seen.values().all(|count| *count >= 10), "{seen:?}");
    }
}

#[test]
fn the_log_brings_its_world_along() {
    let log = bytes(&room(Motion::Stepwise(Stepwise::default())));
    let worlds: Vec<World> = messages(&log, "/truth/world")
        .iter()
        .map(|data| serde_json::from_slice(data).unwrap())
        .collect();
    assert_eq!(worlds, [World::room()]);
}

#[test]
fn equal_parameters_give_equal_bytes_and_seeds_matter() {
    let mut simulation = room(Motion::Stepwise(Stepwise::default()));
    simulation.range_noise.sigma = 0.003;
    let first = bytes(&simulation);
    assert_eq!(first, bytes(&simulation));
    simulation.seed = 2;
    assert_ne!(first, bytes(&simulation));
}

#[test]
fn odometry_noise_leaves_the_readings_alone() {
    let mut simulation = room(Motion::Driving(Driving::default()));
    simulation.range_noise.sigma = 0.003;
    let perfect = ranges(&bytes(&simulation));
    simulation.odometry_noise.heading = 0.01;
    assert_eq!(perfect, ranges(&bytes(&simulation)));
}

#[test]
fn noisy_odometry_comes_with_the_true_poses_and_exact_odometry_without() {
    let mut simulation = room(Motion::Driving(Driving::default()));
    assert!(messages(&bytes(&simulation), "/truth/pose").is_empty());
    simulation.odometry_noise.turn = 0.01;
    let log = bytes(&simulation);
    let poses: Vec<PoseTruth> = messages(&log, "/truth/pose")
        .iter()
        .map(|data| serde_json::from_slice(data).unwrap())
        .collect();
    assert_eq!(poses.len(), messages(&log, "/odom").len());
    let last = poses.last().unwrap();
    assert!(
        (last.x - 1.0).abs() < 1e-9 && (last.y - 1.0).abs() < 1e-9,
        "{last:?}"
    );
}

#[test]
fn false_echoes_come_as_often_as_asked_and_are_told() {
    let mut simulation = room(Motion::Driving(Driving::default()));
    simulation.false_echoes = FalseEchoes {
        cross_talk: 0.2,
        double_reflections: 0.5,
    };
    let log = bytes(&simulation);
    let (truths, ranges) = (truths(&log), ranges(&log));
    let heard = |what| truths.iter().filter(|t| t.false_echo == Some(what)).count() as f64;
    let share = heard(FalseEcho::CrossTalk) / truths.len() as f64;
    assert!((0.05..0.2).contains(&share), "{share}");
    assert!(heard(FalseEcho::DoubleReflection) > 20.0);
    for (truth, range) in truths.iter().zip(&ranges) {
        let own = truth.range.map_or(f32::INFINITY, |range| range as f32);
        assert!(
            truth.false_echo.is_some() || *range == own,
            "{truth:?} {range}"
        );
    }
    // What sonars hear falsely leaves the noise of the others as it is.
    simulation.range_noise.sigma = 0.003;
    let noisy = self::ranges(&bytes(&simulation));
    simulation.false_echoes = FalseEchoes::default();
    let plain = self::ranges(&bytes(&simulation));
    let same = |truth: &ReadingTruth| truth.false_echo.is_none();
    let mut kept = truths
        .iter()
        .zip(noisy.iter().zip(&plain))
        .filter(|(t, _)| same(t));
    assert!(kept.all(|(_, (a, b))| a == b));
}

#[test]
fn as_many_walls_are_rough_as_asked_for() {
    let mut simulation = room(Motion::Driving(Driving::default()));
    let rough = |simulation: &Simulation| {
        let log = bytes(simulation);
        let world: World = serde_json::from_slice(&messages(&log, "/truth/world")[0]).unwrap();
        let walls = world.walls().iter().filter(|wall| wall.diffuse).count();
        let oblique = truths(&log);
        let oblique = oblique
            .iter()
            .filter(|t| t.kind == Some(ReflectorKind::Oblique));
        (walls, oblique.count())
    };
    assert_eq!(rough(&simulation), (0, 0));
    simulation.diffuse = 0.3;
    let (walls, some) = rough(&simulation);
    simulation.diffuse = 1.0;
    let (all, most) = rough(&simulation);
    assert!(
        walls == 2 && all == 6 && some > 100 && most as f64 > 1.5 * some as f64,
        "{some} {most}"
    );
    simulation.diffuse = 1.1;
    assert!(simulation.write(Cursor::new(Vec::new())).is_err());
}
