use super::*;
use crate::core::config::Rule;
use crate::core::event::SonarId;
use crate::core::frames::{Echo, Entry, Frame};
use crate::core::geometry::{Pose2, Vec2};
use crate::core::tmam::Tmam;
use proptest::prelude::*;

proptest! {
    #[test]
    fn what_one_types_lies_on_the_right_side(bound in 1e-6..0.999_f64, relation in prop::sample::select(vec![Relation::Above, Relation::AtLeast, Relation::Below, Relation::AtMost])) {
        for key in ["triple.alpha", "triple.gamma", "sequence.max_gap"] {
            let value = need(key, relation, bound).value().unwrap();
            let inside = if key == "triple.gamma" { value.to_radians() } else { value };
            prop_assert!(relation.holds(inside, bound), "{key} {value} {relation:?} {bound}");
        }
    }
}

#[test]
fn few_digits_but_enough() {
    let flag = |key, relation, bound| need(key, relation, bound).flag();
    let gamma = flag("triple.gamma", Relation::Above, 11.304_f64.to_radians());
    assert_eq!(gamma.as_deref(), Some("--gamma 11.31"));
    // 1 is no alpha, so it takes more digits.
    let alpha = flag("triple.alpha", Relation::Above, 0.9993);
    assert_eq!(alpha.as_deref(), Some("--alpha 0.9994"));
    // The bound itself will not do.
    let beta = flag("triple.beta", Relation::Below, 2.5);
    assert_eq!(beta.as_deref(), Some("--beta 2.49"));
    let gap = flag("sequence.max_gap", Relation::AtLeast, 6.25);
    assert_eq!(gap.as_deref(), Some("--set sequence.max_gap=6.25"));
    assert_eq!(flag("triple.beta", Relation::Below, 1.0), None);
}

const BEAM: f64 = 0.4;

fn angles(theta_c: f64, theta_i: f64) -> Angles {
    Angles {
        theta_c,
        theta_i,
        contact: [[true; 2]; 2],
        intersection: [[true; 2]; 2],
    }
}

/// The label that the machine gives two angles.
fn label(theta_c: f64, theta_i: f64, bounds: &Triple) -> Label {
    angles(theta_c, theta_i).label(bounds).0
}

/// The parameters with every need of a change passed, or missed, by a hair.
fn moved(change: &LabelChange, bounds: &Triple, passed: bool) -> Triple {
    let mut moved = bounds.clone();
    for need in &change.needs {
        let hair = if passed == need.relation.is_upward() {
            1e-9
        } else {
            -1e-9
        };
        let value = need.bound * (1.0 + hair);
        *match need.key {
            "triple.alpha" => &mut moved.alpha,
            "triple.beta" => &mut moved.beta,
            _ => &mut moved.gamma,
        } = value;
    }
    moved
}

/// The parameters as a person would type them.
fn typed(change: &LabelChange, bounds: &Triple) -> Triple {
    let mut typed = bounds.clone();
    for need in &change.needs {
        let value = need.value().unwrap();
        match need.key {
            "triple.alpha" => typed.alpha = value,
            "triple.beta" => typed.beta = value,
            _ => typed.gamma = value.to_radians(),
        }
    }
    typed
}

proptest! {
    #[test]
    fn judged_again_with_the_changed_parameter_the_label_is_the_other_one(
        theta_c in 1e-4..0.39_f64, theta_i in 1e-4..0.39_f64,
        alpha in 0.05..0.95_f64, beta in 1.05..6.0_f64, gamma in 0.01..0.38_f64,
    ) {
        let bounds = Triple { alpha, beta, gamma, ..Triple::default() };
        let now = label(theta_c, theta_i, &bounds);
        let changes = by_angles(now, &angles(theta_c, theta_i), &bounds, BEAM);
        prop_assert!(changes.iter().all(|change| change.label != now.name()));
        for change in &changes {
            if change.impossible.is_some() {
                continue;
            }
            prop_assert!(!change.needs.is_empty());
            let after = label(theta_c, theta_i, &typed(change, &bounds));
            prop_assert_eq!(after.name(), change.label, "{:?}", change);
            let after = label(theta_c, theta_i, &moved(change, &bounds, true));
            prop_assert_eq!(after.name(), change.label, "{:?}", change);
            let short = label(theta_c, theta_i, &moved(change, &bounds, false));
            prop_assert_ne!(short.name(), change.label, "{:?}", change);
        }
    }

    #[test]
    fn what_is_called_impossible_is_so_for_every_parameter(
        theta_c in 1e-4..0.4_f64, theta_i in 1e-4..0.4_f64,
        alpha in 0.01..0.99_f64, beta in 1.01..50.0_f64, gamma in 0.001..0.399_f64,
    ) {
        let bounds = Triple::default();
        let now = label(theta_c, theta_i, &bounds);
        let any = Triple { alpha, beta, gamma, ..Triple::default() };
        let then = label(theta_c, theta_i, &any);
        for change in by_angles(now, &angles(theta_c, theta_i), &bounds, BEAM) {
            if change.impossible.is_some() {
                prop_assert_ne!(then.name(), change.label, "{:?}", change);
            }
        }
    }
}

#[test]
fn the_comparisons_are_those_of_the_rule() {
    let bounds = Triple::default();
    let held = |theta_c, theta_i| {
        angles(theta_c, theta_i)
            .conditions(&bounds)
            .map(|c| c.holds())
    };
    assert_eq!(held(0.01, 0.1), [true, true, false, true]);
    assert_eq!(held(0.1, 0.01), [false, true, true, true]);
    assert_eq!(held(0.39, 0.39), [false, false, false, false]);
}

/// What the machine makes of a sonar that drives along x: past a wall first, and then past a point.
fn reports(noise: &[f64], sigma: f64, config: &Config) -> Vec<ArcReport> {
    let mut tmam = Tmam::new(config);
    for (index, noise) in (0_u32..).zip(noise) {
        let sensor = Vec2::new(0.12 * f64::from(index), 0.0);
        let range = if index < 6 {
            2.0
        } else {
            (Vec2::new(1.0, 2.0) - sensor).norm()
        };
        let stamp_ns = i64::from(index) * 1_000_000;
        tmam.step(&Frame {
            index,
            stamp_ns,
            world_from_robot: Pose2::new(sensor.x, sensor.y, 0.0),
            correction: None,
            entries: vec![Entry {
                sonar: SonarId(0),
                stamp_ns,
                world_from_sensor: Pose2::new(sensor.x, sensor.y, 1.57),
                pose_variance: 0.0,
                beam_width: 0.8,
                echo: Some(Echo {
                    range: range + sigma * noise,
                    variance: sigma * sigma,
                }),
            }],
        });
    }
    tmam.finish().reports.to_vec()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn the_windows_give_the_machine_s_label_and_so_do_the_changes(
        noise in prop::collection::vec(-2.5..2.5_f64, 14), sigma in 0.001..0.02_f64,
    ) {
        let config = Config { rule: Rule::NoiseAware, ..Config::default() };
        let reports = reports(&noise, sigma, &config);
        prop_assert_eq!(reports.len(), noise.len());
        let sequence: Vec<SonarEntry<'_>> = (reports.iter())
            .map(|report| SonarEntry { frame: report.arc.id.frame, report: Some(report) })
            .collect();
        for (place, report) in reports.iter().enumerate() {
            let windows = Windows::new(&sequence, place, &config);
            let label = windows.label_with(config.opinion.gate, config.opinion.decisive);
            let Some(label) = label else { continue };
            prop_assert_eq!(label, report.label);
            prop_assert_eq!(windows.looked_at(report).last(), report.window.as_ref());
            for change in windows.changes() {
                let Some(need) = change.needs.first() else { continue };
                let mut changed = config.clone();
                let value = need.value().unwrap();
                match need.key {
                    "opinion.gate" => changed.opinion.gate = value,
                    _ => changed.opinion.decisive = value,
                }
                let again = self::reports(&noise, sigma, &changed);
                prop_assert_eq!(again[place].label.name(), change.label, "{:?}", change);
            }
        }
    }
}
