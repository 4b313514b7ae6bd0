//! What a comparison found, drawn over the run: where things were, where they are, what changed.

use std::collections::BTreeMap;
use std::io::Write;

use rerun::components::TextLogLevel;
use rerun::{LineStrips2D, Points2D};

use super::Error;
use super::encode::RrdWriter;
use super::hold::{Held, Ready};
use super::log::LogTable;
use super::shapes::Strip;
use super::style::{self, order, ui};
use super::table::{Moment, Table, Timelines, put_static};
use crate::core::event::Sonar;
use crate::core::geometry::Vec2;

/// With more names than this on the map, none could be read.
const MOST_NAMES: usize = 16;

/// What to draw over a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overlay {
    /// Features as they were: pale.
    pub golden: Vec<Sketched>,
    /// Of those, the ones that moved or are missing: bright.
    pub before: Vec<Sketched>,
    /// Features that moved or are new, as they are now: bright, in another colour.
    pub now: Vec<Sketched>,
    /// What became of the label of an arc, by frame and sonar.
    pub labels: BTreeMap<(u32, String), String>,
    /// What the event log says, at a frame and its stamp.
    pub notes: Vec<(u32, i64, String)>,
    /// The frame at which the viewer opens.
    pub first_frame: Option<u32>,
    /// First and last of the frames to show; `None`: all of them. The map is complete in any case.
    pub only: Option<Vec<[u32; 2]>>,
    /// The page that says what the recording is gets this, too (Markdown).
    pub about: String,
}

/// A feature as it is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Sketched {
    /// Both ends of a line; twice the place of a point.
    pub ends: [Vec2; 2],
    /// Whether it is a point.
    pub is_point: bool,
    /// What to call it.
    pub name: String,
}

impl Overlay {
    /// Whether a frame is shown.
    pub fn shows(&self, frame: u32) -> bool {
        let within = |[first, last]: &[u32; 2]| (*first..=*last).contains(&frame);
        self.only
            .as_ref()
            .is_none_or(|only| only.iter().any(within))
    }

    /// Writes what holds at all times.
    pub fn put<W: Write>(&self, out: &mut RrdWriter<W>) -> Result<(), Error> {
        let origin = out.origin();
        for (path, sketched, color, width, above) in [
            (
                "/world/golden",
                &self.golden,
                style::GOLDEN,
                4.5,
                order::GOLDEN,
            ),
            (
                "/world/differences/before",
                &self.before,
                style::BEFORE,
                4.0,
                order::BEFORE,
            ),
            (
                "/world/differences/now",
                &self.now,
                style::NOW,
                3.0,
                order::NOW,
            ),
        ] {
            let names = above > order::GOLDEN && sketched.len() <= MOST_NAMES;
            let of = |points: bool| sketched.iter().filter(move |one| one.is_point == points);
            let name = |one: &Sketched| one.name.clone();
            let lines = LineStrips2D::new(of(false).map(|one| one.ends.map(|end| origin.xy(end))))
                .with_labels(of(false).map(name))
                .with_show_labels(names)
                .with_colors([color])
                .with_radii([ui(width)])
                .with_draw_order(above);
            put_static(format!("{path}/lines"), &lines, out)?;
            let points = Points2D::new(of(true).map(|one| origin.xy(one.ends[0])))
                .with_labels(of(true).map(name))
                .with_show_labels(names)
                .with_colors([color])
                .with_radii([ui(width + 2.0)])
                .with_draw_order(above);
            put_static(format!("{path}/points"), &points, out)?;
        }
        let look = LineStrips2D::update_fields()
            .with_radii([ui(5.0)])
            .with_colors([style::NOW])
            .with_show_labels(true)
            .with_draw_order(order::NOW);
        put_static(LABELS, &look, out)
    }

    /// Writes what the event log says of the differences.
    pub fn note<W: Write>(
        &self,
        sonars: &[Sonar],
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        let mut log = LogTable::new(sonars);
        for (frame, stamp_ns, text) in &self.notes {
            let at = Moment {
                frame: i64::from(*frame),
                stamp_ns: *stamp_ns,
            };
            log.note(at, TextLogLevel::ERROR, text.clone(), lines, out)?;
        }
        log.flush(lines, out)
    }
}

const LABELS: &str = "/world/differences/labels";

/// The arcs of every frame whose labels changed.
pub struct OverlayTable(Table<Strip>);

impl OverlayTable {
    /// An empty table.
    pub fn new() -> Self {
        Self(Table::new(LABELS))
    }

    /// Marks the arcs of a frame.
    pub fn push<W: Write>(
        &mut self,
        ready: &Ready,
        overlay: &Overlay,
        sonars: &[Sonar],
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        let origin = out.origin();
        let row = |held: &Held| -> Vec<Strip> {
            let arcs = held.cells.iter().filter_map(|cell| cell.arc);
            arcs.filter_map(|arc| {
                let sonar = sonars.get(arc.id.sonar.index())?;
                let what = overlay.labels.get(&(arc.id.frame, sonar.name.clone()))?;
                Some(Strip {
                    points: origin.sweep(&arc),
                    color: None,
                    label: format!("{}: {what}", sonar.name),
                })
            })
            .collect()
        };
        match ready {
            _ if overlay.labels.is_empty() => Ok(()),
            Ready::InOrder(held) => self.0.push(held.moment, row(held), lines, out),
            // A chunk of its own, so that the rows of the others stay in order.
            Ready::Late(held) => {
                let mut own = Table::new(LABELS);
                own.push(held.moment, row(held), lines, out)?;
                own.flush(lines, out)
            }
        }
    }

    /// Writes what waits.
    pub fn flush<W: Write>(
        &mut self,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        self.0.flush(lines, out)
    }
}
