//! Turns a replay into a Rerun recording with its own layout.
//!
//! The one place where Rerun types appear. The same replay gives the same bytes: see [`encode`].

mod about;
mod arcs;
mod blueprint;
mod carried;
mod closed;
mod covariance;
mod decided;
mod encode;
mod error;
mod evidence;
mod extent;
mod finish;
pub mod grid;
mod hold;
pub mod live;
mod log;
mod map;
mod names;
mod origin;
mod overlay;
mod plots;
mod robot;
mod shapes;
mod start;
mod style;
mod suspects;
mod table;
#[cfg(test)]
mod tests;
mod truth;
mod views;

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;

pub use self::carried::{Carried, CarriedError};
use self::closed::ClosedTables;
use self::decided::DecidedTables;
use self::encode::RrdWriter;
pub use self::error::Error;
use self::evidence::EvidenceTable;
use self::extent::Extent;
use self::hold::{Held, Hold};
use self::live::LiveError;
use self::log::LogTable;
use self::map::MapTables;
use self::overlay::OverlayTable;
pub use self::overlay::{Overlay, Sketched};
use self::plots::Limits;
use self::robot::RobotTables;
use self::suspects::SuspectTables;
use self::table::{Moment, Timelines};
pub use self::truth::Evaluated;
use self::truth::TruthTables;
use crate::core::event::{Sonar, SonarId};
use crate::core::frames::Frame;
use crate::core::observer::{Observer, ObserverError};
use crate::core::tmam::step::Step;

/// A Rerun recording being written.
pub struct Recording<W: Write> {
    out: RrdWriter<W>,
    // Whether the viewer's end is the recording's.
    only_live: bool,
    lost: Option<LiveError>,
    lines: Timelines,
    sonars: Vec<Sonar>,
    limits: Limits,
    beam_width: f64,
    extent: Extent,
    seen: BTreeSet<SonarId>,
    span: Option<(Moment, Moment)>,
    // What the log says at the first frame; taken then.
    opening: Vec<(&'static str, String)>,
    labels: BTreeMap<&'static str, u64>,
    hold: Hold,
    decided: DecidedTables,
    evidence: EvidenceTable,
    closed: ClosedTables,
    map: MapTables,
    robot: RobotTables,
    log: LogTable,
    suspects: SuspectTables,
    truth: Option<TruthTables>,
    overlay: Overlay,
    marks: OverlayTable,
}

impl<W: Write> Recording<W> {
    /// Closes the file after [`Observer::finish`], with the results of the run in it where they are
    /// `carried`; gives the writer back, flushed, and why the viewer was not shown everything.
    ///
    /// # Errors
    /// When the rest cannot be written.
    pub fn close(mut self, carried: Option<&Carried>) -> Result<(W, Option<LiveError>), Error> {
        if let Some(carried) = carried {
            carried.put(&mut self.out)?;
        }
        let (out, lost) = self.out.finish()?;
        match lost {
            Some(error) if self.only_live => Err(error.into()),
            lost => Ok((out, self.lost.or(lost))),
        }
    }

    /// Notes that the viewer has gone away.
    fn lose(&mut self, lost: Option<LiveError>) -> Result<(), Error> {
        match lost {
            Some(error) if self.only_live => Err(error.into()),
            Some(error) => {
                self.lost.get_or_insert(error);
                Ok(())
            }
            None => Ok(()),
        }
    }

    fn watch(&mut self, frame: &Frame, step: &Step) -> Result<(), Error> {
        let out = &mut self.out;
        let at = Moment {
            frame: i64::from(frame.index),
            stamp_ns: frame.stamp_ns,
        };
        if let Some((_, last)) = self.span {
            self.closed.push(last, self.lines, out)?;
        }
        self.span = Some((self.span.map_or(at, |(first, _)| first), at));

        self.seen
            .extend(frame.entries.iter().map(|entry| entry.sonar));
        self.extent.visit(&frame.world_from_robot);
        for arc in &step.arcs {
            self.extent.echo(arc);
            self.beam_width = self.beam_width.max(arc.beam_width);
        }
        if self.overlay.shows(frame.index) {
            self.robot
                .push(at, frame.world_from_robot, self.lines, out)?;
            self.hold.push(Held::new(at, frame, step));
            let arcs = step.arcs.iter().map(|arc| arc.id);
            self.evidence.add_frame(at, arcs.collect());
            self.suspects.pass(at);
        } else if (frame.index.checked_sub(1)).is_some_and(|before| self.overlay.shows(before)) {
            self.leave(at)?;
        }
        self.digest(at, step)?;
        self.judge(at, step)?;
        let lost = self.out.lost();
        self.lose(lost)
    }

    /// Ends what is shown: the viewer would go on showing the last frame before frames that are not.
    fn leave(&mut self, at: Moment) -> Result<(), Error> {
        self.robot.leave(at, self.lines, &mut self.out)?;
        self.hold.push(Held::blank(at, self.seen.iter().copied()));
        self.evidence.add_frame(at, Vec::new());
        self.suspects.leave(at);
        Ok(())
    }

    /// What a step decided, whether a frame came with it or not.
    fn digest(&mut self, at: Moment, step: &Step) -> Result<(), Error> {
        let out = &mut self.out;
        for (level, text) in std::mem::take(&mut self.opening) {
            self.log.note(at, level, text, self.lines, out)?;
        }
        for report in &step.labelled {
            self.hold.decide(report);
            *self.labels.entry(report.label.name()).or_default() += 1;
        }
        while let Some(ready) = self.hold.pop() {
            self.decided.write(&ready, &self.sonars, self.lines, out)?;
            self.marks
                .push(&ready, &self.overlay, &self.sonars, self.lines, out)?;
        }
        self.closed.note(step, out.origin());
        self.log.push(at, &step.extractions, self.lines, out)?;
        self.evidence.push(&step.reports, self.lines, out)?;
        self.suspects.note(&step.reports);
        self.map.update(at, step, self.lines, out)
    }

    /// What is wrong in a frame.
    fn judge(&mut self, at: Moment, step: &Step) -> Result<(), Error> {
        match &mut self.truth {
            Some(truth) => truth.push(at, &step.arcs, &mut self.log, self.lines, &mut self.out),
            None => Ok(()),
        }
    }
}

impl<W: Write> Observer for Recording<W> {
    fn frame(&mut self, frame: &Frame, step: &Step) -> Result<(), ObserverError> {
        self.watch(frame, step).map_err(ObserverError::new)
    }

    fn finish(&mut self, step: &Step) -> Result<(), ObserverError> {
        self.end(step).map_err(ObserverError::new)
    }
}
