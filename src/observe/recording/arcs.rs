//! Arcs in the map: of the current frame, coloured by label, with the points they were judged by.

use super::canvas::{Canvas, Dot, Row, Strip};
use super::entity::Entity;
use super::hold::Held;
use super::style;
use crate::core::geometry::Vec2;
use crate::core::tmam::pair::PairPoint;
use crate::core::tmam::triple::{Evidence, Verdict};
use crate::observe::viewer::Error;

/// Draws the arcs of a decided frame.
pub fn draw(held: &Held, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    let (origin, at) = (canvas.origin, held.moment);
    let cells = held.cells.iter();
    let decided = || {
        cells
            .clone()
            .filter_map(|cell| Some((cell.arc?, cell.verdict?)))
    };
    let arcs = decided().map(|(arc, verdict)| Strip {
        class: style::class(verdict.label),
        ..Strip::named(
            origin.sweep(&arc),
            story(canvas.sonar(arc.id.sonar), &verdict),
        )
    });
    let arcs = Row::Strips(arcs.collect());
    canvas.row(Entity::Arcs, at, arcs)?;
    let beams = decided().map(|(arc, _)| {
        let ahead = arc.point_at(arc.world_from_sensor.yaw);
        Strip::from(vec![origin.xy(arc.center()), origin.xy(ahead)])
    });
    canvas.row(Entity::Beams, at, Row::Strips(beams.collect()))?;
    let touches = |pick: fn(&Evidence) -> Vec<Vec2>| {
        let evidence = decided().filter_map(|(_, verdict)| verdict.evidence);
        let points = evidence.flat_map(|evidence| pick(&evidence));
        Row::Dots(points.map(|point| Dot::from(origin.xy(point))).collect())
    };
    canvas.row(Entity::ContactPoints, at, touches(contact_points))?;
    canvas.row(Entity::IntersectionPoints, at, touches(intersection_points))
}

/// The sonar, the label and the evidence for it, in a line.
pub fn story(sonar: &str, verdict: &Verdict) -> String {
    let label = style::name(verdict.label);
    let Some(evidence) = &verdict.evidence else {
        return format!("{sonar}, {label}");
    };
    let angle = |theta: f64, sigma: Option<f64>| match sigma {
        Some(sigma) => format!("{:.1} +- {:.1} deg", theta.to_degrees(), sigma.to_degrees()),
        None => format!("{:.1} deg", theta.to_degrees()),
    };
    let opinion = &evidence.opinion;
    format!(
        "{sonar}, {label}; theta_c {}, theta_i {}; chi2 line {}, point {}: {}",
        angle(evidence.angles.theta_c, evidence.spread.theta_c),
        angle(evidence.angles.theta_i, evidence.spread.theta_i),
        chi2(opinion.chi2_line),
        chi2(opinion.chi2_point),
        opinion.support.name()
    )
}

/// A chi2; infinite where the beams have no place for such a feature.
pub fn chi2(x: f64) -> String {
    if x.is_finite() {
        format!("{x:.1}")
    } else {
        "none in the beam".to_owned()
    }
}

/// Where the common tangents with its neighbours touch the middle arc.
fn contact_points(Evidence { angles, .. }: &Evidence) -> Vec<Vec2> {
    on_middle(&angles.before.contact, &angles.after.contact)
}

/// Where its neighbours cross the middle arc.
fn intersection_points(Evidence { angles, .. }: &Evidence) -> Vec<Vec2> {
    on_middle(&angles.before.intersection, &angles.after.intersection)
}

fn on_middle(before: &[Option<PairPoint>], after: &[Option<PairPoint>]) -> Vec<Vec2> {
    let before = before.iter().flatten().map(|pair| pair.on_b);
    let after = after.iter().flatten().map(|pair| pair.on_a);
    before.chain(after).collect()
}
