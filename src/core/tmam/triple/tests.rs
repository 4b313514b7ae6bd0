use super::*;
use crate::core::event::SonarId;
use crate::core::geometry::{Pose2, Vec2, unit};
use crate::core::tmam::arc::ArcId;
use proptest::prelude::*;

const BEAM: f64 = 22.5 * std::f64::consts::PI / 180.0;

fn arc(s: Vec2, yaw: f64, range: f64) -> Arc {
    Arc {
        id: ArcId {
            frame: 0,
            sonar: SonarId(0),
        },
        stamp_ns: 0,
        world_from_sensor: Pose2::new(s.x, s.y, yaw),
        range,
        beam_width: BEAM,
        variance: 1e-4,
    }
}

/// Three arcs of a sensor that looks along `yaw` while it moves along `travel`.
fn triple(travel: f64, yaw: f64, range: impl Fn(Vec2) -> f64) -> [Arc; 3] {
    [0.0, 0.12, 0.24].map(|way| {
        let s = unit(travel) * way;
        arc(s, yaw, range(s))
    })
}

/// The paper's rule on two pairs: the label with its margin, and the angles.
fn rule(before: Points, after: Points, bounds: &Triple) -> (Label, f64, Angles) {
    let angles = Angles::between(&[before, after], BEAM);
    let (label, margin) = angles.label(bounds);
    (label, margin, angles)
}

fn of(arcs: &[Arc; 3], bounds: &Triple) -> (Label, f64, Angles) {
    let [a, b, c] = arcs;
    rule(Points::of(a, b), Points::of(b, c), bounds)
}

fn turns(a: &Arc, b: &Arc, c: &Arc, bounds: &Triple) -> bool {
    let config = Config {
        triple: bounds.clone(),
        ..Config::default()
    };
    let ways = [Way::between(a, b), Way::between(b, c)];
    let found = obstacle([&ways[0], &ways[1]], bend(&[*a, *b, *c]), &config);
    found == Some(Reason::Turning)
}

proptest! {
    #[test]
    fn theorem_2_2_one_tangent_has_identical_contact_points(travel in -3.0..3.0, off in 0.4..2.7, tilt in -0.15..0.15, rho in 0.5..5.0) {
        let normal = travel + off;
        let arcs = triple(travel, normal + tilt, |s| rho - unit(normal).dot(&s));
        let (label, _, found) = of(&arcs, &Triple::default());
        prop_assert!(found.theta_c < 1e-6, "theta_c {}", found.theta_c);
        prop_assert!(found.theta_i >= 0.0);
        prop_assert_eq!(label, Label::Contact);
    }

    #[test]
    fn theorem_2_3_one_point_has_identical_intersection_points(travel in -3.0..3.0, off in 0.5..2.6, tilt in -0.05..0.05, range in 0.8..5.0f64) {
        let p = unit(travel) * 0.12 + unit(travel + off) * range;
        let arcs = triple(travel, travel + off + tilt, |s| (p - s).norm());
        let held = |a: &Arc| a.beam_holds(direction(p - a.center()));
        prop_assume!(arcs.iter().all(held));
        let (label, _, found) = of(&arcs, &Triple::default());
        prop_assert!(found.theta_i < 1e-6, "theta_i {}", found.theta_i);
        prop_assert_eq!(label, Label::Intersection);
    }

    #[test]
    fn theorem_2_1_a_common_tangent_excludes_a_common_intersection(travel in -3.0..3.0, off in 0.5..2.6, rho in 0.5..5.0f64) {
        let on_line = triple(travel, travel + off, |s| rho - unit(travel + off).dot(&s));
        prop_assert!(of(&on_line, &Triple::default()).2.theta_i > 1e-4);
        let p = unit(travel) * 0.12 + unit(travel + off) * rho;
        let at_point = triple(travel, travel + off, |s| (p - s).norm());
        prop_assert!(of(&at_point, &Triple::default()).2.theta_c > 1e-4);
    }

    #[test]
    fn the_margin_is_what_a_label_has_to_spare(travel in -3.0..3.0, off in 0.5..2.6, rho in 0.5..5.0, noise in prop::array::uniform3(-0.01..0.01)) {
        let mut arcs = triple(travel, travel + off, |s| rho - unit(travel + off).dot(&s));
        for (arc, e) in arcs.iter_mut().zip(noise) {
            arc.range += e;
        }
        let (label, margin, _) = of(&arcs, &Triple::default());
        prop_assert!(margin >= 0.0);
        // Moving gamma by less than the margin changes nothing.
        let moved = Triple { gamma: Triple::default().gamma - 0.999 * margin, ..Triple::default() };
        if label == Label::Contact || label == Label::Intersection {
            prop_assert_eq!(of(&arcs, &moved).0, label);
        }
    }
}

#[test]
fn without_points_both_angles_are_the_beam_width() {
    let (label, _, found) = rule(Points::default(), Points::default(), &Triple::default());
    assert_eq!(label, Label::Unidentified(Reason::NoPoints));
    assert_eq!((found.theta_c, found.theta_i), (BEAM, BEAM));
}

fn at(bearing: f64) -> Option<PairPoint> {
    let zero = Vec2::zeros();
    Some(PairPoint {
        bearing_a: bearing,
        bearing_b: bearing,
        on_a: zero,
        on_b: zero,
    })
}

#[test]
fn points_on_opposite_sides_are_never_compared() {
    let before = Points {
        contact: [at(0.1), None],
        intersection: [None, at(0.2)],
    };
    let after = Points {
        contact: [None, at(0.1)],
        intersection: [at(0.2), None],
    };
    let (label, ..) = rule(before, after, &Triple::default());
    assert_eq!(label, Label::Unidentified(Reason::NoPoints));
}

#[test]
fn the_reasons_of_an_undecided_triple() {
    let points = |contact, intersection| Points {
        contact: [contact, None],
        intersection: [intersection, None],
    };
    let zero = points(at(0.0), at(0.0));
    let bounds = Triple::default();
    let (label, ..) = rule(zero, points(at(0.2), at(0.3)), &bounds);
    assert_eq!(label, Label::Unidentified(Reason::Wide));
    let (label, margin, _) = rule(zero, points(at(0.1), at(0.12)), &bounds);
    assert_eq!(label, Label::Unidentified(Reason::Ambiguous));
    assert!(
        (margin - 0.04).abs() < 1e-12,
        "contact lacks 0.1 - 0.5 * 0.12"
    );
}

#[test]
fn a_turn_or_a_bend_beyond_its_tolerance_is_turning() {
    let bounds = Triple::default();
    let still = arc(Vec2::new(0.0, 0.0), 0.0, 1.0);
    let ahead = arc(Vec2::new(0.1, 0.0), 0.0, 1.0);
    let far = arc(Vec2::new(0.2, 0.0), 0.0, 1.0);
    let turned = arc(Vec2::new(0.2, 0.0), 0.1, 1.0);
    let bent = arc(Vec2::new(0.2, 0.05), 0.0, 1.0);
    assert!(!turns(&still, &ahead, &far, &bounds));
    assert!(turns(&still, &ahead, &turned, &bounds));
    assert!(turns(&still, &ahead, &bent, &bounds));
    assert!(
        !turns(&still, &still, &bent, &bounds),
        "no direction, no bend"
    );
}
