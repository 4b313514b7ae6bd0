use std::f64::consts::TAU;

use std::collections::BTreeMap;

use rerun::external::re_log_encoding::{DecoderApp, RawRrdManifest};
use rerun::log::{Chunk, LogMsg};
use rerun::time::TimeType;
use rerun::{Scalars, StateChange};

use super::*;
use crate::config::Config;
use crate::event::SonarId;
use crate::frames::{Echo, Entry};
use crate::geometry::{Pose2, Vec2, angle_between, direction, unit};
use crate::observer::Source;
use crate::tmam::Tmam;
use crate::tmam::triple::{Evidence, Verdict};
use rerun::StoreKind;

/// The room of the paper's Table I.
const ROOM: [[f64; 2]; 6] = [
    [0.0, 0.0],
    [4.0, 0.0],
    [4.0, 2.0],
    [8.0, 2.0],
    [8.0, 5.0],
    [0.0, 5.0],
];
const BEAM: f64 = 22.5 / 360.0 * TAU;

/// Nearest echo inside the beam: the foot of a perpendicular on a wall, or a vertex.
fn echo(sensor: &Pose2) -> Option<f64> {
    let from = sensor.position();
    let corners = ROOM.map(|[x, y]| Vec2::new(x, y));
    let feet = corners
        .iter()
        .zip(corners.iter().cycle().skip(1))
        .filter_map(|(a, b)| {
            let along = b - a;
            let t = (from - a).dot(&along) / along.norm_squared();
            (0.0..=1.0).contains(&t).then(|| a + along * t)
        });
    feet.chain(corners.iter().copied())
        .map(|at| at - from)
        .filter(|to| angle_between(direction(*to), sensor.yaw) <= BEAM / 2.0)
        .map(|to| to.norm())
        .min_by(f64::total_cmp)
}

pub(super) fn ring(count: u16) -> Vec<Sonar> {
    (0..count)
        .map(|i| {
            let yaw = TAU * f64::from(i) / f64::from(count);
            let at = unit(yaw) * 0.2;
            Sonar {
                name: format!("sonar_{i:02}"),
                topic: format!("/sonar/{i}"),
                robot_from_sensor: Pose2::new(at.x, at.y, yaw),
            }
        })
        .collect()
}

/// Steps of 10 cm up and down the room, with a little noise that is the same every time.
pub(super) fn drive(sonars: &[Sonar], count: u32, silent_after: Option<(u16, u32)>) -> Vec<Frame> {
    let mut noise = 1_u64;
    (0..count)
        .map(|index| {
            let s = f64::from(index) * 0.1 % 12.0;
            let (x, yaw) = if s < 6.0 {
                (1.0 + s, 0.0)
            } else {
                (13.0 - s, TAU / 2.0)
            };
            let pose = Pose2::new(x, 3.2, yaw);
            let stamp_ns = 1_700_000_000_000_000_000 + i64::from(index) * 300_000_000;
            let entries = sonars
                .iter()
                .zip(0..)
                .filter(|(_, id)| silent_after.is_none_or(|(s, n)| *id != s || index < n))
                .map(|(sonar, id)| {
                    noise = noise
                        .wrapping_mul(6_364_136_223_846_793_005)
                        .wrapping_add(1);
                    let error = ((noise >> 40) as f64 / f64::from(1 << 24) - 0.5) * 0.002;
                    let world_from_sensor = pose.compose(&sonar.robot_from_sensor);
                    Entry {
                        sonar: SonarId(id),
                        stamp_ns,
                        world_from_sensor,
                        beam_width: BEAM,
                        echo: echo(&world_from_sensor).map(|range| Echo {
                            range: range + error,
                            variance: 0.0,
                        }),
                    }
                })
                .collect();
            Frame {
                index,
                stamp_ns,
                world_from_robot: pose,
                entries,
            }
        })
        .collect()
}

pub(super) fn record(sonars: &[Sonar], frames: &[Frame]) -> (Vec<u8>, Vec<Verdict>) {
    let config = Config::default();
    let source = Source {
        file: "room.mcap".to_owned(),
        messages: 12,
        start_ns: frames.first().map_or(0, |frame| frame.stamp_ns),
        end_ns: frames.last().map_or(0, |frame| frame.stamp_ns),
        complete: true,
        lost: Vec::new(),
        notes: Vec::new(),
    };
    let setting = Setting {
        sonars,
        config: &config,
        source: &source,
        start: Vec2::zeros(),
    };
    let mut tmam = Tmam::new(&config);
    let mut recording = Recording::new(Vec::new(), setting).unwrap();
    let mut verdicts = Vec::new();
    for frame in frames {
        let step = tmam.step(frame);
        verdicts.extend_from_slice(&step.verdicts);
        recording.frame(frame, &step).unwrap();
    }
    let step = tmam.finish();
    verdicts.extend_from_slice(&step.verdicts);
    recording.finish(&step).unwrap();
    (recording.into_inner().unwrap(), verdicts)
}

/// The chunks of a file by entity, in file order, of one kind of store.
pub(super) fn chunks(bytes: &[u8], kind: StoreKind) -> BTreeMap<String, Vec<Chunk>> {
    let mut found = BTreeMap::<String, Vec<Chunk>>::new();
    for message in DecoderApp::decode_lazy(bytes) {
        if let LogMsg::ArrowMsg(store, message) = message.unwrap()
            && store.kind() == kind
        {
            let chunk = Chunk::from_arrow_msg(&message).unwrap();
            let entity = chunk.entity_path().to_string();
            found.entry(entity).or_default().push(chunk);
        }
    }
    found
}

/// theta of every arc that has one, by frame and sonar.
fn angles(chunks: &[Chunk]) -> BTreeMap<(i64, usize), f64> {
    let component = Scalars::descriptor_scalars().component;
    let mut found = BTreeMap::new();
    for chunk in chunks.iter().filter(|chunk| !chunk.is_static()) {
        let frames = chunk.iter_component_indices("frame".into(), component);
        for ((frame, _), row) in frames.zip(chunk.iter_slices::<f64>(component)) {
            for (sonar, angle) in row.iter().enumerate().filter(|(_, angle)| !angle.is_nan()) {
                assert!(found.insert((frame.as_i64(), sonar), *angle).is_none());
            }
        }
    }
    found
}

/// The label of every arc of a sonar, by frame; `None` where nothing echoed.
fn labels(chunks: &[Chunk]) -> BTreeMap<i64, Option<String>> {
    let component = StateChange::descriptor_state().component;
    let mut found = BTreeMap::new();
    for chunk in chunks.iter().filter(|chunk| !chunk.is_static()) {
        let frames = chunk.iter_component_indices("frame".into(), component);
        for ((frame, _), row) in frames.zip(chunk.iter_slices::<String>(component)) {
            let label = row.first().map(|text| text.as_str().to_owned());
            assert!(found.insert(frame.as_i64(), label).is_none());
        }
    }
    found
}

fn assert_read_back_equals(bytes: &[u8], sonars: &[Sonar], frames: &[Frame], all: &[Verdict]) {
    let chunks = chunks(bytes, StoreKind::Recording);
    for (path, pick) in [
        (
            "/angles/theta_c",
            (|e| e.angles.theta_c) as fn(&Evidence) -> f64,
        ),
        ("/angles/theta_i", |e| e.angles.theta_i),
    ] {
        let expected: BTreeMap<(i64, usize), f64> = all
            .iter()
            .filter_map(|v| Some((v.arc, pick(&v.evidence?))))
            .map(|(arc, angle)| {
                let rounded = (angle * 1e9).round() / 1e9;
                ((i64::from(arc.frame), arc.sonar.index()), rounded)
            })
            .collect();
        assert!(!expected.is_empty());
        assert_eq!(angles(&chunks[path]), expected, "{path}");
    }
    for (sonar, id) in sonars.iter().zip(0..) {
        let mut expected: BTreeMap<i64, Option<String>> = frames
            .iter()
            .filter(|frame| frame.entries.iter().any(|entry| entry.sonar == SonarId(id)))
            .map(|frame| (i64::from(frame.index), None))
            .collect();
        for verdict in all.iter().filter(|v| v.arc.sonar == SonarId(id)) {
            let name = style::name(verdict.label);
            expected.insert(i64::from(verdict.arc.frame), Some(name));
        }
        let path = format!("/labels/{}", sonar.name);
        assert_eq!(labels(&chunks[&path]), expected, "{path}");
    }
}

#[test]
fn two_recordings_of_a_run_are_the_same_bytes() {
    let sonars = ring(16);
    let frames = drive(&sonars, 120, None);
    let (one, _) = record(&sonars, &frames);
    let (two, _) = record(&sonars, &frames);
    assert!(one == two);
}

#[test]
fn angles_and_labels_read_back_as_they_were_decided() {
    let sonars = ring(16);
    let frames = drive(&sonars, 700, None);
    let (bytes, verdicts) = record(&sonars, &frames);
    assert_read_back_equals(&bytes, &sonars, &frames, &verdicts);
}

#[test]
fn a_sonar_that_falls_silent_keeps_its_last_label_and_delays_nobody() {
    let sonars = ring(4);
    let frames = drive(&sonars, 700, Some((1, 40)));
    let (bytes, verdicts) = record(&sonars, &frames);
    assert_read_back_equals(&bytes, &sonars, &frames, &verdicts);
    // The frame of the silent sonar's last arc comes last, in chunks of its own.
    let arcs = &chunks(&bytes, StoreKind::Recording)["/world/arcs"];
    assert!(
        arcs.iter()
            .any(|chunk| chunk.num_rows() == 1 && !chunk.is_static())
    );
    for chunk in arcs {
        let frames: Vec<i64> = chunk
            .iter_indices(&"frame".into())
            .map(|(frame, _)| frame.as_i64())
            .collect();
        assert!(frames.is_sorted());
    }
}

#[test]
fn a_run_without_frames_is_still_a_file() {
    let (bytes, _) = record(&ring(2), &[]);
    assert!(chunks(&bytes, StoreKind::Recording).contains_key("/about"));
    assert!(chunks(&bytes, StoreKind::Blueprint).contains_key("/viewport"));
}

#[test]
fn the_footer_lists_every_chunk_of_recording_and_blueprint() {
    let sonars = ring(8);
    let (bytes, _) = record(&sonars, &drive(&sonars, 60, None));
    let manifests = RawRrdManifest::from_rrd_bytes(&bytes).unwrap();
    let kinds: Vec<StoreKind> = manifests.iter().map(|m| m.store_id.kind()).collect();
    assert_eq!(kinds, [StoreKind::Recording, StoreKind::Blueprint]);
    for manifest in &manifests {
        let written: usize = chunks(&bytes, manifest.store_id.kind())
            .values()
            .map(Vec::len)
            .sum();
        assert_eq!(manifest.data.num_rows(), written);
    }
}

#[test]
fn the_blueprint_is_put_in_force() {
    let sonars = ring(8);
    let (bytes, _) = record(&sonars, &drive(&sonars, 5, None));
    let activated = DecoderApp::decode_lazy(bytes.as_slice()).any(|message| {
        matches!(message, Ok(LogMsg::BlueprintActivationCommand(command))
            if command.make_active && command.make_default)
    });
    assert!(activated);
}

#[test]
fn stamps_that_cannot_be_dates_are_durations() {
    assert_eq!(Timelines::new(0).stamp.typ(), TimeType::DurationNs);
    let today = 1_700_000_000_000_000_000;
    assert_eq!(Timelines::new(today).stamp.typ(), TimeType::TimestampNs);
}

#[test]
fn only_the_two_timelines_of_the_replay_are_there() {
    let sonars = ring(4);
    let (bytes, _) = record(&sonars, &drive(&sonars, 20, None));
    for chunk in chunks(&bytes, StoreKind::Recording).values().flatten() {
        let mut names: Vec<&str> = chunk.timelines().keys().map(|name| name.as_str()).collect();
        names.sort_unstable();
        assert!(names.is_empty() || names == ["frame", "stamp"]);
    }
}

#[test]
fn configurations_of_one_log_share_a_layout_and_are_two_recordings() {
    let source = Source {
        file: "a long name, with (signs).mcap".to_owned(),
        messages: 1,
        start_ns: 5,
        end_ns: 6,
        complete: true,
        lost: Vec::new(),
        notes: Vec::new(),
    };
    let ids = |config: &Config| {
        let setting = Setting {
            sonars: &[],
            config,
            source: &source,
            start: Vec2::zeros(),
        };
        store_ids(&setting, None)
    };
    let mut other = Config::default();
    other.triple.gamma = 0.1;
    let ([one, _], [two, _]) = (ids(&Config::default()), ids(&other));
    assert_eq!(one.application_id(), two.application_id());
    assert_eq!(
        one.application_id().as_str(),
        "tmam-a-long-name--with--signs-"
    );
    assert_ne!(one.recording_id(), two.recording_id());
}
