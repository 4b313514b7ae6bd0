//! The plane of a recording: where its origin is, and how much of it the map view must show.
//!
//! A recording holds places as 32-bit floats, seven digits: a millimetre only up to some ten kilometres.
//! Odometry in map coordinates starts farther out, so there the recording counts from where the robot
//! started.

use std::collections::BTreeMap;

use rerun::{Scale3D, Transform3D};

use crate::core::geometry::{Pose2, Vec2};
use crate::core::tmam::arc::Arc;

/// From here on a recording has an origin of its own, metres from the world's.
const FAR: f64 = 1e4;
/// Beyond this there is no place, metres.
const FARTHEST: f64 = 1e12;
/// Widest step along an arc, radians: a chord strays 2 mm from an arc 5 m away.
const ARC_STEP: f64 = 0.06;

/// Where the recording's origin is in the world, metres.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PlaneOrigin(Vec2);

impl PlaneOrigin {
    /// For a robot that starts at `start`: the world's own origin if that is near, or else the
    /// start to the metre.
    pub fn of(start: Vec2) -> Self {
        let is_far = start.norm() > FAR && start.amax() < FARTHEST;
        if is_far {
            Self(start.map(libm::rint))
        } else {
            Self::default()
        }
    }

    /// Where it is in the world, unless it is the world's.
    pub fn shift(self) -> Option<Vec2> {
        (self != Self::default()).then_some(self.0)
    }

    /// A place in the world as seen from here.
    pub fn local(self, place: Vec2) -> Vec2 {
        place - self.0
    }

    /// The same as the viewer stores it.
    pub fn xy(self, place: Vec2) -> [f32; 2] {
        let local = self.local(place);
        [local.x as f32, local.y as f32]
    }

    /// An arc as a strip, right edge to left.
    pub fn sweep(self, arc: &Arc) -> Vec<[f32; 2]> {
        let steps = libm::ceil(arc.beam_width / ARC_STEP).clamp(4.0, 120.0) as u32;
        let right = arc.world_from_sensor.yaw - arc.beam_width / 2.0;
        (0..=steps)
            .map(|i| right + arc.beam_width * f64::from(i) / f64::from(steps))
            .map(|bearing| self.xy(arc.point_at(bearing)))
            .collect()
    }
}

/// What turns a world over: a 2D view has y down.
pub fn upright() -> Transform3D {
    Transform3D::from_scale(Scale3D::from([1.0, -1.0, 1.0]))
}

/// Cell of the histogram over echoes, metres.
const CELL: f64 = 0.25;
/// Share of the echoes, and of the path, that may lie outside at each edge: a few wild readings or a
/// glitch of the odometry must not shrink the map to a dot.
const OUTSIDE: f64 = 0.01;
/// Room for the robot's body and heading, metres.
const ROBOT: f64 = 0.4;
/// Smallest half width, metres.
const LEAST: f64 = 0.5;

/// A box in the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Least x and y.
    pub min: Vec2,
    /// Greatest x and y.
    pub max: Vec2,
}

impl Bounds {
    fn new(min: Vec2, max: Vec2) -> Self {
        Self { min, max }
    }

    /// Width and height, metres.
    pub fn size(&self) -> Vec2 {
        self.max - self.min
    }

    /// With all these places in it, and a margin.
    pub fn of(places: impl Iterator<Item = Vec2>) -> Self {
        let near = places.filter(|place| place.iter().all(|value| value.abs() < FARTHEST));
        Self::around(near.map(|place| Self::new(place, place)))
    }

    /// With all these boxes in it, and a margin.
    fn around(boxes: impl Iterator<Item = Self>) -> Self {
        let all = boxes.reduce(|a, b| Self::new(a.min.inf(&b.min), a.max.sup(&b.max)));
        let bounds = all.unwrap_or(Self::new(Vec2::zeros(), Vec2::zeros()));
        let middle = (bounds.min + bounds.max) / 2.0;
        let half = ((bounds.max - bounds.min) / 2.0).map(|h| (1.1 * h).max(LEAST));
        Self::new(middle - half, middle + half)
    }

    /// The same in a recording with such an origin.
    pub fn seen_from(self, origin: PlaneOrigin) -> Self {
        Self::new(origin.local(self.min), origin.local(self.max))
    }
}

/// Where the robot and nearly all of its echoes were.
#[derive(Debug, Default)]
pub struct Extent {
    path: Histogram,
    echoes: Histogram,
}

/// How often each cell was met, along x and along y.
#[derive(Debug, Default)]
struct Histogram {
    cells: [BTreeMap<i64, u64>; 2],
    count: u64,
}

impl Extent {
    /// The robot was here.
    pub fn visit(&mut self, pose: &Pose2) {
        self.path.add(pose.position());
    }

    /// Something echoed: the middle and both ends of the arc count.
    pub fn echo(&mut self, arc: &Arc) {
        for part in [-0.5, 0.0, 0.5] {
            let bearing = arc.world_from_sensor.yaw + part * arc.beam_width;
            self.echoes.add(arc.point_at(bearing));
        }
    }

    /// The box to show, with a margin.
    pub fn bounds(&self) -> Bounds {
        let boxes = [self.path.bounds(ROBOT), self.echoes.bounds(0.0)];
        let boxes = boxes.into_iter().flatten();
        Bounds::around(boxes)
    }
}

impl Histogram {
    fn add(&mut self, at: Vec2) {
        if !at.iter().all(|value| value.abs() < FARTHEST) {
            return;
        }
        for (cells, value) in self.cells.iter_mut().zip(at.iter()) {
            *cells.entry((value / CELL).floor() as i64).or_default() += 1;
        }
        self.count += 1;
    }

    /// The box that holds all but a share of the cells at each edge, wider by `margin`.
    fn bounds(&self, margin: f64) -> Option<Bounds> {
        let [xs, ys] = &self.cells;
        let ((x0, x1), (y0, y1)) = (self.span(xs)?, self.span(ys)?);
        let (low, high) = (Vec2::new(x0, y0), Vec2::new(x1, y1));
        Some(Bounds::new(
            low.add_scalar(-margin),
            high.add_scalar(margin),
        ))
    }

    fn span(&self, cells: &BTreeMap<i64, u64>) -> Option<(f64, f64)> {
        let outside = (OUTSIDE * self.count as f64) as u64;
        let low = beyond(cells.iter(), outside)?;
        let high = beyond(cells.iter().rev(), outside)?;
        Some((low as f64 * CELL, (high + 1) as f64 * CELL))
    }
}

/// The first cell with which more than `outside` echoes have passed.
fn beyond<'a>(mut cells: impl Iterator<Item = (&'a i64, &'a u64)>, outside: u64) -> Option<i64> {
    let mut passed = 0;
    cells
        .find(|(_, n)| {
            passed += **n;
            passed > outside
        })
        .map(|(cell, _)| *cell)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::event::SonarId;
    use crate::core::tmam::arc::ArcId;

    fn echo(range: f64) -> Arc {
        Arc {
            id: ArcId {
                frame: 0,
                sonar: SonarId(0),
            },
            stamp_ns: 0,
            world_from_sensor: Pose2::IDENTITY,
            range,
            beam_width: 0.4,
            variance: 0.0,
        }
    }

    #[test]
    fn nothing_seen_still_gives_a_box() {
        let bounds = Extent::default().bounds();
        assert_eq!(bounds.min, Vec2::new(-LEAST, -LEAST));
        assert_eq!(bounds.max, Vec2::new(LEAST, LEAST));
    }

    #[test]
    fn a_wild_reading_does_not_shrink_the_map() {
        let mut extent = Extent::default();
        extent.visit(&Pose2::IDENTITY);
        for _ in 0..500 {
            extent.echo(&echo(3.0));
        }
        extent.echo(&echo(900.0));
        let bounds = extent.bounds();
        assert!(bounds.max.x > 3.0 && bounds.max.x < 4.0, "{bounds:?}");
    }

    #[test]
    fn a_glitch_of_the_odometry_does_not_either() {
        let mut extent = Extent::default();
        for k in 0..500 {
            extent.visit(&Pose2::new(f64::from(k) * 0.01, 0.0, 0.0));
        }
        extent.visit(&Pose2::new(1e9, 0.0, 0.0));
        assert!(extent.bounds().max.x < 7.0, "{:?}", extent.bounds());
    }

    #[test]
    fn places_beyond_all_bounds_are_no_trouble() {
        let mut extent = Extent::default();
        extent.echo(&echo(3e38));
        extent.visit(&Pose2::new(1e300, f64::NAN, 0.0));
        assert_eq!(extent.bounds().max, Vec2::new(LEAST, LEAST));
    }

    #[test]
    fn millimetres_are_drawn_wherever_the_robot_starts() {
        let near = PlaneOrigin::of(Vec2::new(3.0, -4.0));
        assert_eq!(
            (near.shift(), near.xy(Vec2::new(1.5, 2.0))),
            (None, [1.5, 2.0])
        );
        let start = Vec2::new(691_234.567, 5_334_321.002);
        let far = PlaneOrigin::of(start);
        assert_eq!(far.shift(), Some(Vec2::new(691_235.0, 5_334_321.0)));
        let [x, y] = far.xy(start + Vec2::new(0.001, 0.0));
        assert!(
            (x - -0.432).abs() < 1e-6 && (y - 0.002).abs() < 1e-6,
            "{x} {y}"
        );
    }

    #[test]
    fn a_start_that_is_no_place_changes_nothing() {
        for x in [f64::NAN, f64::INFINITY, 1e300] {
            assert_eq!(PlaneOrigin::of(Vec2::new(x, 0.0)).shift(), None, "{x}");
        }
    }
}
