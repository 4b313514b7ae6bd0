//! What is known of arcs once all is known: the evidence beside each arc, and the suspects, whose label
//! is contradicted: bright in the map of their frame, and a warning in the log.
//!
//! All is known of an arc only when its run has closed, frames after it was drawn. So evidence has rows
//! of its own, at the entity and the moment of the arcs, an instance for each arc in their order; and
//! suspects are kept and written at the end, in order.

use std::collections::{BTreeMap, VecDeque};

use rerun::components::TextLogLevel;

use super::arcs::{chi2, story};
use super::canvas::{Canvas, Message, Moment, Row, Strip};
use super::entity::Entity;
use super::evidence::Known;
use super::style;
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::hypothesis::HypothesisTest;
use crate::core::tmam::stream::ArcReport;
use crate::observe::viewer::Error;

/// The reports so far.
#[derive(Default)]
pub struct Reports {
    waiting: VecDeque<(Moment, Vec<ArcId>)>,
    known: BTreeMap<ArcId, ArcReport>,
    // Each with whether its arcs are drawn.
    frames: Vec<(Moment, bool)>,
    suspects: BTreeMap<i64, Vec<ArcReport>>,
}

impl Reports {
    /// Adds a frame that is drawn, with its arcs.
    pub fn frame(&mut self, at: Moment, arcs: Vec<ArcId>) {
        self.waiting.push_back((at, arcs));
        self.frames.push((at, true));
    }

    /// Notes that from here on nothing is drawn.
    pub fn leave(&mut self, at: Moment) {
        self.waiting.push_back((at, Vec::new()));
        self.frames.push((at, false));
    }

    /// Takes in what is known of an arc, drawn or not.
    pub fn note(&mut self, report: &ArcReport, is_drawn: bool) {
        if is_drawn {
            self.known.insert(report.arc.id, *report);
        }
        if report.is_suspect() {
            let frame = i64::from(report.arc.id.frame);
            self.suspects.entry(frame).or_default().push(*report);
        }
    }

    /// Writes the evidence of the frames of which all is known.
    pub fn draw(&mut self, canvas: &mut Canvas<'_>) -> Result<(), Error> {
        while let Some((at, arcs)) = self.waiting.front()
            && arcs.iter().all(|arc| self.known.contains_key(arc))
        {
            let known = arcs.iter().filter_map(|arc| self.known.remove(arc));
            let known = known.map(|report| Known {
                sensor: canvas.sonar(report.arc.id.sonar).to_owned(),
                report,
            });
            let row = Row::Evidence(known.collect());
            canvas.row(Entity::Evidence, *at, row)?;
            self.waiting.pop_front();
        }
        Ok(())
    }

    /// How many suspects there are.
    pub fn suspects(&self) -> usize {
        self.suspects.values().map(Vec::len).sum()
    }

    /// Writes the suspects.
    pub fn draw_suspects(&mut self, canvas: &mut Canvas<'_>) -> Result<(), Error> {
        let mut shown = false;
        for (at, is_drawn) in &self.frames {
            let found = self.suspects.remove(&at.frame).filter(|_| *is_drawn);
            let mut suspects = found.unwrap_or_default();
            suspects.sort_by_key(|report| report.arc.id);
            if !suspects.is_empty() || shown {
                let strips = suspects.iter().map(|report| {
                    let story = story(canvas.sonar(report.arc.id.sonar), &report.verdict);
                    let name = format!("{story}; suspect: {}", why(report));
                    Strip::named(canvas.origin.sweep(&report.arc), name)
                });
                let strips = Row::Strips(strips.collect());
                canvas.row(Entity::Suspects, *at, strips)?;
            }
            shown = !suspects.is_empty();
            for report in &suspects {
                let ArcId { frame, sonar } = report.arc.id;
                let (sonar, label) = (canvas.sonar(sonar), report.verdict.label.name());
                let why = why(report);
                let message = Message {
                    text: format!("suspect: {sonar}, frame {frame}: {label}, but {why}"),
                    level: TextLogLevel::WARN,
                    color: style::SUSPECT,
                };
                canvas.row(Entity::SuspectLog, *at, Row::Messages(vec![message]))?;
            }
        }
        canvas.flush()
    }
}

/// What contradicts the label.
fn why(report: &ArcReport) -> String {
    if let Some(map) = report.map.filter(|map| map.support.kind().is_some()) {
        return format!("the map of all readings has a {} there", map.support.name());
    }
    let label = report.verdict.label;
    let triple = report.verdict.evidence.map(|evidence| evidence.opinion);
    let run = report.run.map(|run| run.opinion);
    let tests = [triple, report.wide, run].into_iter().flatten();
    let mut against = tests.filter(|test| test.contradicts(label));
    against.next().map_or_else(String::new, |test| says(&test))
}

fn says(test: &HypothesisTest) -> String {
    format!(
        "{} readings say {} (chi2 line {}, point {})",
        test.readings,
        test.support.name(),
        chi2(test.chi2_line),
        chi2(test.chi2_point)
    )
}
