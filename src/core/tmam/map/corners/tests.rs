use super::*;
use std::f64::consts::FRAC_PI_2;

use crate::core::tmam::fit::testing::Gauss;
use proptest::prelude::*;

/// Of a wall through `(x, y)` whose normal has the direction `theta`, seen for a metre on either side.
fn wall(id: u32, (x, y): (f64, f64), theta: f64, sigma: [f64; 2]) -> MapFeature {
    let mid = Vec2::new(x, y);
    let segment = Segment {
        rho: 0.0,
        theta,
        covariance: Matrix2::zeros(),
        mid,
        half_length: 1.0,
    };
    let covariance = Matrix2::new(sigma[0] * sigma[0], 0.0, 0.0, sigma[1] * sigma[1]);
    let line = segment.with_line_about(mid, Vector2::new(0.0, theta), covariance);
    feature(id, Shape::Line(line.canonical()))
}

fn point(id: u32, x: f64, y: f64, sigma: f64) -> MapFeature {
    feature(
        id,
        Shape::Point(Point {
            position: Vec2::new(x, y),
            covariance: Matrix2::identity() * (sigma * sigma),
        }),
    )
}

fn feature(id: u32, shape: Shape) -> MapFeature {
    MapFeature {
        id,
        shape,
        readings: 20,
        runs: 2,
        status: Status::Confirmed,
    }
}

const MM: f64 = 1e-3;
const SIGMA: [f64; 2] = [2.0 * MM, 2.0 * MM];

/// A corner at (4, 3): a wall along x, 3 m up, and one along y, 4 m ahead.
fn room(corner: (f64, f64)) -> Vec<MapFeature> {
    vec![
        wall(0, (2.0, 3.0), FRAC_PI_2, SIGMA),
        wall(1, (4.0, 1.5), 0.0, SIGMA),
        point(2, corner.0, corner.1, 2.0 * MM),
    ]
}

fn position(features: &[MapFeature], id: u32) -> Point {
    match shape(features, id) {
        Shape::Point(point) => point,
        _ => panic!("no point"),
    }
}

fn segment(features: &[MapFeature], id: u32) -> Segment {
    match shape(features, id) {
        Shape::Line(segment) => segment,
        _ => panic!("no line"),
    }
}

fn shape(features: &[MapFeature], id: u32) -> Shape {
    features.iter().find(|f| f.id == id).unwrap().shape
}

#[test]
fn the_walls_meet_in_their_corner_and_all_three_are_better_known() {
    let before = room((4.003, 2.998));
    let joined = join(&before);
    let corner = position(&joined, 2);
    for id in [0, 1] {
        let (was, now) = (segment(&before, id), segment(&joined, id));
        assert!(Shape::Line(now).distance(corner.position) < 1e-9);
        assert!(Shape::Line(now).distance(now.mid) < 1e-9);
        assert!(now.covariance.m22 < 0.7 * was.covariance.m22, "{now:?}");
    }
    assert!(corner.covariance.trace() < 0.9 * position(&before, 2).covariance.trace());
}

/// Two rho and theta, one corner: the estimate that least squares gives, up to what is not linear.
#[test]
fn one_corner_is_weighted_least_squares() {
    let off = 3.0 * MM;
    let joined = join(&room((4.0 + off, 3.0)));
    // Only the wall ahead is off, and it foretells x within its rho and its theta 1.5 m away.
    let (of_rho, of_theta) = (4e-6, 1.5 * 1.5 * 4e-6);
    let share = (of_rho + of_theta) / (of_rho + of_theta + 4e-6);
    let corner = position(&joined, 2).position;
    assert!((corner.x - (4.0 + share * off)).abs() < 1e-7, "{corner}");
    assert!((corner.y - 3.0).abs() < 1e-7, "{corner}");
    let ahead = segment(&joined, 1);
    let turn = of_theta / 1.5 / (of_rho + of_theta + 4e-6) * off;
    assert!((ahead.theta.abs() - turn).abs() < 1e-7, "{ahead:?}");
}

#[test]
fn what_is_no_corner_is_left_alone() {
    let off_the_walls = room((4.03, 3.0));
    let on_one_wall_only = room((2.0, 3.0));
    let mut tentative = room((4.0, 3.0));
    tentative[2].status = Status::Tentative;
    let far_from_what_was_seen = vec![
        wall(0, (-0.1, 3.0), FRAC_PI_2, SIGMA),
        wall(1, (4.0, 1.5), 0.0, SIGMA),
        point(2, 4.0, 3.0, 2.0 * MM),
    ];
    let mut a_stub = room((4.0, 3.0));
    if let Shape::Line(segment) = &mut a_stub[0].shape {
        segment.half_length = 0.3;
    }
    let nearly_parallel = vec![
        wall(0, (2.0, 3.0), FRAC_PI_2, SIGMA),
        wall(1, (2.0, 3.0), FRAC_PI_2 + 0.4, SIGMA),
        point(2, 2.0, 3.0, 2.0 * MM),
    ];
    // Any point would do for such walls.
    let walls_that_say_nothing = vec![
        wall(0, (2.0, 3.0), FRAC_PI_2, [20.0 * MM, 0.1]),
        wall(1, (4.0, 1.5), 0.0, SIGMA),
        point(2, 4.0, 3.1, 2.0 * MM),
    ];
    for features in [
        off_the_walls,
        on_one_wall_only,
        tentative,
        far_from_what_was_seen,
        a_stub,
        nearly_parallel,
        walls_that_say_nothing,
        Vec::new(),
    ] {
        assert_eq!(join(&features), Vec::new(), "{features:?}");
    }
}

#[test]
fn a_point_takes_the_pair_of_walls_that_foretells_it_best() {
    let mut features = room((4.0, 3.0));
    // The same wall once more, as drift leaves it.
    features.push(wall(3, (4.004, 1.5), 0.0, SIGMA));
    let joined: Vec<u32> = join(&features).iter().map(|f| f.id).collect();
    assert_eq!(joined, [2, 0, 1]);
}

#[test]
fn more_walls_than_are_held_do_no_harm() {
    let rooms = u32::try_from(MOST_WALLS).unwrap();
    let features: Vec<MapFeature> = (0..rooms)
        .flat_map(|k| {
            let x = 10.0 * f64::from(k);
            [
                wall(3 * k, (x + 2.0, 3.0), FRAC_PI_2, SIGMA),
                wall(3 * k + 1, (x + 4.0, 1.5), 0.0, SIGMA),
                point(3 * k + 2, x + 4.001, 3.0, 2.0 * MM),
            ]
        })
        .collect();
    let walls = |f: &&MapFeature| matches!(f.shape, Shape::Line(_));
    let joined = join(&features);
    assert!(joined.iter().filter(walls).count() <= MOST_WALLS);
    assert!(joined.len() > MOST_WALLS);
}

/// The four walls of a room, seen in short pieces, and its corners.
fn square(e: &[f64; 16]) -> Vec<MapFeature> {
    let turns = [(2.0, 0.0), (4.0, 2.0), (2.0, 4.0), (0.0, 2.0)];
    let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)];
    let mut features = Vec::new();
    for (k, (x, y)) in (0u32..).zip(turns) {
        let theta = FRAC_PI_2 * (f64::from(k) + 1.0);
        let at = 2 * k as usize;
        let mid = Vec2::new(x, y) + unit(theta) * (e[at] * SIGMA[0]);
        features.push(wall(k, (mid.x, mid.y), theta + e[at + 1] * SIGMA[1], SIGMA));
    }
    for (k, (x, y)) in (0u32..).zip(corners) {
        let at = 8 + 2 * k as usize;
        let off = [e[at] * 2.0 * MM, e[at + 1] * 2.0 * MM];
        features.push(point(4 + k, x + off[0], y + off[1], 2.0 * MM));
    }
    features
}

proptest! {
    /// All corners hold at once, whatever the order in which they are joined.
    #[test]
    fn a_room_closes(e in prop::array::uniform16(-1.5..1.5)) {
        let before = square(&e);
        let joined = join(&before);
        prop_assert_eq!(joined.len(), 8);
        for corner in 0..4 {
            let point = position(&joined, 4 + corner).position;
            for wall in [corner, (corner + 3) % 4] {
                let wall = segment(&joined, wall);
                prop_assert!(Shape::Line(wall).distance(point) < 1e-9);
                prop_assert!(wall.covariance.symmetric_eigenvalues().min() > 0.0);
            }
        }
        let mut other_way = before;
        other_way.reverse();
        let other = join(&other_way);
        for id in 0..4 {
            let (one, two) = (segment(&joined, id), segment(&other, id));
            prop_assert!((one.rho - two.rho).abs() < 1e-12);
        }
    }
}

/// Where errors are as large as the covariances say before, they are afterwards.
#[test]
fn the_covariances_stay_honest() {
    let mut gauss = Gauss::new(7);
    let (rooms, mut sum) = (400, 0.0);
    for _ in 0..rooms {
        let joined = join(&square(&std::array::from_fn(|_| gauss.sample())));
        for id in 0..4 {
            let middle = Vec2::new(2.0, 2.0);
            let wall = segment(&joined, id);
            let outward = if wall.about(middle).0.x > 0.0 {
                wall
            } else {
                wall.flipped()
            };
            let (local, covariance) = outward.about(middle);
            let quarter = local.y / FRAC_PI_2;
            let off = Vector2::new(local.x - 2.0, (quarter - quarter.round()) * FRAC_PI_2);
            sum += off.dot(&(covariance.try_inverse().unwrap() * off)) / 2.0;
        }
    }
    let nees = sum / f64::from(4 * rooms);
    assert!((nees - 1.0).abs() < 0.1, "{nees}");
}
