use proptest::prelude::*;

use super::super::results::Mark::{Contact, Intersection, Unidentified};
use super::super::text::describe;
use super::*;

fn texts(golden: Vec<Feature>, actual: Vec<Feature>) -> Vec<String> {
    let [golden, actual] = [golden, actual].map(Results::of_map);
    let found = compare(&golden, &actual, &Tolerance::default());
    found.differences.iter().map(describe).collect()
}

#[test]
fn a_line_that_moved_is_named_with_what_moved_and_by_how_much() {
    let mut golden = Feature::line(1.2043, 0.3, [1.15, 0.36], 1.0);
    golden.frames = Some([118, 164]);
    let mut moved = Feature::line(1.2391, 0.3, [1.18, 0.37], 1.0);
    moved.frames = Some([118, 164]);
    assert_eq!(
        texts(vec![golden], vec![moved]),
        [
            "line (0.85, 1.32) to (1.45, -0.60) m, now line 0: rho 1.2043 -> 1.2391 m (+0.0348, 3.5 x tolerance 0.010 m), \
             frames 118-164"
        ]
    );
}

#[test]
fn missing_and_new_features_are_named() {
    let found = texts(
        vec![Feature::point(1.0, 2.0)],
        vec![Feature::wall([0.0, 1.0], [3.0, 1.0])],
    );
    assert_eq!(
        found,
        [
            "point (1.00, 2.00) m is missing",
            "line (0.00, 1.00) to (3.00, 1.00) m, now line 0 is new"
        ]
    );
}

#[test]
fn what_is_gravest_comes_first() {
    let sure = |mut feature: Feature, sigma: f64| {
        feature.sigma = Some([sigma; 2]);
        feature
    };
    let golden = vec![
        sure(Feature::point(0.0, 0.0), 0.01),
        sure(Feature::point(3.0, 0.0), 0.01),
        sure(Feature::point(6.0, 0.0), 0.01),
    ];
    let actual = vec![
        sure(Feature::point(0.0, 0.0), 0.05),
        sure(Feature::point(3.0, 0.09), 0.01),
    ];
    let found = texts(golden, actual);
    let begins = ["point (6.00", "point (3.00", "point (0.00"];
    for (text, begin) in found.iter().zip(begins) {
        assert!(text.starts_with(begin), "{found:#?}");
    }
}

#[test]
fn what_is_within_tolerance_stays_as_it_was_written() {
    let golden = Results::of_map([Feature::point(0.0, 0.0), Feature::point(3.0, 0.0)]);
    let actual = Results::of_map([Feature::point(3.1, 0.0), Feature::point(0.005, 0.0)]);
    let kept = settled(&golden, actual, &Tolerance::default());
    let places = kept.map.iter().map(Feature::place);
    assert_eq!(
        places.collect::<Vec<_>>(),
        ["point (3.10, 0.00) m", "point (0.00, 0.00) m"]
    );
}

proptest! {
    #[test]
    fn order_ids_and_signs_do_not_matter(seed in prop::collection::vec((-5.0..5.0, -5.0..5.0, -3.0..3.0, 0.1..2.0), 1..12), turn in 0..12_usize) {
        let lines = |flip: bool| -> Vec<Feature> {
            seed.iter().map(|(x, y, theta, half)| {
                let rho = unit(*theta).dot(&Vec2::new(*x, *y));
                let (rho, theta) = if flip { (-rho, theta + std::f64::consts::PI) } else { (rho, *theta) };
                Feature::line(rho, theta, [*x, *y], *half)
            }).collect()
        };
        let mut other = lines(true);
        let turn = turn % other.len();
        other.rotate_left(turn);
        let none = Tolerance { theta: 0.0, rho: 0.0, extent: 0.0, ..Tolerance::default() };
        let found = compare(&Results::of_map(lines(false)), &Results::of_map(other), &none);
        prop_assert_eq!(found.differences, vec![]);
    }
}

#[test]
fn noise_that_begins_or_ends_to_be_measured_is_a_difference() {
    use RangeSigma::{Given, Measured, Unknown};
    let differs = |a, b| noise(a, b, &Tolerance::default()).is_some();
    assert!(differs(Measured(0.0035), Given) && differs(Given, Measured(0.0035)));
    assert!(differs(Measured(0.0035), Measured(0.005)));
    assert!(!differs(Given, Given) && !differs(Measured(0.0035), Measured(0.0036)));
    for other in [Unknown, Given, Measured(0.0035)] {
        assert!(!differs(Unknown, other) && !differs(other, Unknown));
    }
}

fn arc(stamp_ns: i64, mark: Mark, margin: f64) -> LabelledArc {
    LabelledArc {
        stamp_ns,
        mark,
        frame: None,
        margin: Some(Margin::Angle(margin)),
        reason: None,
    }
}

fn labels(arcs: &[(i64, Mark, f64)]) -> Labels {
    let arcs = arcs
        .iter()
        .map(|(stamp_ns, mark, margin)| arc(*stamp_ns, *mark, *margin));
    Labels {
        sonars: [("a".to_owned(), arcs.collect())].into(),
        frame_stamps: vec![0, 20, 40],
    }
}

fn borderline(borderline: f64) -> Tolerance {
    Tolerance {
        borderline,
        ..Tolerance::default()
    }
}

#[test]
fn each_kind_of_margin_has_a_tolerance_of_its_own() {
    let tolerance = Tolerance {
        borderline: 0.001,
        borderline_chi2: 0.1,
        ..Tolerance::default()
    };
    assert!(is_borderline(Margin::Chi2(0.05), &tolerance));
    assert!(!is_borderline(Margin::Angle(0.05), &tolerance));
    assert!(!is_borderline(Margin::Chi2(0.2), &tolerance));
}

#[test]
fn a_lost_reading_does_not_shift_the_labels_after_it() {
    let golden = labels(&[
        (1, Contact, 0.1),
        (2, Contact, 0.1),
        (3, Intersection, 0.1),
        (30, Contact, 0.1),
    ]);
    let actual = labels(&[
        (1, Contact, 0.1),
        (3, Intersection, 0.1),
        (30, Contact, 0.1),
        (50, Contact, 0.1),
    ]);
    let (clear, near) = label_runs(&golden, &actual, &BTreeMap::new(), &borderline(0.0));
    let changes: Vec<_> = clear
        .iter()
        .map(|run| {
            (
                run.golden,
                run.actual,
                run.arcs[0].stamp_ns,
                run.arcs[0].frame,
            )
        })
        .collect();
    assert_eq!(
        changes,
        [
            (Some(Contact), None, 2, Some(0)),
            (None, Some(Contact), 50, Some(2))
        ]
    );
    assert!(near.is_empty());
}

#[test]
fn neighbours_that_changed_alike_are_one_run_and_borderline_ones_are_apart() {
    let golden = labels(&[1, 2, 3, 4, 5].map(|stamp_ns| (stamp_ns, Contact, 0.1)));
    let actual = labels(&[
        (1, Unidentified, 0.1),
        (2, Unidentified, 0.2),
        (3, Unidentified, 0.0001),
        (4, Unidentified, 0.3),
        (5, Contact, 0.1),
    ]);
    let (clear, near) = label_runs(&golden, &actual, &BTreeMap::new(), &borderline(0.001));
    let lengths: Vec<usize> = clear.iter().map(|run| run.arcs.len()).collect();
    assert_eq!(lengths, [2, 1]);
    assert_eq!(near.len(), 1);
    assert_eq!(near[0].arcs[0].stamp_ns, 3);
    let same = label_runs(&golden, &golden, &BTreeMap::new(), &borderline(0.001));
    assert_eq!(same, (vec![], vec![]));
}

fn points(xs: &[f64]) -> Vec<Feature> {
    xs.iter().map(|x| Feature::point(*x, 0.0)).collect()
}

#[test]
fn the_sum_of_the_ways_is_the_least_and_the_order_does_not_matter() {
    // Nearest first would pair 0.2 with 0.15 and leave 0 without a partner in reach.
    let pairs_of = |g: &[f64], a: &[f64]| pairs(&points(g), &points(a), &Tolerance::default());
    assert_eq!(pairs_of(&[0.0, 0.2], &[0.15, 0.45]), [(0, 0), (1, 1)]);
    assert_eq!(pairs_of(&[0.2, 0.0], &[0.45, 0.15]), [(0, 0), (1, 1)]);
    assert_eq!(pairs_of(&[0.2, 0.0, 5.0], &[0.15]).len(), 1);
    assert_eq!(pairs_of(&[0.0], &[0.31]), []);
}

#[test]
fn what_did_not_move_keeps_its_partner() {
    let (golden, actual) = (points(&[0.0, 0.1]), points(&[0.1, 0.2]));
    let found = pairs(&golden, &actual, &Tolerance::default());
    assert_eq!(found, [(0, 1), (1, 0)]);
}

#[test]
fn one_line_under_both_signs_is_one_line() {
    let a = [Feature::line(0.01, 3.1, [0.0, 0.0], 1.0)];
    let b = [Feature::line(
        -0.02,
        3.12 - std::f64::consts::PI,
        [0.0, 0.0],
        1.0,
    )];
    let c = [Feature::line(
        0.01,
        3.1 - std::f64::consts::PI,
        [0.0, 0.0],
        1.0,
    )];
    for other in [b, c] {
        assert_eq!(pairs(&a, &other, &Tolerance::default()).len(), 1);
    }
}

#[test]
fn segments_of_one_wall_that_lie_apart_are_two() {
    let a = [Feature::wall([0.0, 1.0], [1.0, 1.0])];
    let b = [Feature::wall([2.0, 1.0], [3.0, 1.0])];
    let c = [Feature::wall([0.5, 1.0], [1.5, 1.0])];
    assert!(pairs(&a, &b, &Tolerance::default()).is_empty());
    assert_eq!(pairs(&a, &c, &Tolerance::default()), [(0, 0)]);
}

#[test]
fn hundreds_of_features_in_one_place_are_still_paired() {
    let many: Vec<f64> = (0..600).map(|i| f64::from(i) * 1e-5).collect();
    let moved: Vec<f64> = many.iter().map(|x| x + 0.02).collect();
    assert_eq!(
        pairs(&points(&many), &points(&moved), &Tolerance::default()).len(),
        600
    );
}
