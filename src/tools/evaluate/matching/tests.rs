use super::*;
use crate::core::tmam::fit::testing::Gauss;
use proptest::prelude::*;

/// A wall from `way` on along the line (rho, theta), 3 m long.
fn wall(rho: f64, theta: f64, way: f64) -> World {
    let along = unit(theta + FRAC_PI_2);
    let start = unit(theta) * rho + along * way;
    World::new(vec![Wall::new(start, start + along * 3.0)], Vec::new()).unwrap()
}

/// A segment on the line (rho, theta) from `way` on.
fn segment(rho: f64, theta: f64, way: f64, length: f64) -> Segment {
    let along = unit(theta + FRAC_PI_2);
    Segment {
        rho,
        theta,
        covariance: Matrix2::new(1e-4, 2e-5, 2e-5, 1e-5),
        mid: unit(theta) * rho + along * (way + length / 2.0),
        half_length: length / 2.0,
    }
}

fn held(segment: Segment, world: &World) -> Comparison {
    compare(&Shape::Line(segment), Reflector::Line(0), world).unwrap()
}

proptest! {
    #[test]
    fn the_sign_of_rho_and_the_order_of_the_ends_do_not_matter(
        rho in -4.0..4.0f64, theta in -3.2..3.2f64, way in -9.0..9.0f64,
        e in -0.02..0.02f64, t in -0.02..0.02f64,
    ) {
        let world = wall(rho, theta, way);
        let [end, start] = [world.walls()[0].start, world.walls()[0].end];
        let turned = World::new(vec![Wall::new(start, end)], Vec::new()).unwrap();
        let found = segment(rho + e, theta + t, way, 1.0);
        let plain = held(found, &world);
        let Error::Line { rho_at_origin: a, theta: b, .. } = plain.error else { panic!() };
        prop_assert!((a.abs() - e.abs()).abs() < 1e-9 && (b - t).abs() < 1e-9);
        prop_assert!(rho.abs() < 1e-9 || (a * rho.signum() - e).abs() < 1e-9, "{a} {e}");
        for (other, world) in [(found.flipped(), &world), (found, &turned), (found.canonical(), &turned)] {
            let other = held(other, world);
            prop_assert!((other.nees.unwrap() - plain.nees.unwrap()).abs() < 1e-6);
            prop_assert_eq!(other.cost.is_some(), plain.cost.is_some());
        }
    }
}

proptest! {
    #[test]
    fn a_room_far_away_has_the_figures_of_one_that_is_near(
        theta in -3.2..3.2f64, way in -9.0..9.0f64, e in -0.02..0.02f64, t in -0.02..0.02f64,
        far_x in -2e6..2e6f64, far_y in -1e7..1e7f64,
    ) {
        let near = World::new(vec![Wall::new(Vec2::zeros(), unit(theta) * 3.0)], vec![]).unwrap();
        let shift = Vec2::new(far_x, far_y);
        let far = World::new(vec![Wall::new(shift, shift + unit(theta) * 3.0)], vec![]).unwrap();
        // The line seen from a place of the wall, and the same in both worlds.
        let local = Vector2::new(e, theta + FRAC_PI_2 + t);
        let covariance = Matrix2::new(1e-4, 2e-5, 2e-5, 1e-5);
        let at = |origin: Vec2, world: &World| {
            let mid = origin + unit(theta) * way.clamp(0.0, 3.0);
            let segment = Segment { mid, half_length: 0.5, ..segment(0.0, 0.0, 0.0, 1.0) };
            held(segment.with_line_about(mid, local, covariance), world)
        };
        let (a, b) = (at(Vec2::zeros(), &near), at(shift, &far));
        let (Error::Line { rho: p, theta: r, .. }, Error::Line { rho: q, theta: s, .. }) =
            (a.error, b.error) else { panic!() };
        prop_assert!((p.abs() - q.abs()).abs() < 1e-6 && (r - s).abs() < 1e-8, "{p} {q} {r} {s}");
        let (a, b) = (a.nees.unwrap(), b.nees.unwrap());
        prop_assert!((a - b).abs() < 0.01 * (1.0 + a), "{a} {b}");
    }
}

#[test]
fn a_segment_beyond_a_gate_is_not_the_wall() {
    let world = wall(2.0, 0.3, 0.0);
    let is_wall = |segment| held(segment, &world).cost.is_some();
    assert!(is_wall(segment(2.0, 0.3, 0.5, 1.0)));
    assert!(is_wall(segment(2.09, 0.3, 0.5, 1.0)));
    assert!(!is_wall(segment(2.11, 0.3, 0.5, 1.0)), "too far off");
    assert!(is_wall(segment(2.0, 0.3, 2.9, 1.0)));
    assert!(!is_wall(segment(2.0, 0.3, 3.1, 1.0)), "past its end");
    assert!(!is_wall(segment(2.0, 0.3, -1.1, 1.0)), "before its start");
    let tilted = |tilt: f64| Segment {
        theta: 0.3 + tilt,
        ..segment(2.0, 0.3, 0.5, 1.0)
    };
    assert!(is_wall(tilted(0.17)));
    assert!(!is_wall(tilted(0.18)), "turned");
    assert!(is_wall(segment(2.0, 0.3, 1.0, 0.0)), "without length");
}

#[test]
fn a_point_is_another_up_to_20_centimetres() {
    let world = World::new(Vec::new(), vec![Vec2::new(1.0, 1.0)]).unwrap();
    let at = |x: f64| {
        let point = Shape::Point(Point {
            position: Vec2::new(x, 1.0),
            covariance: Matrix2::identity() * 0.01,
        });
        compare(&point, Reflector::Point(0), &world).unwrap()
    };
    assert!(at(1.199).cost.is_some());
    assert_eq!(at(1.201).cost, None);
    assert!((at(1.1).nees.unwrap() - 1.0).abs() < 1e-9);
    assert_eq!(
        at(1.1).error,
        Error::Point {
            distance: 1.1 - 1.0
        }
    );
}

#[test]
fn a_covariance_without_an_inverse_has_no_nees() {
    let world = World::new(Vec::new(), vec![Vec2::zeros()]).unwrap();
    let point = Shape::Point(Point {
        position: Vec2::new(0.1, 0.0),
        covariance: Matrix2::zeros(),
    });
    let held = compare(&point, Reflector::Point(0), &world).unwrap();
    assert_eq!(held.nees, None);
}

#[test]
fn honest_covariances_have_a_nees_of_two() {
    let covariance = Matrix2::new(4e-4, 1e-4, 1e-4, 1e-4);
    let root = covariance.cholesky().unwrap().l();
    let world = wall(3.0, 1.0, 5.0);
    let (mut rng, n) = (Gauss::new(3), 3000);
    let sum: f64 = (0..n)
        .map(|_| {
            let e = root * Vec2::new(rng.sample(), rng.sample());
            let found = Segment {
                covariance,
                ..segment(3.0 + e.x, 1.0 + e.y, 5.0, 2.0)
            };
            held(found.flipped(), &world).nees.unwrap()
        })
        .sum();
    let mean = sum / f64::from(n);
    assert!((1.9..2.1).contains(&mean), "{mean}");
}
