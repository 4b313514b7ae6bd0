use nalgebra::Matrix2;

use super::testing::{line, truth};
use super::*;
use crate::geometry::Vec2;
use crate::tmam::feature::Point;

fn point(id: u32, x: f64, y: f64) -> MapFeature {
    MapFeature {
        id,
        shape: Shape::Point(Point {
            position: Vec2::new(x, y),
            covariance: Matrix2::identity() * 1e-4,
        }),
        readings: 5,
        runs: 2,
        status: Status::Confirmed,
    }
}

#[test]
fn a_wall_has_one_line_and_what_else_lies_on_it_is_twice() {
    let features = [
        line(0, 2.05, -1.0, 0.0),
        line(1, 2.01, 0.5, 1.5),
        line(2, 2.5, 0.0, 1.0),
        line(3, 1.97, -0.5, 0.0),
        point(4, 5.1, 5.0),
        point(5, 5.0, 5.3),
    ];
    let score = MapScore::new(features.iter(), &truth(3));
    let lines = &score.lines;
    assert_eq!((lines.features, lines.visible), (4, 1));
    let [best] = lines.matches.as_slice() else {
        panic!("{:?}", lines.matches)
    };
    assert_eq!((best.feature, best.reflector), (1, Reflector::Line(0)));
    assert_eq!(lines.spurious, [2]);
    let twice = Reflector::Line(0);
    assert_eq!(lines.duplicates, [(0, twice), (3, twice)]);
    assert_eq!(lines.surplus(), 3);
    assert!(lines.missed.is_empty() && !lines.is_exact());
    // 1 m, another that holds half a metre more, of 4 m.
    assert!((lines.covered.unwrap() - 0.5).abs() < 1e-9);
    let rho = lines.errors.rho.unwrap();
    assert!((rho.mean - 0.01).abs() < 1e-9 && (rho.max - 0.01).abs() < 1e-9);
    assert!((lines.errors.nees.mean.unwrap() - 0.5).abs() < 1e-6);

    // What was not heard is not asked for, but may be there.
    assert_eq!(score.points.visible, 0);
    assert_eq!(score.points.matches.len(), 1);
    assert_eq!(score.points.spurious, [5]);
    assert!((score.points.errors.position.unwrap().max - 0.1).abs() < 1e-9);
}

#[test]
fn only_what_was_heard_three_times_can_be_missed() {
    assert_eq!(MapScore::new([].iter(), &truth(2)).lines.missed, []);
    let score = MapScore::new([].iter(), &truth(3));
    assert_eq!(score.lines.missed, [Reflector::Line(0)]);
    assert_eq!(score.lines.covered, Some(0.0));
    assert!(!score.is_exact());
    let whole = [line(0, 2.0, -2.0, 2.0)];
    let score = MapScore::new(whole.iter(), &truth(3));
    assert!(score.is_exact());
    assert_eq!(score.lines.covered, Some(1.0));
}

#[test]
fn overlapping_intervals_count_once() {
    assert_eq!(union(&[]), 0.0);
    assert_eq!(
        union(&[(0.0, 2.0), (0.5, 1.0), (1.5, 3.0), (4.0, 5.0)]),
        4.0
    );
    assert_eq!(union(&[(1.0, 0.5)]), 0.0);
}
