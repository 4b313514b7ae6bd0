//! Where walls end: at the corners that were found on them.

use crate::core::geometry::unit;
use crate::core::ties;
use crate::core::tmam::feature::{Point, Segment, Shape};

/// A point this near to a wall's line is on it, metres; beyond what the covariances say.
const ON_LINE: f64 = 0.02;
/// Standard deviations of the point that come on top.
const SIGMAS: f64 = 3.0;
/// The longest piece of wall that is cut off, metres: what runs across a corner by mistake, since
/// ranges pass from a wall to its end so smoothly.
const LONGEST_CUT: f64 = 0.5;
/// The same as a share of the segment's length.
const LARGEST_SHARE: f64 = 0.4;

/// A feature without what reaches beyond a point on its line near one of its ends.
pub fn cut(shape: Shape, points: &[Point]) -> Shape {
    match &shape {
        Shape::Line(segment) => cut_at(segment, points).map_or(shape, Shape::Line),
        Shape::Point(_) | Shape::Circle(_) => shape,
    }
}

/// The segment without what reaches beyond a point on its line near one of its ends; `None` where
/// nothing does.
fn cut_at(segment: &Segment, points: &[Point]) -> Option<Segment> {
    let (normal, along) = (unit(segment.theta), segment.along());
    let longest = LONGEST_CUT.min(LARGEST_SHARE * 2.0 * segment.half_length);
    let [first, last] = segment.extent();
    let (mut low, mut high) = (first, last);
    for point in points {
        let spread = normal.dot(&(point.covariance * normal)).max(0.0).sqrt();
        let off = (point.position.dot(&normal) - segment.rho).abs();
        if off > ON_LINE + SIGMAS * spread {
            continue;
        }
        let way = point.position.dot(&along);
        // As seen from where the wall ended before: several points must not eat it up.
        let within =
            |low, high| ties::above(way, low, ties::LENGTH) && ties::below(way, high, ties::LENGTH);
        if within(last - longest, last) {
            high = high.min(way);
        } else if within(first, first + longest) {
            low = low.max(way);
        }
    }
    let cut = segment.with_extent([low, high]);
    ties::below(cut.half_length, segment.half_length, ties::LENGTH / 2.0).then_some(cut)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::Vec2;
    use nalgebra::Matrix2;
    use std::f64::consts::FRAC_PI_2;

    /// Along x from 0 to 4, 2 m up.
    fn wall() -> Segment {
        Segment {
            rho: 2.0,
            theta: FRAC_PI_2,
            covariance: Matrix2::identity() * 1e-6,
            mid: Vec2::new(2.0, 2.0),
            half_length: 2.0,
        }
    }

    fn point(x: f64, y: f64) -> Point {
        Point {
            position: Vec2::new(x, y),
            covariance: Matrix2::identity() * 1e-6,
        }
    }

    #[test]
    fn a_wall_ends_at_the_corners_that_it_runs_across() {
        let cut = cut_at(&wall(), &[point(0.2, 2.01), point(3.7, 1.99)]).unwrap();
        let [a, b] = cut.ends();
        let (left, right) = (a.x.min(b.x), a.x.max(b.x));
        assert!(
            (left - 0.2).abs() < 1e-12 && (right - 3.7).abs() < 1e-12,
            "{cut:?}"
        );
        assert_eq!((cut.rho, cut.theta), (2.0, FRAC_PI_2));
    }

    #[test]
    fn however_many_points_lie_on_it_the_wall_stays() {
        let points: Vec<Point> = (0..=40)
            .rev()
            .map(|k| point(0.1 * f64::from(k), 2.0))
            .collect();
        let cut = cut_at(&wall(), &points).unwrap();
        assert!(cut.half_length > 1.4, "{cut:?}");
    }

    #[test]
    fn points_in_its_midst_beside_it_or_beyond_it_cut_nothing() {
        for (x, y) in [(2.0, 2.0), (3.3, 2.0), (3.8, 2.1), (4.1, 2.0)] {
            assert_eq!(cut_at(&wall(), &[point(x, y)]), None, "{x} {y}");
        }
    }
}
