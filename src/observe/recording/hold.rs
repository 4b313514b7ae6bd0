//! Holds a frame back until every arc in it has its label.
//!
//! A label comes when the sonar's next reading has come, so a frame usually waits for one or
//! two more. A sonar that falls silent keeps its last arc undecided until the end; so that the
//! frames after it need not wait too, a frame that has waited for [`LONGEST_WAIT`] others steps
//! out of the queue. A sonar has one or two undecided arcs at a time, so few frames ever do.

use std::collections::VecDeque;

use super::table::Moment;
use crate::core::event::SonarId;
use crate::core::frames::Frame;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::step::Step;

/// Frames that may queue behind an undecided one.
const LONGEST_WAIT: usize = 256;

/// What one sonar gave one frame.
#[derive(Debug, Clone)]
pub struct Cell {
    /// Which sonar.
    pub sonar: SonarId,
    /// Its arc; `None` where nothing echoed.
    pub arc: Option<Arc>,
    /// The arc with its label.
    pub report: Option<ArcReport>,
}

/// A frame that waits for its labels.
#[derive(Debug, Clone)]
pub struct Held {
    /// When the frame was.
    pub moment: Moment,
    /// What the sonars gave, sorted by sonar.
    pub cells: Vec<Cell>,
}

impl Held {
    /// The cells of a frame, still undecided.
    pub fn new(moment: Moment, frame: &Frame, step: &Step) -> Self {
        let arc_of = |sonar| step.arcs.iter().find(|arc| arc.id.sonar == sonar).copied();
        Self {
            moment,
            cells: frame
                .entries
                .iter()
                .map(|entry| Cell {
                    sonar: entry.sonar,
                    arc: arc_of(entry.sonar),
                    report: None,
                })
                .collect(),
        }
    }

    /// A frame in which these sonars gave nothing.
    pub fn blank(moment: Moment, sonars: impl Iterator<Item = SonarId>) -> Self {
        let nothing = |sonar| Cell {
            sonar,
            arc: None,
            report: None,
        };
        Self {
            moment,
            cells: sonars.map(nothing).collect(),
        }
    }

    fn decided(&self) -> bool {
        self.cells
            .iter()
            .all(|cell| cell.arc.is_none() || cell.report.is_some())
    }

    fn decide(&mut self, report: &ArcReport) -> bool {
        let cell = self
            .cells
            .iter_mut()
            .find(|cell| cell.sonar == report.arc.id.sonar && cell.arc.is_some());
        match cell {
            Some(cell) => {
                cell.report = Some(report.clone());
                true
            }
            None => false,
        }
    }
}

/// A frame that may be written now.
#[derive(Debug)]
pub enum Ready {
    /// The next frame in order.
    InOrder(Held),
    /// One that stepped out of the queue: later frames have been written already.
    Late(Held),
}

/// The frames that wait.
#[derive(Debug, Default)]
pub struct Hold {
    queue: VecDeque<Held>,
    late: Vec<Held>,
}

impl Hold {
    /// Adds the newest frame.
    pub fn push(&mut self, held: Held) {
        self.queue.push_back(held);
        while self.queue.len() > LONGEST_WAIT {
            match self.queue.front() {
                Some(front) if !front.decided() => self.late.extend(self.queue.pop_front()),
                _ => break,
            }
        }
    }

    /// Hands a label to the frame of its arc; `false` where no held frame has that arc.
    pub fn decide(&mut self, report: &ArcReport) -> bool {
        let frame = i64::from(report.arc.id.frame);
        let at = self.queue.partition_point(|held| held.moment.frame < frame);
        let queued = self.queue.get_mut(at);
        let late = self.late.iter_mut();
        queued
            .into_iter()
            .chain(late)
            .find(|held| held.moment.frame == frame)
            .is_some_and(|held| held.decide(report))
    }

    /// Takes a frame that is decided, if there is one.
    pub fn pop(&mut self) -> Option<Ready> {
        if let Some(at) = self.late.iter().position(Held::decided) {
            return Some(Ready::Late(self.late.remove(at)));
        }
        if self.queue.front()?.decided() {
            return self.queue.pop_front().map(Ready::InOrder);
        }
        None
    }

    /// Takes the oldest frame, decided or not.
    pub fn drain(&mut self) -> Option<Ready> {
        if self.late.is_empty() {
            self.queue.pop_front().map(Ready::InOrder)
        } else {
            Some(Ready::Late(self.late.remove(0)))
        }
    }
}
