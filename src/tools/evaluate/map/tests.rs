use nalgebra::Matrix2;

use super::testing::{heard_in, line, truth};
use super::*;
use crate::core::geometry::Vec2;
use crate::core::tmam::feature::{Point, Shape};
use crate::core::world::{Wall, World};

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
fn a_wall_has_one_line_and_what_else_lies_on_it_is_twice_or_more_of_it() {
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
    // The second best lies on another part of the wall, and half of the third beside it.
    assert_eq!(lines.parts, [3]);
    assert_eq!(lines.duplicates, [(0, Reflector::Line(0))]);
    assert_eq!(lines.surplus(), 2);
    assert!(lines.missed.is_empty() && !lines.is_exact());
    // 1 m, another that holds half a metre more, of 4 m.
    assert!((lines.covered.unwrap() - 0.5).abs() < 1e-9);
    let rho = lines.errors.rho.unwrap();
    assert!((rho.mean - 0.01).abs() < 1e-9 && (rho.max - 0.01).abs() < 1e-9);
    assert!((lines.errors.nees.mean.unwrap() - 0.5).abs() < 1e-6);

    // What was not heard is not asked for, but may be there.
    assert_eq!(score.points.visible, 0);
    assert_eq!(score.points.matches.len(), 1);
    assert_eq!((score.points.matched, score.points.more()), (0, 1));
    assert_eq!(score.points.spurious, [5]);
    // One wall is visible and matched; a part of it, and two that are too many, make all four lines.
    assert_eq!((lines.visible, lines.matched, lines.more()), (1, 1, 1));
    assert!((score.points.errors.position.unwrap().max - 0.1).abs() < 1e-9);
}

#[test]
fn only_what_was_heard_three_times_can_be_missed() {
    assert_eq!(MapScore::new([].iter(), &truth(2)).lines.missed, []);
    let score = MapScore::new([].iter(), &truth(3));
    let missed = Missed {
        reflector: Reflector::Line(0),
        echoes: 3,
    };
    assert_eq!(score.lines.missed, [missed]);
    assert_eq!(score.lines.covered, Some(0.0));
    assert!(!score.exact);
    let whole = [line(0, 2.0, -2.0, 2.0)];
    let score = MapScore::new(whole.iter(), &truth(3));
    assert!(score.exact);
    assert_eq!(score.lines.covered, Some(1.0));
}

#[test]
fn what_a_line_has_beyond_its_wall_is_overrun() {
    let overrun = |features: &[MapFeature]| {
        let lines = MapScore::new(features.iter(), &truth(3)).lines;
        assert_eq!(lines.matches.len(), 1);
        lines.overrun.unwrap()
    };
    assert!(overrun(&[line(0, 2.0, -1.0, 2.0)]).abs() < 1e-9);
    assert!((overrun(&[line(0, 2.0, -2.3, 2.5)]) - 0.8).abs() < 1e-9);
    // What lies on no wall does not go on beyond one.
    let spurious = [line(0, 2.0, -1.0, 2.0), line(1, 3.0, 0.0, 9.0)];
    assert!(overrun(&spurious).abs() < 1e-9);
    let points = MapScore::new([].iter(), &truth(3)).points;
    assert_eq!(points.overrun, None);
}

/// A sensor at the origin that looks up and hears y = 2; the wall there in the pieces `walls`.
fn pieces(walls: &[[f64; 4]]) -> Truth {
    let wall = |[a, b, c, d]: &[f64; 4]| Wall::new(Vec2::new(*a, *b), Vec2::new(*c, *d));
    heard_in(
        3,
        World::new(walls.iter().map(wall).collect(), Vec::new()).unwrap(),
    )
}

#[test]
fn a_line_is_every_piece_of_a_wall_that_it_covers() {
    let halves = pieces(&[[-2.0, 2.0, 0.5, 2.0], [0.6, 2.01, 2.0, 2.01]]);
    let whole = [line(0, 2.0, -2.0, 2.0)];
    let lines = MapScore::new(whole.iter(), &halves).lines;
    assert_eq!((lines.matches.len(), lines.shared.len()), (1, 0));
    assert!(lines.missed.is_empty() && lines.spurious.is_empty() && lines.duplicates.is_empty());
    assert!((lines.covered.unwrap() - 1.0).abs() < 1e-4);
    assert!(lines.overrun.unwrap() < 1e-4, "the gap is wall");

    // Behind a door is another wall: a line that reaches there by a hand is not that.
    let door = pieces(&[[-2.0, 2.0, 0.5, 2.0], [1.3, 2.0, 3.0, 2.0]]);
    for (end, shared) in [(1.5, 0), (2.9, 1)] {
        let over = [line(0, 2.0, -2.0, end)];
        let lines = MapScore::new(over.iter(), &door).lines;
        assert_eq!((lines.matches.len(), lines.shared.len()), (1, shared));
        // The wall behind the door never echoed: it is not counted, shown or not.
        assert_eq!((lines.matched, lines.without_own()), (1, 0));
    }
}

#[test]
fn where_pieces_go_on_echoes_the_wall_and_no_point() {
    // The gap is where the perpendicular falls.
    let gap = pieces(&[[-2.0, 2.0, -0.05, 2.0], [0.05, 2.0, 2.0, 2.0]]);
    assert!((0..2).all(|point| gap.echoes(Reflector::Point(point)) == 0));
    assert_eq!(gap.echoes(Reflector::Line(0)), 3);
}

#[test]
fn the_corner_of_walls_that_do_not_reach_it_is_a_right_point() {
    let walls = pieces(&[[-2.0, 2.0, 1.7, 2.0], [2.0, 1.7, 2.0, 0.0]]);
    let features = [point(0, 2.0, 2.0), point(1, 1.72, 2.0), point(2, 0.0, 2.0)];
    let points = MapScore::new(features.iter(), &walls).points;
    assert_eq!(points.matches.len(), 1);
    assert_eq!(points.matches[0].feature, 0);
    assert_eq!(points.spurious, [1, 2], "the walls' surveyed ends are none");
}
