//! What the runs that closed in a frame gave: drawn in that frame only, and told in the event log.

use rerun::Color;
use rerun::components::TextLogLevel;

use super::canvas::{Canvas, LogLine, Mark, Moment, Shown};
use super::entity::Entity;
use super::plane::PlaneOrigin;
use super::style;
use crate::core::rounding::fixed;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{Action, Kind, Rejection, Shape};
use crate::core::tmam::step::{Extraction, Step};
use crate::core::wording::counted;
use crate::observe::viewer::Error;

/// The extracted features of one frame, and the arcs they came from.
#[derive(Default)]
pub struct Closed {
    // Every arc so far, by id: a run over arcs without a label reaches back as far as it is long.
    arcs: Vec<Arc>,
    now: Vec<Drawn>,
    shown: bool,
}

/// A feature as it is drawn, in one colour under one name.
struct Drawn {
    color: Color,
    name: String,
    arcs: Vec<Vec<[f32; 2]>>,
    line: Option<Vec<[f32; 2]>>,
    point: Option<[f32; 2]>,
}

impl Closed {
    /// Takes in what a step extracted.
    pub fn note(&mut self, step: &Step, origin: PlaneOrigin) {
        self.arcs.extend(&step.arcs);
        for extraction in &step.extractions {
            let associated = extraction.associated.iter();
            let associated = associated.filter_map(|id| {
                let at = self.arcs.binary_search_by_key(id, |arc| arc.id);
                self.arcs.get(at.ok()?)
            });
            self.now.push(Drawn {
                color: color(extraction),
                name: name(extraction),
                arcs: associated.map(|arc| origin.sweep(arc)).collect(),
                line: match extraction.shape {
                    Some(Shape::Line(line)) => Some(line.ends().map(|end| origin.xy(end)).into()),
                    Some(Shape::Circle(circle)) => {
                        Some(circle.outline().map(|at| origin.xy(at)).collect())
                    }
                    _ => None,
                },
                point: match extraction.shape {
                    Some(Shape::Point(point)) => Some(origin.xy(point.position)),
                    _ => None,
                },
            });
        }
    }

    /// Ends a frame: writes its drawing, or clears the one of the frame before.
    pub fn draw(&mut self, at: Moment, canvas: &mut Canvas<'_>) -> Result<(), Error> {
        let now = std::mem::take(&mut self.now);
        let empty = now.iter().all(Drawn::is_empty);
        let shown = std::mem::replace(&mut self.shown, !empty);
        if empty && !shown {
            return Ok(());
        }
        let arcs = now
            .iter()
            .flat_map(|one| one.arcs.iter().map(move |arc| one.mark(arc)));
        canvas.row(Entity::ClosedArcs, at, Shown::Strips(arcs.collect()))?;
        let lines = now
            .iter()
            .filter_map(|one| Some(one.mark(one.line.as_ref()?)));
        canvas.row(Entity::ClosedLines, at, Shown::Strips(lines.collect()))?;
        let points = now
            .iter()
            .filter_map(|one| Some(one.mark(one.point.as_ref()?)));
        canvas.row(Entity::ClosedPoints, at, Shown::Dots(points.collect()))
    }
}

impl Drawn {
    fn is_empty(&self) -> bool {
        self.arcs.is_empty() && self.line.is_none() && self.point.is_none()
    }

    fn mark<P: Clone>(&self, at: &P) -> Mark<P> {
        let color = Some(self.color);
        Mark {
            color,
            ..Mark::named(at.clone(), self.name.clone())
        }
    }
}

/// The colour of what a run gave.
fn color(extraction: &Extraction) -> Color {
    match (extraction.action, extraction.kind) {
        (Action::Rejected(_), _) => style::REJECTED,
        (_, Kind::Line) => style::CONTACT,
        (_, Kind::Point) => style::INTERSECTION,
        (_, Kind::Circle) => style::CIRCLE,
    }
}

fn name(extraction: &Extraction) -> String {
    let kind = extraction.kind.name();
    match extraction.action {
        Action::Registered(id) => format!("{kind} run {}: new in the map as {id}", extraction.id),
        Action::Merged(id) => format!("{kind} run {}: merged into {id}", extraction.id),
        Action::Rejected(_) => format!("{kind} run {}: rejected", extraction.id),
    }
}

/// One message per extraction.
pub fn tell(at: Moment, extractions: &[Extraction], canvas: &mut Canvas<'_>) -> Result<(), Error> {
    for extraction in extractions {
        let first = extraction.labelled.first();
        let sonar = first.map_or("?", |arc| canvas.sonar(arc.sonar));
        let message = LogLine {
            text: describe(extraction, sonar),
            level: match extraction.action {
                Action::Rejected(_) => TextLogLevel::WARN,
                _ => TextLogLevel::INFO,
            },
            color: color(extraction),
        };
        canvas.row(Entity::Log, at, Shown::Messages(vec![message]))?;
    }
    Ok(())
}

/// A closed run in one sentence: what, whence, where, and what became of it.
fn describe(extraction: &Extraction, sonar: &str) -> String {
    let kind = extraction.kind.name();
    let frames = match (extraction.associated.first(), extraction.associated.last()) {
        (Some(first), Some(last)) => format!("frames {}-{}", first.frame, last.frame),
        _ => "no frames".to_owned(),
    };
    let run = format!(
        "run {} of {sonar}, {frames} ({})",
        extraction.id,
        counted(extraction.associated.len() as u64, "reading")
    );
    let estimate = estimate(extraction);
    match extraction.action {
        Action::Registered(id) => format!("new map {kind} {id}: {estimate} by {run}"),
        Action::Merged(id) => {
            let all = extraction.map_feature.map(|feature| feature.readings);
            let all = all.map_or_else(String::new, |n| format!(" (n {n})"));
            format!("map {kind} {id}{all} takes in {estimate} by {run}")
        }
        Action::Rejected(why) => format!("no {kind}, {}: {run}", in_words(why)),
    }
}

fn estimate(extraction: &Extraction) -> String {
    let place = match &extraction.shape {
        Some(Shape::Line(line)) => format!(
            "rho {:.3} m, theta {} deg",
            line.rho,
            fixed(line.theta.to_degrees(), 1)
        ),
        Some(Shape::Point(point)) => {
            let [x, y] = [point.position.x, point.position.y].map(|place| fixed(place, 3));
            format!("x {x} m, y {y} m")
        }
        Some(Shape::Circle(circle)) => {
            let [x, y, radius] =
                [circle.center.x, circle.center.y, circle.radius].map(|place| fixed(place, 3));
            format!("x {x} m, y {y} m, radius {radius} m")
        }
        None => return String::new(),
    };
    format!("{place}, rms {:.1} mm,", extraction.residual_rms * 1e3)
}

fn in_words(why: Rejection) -> &'static str {
    match why {
        Rejection::NoStart => "no two of its arcs share a point to start the fit from",
        Rejection::Singular => "the readings do not determine it",
        Rejection::Diverged => "the fit ran away",
        Rejection::OutsideBeams => "it lies outside the beams it came from",
        Rejection::Misfit => "its readings do not all come from one feature",
        Rejection::Mirrored => "its mirror image at the robot's path fits as well",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::event::SonarId;
    use crate::core::geometry::Vec2;
    use crate::core::tmam::arc::ArcId;
    use crate::core::tmam::feature::{MapFeature, Segment, Status};
    use crate::core::tmam::hypothesis::{HypothesisTest, Support};
    use nalgebra::Matrix2;

    fn extraction(action: Action, shape: Option<Shape>) -> Extraction {
        let arcs: Vec<ArcId> = (12..=19)
            .map(|frame| ArcId {
                frame,
                sonar: SonarId(4),
            })
            .collect();
        Extraction {
            id: 3,
            kind: Kind::Line,
            labelled: arcs.iter().skip(1).take(6).copied().collect(),
            associated: arcs,
            shape,
            residual_rms: 0.0031,
            iterations: 4,
            converged: true,
            opinion: Some(HypothesisTest {
                gate: 6.63,
                readings: 8,
                chi2_line: 5.0,
                chi2_point: 500.0,
                chi2_circle: None,
                gate_circle: 6.63,
                is_beside: false,
                support: Support::Line,
            }),
            outliers: Vec::new(),
            action,
            map_feature: None,
            absorbed: Vec::new(),
        }
    }

    #[test]
    fn a_message_says_what_a_person_wants_to_know() {
        let line = Shape::Line(Segment {
            rho: 2.0034,
            theta: 1.5725,
            covariance: Matrix2::zeros(),
            mid: Vec2::new(1.0, 2.0),
            half_length: 0.75,
        });
        let mut merged = extraction(Action::Merged(5), Some(line));
        merged.map_feature = Some(MapFeature {
            id: 5,
            shape: line,
            readings: 23,
            runs: 3,
            status: Status::Confirmed,
        });
        assert_eq!(
            describe(&merged, "sonar_04"),
            "map line 5 (n 23) takes in rho 2.003 m, theta 90.1 deg, rms 3.1 mm, \
             by run 3 of sonar_04, frames 12-19 (8 readings)"
        );
        assert_eq!(
            describe(
                &extraction(Action::Rejected(Rejection::Singular), None),
                "sonar_04"
            ),
            "no line, the readings do not determine it: run 3 of sonar_04, frames 12-19 (8 readings)"
        );
    }
}
