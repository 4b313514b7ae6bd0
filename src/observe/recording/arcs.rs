//! Arcs in the map: of the current frame, coloured by label, with the points they were judged by; and where
//! every echo so far lies on the axis of its beam.

use super::canvas::{Canvas, Dot, Moment, Shown, Strip};
use super::entity::Entity;
use super::hold::HeldFrame;
use super::style;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::pair::{PairPoint, Points};
use crate::core::tmam::report::ArcReport;
use crate::observe::viewer::Error;

/// Draws the arcs of a decided frame.
pub fn draw(held: &HeldFrame, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    let (origin, at) = (canvas.origin, held.moment);
    let cells = held.cells.iter();
    let decided = || cells.clone().filter_map(|cell| cell.report.as_ref());
    let arcs = decided().map(|report| Strip {
        class: style::class(report.label),
        ..Strip::named(
            origin.sweep(&report.arc),
            story(canvas.sonar(report.arc.id.sonar), report),
        )
    });
    let arcs = Shown::Strips(arcs.collect());
    canvas.row(Entity::Arcs, at, arcs)?;
    let beams = decided().map(|ArcReport { arc, .. }| {
        let ahead = arc.point_at(arc.world_from_sensor.yaw);
        Strip::from(vec![origin.xy(arc.center()), origin.xy(ahead)])
    });
    canvas.row(Entity::Beams, at, Shown::Strips(beams.collect()))?;
    // Where the pairs of a triple meet its middle arc.
    let touches = |of: fn(Points) -> [Option<PairPoint>; 2]| {
        let triples = cells.clone().filter_map(|cell| cell.triple.as_ref());
        let points = triples.flat_map(|[before, middle, after]| {
            let first = of(Points::of(before, middle)).into_iter().flatten();
            let second = of(Points::of(middle, after)).into_iter().flatten();
            (first.map(|point| point.on_b)).chain(second.map(|point| point.on_a))
        });
        Shown::Dots(points.map(|point| Dot::from(origin.xy(point))).collect())
    };
    let contact = touches(|points| points.contact);
    canvas.row(Entity::ContactPoints, at, contact)?;
    let intersection = touches(|points| points.intersection);
    canvas.row(Entity::IntersectionPoints, at, intersection)
}

/// Draws where the echoes of a frame lie on the axes of their beams.
pub fn draw_echoes(at: Moment, arcs: &[Arc], canvas: &mut Canvas<'_>) -> Result<(), Error> {
    let origin = canvas.origin;
    let dots = arcs.iter().map(|arc| Dot {
        class: style::class_of(arc.id.sonar),
        ..Dot::from(origin.xy(arc.point_at(arc.world_from_sensor.yaw)))
    });
    canvas.row(Entity::Echoes, at, Shown::Dots(dots.collect()))
}

/// The sonar, the label and the evidence for it, in a line.
fn story(sonar: &str, report: &ArcReport) -> String {
    let label = style::name(report.label);
    let Some(triple) = &report.triple else {
        return format!("{sonar}, {label}");
    };
    let angle = |theta: f64, sigma: Option<f64>| match sigma {
        Some(sigma) => format!("{:.1} +- {:.1} deg", theta.to_degrees(), sigma.to_degrees()),
        None => format!("{:.1} deg", theta.to_degrees()),
    };
    let test = &triple.test;
    format!(
        "{sonar}, {label}; theta_c {}, theta_i {}; chi2 line {}, point {}: {}",
        angle(triple.angles.theta_c, triple.spread.theta_c()),
        angle(triple.angles.theta_i, triple.spread.theta_i()),
        chi2(test.chi2_line),
        chi2(test.chi2_point),
        test.support.name()
    )
}

/// A chi2; infinite where the beams have no place for such a feature.
fn chi2(x: f64) -> String {
    if x.is_finite() {
        format!("{x:.1}")
    } else {
        "none in the beam".to_owned()
    }
}
