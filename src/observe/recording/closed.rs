//! What the runs that closed in a frame gave, drawn in that frame only.

use rerun::Color;

use super::canvas::{Canvas, Mark, Moment, Row};
use super::entity::Entity;
use super::plane::Origin;
use super::style;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{Action, Kind, Shape};
use crate::core::tmam::step::{Extraction, Step};
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
    pub fn note(&mut self, step: &Step, origin: Origin) {
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
        canvas.row(Entity::ClosedArcs, at, Row::Strips(arcs.collect()))?;
        let lines = now
            .iter()
            .filter_map(|one| Some(one.mark(one.line.as_ref()?)));
        canvas.row(Entity::ClosedLines, at, Row::Strips(lines.collect()))?;
        let points = now
            .iter()
            .filter_map(|one| Some(one.mark(one.point.as_ref()?)));
        canvas.row(Entity::ClosedPoints, at, Row::Dots(points.collect()))
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
pub fn color(extraction: &Extraction) -> Color {
    match (extraction.action, extraction.kind) {
        (Action::Rejected(_), _) => style::REJECTED,
        (_, Kind::Line) => style::CONTACT,
        (_, Kind::Point) => style::INTERSECTION,
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
