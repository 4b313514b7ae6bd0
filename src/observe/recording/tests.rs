mod corrected;
mod run;
mod truth;
mod windows;

use std::collections::BTreeMap;

use rerun::external::re_log_encoding::{DecoderApp, RawRrdManifest};
use rerun::log::{Chunk, LogMsg};
use rerun::time::TimeType;
use rerun::{LineStrips2D, Scalars, StateChange, StoreKind};

pub use self::run::{chunks, drive, record, record_under, ring};
use super::canvas::Timelines;
use super::*;
use crate::core::config::Config;
use crate::core::event::{Events, Sonar, SonarId};
use crate::core::geometry::Vec2;
use crate::core::observer::{Setting, Source};
use crate::core::tmam::Tmam;
use crate::core::tmam::report::ArcReport;

/// The number of every frame that has one.
fn numbers(chunks: &[Chunk]) -> BTreeMap<i64, f64> {
    let component = Scalars::descriptor_scalars().component;
    let mut found = BTreeMap::new();
    for chunk in chunks.iter().filter(|chunk| !chunk.is_static()) {
        let frames = chunk.iter_component_indices("frame".into(), component);
        for ((frame, _), row) in frames.zip(chunk.iter_slices::<f64>(component)) {
            let [number] = row else {
                panic!("{row:?}");
            };
            assert!(!number.is_nan(), "what is absent has no row");
            assert!(found.insert(frame.as_i64(), *number).is_none());
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

fn assert_read_back_equals(bytes: &[u8], sonars: &[Sonar], frames: &[Frame], all: &[ArcReport]) {
    let chunks = chunks(bytes, StoreKind::Recording);
    let mut plotted = 0;
    for plot in plots::deciding(&Config::default(), 0.5) {
        for (sonar, id) in sonars.iter().zip(0..) {
            let of_sonar = all.iter().filter(|r| r.arc.id.sonar == SonarId(id));
            let expected: BTreeMap<i64, f64> = of_sonar
                .filter_map(|r| Some((r.arc.id.frame.into(), plot.value(r)?)))
                .map(|(frame, value)| (frame, (value * 1e9).round() / 1e9))
                .collect();
            let path = format!("{}/{}", (plot.dots)(SonarId(id)).path(), sonar.name);
            let found = chunks.get(&path).map(|chunks| numbers(chunks));
            plotted += expected.len();
            assert_eq!(found.unwrap_or_default(), expected, "{path}");
        }
    }
    assert!(plotted > 0);
    for (sonar, id) in sonars.iter().zip(0..) {
        let mut expected: BTreeMap<i64, Option<String>> = frames
            .iter()
            .filter(|frame| frame.entries.iter().any(|entry| entry.sonar == SonarId(id)))
            .map(|frame| (i64::from(frame.index), None))
            .collect();
        for report in all.iter().filter(|r| r.arc.id.sonar == SonarId(id)) {
            let name = reports::on_lane(report);
            expected.insert(i64::from(report.arc.id.frame), Some(name));
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
    let (bytes, reports) = record(&sonars, &frames);
    assert_read_back_equals(&bytes, &sonars, &frames, &reports);
}

#[test]
fn a_sonar_that_falls_silent_keeps_its_last_label_and_delays_nobody() {
    let sonars = ring(4);
    let frames = drive(&sonars, 700, Some((1, 40)));
    let (bytes, reports) = record(&sonars, &frames);
    assert_read_back_equals(&bytes, &sonars, &frames, &reports);
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
fn every_arc_of_a_run_is_drawn_where_it_closes() {
    let sonars = ring(16);
    let frames = drive(&sonars, 300, None);
    let (bytes, _) = record(&sonars, &frames);
    let strips = LineStrips2D::descriptor_strips().component;
    let chunks = &chunks(&bytes, StoreKind::Recording)["/world/features/arcs"];
    let drawn = chunks.iter().filter(|chunk| !chunk.is_static());
    let drawn = drawn.flat_map(|chunk| chunk.components().get(strips));
    let drawn: usize = drawn.map(|column| column.list_array.values().len()).sum();
    let mut tmam = Tmam::new(&Config::default());
    let steps: Vec<Step> = frames.iter().map(|frame| tmam.step(frame)).collect();
    // What closes because the log ends is not drawn.
    tmam.finish();
    let runs = steps.iter().flat_map(|step| &step.extractions);
    assert_eq!(drawn, runs.map(|run| run.associated.len()).sum::<usize>());
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
fn only_the_three_timelines_of_the_replay_are_there() {
    let sonars = ring(4);
    let (bytes, _) = record(&sonars, &drive(&sonars, 20, None));
    for chunk in chunks(&bytes, StoreKind::Recording).values().flatten() {
        let mut names: Vec<&str> = chunk.timelines().keys().map(|name| name.as_str()).collect();
        names.sort_unstable();
        assert!(names.is_empty() || names == ["frame", "seconds", "stamp"]);
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
            events: &Events::default(),
            events_sha256: "e3b0c442",
            origin_ns: 5,
            start: Vec2::zeros(),
        };
        identity(&setting, &Overlay::default()).0
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

#[test]
fn two_configurations_and_two_logs_share_no_chunk() {
    let sonars = ring(4);
    let frames = drive(&sonars, 30, None);
    let ids = |config: &Config, events: &str| {
        let bytes = run::record_as(config, events, &sonars, &frames);
        let chunks = chunks(&bytes, StoreKind::Recording);
        let ids = chunks
            .values()
            .flatten()
            .map(|chunk| chunk.id().to_string());
        ids.collect::<BTreeSet<String>>()
    };
    let mut other = Config::default();
    other.triple.gamma = 0.1;
    let all = [
        ids(&Config::default(), "e3b0c442"),
        ids(&other, "e3b0c442"),
        ids(&Config::default(), "98fc1c14"),
    ];
    let count: usize = all.iter().map(BTreeSet::len).sum();
    let distinct: BTreeSet<&String> = all.iter().flatten().collect();
    assert_eq!(distinct.len(), count);
    assert_eq!(all[0], ids(&Config::default(), "e3b0c442"));
}
