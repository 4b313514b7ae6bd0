//! Common points of two neighbouring arcs: equations (1) to (4).

use super::arc::Arc;
use crate::core::geometry::{Vec2, direction};

/// Sensor centres nearer than this have no base line, metres.
pub const MIN_BASELINE: f64 = 1e-6;

/// How far beyond 1 a cosine counts as 1.
const COSINE_SLACK: f64 = 1e-12;

/// Where a common tangent or a crossing lies on each of the two arcs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairPoint {
    /// Bearing from the first arc's centre, radians in the world.
    pub bearing_a: f64,
    /// Bearing from the second arc's centre.
    pub bearing_b: f64,
    /// The point on the first arc.
    pub on_a: Vec2,
    /// The point on the second arc; the same place as `on_a` for an intersection.
    pub on_b: Vec2,
}

/// The points of a pair of arcs, by side: left of travel, then right.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Points {
    /// Where the common tangent touches.
    pub contact: [Option<PairPoint>; 2],
    /// Where the arcs cross.
    pub intersection: [Option<PairPoint>; 2],
}

impl Points {
    /// The points of arcs `a` and `b` that lie within both beams.
    pub fn of(a: &Arc, b: &Arc) -> Self {
        let held = |point: Option<PairPoint>| {
            point.filter(|p| a.beam_holds(p.bearing_a) && b.beam_holds(p.bearing_b))
        };
        let circles = Self::of_circles(a, b);
        Self {
            contact: circles.contact.map(held),
            intersection: circles.intersection.map(held),
        }
    }

    /// The points of the whole circles of which `a` and `b` are a part, whatever the beams hold.
    pub fn of_circles(a: &Arc, b: &Arc) -> Self {
        let baseline = b.center() - a.center();
        let d = baseline.norm();
        if d < MIN_BASELINE {
            return Self::default();
        }
        let base = direction(baseline);
        let sides = |cosine: f64, place: &dyn Fn(f64) -> PairPoint| {
            let phi = bearing(cosine);
            [1.0, -1.0].map(|side| phi.map(|phi| place(base + side * phi)))
        };
        Self {
            contact: sides(cos_contact(a.range, b.range, d), &|normal| PairPoint {
                bearing_a: normal,
                bearing_b: normal,
                on_a: a.point_at(normal),
                on_b: b.point_at(normal),
            }),
            intersection: sides(cos_intersection(a.range, b.range, d), &|bearing_a| {
                let point = a.point_at(bearing_a);
                PairPoint {
                    bearing_a,
                    bearing_b: direction(point - b.center()),
                    on_a: point,
                    on_b: point,
                }
            }),
        }
    }
}

/// The angle of a cosine; `None` where there is no such angle.
fn bearing(cosine: f64) -> Option<f64> {
    (cosine.abs() < 1.0 + COSINE_SLACK).then(|| libm::acos(cosine.clamp(-1.0, 1.0)))
}

/// Cosine of the bearing, from the base line of length `d`, of the common tangent: (1) as the radius of a
/// circle that both arcs touch grows. Metres.
pub fn cos_contact(r1: f64, r2: f64, d: f64) -> f64 {
    (r1 - r2) / d // (2)
}

/// Cosine of the bearing of the crossing: (1) of radius 0.
pub fn cos_intersection(r1: f64, r2: f64, d: f64) -> f64 {
    (r1 * r1 - r2 * r2 + d * d) / (2.0 * d * r1) // (3)
}

/// Radius of the circle that both arcs touch when the first sees it at a bearing with this cosine.
///
/// Metres; cosines as of [`cos_contact`]. The paper's (4) lacks `d^2` in the numerator.
pub fn circle_radius(r1: f64, r2: f64, d: f64, cosine: f64) -> f64 {
    (r1 * r1 - r2 * r2 + d * d - 2.0 * d * cosine * r1) / (2.0 * (d * cosine + r2 - r1)) // (4)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::event::SonarId;
    use crate::core::geometry::{Pose2, angle_between, unit};
    use crate::core::tmam::arc::ArcId;
    use proptest::prelude::*;

    /// Cosine of the bearing, from the base line, at which both arcs touch a circle of `radius`.
    fn cos_circle(r1: f64, r2: f64, d: f64, radius: f64) -> f64 {
        let (a, b) = (r1 + radius, r2 + radius);
        (a * a - b * b + d * d) / (2.0 * d * a) // (1)
    }

    fn arc(x: f64, y: f64, yaw: f64, range: f64, beam_width: f64) -> Arc {
        Arc {
            id: ArcId {
                frame: 0,
                sonar: SonarId(0),
            },
            stamp_ns: 0,
            world_from_sensor: Pose2::new(x, y, yaw),
            range,
            beam_width,
            variance: 1e-4,
        }
    }

    proptest! {
        #[test]
        fn equations_1_and_4_undo_each_other(r1 in 0.3..5.0f64, d in 0.05..0.5, radius in 0.01..20.0f64, phi in 0.1..3.0) {
            // r2 is what the second sensor measures to the circle that the first sees at phi.
            let center = unit(phi) * (r1 + radius);
            let r2 = (center - Vec2::new(d, 0.0)).norm() - radius;
            prop_assume!(r2 > 0.01);
            prop_assert!((cos_circle(r1, r2, d, radius) - libm::cos(phi)).abs() < 1e-9);
            let back = circle_radius(r1, r2, d, libm::cos(phi));
            prop_assert!((back - radius).abs() < 1e-5 * (1.0 + radius * radius), "{back} for {radius}");
        }

        #[test]
        fn equation_3_is_equation_1_at_radius_zero(r1 in 0.3..5.0, r2 in 0.3..5.0, d in 0.05..0.5) {
            prop_assert_eq!(cos_intersection(r1, r2, d), cos_circle(r1, r2, d, 0.0));
        }

        #[test]
        fn equation_2_is_the_limit_of_equation_1(r1 in 0.3..5.0, step in -0.9..0.9, d in 0.05..0.5) {
            let r2 = r1 - step * d;
            prop_assert!((cos_contact(r1, r2, d) - cos_circle(r1, r2, d, 1e7)).abs() < 1e-5);
        }

        #[test]
        fn a_contact_point_touches_both_arcs_at_a_right_angle(
            x in -2.0..2.0, y in -2.0..2.0, yaw in -3.0..3.0, wall in -3.0..3.0, rho in 3.0..6.0f64,
        ) {
            // Two sensors that face a wall at `rho` with its normal at `wall`.
            let (s1, s2) = (Vec2::new(x, y), Vec2::new(x, y) + unit(yaw) * 0.15);
            let n = unit(wall);
            let a = arc(s1.x, s1.y, wall, rho - n.dot(&s1), 0.4);
            let b = arc(s2.x, s2.y, wall, rho - n.dot(&s2), 0.4);
            let found = Points::of(&a, &b).contact;
            let near = found.iter().flatten().any(|p| {
                angle_between(p.bearing_a, wall) < 1e-6
                    && (n.dot(&p.on_a) - rho).abs() < 1e-9
                    && (n.dot(&p.on_b) - rho).abs() < 1e-9
            });
            prop_assert!(near, "{found:?}");
        }

        #[test]
        fn an_intersection_point_is_where_both_arcs_are(
            x in -2.0..2.0, y in -2.0..2.0, yaw in -3.0..3.0, px in 3.0..6.0, py in -2.0..2.0,
        ) {
            let p = Vec2::new(px, py);
            let (s1, s2) = (Vec2::new(x, y), Vec2::new(x, y) + unit(yaw) * 0.15);
            let see = |s: Vec2| arc(s.x, s.y, direction(p - s), (p - s).norm(), 0.4);
            let found = Points::of(&see(s1), &see(s2)).intersection;
            prop_assert!(found.iter().flatten().any(|q| (q.on_a - p).norm() < 1e-6), "{found:?}");
        }
    }

    #[test]
    fn sensors_in_one_place_have_no_points() {
        let a = arc(0.0, 0.0, 0.0, 1.0, 0.4);
        assert_eq!(Points::of(&a, &a), Points::default());
    }

    #[test]
    fn a_range_difference_beyond_the_base_line_has_no_tangent() {
        let (a, b) = (arc(0.0, 0.0, 0.0, 1.2, 6.0), arc(0.1, 0.0, 0.0, 1.0, 6.0));
        assert_eq!(Points::of(&a, &b).contact, [None, None]);
    }

    #[test]
    fn straight_ahead_the_tangent_is_at_the_base_line() {
        let (a, b) = (arc(0.0, 0.0, 0.0, 1.1, 0.4), arc(0.1, 0.0, 0.0, 1.0, 0.4));
        let [left, right] = Points::of(&a, &b).contact;
        assert!(
            left.is_some() && right.is_some(),
            "rounding must not lose it"
        );
    }

    #[test]
    fn points_outside_a_beam_do_not_count() {
        // The wall is ahead of a, but b looks away from it.
        let (a, b) = (arc(0.0, 0.0, 1.57, 1.0, 0.4), arc(0.1, 0.0, 0.8, 1.0, 0.4));
        assert_eq!(Points::of(&a, &b).contact, [None, None]);
        assert_eq!(Points::of(&a, &b).intersection, [None, None]);
    }

    #[test]
    fn a_reading_of_zero_range_is_no_trouble() {
        let (a, b) = (arc(0.0, 0.0, 0.0, 0.0, 6.3), arc(0.1, 0.0, 0.0, 0.0, 6.3));
        let points = Points::of(&a, &b);
        assert!(points.contact.iter().all(Option::is_some));
        assert_eq!(points.intersection, [None, None]);
    }
}
