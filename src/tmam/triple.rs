//! The decision on the middle arc of a triple.

use super::arc::{Arc, ArcId};
use super::feature::Kind;
use super::opinion::Opinion;
use super::pair::{MIN_BASELINE, PairPoint, Points};
use super::spread::Spread;
use crate::config::Triple;
use crate::geometry::{angle_between, direction};

/// What an arc belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Label {
    /// A line.
    Contact,
    /// A point.
    Intersection,
    /// Neither could be told.
    Unidentified(Reason),
}

/// Why an arc is unidentified, in the order in which the reasons are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reason {
    /// No echo before or after it in the sonar's sequence.
    Missing,
    /// A neighbour too far in time or distance.
    Gap,
    /// The robot turned, or its path bent.
    Turning,
    /// No two points on a common side, neither contact nor intersection points.
    NoPoints,
    /// The smaller angle is not below gamma.
    Wide,
    /// The ratio of the angles lies between alpha and beta; under the noise-aware rule, both a line
    /// and a point explain all the readings that there are.
    Ambiguous,
    /// Under the noise-aware rule: the readings around it come from different targets.
    Neither,
}

/// The geometry of a triple, from which its label follows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angles {
    /// Contact and intersection points of arcs k-1 and k.
    pub before: Points,
    /// Contact and intersection points of arcs k and k+1.
    pub after: Points,
    /// Smallest angle on arc k between contact points on a common side, radians; the full beam
    /// width where there is none.
    pub theta_c: f64,
    /// The same of intersection points.
    pub theta_i: f64,
    /// Radians that the angles lack, or have to spare, to the nearest bound that would change the
    /// label.
    pub margin: f64,
}

/// What speaks for a label and against it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// The angles, which decide under the paper's rule.
    pub angles: Angles,
    /// How far noise spreads them.
    pub spread: Spread,
    /// What the readings themselves support, within their noise.
    pub opinion: Opinion,
}

/// The decision on one arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// The arc.
    pub arc: ArcId,
    /// What it belongs to.
    pub label: Label,
    /// Radians that the angles lack, or have to spare, to the nearest bound that would change the
    /// label; `None` where angles do not decide.
    pub margin: Option<f64>,
    /// How far the chi2 of its readings is from another label; `None` where readings do not decide.
    pub chi2_margin: Option<f64>,
    /// Why; `None` where the arc is not the middle of a triple.
    pub evidence: Option<Evidence>,
}

/// Whether the sensor turned, or its path bent, between three neighbouring arcs.
pub fn turns(before: &Arc, middle: &Arc, after: &Arc, bounds: &Triple) -> bool {
    let heading =
        |a: &Arc, b: &Arc| angle_between(a.world_from_sensor.yaw, b.world_from_sensor.yaw);
    if heading(before, middle) > bounds.turn_tolerance
        || heading(middle, after) > bounds.turn_tolerance
    {
        return true;
    }
    let (first, second) = (
        middle.center() - before.center(),
        after.center() - middle.center(),
    );
    // A sensor that stands still has no direction of travel to bend.
    first.norm() >= MIN_BASELINE
        && second.norm() >= MIN_BASELINE
        && angle_between(direction(first), direction(second)) > bounds.bend_tolerance
}

/// Labels the middle arc from its points with the arc before and the arc after it.
pub fn judge(before: Points, after: Points, beam_width: f64, bounds: &Triple) -> (Label, Angles) {
    let contact = smallest_angle(&before.contact, &after.contact);
    let intersection = smallest_angle(&before.intersection, &after.intersection);
    let theta_c = contact.unwrap_or(beam_width);
    let theta_i = intersection.unwrap_or(beam_width);

    // How far each label's two conditions hold: positive where they do.
    let by_contact = (bounds.alpha * theta_i - theta_c).min(bounds.gamma - theta_c);
    let by_intersection = (theta_c - bounds.beta * theta_i).min(bounds.gamma - theta_i);
    let (label, margin) = if by_contact > 0.0 {
        (Label::Contact, by_contact)
    } else if by_intersection > 0.0 {
        (Label::Intersection, by_intersection)
    } else {
        let reason = if contact.is_none() && intersection.is_none() {
            Reason::NoPoints
        } else if theta_c.min(theta_i) >= bounds.gamma {
            Reason::Wide
        } else {
            Reason::Ambiguous
        };
        (
            Label::Unidentified(reason),
            -by_contact.max(by_intersection),
        )
    };
    let angles = Angles {
        before,
        after,
        theta_c,
        theta_i,
        margin,
    };
    (label, angles)
}

/// The smallest angle, on the middle arc, between points of the two pairs on a common side.
fn smallest_angle(before: &[Option<PairPoint>; 2], after: &[Option<PairPoint>; 2]) -> Option<f64> {
    before
        .iter()
        .zip(after)
        .filter_map(|(b, a)| Some(angle_between(b.as_ref()?.bearing_b, a.as_ref()?.bearing_a)))
        .min_by(f64::total_cmp)
}

impl Label {
    /// `contact`, `intersection` or `unidentified`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::Intersection => "intersection",
            Self::Unidentified(_) => "unidentified",
        }
    }

    /// The kind of feature that the arc belongs to.
    pub fn kind(self) -> Option<Kind> {
        match self {
            Self::Contact => Some(Kind::Line),
            Self::Intersection => Some(Kind::Point),
            Self::Unidentified(_) => None,
        }
    }

    /// Why, for an unidentified arc.
    pub fn reason(self) -> Option<Reason> {
        match self {
            Self::Unidentified(reason) => Some(reason),
            Self::Contact | Self::Intersection => None,
        }
    }
}

impl Reason {
    /// Every reason, in the order in which they are tried.
    pub const ALL: [Self; 7] = [
        Self::Missing,
        Self::Gap,
        Self::Turning,
        Self::NoPoints,
        Self::Wide,
        Self::Ambiguous,
        Self::Neither,
    ];

    /// The word in files: `missing`, `gap`, `turning`, `no-points`, `wide`, `ambiguous` or
    /// `neither`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Missing => "missing",
            Self::Gap => "gap",
            Self::Turning => "turning",
            Self::NoPoints => "no-points",
            Self::Wide => "wide",
            Self::Ambiguous => "ambiguous",
            Self::Neither => "neither",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::SonarId;
    use crate::geometry::{Pose2, Vec2, unit};
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

    fn evidence(arcs: &[Arc; 3]) -> (Label, Angles) {
        let [a, b, c] = arcs;
        judge(Points::of(a, b), Points::of(b, c), BEAM, &Triple::default())
    }

    proptest! {
        #[test]
        fn theorem_2_2_one_tangent_has_identical_contact_points(travel in -3.0..3.0, off in 0.4..2.7, tilt in -0.15..0.15, rho in 0.5..5.0) {
            let normal = travel + off;
            let arcs = triple(travel, normal + tilt, |s| rho - unit(normal).dot(&s));
            let (label, found) = evidence(&arcs);
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
            let (label, found) = evidence(&arcs);
            prop_assert!(found.theta_i < 1e-6, "theta_i {}", found.theta_i);
            prop_assert_eq!(label, Label::Intersection);
        }

        #[test]
        fn theorem_2_1_a_common_tangent_excludes_a_common_intersection(travel in -3.0..3.0, off in 0.5..2.6, rho in 0.5..5.0f64) {
            let on_line = triple(travel, travel + off, |s| rho - unit(travel + off).dot(&s));
            prop_assert!(evidence(&on_line).1.theta_i > 1e-4);
            let p = unit(travel) * 0.12 + unit(travel + off) * rho;
            let at_point = triple(travel, travel + off, |s| (p - s).norm());
            prop_assert!(evidence(&at_point).1.theta_c > 1e-4);
        }

        #[test]
        fn the_margin_is_what_a_label_has_to_spare(travel in -3.0..3.0, off in 0.5..2.6, rho in 0.5..5.0, noise in prop::array::uniform3(-0.01..0.01)) {
            let mut arcs = triple(travel, travel + off, |s| rho - unit(travel + off).dot(&s));
            for (arc, e) in arcs.iter_mut().zip(noise) {
                arc.range += e;
            }
            let (label, found) = evidence(&arcs);
            prop_assert!(found.margin >= 0.0);
            // Moving gamma by less than the margin changes nothing.
            let [a, b, c] = &arcs;
            let moved = Triple { gamma: Triple::default().gamma - 0.999 * found.margin, ..Triple::default() };
            if label == Label::Contact || label == Label::Intersection {
                prop_assert_eq!(judge(Points::of(a, b), Points::of(b, c), BEAM, &moved).0, label);
            }
        }
    }

    #[test]
    fn without_points_both_angles_are_the_beam_width() {
        let (label, found) = judge(
            Points::default(),
            Points::default(),
            BEAM,
            &Triple::default(),
        );
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
        let (label, _) = judge(before, after, BEAM, &Triple::default());
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
        let (label, _) = judge(zero, points(at(0.2), at(0.3)), BEAM, &bounds);
        assert_eq!(label, Label::Unidentified(Reason::Wide));
        let (label, found) = judge(zero, points(at(0.1), at(0.12)), BEAM, &bounds);
        assert_eq!(label, Label::Unidentified(Reason::Ambiguous));
        assert!(
            (found.margin - 0.04).abs() < 1e-12,
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
}
