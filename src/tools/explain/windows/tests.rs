use super::*;
use crate::core::config::Rule;
use crate::core::event::SonarId;
use crate::core::geometry::{Pose2, Vec2};
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::feature::Extraction;
use crate::core::tmam::stream::{ArcReport, Stream};
use proptest::prelude::*;

/// Readings of a sonar that drives along x: of a wall first, and then of a point.
fn sequence(noise: &[f64], sigma: f64) -> Vec<Given> {
    (0_u32..)
        .zip(noise)
        .map(|(frame, noise)| {
            let sensor = Vec2::new(0.12 * f64::from(frame), 0.0);
            let range = if frame < 6 {
                2.0
            } else {
                (Vec2::new(1.0, 2.0) - sensor).norm()
            };
            let arc = Arc {
                id: ArcId {
                    frame,
                    sonar: SonarId(0),
                },
                stamp_ns: i64::from(frame) * 1_000_000,
                world_from_sensor: Pose2::new(sensor.x, sensor.y, 1.57),
                range: range + sigma * noise,
                beam_width: 0.8,
                variance: sigma * sigma,
            };
            Given {
                frame,
                stamp_ns: arc.stamp_ns,
                arc: Some(arc),
            }
        })
        .collect()
}

/// What the machine makes of the sequence.
fn judged(sequence: &[Given], config: &Config) -> Vec<ArcReport> {
    let gate = Gate::new(config.opinion.gate);
    let mut stream = Stream::default();
    let mut judgements = Vec::new();
    let mut runs = Vec::new();
    for given in sequence {
        runs.extend(stream.push(given.arc, config, &gate).closed);
    }
    runs.extend(stream.finish(config, &gate).closed);
    for run in runs {
        stream.note(&Extraction {
            id: 0,
            kind: run.kind,
            labelled: run.labelled.clone(),
            associated: Vec::new(),
            shape: None,
            residual_rms: 0.0,
            iterations: 0,
            converged: true,
            opinion: HypothesisTest::of(&run.associated, &gate),
            outliers: Vec::new(),
            action: crate::core::tmam::feature::Action::Registered(0),
            map_feature: None,
            absorbed: Vec::new(),
        });
    }
    judgements.extend(stream.complete(None));
    judgements
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn the_windows_give_the_machine_s_label_and_so_do_the_changes(
        noise in prop::collection::vec(-2.5..2.5_f64, 14), sigma in 0.001..0.02_f64,
    ) {
        let config = Config { rule: Rule::NoiseAware, ..Config::default() };
        let sequence = sequence(&noise, sigma);
        let judgements = judged(&sequence, &config);
        prop_assert_eq!(judgements.len(), sequence.len());
        for (place, judgement) in judgements.iter().enumerate() {
            let windows = Windows::new(&sequence, place, &config);
            let Some(label) = windows.label() else { continue };
            prop_assert_eq!(label, judgement.verdict.label);
            let widest = windows.looked_at().last().copied().unwrap();
            prop_assert_eq!(2 * widest.half_width + 1, judgement.wide.unwrap().readings);
            for change in windows.changes() {
                let Some(need) = change.needs.first() else { continue };
                let mut changed = config.clone();
                let value = need.value().unwrap();
                match need.key {
                    "opinion.gate" => changed.opinion.gate = value,
                    _ => changed.opinion.decisive = value,
                }
                let again = judged(&sequence, &changed);
                prop_assert_eq!(again[place].verdict.label.name(), change.label, "{:?}", change);
            }
        }
    }
}
