//! Arcs whose label is contradicted: bright in the map of their frame, and a warning in the log.
//!
//! What contradicts a label is known only later, so they are kept and written at the end, in order.

use std::collections::BTreeMap;
use std::io::Write;

use rerun::LineStrips2D;
use rerun::components::TextLogLevel;

use super::Error;
use super::arcs::{chi2, story};
use super::encode::RrdWriter;
use super::log::Message;
use super::origin::Origin;
use super::shapes::Strip;
use super::style::{self, order, ui};
use super::table::{Moment, Table, Timelines, put_static};
use crate::core::event::Sonar;
use crate::core::tmam::hypothesis::HypothesisTest;
use crate::core::tmam::report::ArcReport;

const PATH: &str = "/world/suspects";
const LOG: &str = "/log/suspects";

/// The suspects so far.
pub struct SuspectTables {
    sonars: Vec<String>,
    found: BTreeMap<i64, Vec<ArcReport>>,
    // Each with whether its arcs are drawn.
    frames: Vec<(Moment, bool)>,
}

impl SuspectTables {
    /// Nobody is suspect yet.
    pub fn new(sonars: &[Sonar]) -> Self {
        Self {
            sonars: sonars.iter().map(|sonar| sonar.name.clone()).collect(),
            found: BTreeMap::new(),
            frames: Vec::new(),
        }
    }

    /// Notes when a frame was.
    pub fn pass(&mut self, at: Moment) {
        self.frames.push((at, true));
    }

    /// Notes that from here on nothing is drawn.
    pub fn leave(&mut self, at: Moment) {
        self.frames.push((at, false));
    }

    /// Takes in what is known of arcs.
    pub fn note(&mut self, reports: &[ArcReport]) {
        for report in reports.iter().filter(|report| report.is_suspect()) {
            let frame = i64::from(report.arc.id.frame);
            self.found.entry(frame).or_default().push(report.clone());
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.found.values().map(Vec::len).sum()
    }

    /// Writes them all.
    pub fn write<W: Write>(
        &mut self,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        let (mut strips, mut log) = (Table::new(PATH), Table::new(LOG));
        let (origin, mut shown) = (out.origin(), false);
        for (at, drawn) in &self.frames {
            let found = self.found.remove(&at.frame).filter(|_| *drawn);
            let mut suspects = found.unwrap_or_default();
            suspects.sort_by_key(|report| report.arc.id);
            if !suspects.is_empty() || shown {
                let row = suspects.iter().map(|report| self.strip(report, origin));
                strips.push(*at, row, lines, out)?;
            }
            shown = !suspects.is_empty();
            for report in &suspects {
                let message = Message {
                    text: self.message(report),
                    level: TextLogLevel::WARN,
                    color: style::SUSPECT,
                };
                log.push(*at, [message], lines, out)?;
            }
        }
        strips.flush(lines, out)?;
        log.flush(lines, out)
    }

    fn sonar(&self, report: &ArcReport) -> &str {
        let sonar = self.sonars.get(report.arc.id.sonar.index());
        sonar.map_or("?", String::as_str)
    }

    fn strip(&self, report: &ArcReport, origin: Origin) -> Strip {
        let story = story(self.sonar(report), report);
        Strip {
            points: origin.sweep(&report.arc),
            color: None,
            label: format!("{story}; suspect: {}", why(report)),
        }
    }

    fn message(&self, report: &ArcReport) -> String {
        format!(
            "suspect: {}, frame {}: {}, but {}",
            self.sonar(report),
            report.arc.id.frame,
            report.label.name(),
            why(report)
        )
    }
}

/// What contradicts the label.
fn why(report: &ArcReport) -> String {
    if let Some(map) = report.map.filter(|map| map.support.kind().is_some()) {
        return format!("the map of all readings has a {} there", map.support.name());
    }
    let mut tests = report.tests().map(|(_, test)| test);
    let against = tests.find(|test| test.contradicts(report.label));
    against.map_or_else(String::new, says)
}

fn says(opinion: &HypothesisTest) -> String {
    format!(
        "{} readings say {} (chi2 line {}, point {})",
        opinion.readings,
        opinion.support.name(),
        chi2(opinion.chi2_line),
        chi2(opinion.chi2_point)
    )
}

/// How suspects look: a wide band below the arc, so that its own colour stays to be seen.
pub fn put_styles<W: Write>(out: &mut RrdWriter<W>) -> Result<(), Error> {
    put_static(
        PATH,
        &LineStrips2D::update_fields()
            .with_radii([ui(5.0)])
            .with_colors([style::SUSPECT])
            .with_show_labels(false)
            .with_draw_order(order::SUSPECT),
        out,
    )
}
