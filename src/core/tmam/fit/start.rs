//! Where the iteration starts.

use nalgebra::Vector2;

use super::{Model, weighted_square_sum};
use crate::core::geometry::angle_between;
use crate::core::ties;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::pair::{PairPoint, Points};

/// Parameters to start from and how far they lie from the axes of the two beams, radians.
#[derive(Debug, Clone, Copy)]
pub struct Start {
    parameters: Vector2<f64>,
    off_axis: f64,
}

impl Start {
    /// From a point of a pair of arcs.
    pub fn at(parameters: Vector2<f64>, point: &PairPoint, first: &Arc) -> Self {
        Self {
            parameters,
            off_axis: angle_between(point.bearing_a, first.world_from_sensor.yaw),
        }
    }
}

/// Where the iteration starts: the points of the first and the last arc, else those of the first
/// neighbouring pair that has any. Of two sides the one with the smaller residuals is taken; sides
/// that fit equally well (on a straight path a line and its mirror image do) are told apart by the
/// beam axis.
pub fn start(model: &impl Model, arcs: &[Arc]) -> Option<Vector2<f64>> {
    let (first, last) = (arcs.first()?, arcs.last()?);
    let neighbours = arcs
        .windows(2)
        .filter_map(|w| Some((w.first()?, w.last()?)));
    let sides = std::iter::once((first, last))
        .chain(neighbours)
        .map(|(a, b)| model.starts(&Points::of(a, b)))
        .find(|sides| sides.iter().any(Option::is_some))?;
    let cost = |start: &Start| weighted_square_sum(model, start.parameters, arcs);
    match sides {
        [Some(left), Some(right)] => {
            let (cost_left, cost_right) = (cost(&left), cost(&right));
            let slack = ties::of_chi2(cost_left, cost_right);
            let right_is_better = if (cost_left - cost_right).abs() <= slack {
                ties::below(right.off_axis, left.off_axis, ties::ANGLE)
            } else {
                cost_right < cost_left
            };
            Some(if right_is_better { right } else { left }.parameters)
        }
        [side, None] | [None, side] => side.map(|start| start.parameters),
    }
}
