use std::collections::BTreeMap;
use std::io::Cursor;

use rerun::log::Chunk;
use rerun::{LineStrips2D, StoreKind};

use super::chunks;
use crate::core::config::{Config, Rule};
use crate::core::replay::Replay;
use crate::io::log::read_with_truth_in;
use crate::observe::recording::Recording;
use crate::tools::evaluate::drawing::overlay;
use crate::tools::evaluate::truth::AGREEING_RANGE;
use crate::tools::evaluate::{Evaluation, Truth};
use crate::tools::simulate::{Motion, RangeNoise, Simulation, Stepwise};

fn room() -> Vec<u8> {
    let simulation = Simulation {
        motion: Motion::Stepwise(Stepwise {
            steps: Some(40),
            ..Stepwise::default()
        }),
        range_noise: RangeNoise {
            sigma: 0.003,
            ..RangeNoise::default()
        },
        seed: 4,
        ..Simulation::default()
    };
    simulation
        .write(Cursor::new(Vec::new()))
        .unwrap()
        .into_inner()
}

/// Non-empty rows of an entity by frame, and their instances.
fn instances(chunks: &[Chunk], component: rerun::ComponentIdentifier) -> BTreeMap<i64, usize> {
    let mut found = BTreeMap::new();
    for chunk in chunks.iter().filter(|chunk| !chunk.is_static()) {
        let frames = chunk.iter_component_indices("frame".into(), component);
        for ((frame, _), row) in frames.zip(chunk.iter_slices::<String>(component)) {
            if !row.is_empty() {
                found.insert(frame.as_i64(), row.len());
            }
        }
    }
    found
}

#[test]
fn every_wrong_label_is_marked_in_its_frame_and_every_feature_too_many_at_the_end() {
    let config = Config::with_rule(Rule::Paper);
    let (log, recorded) = read_with_truth_in(Cursor::new(room()), "room.mcap", &config).unwrap();
    let replay = Replay::new(&log, &config).unwrap();
    let truth = Truth::new(&replay, &recorded, None, AGREEING_RANGE).unwrap();
    let outcome = replay.run(&mut []).unwrap();
    let evaluation = Evaluation::new(&truth, &[], &outcome);
    let record = || {
        let setting = replay.setting();
        let overlay = overlay(&setting, &truth, &evaluation, &outcome.map);
        let mut bytes = Vec::new();
        let mut recording = Recording::new(Some(&mut bytes), None, setting, overlay).unwrap();
        replay.run(&mut [&mut recording]).unwrap();
        recording.close(None).unwrap();
        bytes
    };
    let bytes = record();
    assert_eq!(bytes, record(), "the same bytes every time");

    let chunks = chunks(&bytes, StoreKind::Recording);
    let strips = LineStrips2D::descriptor_labels().component;
    let mut wrong = BTreeMap::new();
    for arc in evaluation
        .arcs
        .iter()
        .filter(|arc| arc.is_right() == Some(false))
    {
        *wrong.entry(i64::from(arc.arc.frame)).or_default() += 1;
    }
    assert!(!wrong.is_empty());
    assert_eq!(
        instances(&chunks["/world/truth/wrong_labels"], strips),
        wrong
    );

    let map = &evaluation.map;
    let last = i64::from(outcome.frames - 1);
    let too_many = BTreeMap::from([(last, map.lines.surplus() as usize)]);
    assert_eq!(
        instances(&chunks["/world/truth/spurious_lines"], strips),
        too_many
    );
    let matched = 2 * map.lines.matches.len() + map.points.matches.len();
    let errors = instances(&chunks["/world/truth/errors"], strips);
    assert_eq!(errors, BTreeMap::from([(last, matched)]));
    for path in ["/evaluation", "/world/truth/walls", "/world/truth/points"] {
        assert!(chunks[path].iter().all(Chunk::is_static), "{path}");
    }
}
