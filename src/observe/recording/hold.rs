//! Holds a frame back until every arc in it has its label.
//!
//! A label comes when the sonar's next reading has come, so a frame usually waits for one or
//! two more. A sonar that falls silent keeps its last arc undecided until the end; so that the
//! frames after it need not wait too, a frame that has waited for [`LONGEST_WAIT`] others steps
//! out of the queue. A sonar has one or two undecided arcs at a time, so few frames ever do.

use std::collections::VecDeque;

use super::canvas::Moment;
use crate::core::event::SonarId;
use crate::core::frames::Frame;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::step::Step;

/// Frames that may queue behind an undecided one.
const LONGEST_WAIT: usize = 256;

/// What one sonar gave one frame.
#[derive(Debug, Clone)]
pub struct HeldCell {
    pub sonar: SonarId,
    /// `None` where nothing echoed.
    pub arc: Option<Arc>,
    /// Once it has its label.
    pub report: Option<ArcReport>,
    /// Then, too: the arc between its neighbours, where the three make a triple.
    pub triple: Option<[Arc; 3]>,
}

/// A frame that waits for its labels.
#[derive(Debug, Clone)]
pub struct HeldFrame {
    pub moment: Moment,
    /// What the sonars gave, sorted by sonar.
    pub cells: Vec<HeldCell>,
}

impl HeldFrame {
    /// The cells of a frame, still undecided.
    pub fn new(moment: Moment, frame: &Frame, step: &Step) -> Self {
        let arc_of = |sonar| step.arcs.iter().find(|arc| arc.id.sonar == sonar).copied();
        let sonars = frame.entries.iter().map(|entry| entry.sonar);
        Self {
            moment,
            cells: sonars
                .map(|sonar| HeldCell::new(sonar, arc_of(sonar)))
                .collect(),
        }
    }

    /// A frame in which these sonars gave nothing.
    pub fn blank(moment: Moment, sonars: impl Iterator<Item = SonarId>) -> Self {
        Self {
            moment,
            cells: sonars.map(|sonar| HeldCell::new(sonar, None)).collect(),
        }
    }

    fn is_decided(&self) -> bool {
        let mut cells = self.cells.iter();
        cells.all(|cell| cell.arc.is_none() || cell.report.is_some())
    }
}

impl HeldCell {
    fn new(sonar: SonarId, arc: Option<Arc>) -> Self {
        Self {
            sonar,
            arc,
            report: None,
            triple: None,
        }
    }
}

/// The frames that wait.
#[derive(Debug, Default)]
pub struct Hold {
    queue: VecDeque<HeldFrame>,
    // Frames that stepped out of the queue, with late moments.
    late: Vec<HeldFrame>,
}

impl Hold {
    /// Adds the newest frame.
    pub fn push(&mut self, held: HeldFrame) {
        self.queue.push_back(held);
        while self.queue.len() > LONGEST_WAIT
            && let Some(mut front) = self.queue.pop_front_if(|front| !front.is_decided())
        {
            front.moment.late = true;
            self.late.push(front);
        }
    }

    /// Hands a label to the frame of its arc, if that is held.
    pub fn decide(&mut self, report: &ArcReport, triple: Option<[Arc; 3]>) {
        let frame = i64::from(report.arc.id.frame);
        let at = self.queue.partition_point(|held| held.moment.frame < frame);
        let queued = self.queue.get_mut(at).into_iter();
        let held = queued.chain(&mut self.late);
        let of_frame = held.filter(|held| held.moment.frame == frame).take(1);
        let mut cells = of_frame.flat_map(|held| &mut held.cells);
        let cell = cells.find(|cell| cell.sonar == report.arc.id.sonar && cell.arc.is_some());
        if let Some(cell) = cell {
            cell.report = Some(report.clone());
            cell.triple = triple;
        }
    }

    /// Takes a frame that is decided, if there is one.
    pub fn pop(&mut self) -> Option<HeldFrame> {
        match self.late.iter().position(HeldFrame::is_decided) {
            Some(at) => Some(self.late.remove(at)),
            None => self.queue.pop_front_if(|front| front.is_decided()),
        }
    }

    /// Takes the oldest frame, decided or not.
    pub fn drain(&mut self) -> Option<HeldFrame> {
        if self.late.is_empty() {
            self.queue.pop_front()
        } else {
            Some(self.late.remove(0))
        }
    }
}
