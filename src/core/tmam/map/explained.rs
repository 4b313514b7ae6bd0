//! Features that another one explains away.

use crate::core::geometry::{Vec2, direction, unit};
use crate::core::ties;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::Shape;
use crate::core::tmam::hypothesis::Gate;

/// Chi2 with one degree of freedom beyond which a feature does not explain a reading: one true
/// reading in a thousand lies beyond.
const GATE: f64 = 10.83;

/// Whether a feature of the map explains the readings that another one was made of, all of them
/// inside their beams.
pub fn explains(shape: &Shape, arcs: &[Arc]) -> bool {
    let chi2: Option<f64> = arcs.iter().map(|arc| misfit(shape, arc)).sum();
    chi2.is_some_and(|chi2| chi2 < Gate::new(GATE).at(arcs.len()))
}

/// Squared misfit of a reading in standard deviations; `None` where the beam does not hold the
/// feature.
fn misfit(shape: &Shape, arc: &Arc) -> Option<f64> {
    let (away, variance): (Vec2, f64) = match shape {
        Shape::Line(segment) => {
            let (local, covariance) = segment.about(arc.center());
            (unit(local.y) * local.x, covariance.m11)
        }
        Shape::Point(point) => {
            let away = point.position - arc.center();
            let ray = away / away.norm().max(f64::MIN_POSITIVE);
            (away, ray.dot(&(point.covariance * ray)))
        }
    };
    let off = away.norm() - arc.range;
    let in_beam = arc.beam_nearly_holds(direction(away), ties::ANGLE);
    in_beam.then(|| off * off / (arc.variance + variance.max(0.0)))
}
