use super::*;
use crate::core::config;
use crate::core::event::SonarId;
use crate::core::geometry::Pose2;
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::label::{Kind, Reason};

/// Along x at 10 cm a step and a step a second, looking left at a wall 2 m away.
fn wall(frame: u32) -> Arc {
    Arc {
        id: ArcId {
            frame,
            sonar: SonarId(0),
        },
        stamp_ns: i64::from(frame) * 1_000_000_000,
        world_from_sensor: Pose2::new(0.1 * f64::from(frame), 0.0, 1.57),
        range: 2.0,
        beam_width: 0.4,
        variance: 1e-4,
    }
}

/// The labels by frame, and the runs that closed.
fn decide(entries: impl IntoIterator<Item = Option<Arc>>) -> (Vec<(u32, Label)>, Vec<Run>) {
    let config = Config::with_rule(config::Rule::Paper);
    let gate = Gate::new(config.opinion.gate);
    let rule = Policies::of(&config, &gate);
    let (mut stream, mut reports, mut runs) = (Stream::default(), Vec::new(), Vec::new());
    for next in entries.into_iter().chain([None]) {
        stream.triple(next, &config, &gate);
        stream.window(next, &config, &gate, &mut reports);
        while let Some((report, decision)) = stream.label(&rule, &mut reports) {
            runs.extend(stream.run(&rule, &report, &decision));
        }
    }
    let labels = reports.iter().map(|r| (r.arc.id.frame, r.label)).collect();
    (labels, runs)
}

const MISSING: Label = Label::Unidentified(Reason::Missing);
const GAP: Label = Label::Unidentified(Reason::Gap);

#[test]
fn a_run_of_n_plus_1_labels_associates_n_plus_3_readings() {
    let (labels, runs) = decide((0..6).map(|k| Some(wall(k))));
    let contact = Label::Contact;
    let expected = [MISSING, contact, contact, contact, contact, MISSING];
    assert!(labels.iter().map(|l| l.1).eq(expected), "{labels:?}");
    let [run] = runs.as_slice() else {
        panic!("{runs:?}")
    };
    assert_eq!(run.kind, Kind::Line);
    let frames = |ids: Vec<ArcId>| ids.into_iter().map(|id| id.frame).collect::<Vec<_>>();
    assert_eq!(frames(run.labelled.clone()), [1, 2, 3, 4]);
    let associated = run.associated.iter().map(|arc| arc.id).collect();
    assert_eq!(frames(associated), [0, 1, 2, 3, 4, 5]);
}

#[test]
fn a_no_echo_breaks_the_sequence_and_a_silent_frame_does_not() {
    let silent = [0, 1, 3, 4].map(|k| Some(wall(k)));
    let (labels, runs) = decide(silent);
    assert_eq!(labels[1], (1, Label::Contact));
    assert_eq!(runs.len(), 1);
    let (labels, runs) = decide([Some(wall(0)), Some(wall(1)), None, Some(wall(3))]);
    assert_eq!(labels, [(0, MISSING), (1, MISSING), (3, MISSING)]);
    assert!(runs.is_empty());
}

#[test]
fn time_and_distance_break_it_too() {
    let late = |k: u32| {
        let mut arc = wall(k);
        arc.stamp_ns += 5_000_000_000;
        Some(arc)
    };
    let (labels, _) = decide([Some(wall(0)), Some(wall(1)), late(2), late(3)]);
    assert_eq!(labels[1].1, GAP);
    assert_eq!(labels[2].1, GAP);
    let (labels, _) = decide([0, 1, 7, 8].map(|k| Some(wall(k))));
    assert_eq!(labels[1].1, GAP, "0.6 m apart");
}

#[test]
fn what_is_missing_is_said_before_what_is_too_far() {
    let (labels, _) = decide([None, Some(wall(1)), Some(wall(9))]);
    assert_eq!(labels[0].1, MISSING);
}
