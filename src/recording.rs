//! Turns a replay into a Rerun recording with its own layout.
//!
//! The one place where Rerun types appear. The same replay gives the same bytes: see [`encode`].

mod about;
mod arcs;
mod blueprint;
mod closed;
mod covariance;
mod decided;
mod encode;
mod error;
mod extent;
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
mod style;
mod suspects;
mod table;
#[cfg(test)]
mod tests;
mod truth;
mod views;

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;

use rerun::components::TextLogLevel;
use rerun::{RecordingInfo, Scale3D, Transform3D};

use self::blueprint::Layout;
use self::closed::ClosedTables;
use self::decided::DecidedTables;
use self::encode::RrdWriter;
pub use self::error::Error;
use self::extent::Extent;
use self::hold::{Held, Hold};
use self::live::{Live, LiveError};
use self::log::{LogTable, opening};
use self::map::MapTables;
use self::names::store_ids;
use self::origin::Origin;
use self::overlay::OverlayTable;
pub use self::overlay::{Overlay, Sketched};
use self::plots::Limits;
use self::robot::RobotTables;
use self::suspects::SuspectTables;
use self::table::{Moment, Timelines, put_static};
pub use self::truth::Evaluated;
use self::truth::TruthTables;
use crate::event::{Sonar, SonarId};
use crate::frames::Frame;
use crate::observer::{Observer, ObserverError, Setting};
use crate::tmam::step::Step;
use crate::wording::counted;

/// What the angle plots are laid out for until the beams are known, radians.
const USUAL_BEAM_WIDTH: f64 = 0.5;

/// A Rerun recording being written.
pub struct Recording<W: Write> {
    // Taken at the end; `None` means that the file is closed.
    out: Option<RrdWriter<W>>,
    done: Option<W>,
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
    /// Starts a recording; everything that never changes is written now.
    ///
    /// # Errors
    /// When `out` cannot be written to.
    pub fn new(out: W, setting: Setting<'_>) -> Result<Self, Error> {
        Self::start(out, setting, Overlay::default(), None, None)
    }

    /// Starts a recording of a replay that has been evaluated, with the truth and the errors in it.
    ///
    /// # Errors
    /// When `out` cannot be written to.
    pub fn of_evaluated(
        out: W,
        setting: Setting<'_>,
        evaluated: Evaluated<'_>,
    ) -> Result<Self, Error> {
        Self::start(out, setting, Overlay::default(), Some(evaluated), None)
    }

    /// Starts a recording with something drawn over it.
    ///
    /// # Errors
    /// When `out` cannot be written to.
    pub fn overlaid(out: W, setting: Setting<'_>, overlay: Overlay) -> Result<Self, Error> {
        Self::start(out, setting, overlay, None, None)
    }

    /// Starts a recording that an open viewer, where there is one, is shown as well. When it goes
    /// away that is an error where the recording is `only_live`; else it goes on without, and
    /// [`lost`](Self::lost) says so.
    ///
    /// # Errors
    /// When `out` cannot be written to.
    pub fn with_viewer(
        out: W,
        viewer: Option<Live>,
        only_live: bool,
        setting: Setting<'_>,
    ) -> Result<Self, Error> {
        let live = viewer.map(|viewer| (viewer, only_live));
        Self::start(out, setting, Overlay::default(), None, live)
    }

    fn start(
        out: W,
        setting: Setting<'_>,
        overlay: Overlay,
        evaluated: Option<Evaluated<'_>>,
        live: Option<(Live, bool)>,
    ) -> Result<Self, Error> {
        let (viewer, only_live) = live.map_or((None, false), |(viewer, only)| (Some(viewer), only));
        let source = setting.source;
        let world = evaluated.map(|evaluated| evaluated.truth.world());
        let [recording, blueprint] = store_ids(&setting, world);
        let origin = Origin::of(setting.start);
        let start_ns = source.start_ns;
        let mut out = RrdWriter::new(out, viewer, recording, blueprint, start_ns, origin)?;
        let limits = Limits {
            gamma: setting.config.triple.gamma,
            gate: setting.config.opinion.gate,
        };
        put_static(
            "/__properties",
            &RecordingInfo::new()
                .with_name(source.file.as_str())
                .with_start_time(source.start_ns),
            &mut out,
        )?;
        origin.put(&mut out)?;
        put_static(
            "/about",
            &about::page(&setting, &overlay.about, origin),
            &mut out,
        )?;
        // A 2D view has y down: turn the world over.
        put_static(
            "/world",
            &Transform3D::from_scale(Scale3D::from([1.0, -1.0, 1.0])),
            &mut out,
        )?;
        put_static("/world", &style::annotations(), &mut out)?;
        arcs::put_styles(&mut out)?;
        plots::put_styles(setting.sonars, limits, &mut out)?;
        suspects::put_styles(&mut out)?;
        closed::put_styles(&mut out)?;
        robot::put_styles(setting.sonars, &mut out)?;
        let truth = evaluated
            .map(|evaluated| TruthTables::new(&setting, evaluated, &mut out))
            .transpose()?;
        let lines = Timelines::new(source.start_ns);
        out.preview(|out| {
            let layout = Layout {
                bounds: None,
                frames: 0,
                lanes: setting.sonars.len(),
                sonars: setting.sonars.len(),
                beam_width: USUAL_BEAM_WIDTH.max(limits.gamma),
                gate: limits.gate,
                stamp: lines.stamp,
                evaluated: evaluated.is_some(),
                first: None,
            };
            blueprint::put(&layout, out)
        })?;
        if overlay != Overlay::default() {
            overlay.put(&mut out)?;
            overlay.note(setting.sonars, lines, &mut out)?;
        }
        Ok(Self {
            out: Some(out),
            done: None,
            only_live,
            lost: None,
            lines,
            sonars: setting.sonars.to_vec(),
            limits,
            beam_width: limits.gamma,
            extent: Extent::default(),
            span: None,
            opening: opening(&setting),
            labels: BTreeMap::new(),
            hold: Hold::default(),
            seen: BTreeSet::new(),
            decided: DecidedTables::new(setting.sonars),
            closed: ClosedTables::new(),
            map: MapTables::new(),
            robot: RobotTables::new(),
            log: LogTable::new(setting.sonars),
            suspects: SuspectTables::new(setting.sonars),
            truth,
            overlay,
            marks: OverlayTable::new(),
        })
    }

    /// The writer, flushed, once [`Observer::finish`] has closed the file.
    pub fn into_inner(self) -> Option<W> {
        self.done
    }

    /// Why the viewer was not shown everything.
    pub fn lost(&self) -> Option<&LiveError> {
        self.lost.as_ref()
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
        let Some(out) = self.out.as_mut() else {
            return Ok(());
        };
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
            self.suspects.pass(at);
        }
        self.digest(at, step)?;
        self.judge(at, step)?;
        let lost = self.out.as_mut().and_then(RrdWriter::lost);
        self.lose(lost)
    }

    /// What a step decided, whether a frame came with it or not.
    fn digest(&mut self, at: Moment, step: &Step) -> Result<(), Error> {
        let Some(out) = self.out.as_mut() else {
            return Ok(());
        };
        for (level, text) in std::mem::take(&mut self.opening) {
            self.log.note(at, level, text, self.lines, out)?;
        }
        for verdict in &step.verdicts {
            self.hold.decide(verdict);
            *self.labels.entry(verdict.label.name()).or_default() += 1;
        }
        while let Some(ready) = self.hold.pop() {
            self.decided.write(&ready, &self.sonars, self.lines, out)?;
            self.marks
                .push(&ready, &self.overlay, &self.sonars, self.lines, out)?;
        }
        self.closed.note(step, out.origin());
        self.log.push(at, &step.extractions, self.lines, out)?;
        self.suspects.note(&step.judgements);
        self.map.update(at, step, self.lines, out)
    }

    /// What is wrong in a frame.
    fn judge(&mut self, at: Moment, step: &Step) -> Result<(), Error> {
        match (&mut self.truth, self.out.as_mut()) {
            (Some(truth), Some(out)) => truth.push(at, &step.arcs, &mut self.log, self.lines, out),
            _ => Ok(()),
        }
    }

    fn end(&mut self, step: &Step) -> Result<(), Error> {
        let last = self.span.map_or(
            Moment {
                frame: 0,
                stamp_ns: 0,
            },
            |(_, last)| last,
        );
        self.digest(last, step)?;
        let Some(mut out) = self.out.take() else {
            return Ok(());
        };
        let (lines, out_ref) = (self.lines, &mut out);
        while let Some(ready) = self.hold.drain() {
            self.decided.write(&ready, &self.sonars, lines, out_ref)?;
            self.marks
                .push(&ready, &self.overlay, &self.sonars, lines, out_ref)?;
        }
        if let Some((first, last)) = self.span {
            self.closed.push(last, lines, out_ref)?;
            let arcs = |label| self.labels.get(label).copied().unwrap_or_default();
            let [walls, points, tentative] = self.map.counts();
            let text = format!(
                "end: {}; {} contact, {} intersection, {} unidentified arcs, {} suspect; \
                 {} and {} in the map, {tentative} more tentative",
                counted((last.frame - first.frame + 1).unsigned_abs(), "frame"),
                arcs("contact"),
                arcs("intersection"),
                arcs("unidentified"),
                self.suspects.count(),
                counted(walls as u64, "line"),
                counted(points as u64, "point"),
            );
            self.log
                .note(last, TextLogLevel::INFO, text, lines, out_ref)?;
        }
        if let Some(truth) = &mut self.truth {
            truth.finish(last, lines, out_ref)?;
        }
        self.decided.flush(lines, out_ref)?;
        self.marks.flush(lines, out_ref)?;
        self.closed.flush(lines, out_ref)?;
        self.map.flush(lines, out_ref)?;
        self.robot.flush(lines, out_ref)?;
        self.log.flush(lines, out_ref)?;
        self.suspects.write(lines, out_ref)?;
        let ends: Vec<Moment> = self.span.iter().flat_map(|(a, b)| [*a, *b]).collect();
        let seen = &self.seen;
        plots::put_last(&self.sonars, seen, self.limits, &ends, lines, out_ref)?;
        let layout = Layout {
            bounds: Some(self.extent.bounds().seen_from(out_ref.origin())),
            frames: self
                .span
                .map_or(0, |(first, last)| last.frame - first.frame + 1),
            lanes: self.seen.len(),
            sonars: self.sonars.len(),
            beam_width: self.beam_width,
            gate: self.limits.gate,
            stamp: lines.stamp,
            evaluated: self.truth.is_some(),
            first: self.overlay.first_frame,
        };
        blueprint::put(&layout, out_ref)?;
        let (done, lost) = out.finish()?;
        self.done = Some(done);
        self.lose(lost)
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
