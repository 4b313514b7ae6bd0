//! What the runs that closed in a frame gave, drawn in that frame only.

use std::collections::BTreeMap;
use std::io::Write;

use rerun::{Color, LineStrips2D, Points2D};

use super::Error;
use super::encode::RrdWriter;
use super::origin::Origin;
use super::shapes::{Dot, Strip};
use super::style::{self, order, ui};
use super::table::{Moment, Table, Timelines, put_static};
use crate::core::tmam::arc::{Arc, ArcId};
use crate::core::tmam::feature::{Action, Extraction, Kind, Shape};
use crate::core::tmam::label::Label;
use crate::core::tmam::step::Step;

/// The extracted features of one frame, and the arcs they came from.
pub struct ClosedTables {
    recent: BTreeMap<ArcId, Arc>,
    now: Drawing,
    shown: bool,
    arcs: Table<Strip>,
    lines: Table<Strip>,
    points: Table<Dot>,
}

#[derive(Default)]
struct Drawing {
    arcs: Vec<Strip>,
    lines: Vec<Strip>,
    points: Vec<Dot>,
}

impl ClosedTables {
    /// Nothing has closed yet.
    pub fn new() -> Self {
        Self {
            recent: BTreeMap::new(),
            now: Drawing::default(),
            shown: false,
            arcs: Table::new("/world/features/arcs"),
            lines: Table::new("/world/features/lines"),
            points: Table::new("/world/features/points"),
        }
    }

    /// Takes in what a step extracted.
    pub fn note(&mut self, step: &Step, origin: Origin) {
        self.recent
            .extend(step.arcs.iter().map(|arc| (arc.id, *arc)));
        for extraction in &step.extractions {
            self.draw(extraction, origin);
        }
        self.forget(step);
    }

    fn draw(&mut self, extraction: &Extraction, origin: Origin) {
        let (color, label) = (color(extraction), label(extraction));
        let strip = |points| Strip {
            points,
            color: Some(color),
            label: label.clone(),
        };
        let associated = extraction.associated.iter();
        self.now.arcs.extend(
            associated
                .filter_map(|id| self.recent.get(id))
                .map(|arc| strip(origin.sweep(arc))),
        );
        match extraction.shape {
            Some(Shape::Line(segment)) => {
                let ends = segment.ends().map(|end| origin.xy(end));
                self.now.lines.push(strip(ends.to_vec()));
            }
            Some(Shape::Point(point)) => self.now.points.push(Dot {
                position: origin.xy(point.position),
                color: Some(color),
                label: label.clone(),
            }),
            None => {}
        }
    }

    /// Forgets arcs that no open run can reach any more.
    fn forget(&mut self, step: &Step) {
        let unlabelled = step
            .labelled
            .iter()
            .filter(|report| matches!(report.label, Label::Unidentified(_)))
            .map(|report| report.arc.id);
        let closed = step
            .extractions
            .iter()
            .filter_map(|extraction| extraction.labelled.last().copied());
        for last in unlabelled.chain(closed) {
            self.recent
                .retain(|id, _| id.sonar != last.sonar || id.frame >= last.frame);
        }
    }

    /// Ends a frame: logs its drawing, or clears the one of the frame before.
    pub fn push<W: Write>(
        &mut self,
        at: Moment,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        let now = std::mem::take(&mut self.now);
        let empty = now.arcs.is_empty() && now.lines.is_empty() && now.points.is_empty();
        if empty && !self.shown {
            return Ok(());
        }
        self.shown = !empty;
        self.arcs.push(at, now.arcs, lines, out)?;
        self.lines.push(at, now.lines, lines, out)?;
        self.points.push(at, now.points, lines, out)
    }

    /// Writes what waits.
    pub fn flush<W: Write>(
        &mut self,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        self.arcs.flush(lines, out)?;
        self.lines.flush(lines, out)?;
        self.points.flush(lines, out)
    }
}

fn color(extraction: &Extraction) -> Color {
    match (extraction.action, extraction.kind) {
        (Action::Rejected(_), _) => style::REJECTED,
        (_, Kind::Line) => style::CONTACT,
        (_, Kind::Point) => style::INTERSECTION,
    }
}

fn label(extraction: &Extraction) -> String {
    let kind = extraction.kind.name();
    match extraction.action {
        Action::Registered(id) => format!("{kind} run {}: new in the map as {id}", extraction.id),
        Action::Merged(id) => format!("{kind} run {}: merged into {id}", extraction.id),
        Action::Rejected(_) => format!("{kind} run {}: rejected", extraction.id),
    }
}

/// How extracted features look.
pub fn put_styles<W: Write>(out: &mut RrdWriter<W>) -> Result<(), Error> {
    let strips = LineStrips2D::update_fields;
    put_static(
        "/world/features/arcs",
        &strips()
            .with_radii([ui(0.75)])
            .with_show_labels(false)
            .with_draw_order(order::ASSOCIATED),
        out,
    )?;
    put_static(
        "/world/features/lines",
        &strips()
            .with_radii([ui(4.5)])
            .with_show_labels(false)
            .with_draw_order(order::FEATURE),
        out,
    )?;
    put_static(
        "/world/features/points",
        &Points2D::update_fields()
            .with_radii([ui(7.5)])
            .with_show_labels(false)
            .with_draw_order(order::FEATURE),
        out,
    )
}
