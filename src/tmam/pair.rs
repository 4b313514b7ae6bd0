//! Common points of two neighbouring arcs.

use crate::geometry::Vec2;

/// Where a common tangent or a crossing lies on each of the two arcs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairPoint {
    /// Bearing from the first arc's centre, radians in the world.
    pub bearing_a: f64,
    /// Bearing from the second arc's centre.
    pub bearing_b: f64,
    /// The point on the first arc.
    pub on_a: Vec2,
    /// The point on the second arc; the same as `on_a` for an intersection.
    pub on_b: Vec2,
}

/// The points of a pair of arcs, by side: left and right of travel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Points {
    /// Where the common tangent touches.
    pub contact: [Option<PairPoint>; 2],
    /// Where the arcs cross.
    pub intersection: [Option<PairPoint>; 2],
}
